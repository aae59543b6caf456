"""What really happens in a case: its pushes, solved by FEniCSx on a mesh of the truth's own."""
import math

import numpy as np

from . import energies
from .session import in_time, lagrange
from .solid import Solid

LEVELS = 4         # at which a push without history is solved; a quartic goes through them and rest
TRAVEL = 2.5       # mm between keys of a push with history
FEATURES = {"strain-stiffening": "stiffening", "anisotropy": "fibres", "skin": "skin", "sliding-actuator": "slide", "loose-base": "loose",
            "viscoelasticity": "visco", "permanent-set": "set", "softening": "worn", "pulling-cable": "tension", "pulsating-cavity": "pressure"}
STEPPED = {"viscoelasticity", "softening", "permanent-set", "swelling", "growing-lump", "pulling-cable", "pulsating-cavity"}


class Truth:
    """numbers: {kind: {...}} of the effects that are in it; material: youngs_modulus kPa, poissons_ratio; density g/cm3."""

    def __init__(self, mesh, pads, material, numbers, density=1.0):
        self.solid = Solid(mesh, {FEATURES[kind] for kind in numbers if kind in FEATURES})
        self.newton, self.pads, self.numbers = self.solid.newton, pads, numbers
        self.stepped = bool(STEPPED & set(numbers))
        E, nu = material["youngs_modulus"], material["poissons_ratio"]
        self.mu, self.kappa = E / (2 * (1 + nu)), E / (3 * (1 - 2 * nu))
        self.solid.set(mu=self.mu, kappa=self.kappa)
        self._set_effects(density)
        self._groups()
        self.origin = np.zeros_like(self.solid.u.x.array)
        if "gravity" in numbers:
            self._hang()

    def _set_effects(self, density):
        solid, n, X = self.solid, self.numbers, self.solid.where
        direct = {"strain-stiffening": lambda v: {"b": v["b"]}, "anisotropy": lambda v: {"fibres": v["k"], "axis": v["axis"]},
                  "skin": lambda v: {"skin": v["stiffness"]}, "viscoelasticity": lambda v: {"g": v["g1"]}, "permanent-set": lambda v: v,
                  "softening": lambda v: {"inverse_r": 1.0 / v["r"], "w0": v["w0"]},
                  "loose-base": lambda v: {"loose_center": v["center"], "loose_radius": v["radius"], "loose_hold": v["k_t"]}}
        for kind, values in n.items():
            if kind in direct:
                solid.set(**direct[kind](values))
        if "inclusion" in n:
            solid.stiffness.x.array[self._in_ball("inclusion")] *= n["inclusion"]["ratio"]
        if "stiffness-gradient" in n:
            solid.stiffness.x.array[:] *= np.exp(n["stiffness-gradient"]["k"] * X @ np.array(n["stiffness-gradient"]["axis"]))
        if "gravity" in n:
            self.weight = density * energies.GRAVITY * np.array(n["gravity"]["gravity"])
        if "pulling-cable" in n:
            solid.set(along=self._cable_axis())
        for k, pad in enumerate(self.pads):
            solid.set(**{f"normal{k}": self._plate(k)})

    def _plate(self, k):
        """The pad's mean outward normal: what a plate that slides holds across."""
        p = self.solid.body_mesh.points[self.solid.body_mesh.facets[f"A{k + 1}"]]
        n = np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]).sum(0)
        return n / np.linalg.norm(n)

    def _in_ball(self, kind):
        v = self.numbers[kind]
        return np.linalg.norm(self.solid.where - np.array(v["center"]), axis=1) < v["radius"]

    def _cable_axis(self):
        v = self.numbers["pulling-cable"]
        axis = np.array(v["to"]) - np.array(v["from"])
        return axis / np.linalg.norm(axis)

    def _groups(self):
        every = lambda nodes: (3 * nodes[:, None] + np.arange(3)).ravel()
        self.pad_nodes = [self.solid.group_nodes[f"A{k + 1}"] for k in range(len(self.pads))]
        base = self.solid.group_nodes["base"]
        if "loose-base" not in self.numbers:
            self.base = every(base)
            return
        v = self.numbers["loose-base"]
        loose = np.linalg.norm(self.solid.nodes[base] - np.array(v["center"]), axis=1) < v["radius"]
        self.base = np.concatenate([every(base[~loose]), 3 * base[loose] + 2])  # it slides along itself, and does not lift

    def _hang(self):
        """The body hangs under its weight before anything is recorded."""
        self.newton.hold(self.base)
        for share in (0.5, 1.0):
            self.newton.solve(np.zeros(len(self.newton.fixed)), lambda part, share=share: self.solid.set(weight=(share - 0.5 + 0.5 * part) * self.weight))
        self.origin = self.solid.u.x.array.copy()

    def rest(self):
        self.solid.rest()
        self.solid.u.x.array[:] = self.origin

    def sag(self, k):
        """mm, of pad k's patch before it is pushed."""
        return self.origin.reshape(-1, 3)[self.pad_nodes[k]].mean(0)

    def _place(self, depths):
        """Holds what touches; prescribed values: pads moved from where they hang by depths {pad: mm}."""
        u = self.origin.copy()
        held = [self.base]
        for k, pad in enumerate(self.pads):
            moved = depths.get(k, 0.0) * pad["direction"]
            if "slide" in self.solid.features:
                self.solid.set(**{f"touches{k}": float(k in depths), f"moved{k}": moved})
            elif k in depths:
                u.reshape(-1, 3)[self.pad_nodes[k]] += moved
                held.append((3 * self.pad_nodes[k][:, None] + np.arange(3)).ravel())
        fixed = self.newton.hold(np.concatenate(held))
        return u[fixed]

    def _at(self, t):
        """Loads that come with time."""
        n, solid = self.numbers, self.solid
        if "swelling" in n:
            solid.growth.x.array[:] = 1.0 + n["swelling"]["rate"] * t
        if "growing-lump" in n:
            v = n["growing-lump"]
            solid.growth.x.array[self._in_ball("growing-lump")] = 1.0 + v["growth"] * min(1.0, t / v["seconds"])
        if "pulsating-cavity" in n:
            v = n["pulsating-cavity"]
            most = v["swing"] * (self.kappa + 4.0 / 3.0 * self.mu)
            solid.pressure.x.array[self._in_ball("pulsating-cavity")] = most * 0.5 * (1.0 - math.cos(2.0 * math.pi * t / v["period"]))
        if "pulling-cable" in n:
            v, X = n["pulling-cable"], solid.where
            away = X - np.array(v["center"])
            along = away @ self._cable_axis()
            inside = (np.abs(along) < v["radius"]) & (np.linalg.norm(away - along[:, None] * self._cable_axis(), axis=1) < v["thickness"])
            solid.tension.x.array[inside] = v["tension"] * min(1.0, t / v["seconds"])

    def solve_push(self, depths, guess=None):
        """Equilibrium of a push without history, in one go from where the body is."""
        if "slide" in self.solid.features:
            self.newton.solve(self._place(depths), lambda share: self._place({k: share * d for k, d in depths.items()}), guess)
        else:
            self.newton.solve(self._place(depths), guess=guess)

    def _observe(self, observer, trial):
        """(3 points + 3 pads of the trial) mm, N."""
        forces = [self.solid.pad_force(k) for k in trial.pads]
        return np.concatenate([self.solid.seen(observer).ravel()] + forces)

    def curve(self, trial, observer):
        """Values at LEVELS + 1 shares of the push."""
        self.rest()
        self._at(0.0)
        values, past = [], [self.origin.copy()]
        self._place({k: 0.0 for k in trial.pads})
        values.append(self._observe(observer, trial))
        for level in range(1, LEVELS + 1):
            guess = None
            if len(past) > 1:
                xs = list(range(level - len(past), level))
                guess = sum(w * x for w, x in zip(lagrange(xs, level), past))
            self.solve_push({k: d * level / LEVELS for k, d in trial.pads.items()}, guess)
            values.append(self._observe(observer, trial))
            past = (past + [self.solid.u.x.array.copy()])[-4:]
        return np.array(values)

    def _course(self, trial, observer, keys):
        """Values at the keys of a push with history or loads that come with time."""
        self.rest()
        values, past, before = [], [], 0.0
        for number, t in enumerate(keys):
            dt = t - before
            if "viscoelasticity" in self.numbers:
                r = dt / self.numbers["viscoelasticity"]["tau1"]
                self.solid.set(kept=math.exp(-r), taken=-math.expm1(-r) / r if r > 0.0 else 1.0)
            if number > 0:
                guess = self._guess(keys, number, past, trial)
                share, earlier = trial.share(t), trial.share(before)

                def apply(part):
                    self._at(before + part * dt)
                    if "slide" in self.solid.features:
                        self._place({k: d * (earlier + part * (share - earlier)) for k, d in trial.pads.items()})

                target = self._place({k: d * share for k, d in trial.pads.items()})
                self.newton.solve(target, apply, guess)
                self.solid.accept()
            else:
                self._at(0.0)
                self._place({k: 0.0 for k in trial.pads})
                self.solid.accept()
            values.append(self._observe(observer, trial))
            past, before = (past + [self.solid.u.x.array.copy()])[-3:], t
        return np.array(values)

    def _guess(self, keys, number, past, trial):
        """Extrapolated in time within a phase; None at its beginning."""
        edges = [end for _, end in trial.phases()]
        count = 1
        while count < len(past) and not any(abs(keys[number - count] - e) < 1e-9 for e in edges):
            count += 1
        if count < 2:
            return None
        return sum(w * x for w, x in zip(lagrange(keys[number - count:number], keys[number]), past[-count:]))

    def run(self, trial, observer, times, delay=0.0):
        """(frames, 3 points) displacements mm, at times minus a delay; (frames, 3 pads) forces N."""
        count = 3 * len(observer[0])
        if self.stepped:
            keys = trial.keys(TRAVEL)
            values = self._course(trial, observer, keys)
            at = lambda t: sum(w * values[k] for k, w in in_time(trial, keys, t))
        else:
            values = self.curve(trial, observer)
            shares = [level / LEVELS for level in range(LEVELS + 1)]
            at = lambda t: np.array(lagrange(shares, trial.share(t))) @ values
        seen = np.array([at(t - delay)[:count] for t in times])
        forces = np.array([at(t)[count:] for t in times])
        return seen, forces

    def samples(self, trial, observer):
        """[(3 points + 3 pads) mm, N] at the end of the hold and half way out: what softens or slides shows on the way out alone."""
        if not self.stepped:
            values = self.curve(trial, observer)
            return [values[-1], values[LEVELS // 2]]
        half = 1.5 * trial.ramp + trial.hold
        way = [t for t in trial.keys(2.0 * TRAVEL) if t < trial.ramp + trial.hold + 1e-9]
        values = self._course(trial, observer, way + [half - 0.25 * trial.ramp, half])
        return [values[len(way) - 1], values[-1]]
