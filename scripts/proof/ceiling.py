"""How well the best possible explanation predicts: our own simulation with the true physics and its true numbers, against FEniCSx.

usage: cd scripts; python3 -m proof.ceiling TISSUECTL OUT        of every case of OUT whose physics has names in the library; opens the seals

What is left is our elements' error on the bundle's mesh; where it is much more, the truth is not what it claims, or our law is another.
"""
import json
import os
import subprocess
import sys
import tempfile

from . import scoring, seal


# What stands in tissued-model/1 beside the numbers.
FRAME = {"format": "tissued-model/1", "left": 0.0, "verdict": "missing-physics", "measurement": {"numbers": {}, "slipped": []}}
MEASUREMENT = {"latency", "registration", "marker-slip"}


def spread(numbers):
    """{name: number} with the components of vectors as name.x, name.y, name.z."""
    out = {}
    for name, value in numbers.items():
        out.update({f"{name}.{axis}": x for axis, x in zip("xyz", value)} if isinstance(value, list) else {name: value})
    return out


def named(kind, v):
    """An effect's true numbers under the names of core/effects."""
    if kind == "stiffness-gradient":
        return {"slope": [v["k"] * x for x in v["axis"]]}
    if kind == "softening":
        return {"inverse_r": 1.0 / v["r"], "w0": v["w0"]}
    if kind == "loose-base":
        return {"center": v["center"], "radius": v["radius"], "looseness": 1.0, "normal_held": 1.0}
    if kind == "sliding-actuator":
        return {"slip": 1.0, "across": 0.0}
    return {**v, "g2": 0.0, "tau2": 5.0} if kind == "viscoelasticity" else v


def model(answers, markers):
    """model.json with the truth in it; None where the library has no words for it, or a fault of the measurement is in it."""
    physics = set(answers["kinds"]) - {"parameters"}
    if physics & ({"unknown"} | MEASUREMENT):
        return None
    effects = [{"kind": kind, "parameters": spread(named(kind, v))} for kind, v in answers["numbers"].items()]
    return {**FRAME, "bundle": answers["name"], "effects": effects, "material": {**answers["true"], "density": 1.0},
            "marker_offsets": {name: [0.0, 0.0, 0.0] for name in markers}}


def main():
    tissuectl, folders = sys.argv[1], seal.Folders.at(sys.argv[2])
    print(f"{'case':14s}{'kinds':44s}  held-out targets and markers, mm: assumed physics -> true physics")
    for name in sorted(os.path.splitext(f)[0] for f in os.listdir(folders.seals)):
        answers = seal.opened(folders, name)
        bundle = json.loads(seal.read(os.path.join(folders.bundle(name), "bundle.json")))
        true = model(answers, bundle["markers"])
        if true is None:
            continue
        with tempfile.TemporaryDirectory() as scratch:
            path = os.path.join(scratch, "model.json")
            with open(path, "w") as out:
                json.dump(true, out)
            failed = ""
            for trial in bundle["held_out"]:
                for extra, end in (([], ".assumed.csv"), (["--model", path], ".csv")):
                    command = [tissuectl, "predict", folders.bundle(name), *extra, "--trial", trial, "--out", os.path.join(scratch, trial + end)]
                    failed += subprocess.run(command, check=False, capture_output=True, text=True).stderr
            errors = scoring.held_out_errors(answers, scratch)
        if errors is None:
            print(f"{name:14s}{' '.join(answers['kinds']):44s}  {failed.strip()}", flush=True)
            continue
        cells = ["{:.3f} -> {:.3f}".format(*errors[what]) for what in ("target", "marker")]
        print(f"{name:14s}{' '.join(answers['kinds']) or 'none':44s}  {cells[0]:20s} {cells[1]}", flush=True)


if __name__ == "__main__":
    main()
