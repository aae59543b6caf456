"""Newton's method for a Solid: with a factor that is kept while it serves, Anderson's acceleration, and halved steps where it fails."""
import numpy as np
from dolfinx import fem
from mpi4py import MPI
from petsc4py import PETSc

ACCURACY = 2e-5   # mm: largest last correction
SERVES = 0.3      # a kept factor that shrinks corrections by less is renewed
MOST = 40         # corrections
FARTHEST = 40.0   # mm: a larger correction has left its senses
SMALLEST = 1.0 / 8.0  # of a load step


class NoEquilibrium(Exception):
    pass


class Newton:
    def __init__(self, solid):
        self.solid, self.u = solid, solid.u.x.array
        self.A, self.r = fem.petsc.create_matrix(solid.tangent), fem.petsc.create_vector(solid.residual)
        self.b, self.x = self.r.duplicate(), self.r.duplicate()  # PETSc's own are not collected: made once
        self.K, self.factor, self.fixed, self.factorisations = None, None, np.zeros(0, np.int32), 0

    def hold(self, dofs):
        """Which scalar dofs are prescribed from now on; sorted."""
        dofs = np.unique(np.asarray(dofs, np.int32))
        if not np.array_equal(dofs, self.fixed):
            self.fixed = dofs
            self._forget()
        return self.fixed

    def _forget(self):
        if self.factor is not None:
            self.factor.destroy()
        self.factor = None

    def close(self):
        """Gives back what PETSc holds, some 300 MB, which Python would not collect."""
        self._forget()
        for part in (self.A, self.K, self.r, self.b, self.x):
            if part is not None:
                part.destroy()

    def residual(self):
        """mN at every dof, of the energy, prescribed dofs included."""
        return self.assembled(self.solid.residual)

    def assembled(self, form):
        with self.r.localForm() as local:
            local.set(0.0)
        fem.petsc.assemble_vector(self.r, form)
        return self.r.array

    def _factorise(self):
        self.A.zeroEntries()
        fem.petsc.assemble_matrix(self.A, self.solid.tangent)
        self.A.assemble()
        if self.K is None:
            self.K = self.A.duplicate()
        self.A.copy(self.K, PETSc.Mat.Structure.SAME_NONZERO_PATTERN)
        self.A.zeroRowsColumns(self.fixed, 1.0)
        if self.factor is None:
            self.factor = PETSc.KSP().create(MPI.COMM_SELF)
            self.factor.setType("preonly")
            self.factor.getPC().setType("lu")
            self.factor.getPC().setFactorSolverType("mumps")
        self.factor.setOperators(self.A)
        self.factor.setUp()
        self.factorisations += 1

    def _correction(self, prescribed):
        """What the kept tangent makes of the residual and of the prescribed dofs' way to where they shall be, mm."""
        rhs = -self.residual().copy()
        way = np.zeros_like(rhs)
        way[self.fixed] = prescribed - self.u[self.fixed]
        if np.abs(way).max(initial=0.0) > 0.0:
            self.b.array = way
            self.K.mult(self.b, self.x)
            rhs -= self.x.array
        rhs[self.fixed] = way[self.fixed]
        self.b.array = rhs
        self.factor.solve(self.b, self.x)
        return self.x.array.copy()

    def solve(self, prescribed, apply=lambda share: None, guess=None):
        """Equilibrium with `prescribed` mm at the held dofs. apply(share of the step) sets other loads; guess: where to begin, else here."""
        start, old = self.u.copy(), self.u[self.fixed].copy()
        apply(1.0)
        if guess is not None:
            self.u[:] = guess
            if self._iterate(prescribed):
                return
            self.u[:] = start
        done, step = 0.0, 1.0 if guess is None else 0.5
        while done < 1.0:
            share = min(1.0, done + step)
            apply(share)
            before = self.u.copy()
            if self._iterate(old + share * (prescribed - old)):
                done = share
                continue
            self.u[:] = before
            step /= 2.0
            if step < SMALLEST:
                self.u[:] = start
                self._forget()
                raise NoEquilibrium()
            self._forget()  # it is one of where Newton's method went astray

    def _iterate(self, prescribed):
        """True once corrections are small; False where they grow though factor and place are new."""
        fresh = self.factor is None
        if fresh:
            self._factorise()
        steps, places, last = [], [], None
        for _ in range(MOST):
            step = self._correction(prescribed)
            size = np.abs(step).max()
            if not np.isfinite(size) or size > FARTHEST:
                return False
            if size < ACCURACY:
                self.u += step
                return True
            if last is not None and size > SERVES * last:
                if fresh and size > last and not self._nearer(places[-1], steps[-1], last, prescribed):
                    return False
                self._factorise()
                steps, places, fresh = [], [], True
                step = self._correction(prescribed)
                size = np.abs(step).max()
                if not np.isfinite(size) or size > FARTHEST:
                    return False
            elif last is not None:
                fresh = False
            last = size
            steps.append(step)
            places.append(self.u.copy())
            self.u[:] = _accelerated(steps[-6:], places[-6:])
            self.u[self.fixed] = prescribed
        return False

    def _nearer(self, place, step, size, prescribed):
        """Goes a part of a step from `place` after which the same factor asks for less than before; False where none does."""
        for part in (0.5, 0.25, 0.125):
            self.u[:] = place + part * step
            self.u[self.fixed] = prescribed
            now = np.abs(self._correction(prescribed)).max()
            if np.isfinite(now) and now < size:
                return True
        return False


def _accelerated(steps, places):
    """Anderson: the combination of the last places (all with the same prescribed dofs but the first) whose correction is least."""
    new = places[-1] + steps[-1]
    if len(steps) > 2:
        D = np.stack([steps[k + 1] - steps[k] for k in range(1, len(steps) - 1)], axis=1)
        X = np.stack([places[k + 1] - places[k] for k in range(1, len(places) - 1)], axis=1)
        new -= (X + D) @ np.linalg.lstsq(D, steps[-1], rcond=None)[0]
    return new
