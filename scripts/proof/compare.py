"""Is the truth what it claims to be? One push with every effect, by FEniCSx and by our own judge (`tissuectl solve --model fem`).

usage: cd scripts; python3 -m proof.compare TISSUECTL [KIND]...

For every kind: how far the effect moves markers (mm RMS) and forces (N), and how far ours is from FEniCSx, once on the truth's own mesh, where
the formulas alone differ, and once on the bundle's, where the discretisation does too. What has a history is pushed in 10 ms and held. Gravity and what
shows on the way out only are left to ceiling.py: `solve` pushes from where pads lie at rest, not from where they hang.
"""
import json
import math
import os
import random
import subprocess
import sys
import tempfile

import numpy as np

from .bodies import mesh_of, write_gmsh
from .draw import draw_case
from .make import _bundle_json
from .session import Trial
from .truth import Truth

HOLD = 2.0  # s
KINDS = {
    "none": {}, "viscoelasticity": {"g1": 0.5, "tau1": 0.7}, "strain-stiffening": {"b": 5.0}, "inclusion": {"radius": 12.0, "ratio": 6.0},
    "stiffness-gradient": {"k": 0.02, "axis": [0.6, 0.0, 0.8]}, "anisotropy": {"k": 6.0, "axis": [0.8, 0.6, 0.0]}, "skin": {"stiffness": 60.0},
    "swelling": {"rate": 0.01}, "loose-base": {"radius": 30.0, "k_t": 0.0}, "sliding-actuator": {}}


def settings(kind, numbers):
    """--effect and --set of our own, under our own names."""
    if kind == "none":
        return []
    out = ["--effect", kind]
    given = dict(numbers)
    if kind == "stiffness-gradient":
        given = {"slope": [numbers["k"] * x for x in numbers["axis"]]}
    if kind == "loose-base":
        given = {"center": numbers["center"], "radius": numbers["radius"], "looseness": 1.0}
    if kind == "sliding-actuator":
        given = {"slip": 1.0}
    for name, value in given.items():
        for end, number in zip(("", ".y", ".z"), [value]) if not isinstance(value, list) else zip((".x", ".y", ".z"), value):
            out += ["--set", f"{kind}.{name}{end}={number!r}"]
    return out


def theirs(tissuectl, folder, trial, kind, numbers, mesh):
    """(markers and targets, 3) mm and (3) N by our own judge."""
    command = [tissuectl, "solve", folder, "--model", "fem", "--json", "--load-step", "2", "--push",
               ",".join(f"A{k + 1}={d!r}" for k, d in trial.pads.items()), *settings(kind, numbers)]
    if kind in ("viscoelasticity", "swelling"):
        command += ["--hold", str(HOLD)]
    if mesh:
        command += ["--mesh", mesh]
    answer = json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)
    return answer


def main():
    tissuectl, wanted = sys.argv[1], sys.argv[2:] or list(KINDS)
    case = next(c for c in map(draw_case, range(1, 30)) if c.body.shape == "dome")
    case.assumed = case.true = {"youngs_modulus": 6.0, "poissons_ratio": 0.45}
    lump = case.body.mapped(0.72 * case.body.pads[0][0])[0].tolist()
    trial = Trial("push", {0: 10.0}, 0.01, HOLD, 0.1)
    meshes = {"truth": mesh_of(case.body, 4500, 0.5, (lump, 12.0, 0.65), seed=2), "bundle": mesh_of(case.body, 2000, 0.55, seed=1)}
    with tempfile.TemporaryDirectory() as folder:
        case.trials = case.held_out = []
        json.dump(_bundle_json(case, "compare"), open(os.path.join(folder, "bundle.json"), "w"))
        write_gmsh(meshes["bundle"], os.path.join(folder, "mesh.msh"))
        write_gmsh(meshes["truth"], os.path.join(folder, "truth.msh"))
        places = np.array(list(case.markers.values()) + list(case.targets.values()))
        print(f"{'kind':20s} effect: markers  forces | ours on the truth's mesh: markers  targets  forces | on the bundle's: markers  targets  forces")
        plain = None
        for kind in ["none"] + [k for k in wanted if k != "none"]:
            numbers = dict(KINDS[kind])
            if kind == "inclusion":
                numbers = {"center": lump, **numbers}
            if kind == "loose-base":
                numbers = {"center": [float(x) for x in case.pads[0]["center"][:2] * 0.6] + [0.0], **numbers}
            truth = Truth(meshes["truth"], case.pads, case.true, {} if kind == "none" else {kind: numbers})
            values = truth.samples(trial, truth.solid.observer(places))[0]
            ours, force = values[:-3].reshape(-1, 3), values[-3:]
            plain = (ours, force) if plain is None else plain
            rms = lambda a, b: math.sqrt(((a - b) ** 2).mean())
            n, cells = len(case.markers), []
            for mesh in (os.path.join(folder, "truth.msh"), None):
                answer = theirs(tissuectl, folder, trial, kind, numbers, mesh)
                u = np.array([answer["displacement_mm"][k] for k in case.markers] + [answer["displacement_mm"][k] for k in case.targets])
                f = np.array(answer["pads"]["A1"]["force_N"])
                cells.append(f"{rms(u[:n], ours[:n]):8.4f} {rms(u[n:], ours[n:]):8.4f} {np.linalg.norm(f - force):7.3f}")
            print(f"{kind:20s} {rms(ours[:n], plain[0][:n]):14.3f} {np.linalg.norm(force - plain[1]):7.3f} | {cells[0]:>51s} | {cells[1]:>42s}"
                  f"   of {math.sqrt((ours[:n] ** 2).mean()):.2f} mm, {np.linalg.norm(force):.2f} N", flush=True)


if __name__ == "__main__":
    random.seed(1)
    main()
