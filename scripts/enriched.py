"""Table of scripts/enriched: TRUTH_DIR RESULTS CASE... The truth's targets carry the sensor's noise; its share is taken off."""
import csv
import json
import math
import os
import sys

from proof.scoring import trajectories

NOISE = 0.3  # mm per axis, of the recorded targets
MODELS = ["admm", "admm-found", "kf-admm", "kf-admm-found"]


def errors(truth, frames):
    """{model: root mean square per axis, noise taken off} and {model: [step times]}."""
    square, count = {}, {}
    for row in csv.DictReader(open(frames)):
        if row["contact"] != "1":
            continue
        real = truth[row["trial"]].get(row["target"])
        real = real[int(row["frame"]) - 1] if real else None
        if not real:
            continue
        model = row["model"]
        square[model] = square.get(model, 0.0) + sum((float(row[a + "_mm"]) - v) ** 2 for a, v in zip("xyz", real))
        count[model] = count.get(model, 0) + 3
    return {m: math.sqrt(max(0.0, square[m] / count[m] - NOISE ** 2)) for m in square}


def step_times(runs):
    times = {}
    for row in csv.DictReader(open(runs)):
        times.setdefault(row["model"], []).append((float(row["step_p50_ms"]), float(row["step_p99_ms"])))
    return {m: tuple(sum(t[k] for t in v) / len(v) for k in (0, 1)) for m, v in times.items()}


def main():
    truth_dir, results, cases = sys.argv[1], sys.argv[2], sys.argv[3:]
    print("targets, mm RMS per axis while a pad touches, held-out trials; step times p50/p99, ms")
    print(f"{'case':18s}" + "".join(f"{m:>15s}" for m in MODELS) + "   " + "".join(f"{m:>15s}" for m in MODELS))
    cuts = []
    for case in cases:
        held = json.load(open(os.path.join(truth_dir, case, "truth.json")))["held_out"]
        truth = {t: trajectories(os.path.join(truth_dir, case, t + ".csv")) for t in held}
        error = errors(truth, os.path.join(results, case, "frames.csv"))
        steps = step_times(os.path.join(results, case, "runs.csv"))
        print(f"{case:18s}" + "".join(f"{error.get(m, math.nan):15.3f}" for m in MODELS) + "   "
              + "".join(f"{'%.1f/%.1f' % steps[m]:>15s}" for m in MODELS))
        cuts.append((error["admm"], error["admm-found"], error["kf-admm"], error["kf-admm-found"]))
    mean = [sum(c[k] for c in cuts) / len(cuts) for k in range(4)]
    print(f"{'mean':18s}" + "".join(f"{v:15.3f}" for v in mean))


main()
