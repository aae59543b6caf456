"""Makes one case: its bundle, and its answers for the seal.

usage: python3 -m proof.make SEED NAME BUNDLE_FOLDER SEALED_FILE SALT
"""
import hashlib
import json
import math
import os
import random
import sys
import time

import numpy as np

from .bodies import mesh_of, write_gmsh
from .draw import OUTSIDE, SHOWN_BY_FORCE, draw_case
from .newton import NoEquilibrium
from .session import nexus_csv, rotation_matrix
from .truth import STEPPED, Truth

COARSE, FINE = (1500, 2500), 3600  # tetrahedra of the bundle's mesh and of the truth's
SCATTER = 0.3                      # mm per axis: markers are placed to about half a millimetre
SEEN_MM, SEEN_SD = 0.15, 8.0        # an effect shows in the markers by so much (RMS of holds), or, if it is one of SHOWN_BY_FORCE, so many times the forces' noise
MEASUREMENT = {"latency", "registration", "marker-slip"}


class NotSeen(Exception):
    pass


def _on_skin(mesh, places):
    """The nearest points of the mesh's skin, (n, 3)."""
    a, b, c = (mesh.points[mesh.facets["skin"][:, k]] for k in range(3))
    out = []
    for p in places:
        # By dense sampling of each near facet: 0.1 mm is enough for a marker that is placed to half a millimetre.
        near = np.argsort(np.linalg.norm((a + b + c) / 3.0 - p, axis=1))[:12]
        best = None
        for s in np.linspace(0, 1, 41):
            for t in np.linspace(0, 1 - s, max(2, int(41 * (1 - s)))):
                q = a[near] + s * (b[near] - a[near]) + t * (c[near] - a[near])
                d = np.linalg.norm(q - p, axis=1)
                k = int(d.argmin())
                if best is None or d[k] < best[0]:
                    best = (d[k], q[k])
        out.append(best[1])
    return np.array(out)


def _lump_of(case):
    for kind in ("inclusion", "growing-lump", "pulsating-cavity", "pulling-cable"):
        if kind in case.numbers:
            v = case.numbers[kind]
            return v["center"], v["radius"], 0.65
    return None


class Faults:
    """What the measurement does to true places: latency s, registration, slipped markers {name: (trial, time s, shift mm)}."""

    def __init__(self, case, rng, mesh):
        n = case.numbers
        self.delay = n.get("latency", {}).get("seconds", 0.0)
        spec = n.get("registration")
        self.rotation = np.array(rotation_matrix(spec["rotation"])) if spec else np.eye(3)
        self.shift = np.array(spec["shift"]) if spec else np.zeros(3)
        self.slips = {}
        if "marker-slip" in n:
            trial = rng.randrange(len(case.trials))
            inside = case.trials[trial]
            at = rng.uniform(0.2, 0.7) * inside.duration if trial == 0 or rng.random() < 0.5 else 0.0
            for name in rng.sample(sorted(case.markers), n["marker-slip"]["count"]):
                along = _tangent(mesh, case.markers[name], rng)
                self.slips[name] = (trial, at, n["marker-slip"]["size"] * along)

    def seen(self, places, names, trial, times):
        """(frames, n, 3) where the tracker has them. trial: index; a held-out one comes after all."""
        out = places @ self.rotation.T + self.shift
        for name, (since, at, shift) in self.slips.items():
            late = np.array([trial > since or (trial == since and t >= at) for t in times])
            out[late, names.index(name)] += shift
        return out


def _tangent(mesh, place, rng):
    facets = mesh.facets["skin"]
    k = int(np.linalg.norm(mesh.points[facets].mean(1) - place, axis=1).argmin())
    p = mesh.points[facets[k]]
    n = np.cross(p[1] - p[0], p[2] - p[0])
    n /= np.linalg.norm(n)
    v = np.array([rng.gauss(0, 1) for _ in range(3)])
    v -= (v @ n) * n
    return v / np.linalg.norm(v)


def _visibility(case, mesh):
    """{kind: {marker_mm, force_N}}: RMS between the body with and without an effect, at the ends of holds or half way out: a rehearsal
    on the bundle's mesh.

    Of a pair each alone, where that has no history; else both together.
    """
    kinds, count = [kind for kind in case.kinds if kind not in MEASUREMENT], 3 * len(case.markers)

    def samples(numbers):
        truth = Truth(mesh, case.pads, case.true, numbers)
        observer = truth.solid.observer(list(case.markers.values()))
        out = [truth.samples(trial, observer) for trial in case.trials]
        truth.newton.close()
        return out

    seen, without = {}, samples({}) if kinds else []
    for kind in kinds:
        alone = len(kinds) == 1 or kind not in STEPPED
        numbers = {kind: case.numbers[kind]} if alone else {k: case.numbers[k] for k in kinds}
        apart = [[one - other for one, other in zip(*both)] for both in zip(samples(numbers), without)]
        rms = lambda cut: max(math.sqrt(np.mean([(cut(own[when]) ** 2).mean() for own in apart])) for when in (0, 1))
        seen[kind] = {"marker_mm": rms(lambda values: values[:count]), "force_N": rms(lambda values: values[count:])}
    return seen


def _check_seen(case, seen):
    for kind, size in seen.items():
        by_force = kind in SHOWN_BY_FORCE and case.has_force and size["force_N"] >= SEEN_SD * case.noise["force"]
        if size["marker_mm"] < SEEN_MM and not by_force:
            raise NotSeen(f"{kind} moves markers by {size['marker_mm']:.3f} mm only")


def _record(case, rng, fine):
    """{trial: (times of frames, true places of markers and targets (frames, n, 3), forces (frames, pads, 3), places of pads)}, factorisations."""
    nominal = np.array(list(case.markers.values()))
    scattered = nominal + np.array([[rng.gauss(0, SCATTER) for _ in range(3)] for _ in nominal])
    places = np.concatenate([_on_skin(fine, scattered), np.array(list(case.targets.values()))])
    numbers = {k: v for k, v in case.numbers.items() if k not in MEASUREMENT}
    truth = Truth(fine, case.pads, case.true, numbers)
    observer = truth.solid.observer(places)
    recorded = {}
    for trial in case.trials + case.held_out:
        times = trial.frames(case.rate)
        seen, forces = truth.run(trial, observer, times, case.numbers.get("latency", {}).get("seconds", 0.0))
        at = places + seen.reshape(len(times), -1, 3)
        pads = {k: np.array([case.pads[k]["center"] + truth.sag(k) + trial.share(t) * d * case.pads[k]["direction"] for t in times])
                for k, d in trial.pads.items()}
        recorded[trial.name] = (times, at, forces.reshape(len(times), -1, 3), pads)
    factorisations = truth.newton.factorisations
    truth.newton.close()
    return recorded, factorisations


def _lose(case, rng, at):
    """(frames, markers) true where a marker is not seen."""
    frames, count = at.shape[0], len(case.markers)
    lost = np.zeros((frames, count), bool)
    for m in range(count):
        if rng.random() < case.gaps:
            begin, length = int(rng.uniform(0, 0.9) * frames), int(rng.uniform(0.1, 0.4) * frames)
            lost[begin:begin + length, m] = True
    return lost


def _bundle_json(case, name):
    vector = lambda v, digits=6: [round(float(x), digits) for x in v]
    return {
        "format": "tissue-recording/1", "name": name,
        "units": {"length": "mm", "time": "s", "stress": "kPa", "force": "N", "density": "g/cm3", "gravity": "g0"},
        "mesh": "mesh.msh", "fixed": "base", "surface": "skin",
        "material": {"model": "neo-hookean", **case.assumed, "density": 1.0}, "gravity": [0, 0, 0], "subject": "phantom", "rate": case.rate,
        "actuators": {f"A{k + 1}": {"surface": f"A{k + 1}", "center": vector(pad["center"]), "normal": vector(pad["normal"], 9),
                                    "direction": vector(pad["direction"], 9), "radius": round(pad["radius"], 3), "attachment": "glued"}
                      for k, pad in enumerate(case.pads)},
        "markers": {k: vector(p, 3) for k, p in case.markers.items()}, "marker_sets": {},
        "targets": {k: vector(p, 3) for k, p in case.targets.items()},
        "noise": case.noise, "trials": [t.name for t in case.trials], "held_out": [t.name for t in case.held_out]}


def _write_bundle(case, name, folder, recorded, faults, rng, mesh):
    os.makedirs(folder, exist_ok=True)
    write_gmsh(mesh, os.path.join(folder, "mesh.msh"))
    names, held = list(case.markers), {}
    for index, trial in enumerate(case.trials + case.held_out):
        times, at, forces, pads = recorded[trial.name]
        blind = trial in case.held_out
        everything = faults.seen(at, names + list(case.targets), index, times)
        positions = {}
        if blind:
            held[trial.name] = {label: np.round(everything[:, k], 4).tolist() for k, label in enumerate(names + list(case.targets))}
        else:
            lost = _lose(case, rng, at)
            noise = np.array([rng.gauss(0, case.noise["marker"]) for _ in range(at.shape[0] * len(names) * 3)]).reshape(at.shape[0], -1, 3)
            for k, label in enumerate(names):
                positions[label] = [None if gone else p for gone, p in zip(lost[:, k], everything[:, k] + noise[:, k])]
        for k, way in pads.items():
            positions[f"A{k + 1}"] = list(way)
        pushed = None
        if case.has_force and not blind:
            pushed = {f"A{k + 1}": forces[:, i] + np.array([[rng.gauss(0, case.noise["force"]) for _ in range(3)] for _ in times])
                      for i, k in enumerate(trial.pads)}
        with open(os.path.join(folder, trial.name + ".csv"), "w") as out:
            out.write(nexus_csv(case.rate, "phantom", len(times), pushed, positions))
    with open(os.path.join(folder, "bundle.json"), "w") as out:  # last: a bundle with it is whole
        json.dump(_bundle_json(case, name), out, indent=1)
    return held


def _place(case):
    """Where a finding should be: (kind, center, radius) or None."""
    for kind in ("inclusion", "loose-base", "growing-lump", "pulsating-cavity", "pulling-cable"):
        if kind in case.numbers:
            v = case.numbers[kind]
            return {"kind": "unknown" if kind in OUTSIDE else kind, "center": v["center"], "radius": v["radius"]}
    return None


def _answers(case, name, seen, held, faults):
    differs = any(abs(math.log(case.true[k] / case.assumed[k])) > 1e-9 for k in case.assumed)
    kinds = ["unknown" if k in OUTSIDE else k for k in case.kinds] + (["parameters"] if differs else [])
    numbers = {k: dict(v) for k, v in case.numbers.items()}
    if "marker-slip" in numbers:
        numbers["marker-slip"]["markers"] = {k: {"trial": t, "time": at, "shift": v.tolist()} for k, (t, at, v) in faults.slips.items()}
    return {"format": "tissue-proof-answers/1", "name": name, "seed": case.seed, "stratum": case.stratum, "shape": case.body.shape,
            "kinds": kinds, "outside": [k for k in case.kinds if k in OUTSIDE], "numbers": numbers, "true": case.true, "assumed": case.assumed,
            "place": _place(case), "visible": seen, "has_force": case.has_force, "gaps": case.gaps, "held_out": held}


def _rehearsed(seed):
    """A case whose pushes have an equilibrium and whose effects show, its bundle's mesh, how they show; [why others were not taken]."""
    trouble = []
    for redraw in range(20):
        for scale in (1.0, 0.85):
            case = draw_case(seed, scale, redraw)
            try:
                coarse = mesh_of(case.body, random.Random(f"mesh {seed} {redraw}").randint(*COARSE), 0.55, seed=1)
                seen = _visibility(case, coarse)
                _check_seen(case, seen)
                yield case, coarse, seen, list(trouble)
                trouble.append("no equilibrium on the fine mesh")
            except NoEquilibrium:
                trouble.append("no equilibrium")
            except (NotSeen, ValueError) as error:
                trouble.append(str(error))
                break
    raise SystemExit(f"seed {seed}: could not be made: {trouble}")


def make(seed, name, folder, sealed, salt):
    """Writes the bundle, then the sealed answers; returns their SHA-256."""
    began = time.process_time()
    for case, coarse, seen, trouble in _rehearsed(seed):
        rng = random.Random(f"session {seed} {len(trouble)}")
        try:
            fine = mesh_of(case.body, FINE, 0.6, _lump_of(case), seed=2)
            recorded, factorisations = _record(case, rng, fine)
        except (NoEquilibrium, ValueError):
            continue
        faults = Faults(case, rng, fine)
        held = _write_bundle(case, name, folder, recorded, faults, rng, coarse)
        answers = _answers(case, name, seen, held, faults)
        answers.update(salt=salt, redraws=trouble, seconds=time.process_time() - began, tets=[len(coarse.tets), len(fine.tets)],
                       factorisations=factorisations)
        text = json.dumps(answers)
        with open(sealed + ".part", "w") as out:
            os.chmod(sealed + ".part", 0o600)
            out.write(text)
        os.replace(sealed + ".part", sealed)
        return hashlib.sha256(text.encode()).hexdigest()


if __name__ == "__main__":
    print(make(int(sys.argv[1]), *sys.argv[2:]))
