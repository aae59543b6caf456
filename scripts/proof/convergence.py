"""How much of the truth is its mesh? A case's body with nothing missing, pushed as the case's trials are, on meshes that differ in nothing but how they were drawn.

usage: cd scripts; python3 -m proof.convergence SEED [TIMES]...

First the bundle's mesh, then two of the truth's size, then of TIMES as many tetrahedra: the pads' areas, and how far markers and targets are
from where the meshes before have them at the ends of the holds (mm RMS over trials). Nothing that a session with nothing missing shows is known better than that.
"""
import sys

import numpy as np

from .bodies import mesh_of
from .make import FINE, _on_skin, _rehearsed
from .truth import Truth


def area(mesh, group):
    a, b, c = (mesh.points[mesh.facets[group][:, k]] for k in range(3))
    return 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum()


def held(case, mesh):
    """(trials, markers and targets, 3) mm of displacement at the ends of the holds."""
    places = np.concatenate([_on_skin(mesh, np.array(list(case.markers.values()))), np.array(list(case.targets.values()))])
    truth = Truth(mesh, case.pads, case.true, {})
    observer = truth.solid.observer(places)
    ends = [truth.samples(trial, observer)[0][:3 * len(places)] for trial in case.trials]
    truth.newton.close()
    return np.array(ends).reshape(len(ends), -1, 3)


def main():
    seed, times = int(sys.argv[1]), [float(x) for x in sys.argv[2:]]
    case, coarse, _, _ = next(_rehearsed(seed))
    rms = lambda apart: np.sqrt((apart ** 2).mean())
    wanted = [("the bundle's", None, 0), ("the truth's", 1.0, 2), ("another of the truth's size", 1.0, 5)]
    wanted += [(f"{x:g} times as fine", x, 3) for x in times]
    before = []
    for label, share, drawn in wanted:
        mesh = coarse if share is None else mesh_of(case.body, round(share * FINE), 0.6, seed=drawn)
        there = held(case, mesh)
        areas = ", ".join(f"{area(mesh, f'A{k + 1}'):.0f}" for k in range(len(case.pads)))
        print(f"{label}: {len(mesh.tets)} tetrahedra, pads of {areas} mm2", flush=True)
        for other, known in before:
            apart, count = there - known, len(case.markers)
            print(f"    from {other}: markers {rms(apart[:, :count]):.3f}, targets {rms(apart[:, count:]):.3f}", flush=True)
        before.append((label, there))


if __name__ == "__main__":
    main()
