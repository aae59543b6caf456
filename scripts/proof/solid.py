"""A body of quadratic tetrahedra under finite strain: what FEniCSx makes of it.

Positions mm, stresses kPa, forces mN inside and N outside. Pads are glued (their nodes are moved) or slide (springs across the plate);
the base holds, or in a disc slides along itself.
"""
import os

import basix.ufl_wrapper
import dolfinx
import numpy as np
import ufl
from dolfinx import fem, mesh as dmesh
from mpi4py import MPI
from petsc4py import PETSc

from . import energies
from .newton import Newton

DEGREE = 4           # of the quadrature rule
FIRM = 1e4           # kPa/mm: springs across a sliding pad's plate give by less than 1e-3 mm
JIT = {"cffi_extra_compile_args": ["-O3", "-march=native", "-ffast-math", "-fno-math-errno"],
       "cache_dir": os.path.join(os.environ.get("XDG_CACHE_HOME", os.path.expanduser("~/.cache")), "tissued-proof", os.uname().nodename)}


class Solid:
    """features: names of energies beside the neo-Hookean one: stiffening, fibres, skin, slide, loose, visco, set, worn, tension, pressure."""

    def __init__(self, body_mesh, features):
        self.features = frozenset(features)
        cell = ufl.Cell("tetrahedron", geometric_dimension=3)
        coordinates = ufl.Mesh(ufl.VectorElement("Lagrange", cell, 1))
        self.mesh = dmesh.create_mesh(MPI.COMM_SELF, body_mesh.tets.astype(np.int64), body_mesh.points, coordinates)
        self.V = fem.FunctionSpace(self.mesh, ufl.VectorElement("Lagrange", cell, 2))
        self.u, self.body_mesh = fem.Function(self.V), body_mesh
        self.nodes = self.V.tabulate_dof_coordinates()
        self.cells = self.mesh.topology.index_map(3).size_local
        self._tag_facets()
        self._make_fields()
        self._make_forms()
        self.newton = Newton(self)

    # What is where.

    def _tag_facets(self):
        """Facet markers 2 base, 3 skin, 4... pads; the nodes (of V) of each group."""
        mesh, groups = self.mesh, self.body_mesh.facets
        self.names = ["base", "skin"] + sorted(k for k in groups if k not in ("base", "skin"))
        new_of_old = np.empty(len(self.body_mesh.points), np.int64)
        new_of_old[mesh.geometry.input_global_indices] = np.arange(len(mesh.geometry.input_global_indices))
        mesh.topology.create_connectivity(2, 3)
        mesh.topology.create_connectivity(3, 0)
        mesh.topology.create_connectivity(2, 0)
        # Geometry nodes and topological vertices are numbered apart.
        of_cell, vertices = mesh.geometry.dofmap, mesh.topology.connectivity(3, 0)
        vertex_of_node = np.empty(len(new_of_old), np.int64)
        for c in range(self.cells):
            vertex_of_node[of_cell.links(c)] = vertices.links(c)
        facet_of = {tuple(sorted(mesh.topology.connectivity(2, 0).links(f))): f
                    for f in dmesh.exterior_facet_indices(mesh.topology)}
        indices, values, self.group_nodes = [], [], {}
        for k, name in enumerate(self.names):
            own = [facet_of[tuple(sorted(vertex_of_node[new_of_old[face]]))] for face in groups[name]]
            indices += own
            values += [2 + k] * len(own)
            self.group_nodes[name] = fem.locate_dofs_topological(self.V, 2, np.array(own, np.int32))
        order = np.argsort(indices)
        self.tags = dmesh.meshtags(mesh, 2, np.array(indices, np.int32)[order], np.array(values, np.int32)[order])

    def _make_fields(self):
        cell = self.mesh.ufl_cell()
        data = {"quadrature_degree": DEGREE, "quadrature_scheme": "default"}
        scalar = ufl.FiniteElement("Quadrature", cell, DEGREE, quad_scheme="default")
        six = ufl.VectorElement("Quadrature", cell, DEGREE, dim=6, quad_scheme="default")
        self.Q, self.Q6 = fem.FunctionSpace(self.mesh, scalar), fem.FunctionSpace(self.mesh, six)
        self.points, self.weights = basix.make_quadrature(basix.CellType.tetrahedron, DEGREE)
        where = fem.Expression(ufl.SpatialCoordinate(self.mesh), self.points).eval(np.arange(self.cells, dtype=np.int32))
        self.where = where.reshape(-1, 3)  # (cells x points, 3) mm, in the order of a quadrature function's values
        self.stiffness, self.growth = self._field(1.0), self._field(1.0)
        self.tension, self.pressure = self._field(0.0), self._field(0.0)
        self.before, self.h, self.most = fem.Function(self.Q6), fem.Function(self.Q6), self._field(0.0)
        constant = lambda value: fem.Constant(self.mesh, PETSc.ScalarType(value))
        self.numbers = {name: constant(value) for name, value in {
            "mu": 1.0, "kappa": 1.0, "b": 1.0, "fibres": 0.0, "axis": (0.0, 0.0, 1.0), "skin": 0.0, "weight": (0.0, 0.0, 0.0),
            "g": 0.0, "kept": 1.0, "taken": 1.0, "limit": 1.0, "inverse_r": 0.0, "w0": 1.0, "along": (0.0, 0.0, 1.0),
            "loose_center": (0.0, 0.0, 0.0), "loose_radius": 0.0, "loose_hold": 0.0, "slide_hold": 0.0}.items()}
        for k in range(len(self.names) - 2):
            self.numbers[f"normal{k}"] = constant((0.0, 0.0, 1.0))
            self.numbers[f"moved{k}"] = constant((0.0, 0.0, 0.0))
            self.numbers[f"touches{k}"] = constant(0.0)
        self.dx = ufl.Measure("dx", self.mesh, metadata=data)
        self.ds = ufl.Measure("ds", self.mesh, subdomain_data=self.tags, metadata=data)

    def _field(self, value):
        field = fem.Function(self.Q)
        field.x.array[:] = value
        return field

    def set(self, **numbers):
        for name, value in numbers.items():
            self.numbers[name].value = value

    # What it weighs, holds and resists.

    def _make_forms(self):
        n, u, v = self.numbers, self.u, ufl.TestFunction(self.V)
        F = ufl.Identity(3) + ufl.grad(u)
        mu, kappa = n["mu"] * self.stiffness, n["kappa"] * self.stiffness
        has = self.features.__contains__
        shape = energies.stiffening(F, mu, n["b"]) if has("stiffening") else energies.neo_hookean(F, mu)
        rest = energies.volume(F, kappa, self.growth)
        if has("fibres"):
            rest += self.stiffness * energies.fibres(F, n["fibres"], n["axis"])
        if has("tension"):
            along = F * n["along"]
            rest += self.tension * ufl.sqrt(ufl.dot(along, along))
        if has("pressure"):
            rest -= self.pressure * ufl.det(F)
        residual = ufl.derivative(rest * self.dx, u, v) - ufl.inner(n["weight"], v) * self.dx
        plain = ufl.derivative(shape * self.dx, u, v)
        S, before, h = energies.shape_stress(F), energies.unpack(self.before), energies.unpack(self.h)
        if has("worn"):
            P = energies.worn(F, mu, self.most, n["inverse_r"], n["w0"]) * mu * (F * S)
            residual += ufl.inner(P, ufl.grad(v)) * self.dx
            self._most = fem.Expression(energies.neo_hookean(F, mu), self.points, jit_params=JIT)
        elif has("visco") or has("set"):
            new = energies.overstress(S, before, h, n["kept"], n["taken"]) if has("visco") else energies.slid(S, before, h, n["limit"])
            P = mu * (F * ((1 - n["g"]) * S + n["g"] * new))
            residual += ufl.inner(P, ufl.grad(v)) * self.dx
            self._new = fem.Expression(energies.pack(new), self.points, jit_params=JIT)
            self._stress = fem.Expression(energies.pack(S), self.points, jit_params=JIT)
        else:
            residual += plain
        if has("skin"):
            residual += ufl.derivative(self._skin(), u, v)
        springs = self._springs()
        if springs is not None:
            residual += ufl.derivative(springs, u, v)
        self.residual = fem.form(residual, jit_params=JIT)
        self.tangent = fem.form(ufl.derivative(residual, u, ufl.TrialFunction(self.V)), jit_params=JIT)
        self.pull = None if springs is None else fem.form(ufl.derivative(springs, u, v), jit_params=JIT)

    def _skin(self):
        F = ufl.Identity(3) + ufl.grad(self.u)
        energy = energies.skin(F, ufl.FacetNormal(self.mesh), self.numbers["skin"])
        return sum((energy * self.ds(2 + k) for k in range(2, len(self.names))), energy * self.ds(3))

    def _springs(self):
        n, springs = self.numbers, []
        if "slide" in self.features:
            for k in range(len(self.names) - 2):
                away = self.u - n[f"moved{k}"]
                across = ufl.dot(away, n[f"normal{k}"])
                along = ufl.dot(away, away) - across ** 2
                springs.append(n[f"touches{k}"] * (FIRM / 2 * across ** 2 + n["slide_hold"] / 2 * along) * self.ds(4 + k))
        if "loose" in self.features:
            X = ufl.SpatialCoordinate(self.mesh)
            away = X - n["loose_center"]
            inside = ufl.conditional(ufl.lt(ufl.sqrt(ufl.dot(away, away)), n["loose_radius"]), 1.0, 0.0)
            # Outside of the disc the nodes are held, so that only what is loose is left to the spring.
            springs.append(inside * n["loose_hold"] / 2 * (self.u[0] ** 2 + self.u[1] ** 2) * self.ds(2))
        return sum(springs[1:], springs[0]) if springs else None

    # What it remembers.

    def rest(self):
        self.u.x.array[:] = 0.0
        for field in (self.before, self.h, self.most):
            field.x.array[:] = 0.0

    def accept(self):
        """Takes the state over into the history."""
        cells = np.arange(self.cells, dtype=np.int32)
        if "worn" in self.features:
            now = self._most.eval(cells).reshape(-1)
            np.maximum(self.most.x.array, now, out=self.most.x.array)
        if self.features & {"visco", "set"}:
            new, stress = self._new.eval(cells).reshape(-1), self._stress.eval(cells).reshape(-1)
            self.h.x.array[:], self.before.x.array[:] = new, stress

    # What is seen of it.

    def pad_force(self, k):
        """N, of pad k on the tissue."""
        if "slide" in self.features:
            pulled = self.newton.assembled(self.pull).reshape(-1, 3)
            return -pulled[self.group_nodes[f"A{k + 1}"]].sum(0) / 1000.0
        return self.newton.residual().reshape(-1, 3)[self.group_nodes[f"A{k + 1}"]].sum(0) / 1000.0

    def observer(self, points):
        """(n x nodes of a cell) weights and nodes: displacements at places (n, 3) of the body, the nearest where they are outside."""
        tets = self.mesh.geometry.x[np.array([self.mesh.geometry.dofmap.links(c) for c in range(self.cells)])]
        origin, edges = tets[:, 0], (tets[:, 1:] - tets[:, :1]).transpose(0, 2, 1)
        inverse = np.linalg.inv(edges)
        element = basix.create_element(basix.ElementFamily.P, basix.CellType.tetrahedron, 2, basix.LagrangeVariant.gll_warped)
        weights, nodes = [], []
        for p in np.asarray(points).reshape(-1, 3):
            local = np.einsum("cij,cj->ci", inverse, p - origin)
            c = int(np.argmax(np.minimum(local.min(1), 1.0 - local.sum(1))))
            weights.append(element.tabulate(0, local[c][None])[0, 0].reshape(-1))
            nodes.append(self.V.dofmap.cell_dofs(c))
        return np.array(weights), np.array(nodes)

    def seen(self, observer):
        """(n, 3) mm."""
        weights, nodes = observer
        return np.einsum("pk,pki->pi", weights, self.u.x.array.reshape(-1, 3)[nodes])
