"""How right a diagnosis was: the notions of ../../shared/checks/score_diagnosis.py, and the figures that issue 5 asks for.

A kind is *said* where its probability is at least 0.5. A case is *named exactly* where the kinds said beside `parameters` are those of the
truth, and the verdict is right where no physics is missing. Lengths mm; targets are compared where they truly are, markers by how far they
moved since the first frame (they were placed to half a millimetre only).
"""
import json
import math
import os

from . import found_numbers
from .intervals import bootstrap, mean, median, reliability, wilson

MEASUREMENT = {"latency", "registration", "marker-slip"}
SAID = 0.5
NEAR = 8.0  # mm


def verdict_of(kinds):
    if not kinds:
        return "no-mismatch"
    if kinds <= {"parameters"}:
        return "parameters"
    if "unknown" in kinds:
        return "unexplained"
    return "measurement" if kinds <= MEASUREMENT | {"parameters"} else "missing-physics"


def trajectories(path):
    """{label: [(x, y, z) or None a frame]} of a Nexus-style export."""
    with open(path) as source:
        rows = source.read().splitlines()
    begin = rows.index("Trajectories")
    labels = [cell.split(":")[-1] for cell in rows[begin + 2].split(",")[2:] if cell.strip()]
    out = {label: [] for label in labels}
    for row in rows[begin + 5:]:
        if not row.strip():
            break
        cells = row.split(",")[2:]
        for k, label in enumerate(labels):
            xyz = cells[3 * k:3 * k + 3]
            out[label].append([float(v) for v in xyz] if all(v.strip() for v in xyz) else None)
    return out


def _rms(predicted, true, prefix, moved):
    """Per axis, mm; NaN where there is nothing to compare. moved: since the first frame."""
    square = count = 0
    for label, places in true.items():
        if not label.startswith(prefix) or label not in predicted:
            continue
        p0, q0 = (predicted[label][0], places[0]) if moved else ([0.0] * 3, [0.0] * 3)
        for p, q in zip(predicted[label], places):
            if p and q:
                square += sum(((u - a) - (v - b)) ** 2 for u, a, v, b in zip(p, p0, q, q0))
                count += 3
    return math.sqrt(square / count) if count else math.nan


def held_out_errors(answers, folder):
    """{marker, target: (assumed, explained)} over all held-out trials; None where nothing was held out or a prediction is missing."""
    if not answers["held_out"]:
        return None
    pairs = {"M": [], "T": []}
    for trial, true in answers["held_out"].items():
        paths = [os.path.join(folder, trial + end) for end in (".assumed.csv", ".csv")]
        if not all(os.path.exists(path) for path in paths):
            return None
        predicted = [trajectories(path) for path in paths]
        for prefix in pairs:
            pairs[prefix].append([_rms(p, true, prefix, prefix == "M") for p in predicted])
    total = lambda rows: tuple(math.sqrt(mean([row[k] ** 2 for row in rows])) for k in (0, 1))
    return {"marker": total(pairs["M"]), "target": total(pairs["T"])}


def score_case(answers, folder):
    """A row of the table: everything about one case that is counted later."""
    kinds = set(answers["kinds"])
    row = {"name": answers["name"], "seed": answers["seed"], "stratum": answers["stratum"], "shape": answers["shape"], "kinds": sorted(kinds),
           "outside": answers["outside"], "physics": sorted(kinds - {"parameters"}), "has_force": answers["has_force"], "visible": answers["visible"],
           "true_numbers": answers["numbers"], "report": False, "right": False, "said": [], "claimed": [], "verdict": "failed", "findings": [],
           "judged": [], "numbers": [], "place": None, "errors": None, "seconds": math.nan, "fit": {}}
    path = os.path.join(folder, "report.json")
    if not os.path.exists(path):
        return row
    with open(path) as source:
        report = json.load(source)
    physics = kinds - {"parameters"}
    said = {f["kind"] for f in report["findings"] if f.get("probability", 1) >= SAID}
    claimed = said - {"parameters"}
    row.update(report=True, verdict=report["verdict"], said=sorted(said), claimed=sorted(claimed), seconds=report.get("seconds", math.nan),
               right=claimed == physics and (report["verdict"] == verdict_of(kinds) or bool(physics)), fit=report.get("fit", {}),
               complete=report.get("complete", True), processor=_processor_seconds(folder))
    row["findings"] = [(f["kind"], f.get("probability", 1), f["kind"] in kinds) for f in report["findings"] if f["kind"] != "parameters"]
    row["judged"] = [(p, right) for _, p, right in row["findings"]]
    row["judged"] += [(a["probability"], a["kind"] in kinds) for a in report.get("alternatives", []) if "+" not in a["kind"] and a["kind"] != "parameters"]
    row["place"] = _place(answers, report)
    row["numbers"] = _numbers(answers, report, kinds)
    row["errors"] = held_out_errors(answers, folder)
    return row


def _processor_seconds(folder):
    path = os.path.join(folder, "done.json")
    if not os.path.exists(path):
        return None
    with open(path) as source:
        return json.load(source).get("processor_seconds")


def _place(answers, report):
    """How far from the true place the nearest finding that has one is; off: None where none has."""
    true = answers["place"]
    if true is None:
        return None
    placed = [f["where"]["center"] for f in report["findings"] if f["kind"] in ("inclusion", "loose-base", "unknown") and (f.get("where") or {}).get("center")]
    off = min((math.dist(center, true["center"]) for center in placed), default=None)
    return {"kind": true["kind"], "off": off, "radius": true["radius"], "near": off is not None and off <= NEAR,
            "inside": off is not None and off <= max(NEAR, true["radius"])}


def _numbers(answers, report, kinds):
    rows = []
    for finding in report["findings"]:
        kind = finding["kind"]
        true = answers["true"] if kind == "parameters" else answers["numbers"].get(kind)
        if kind in kinds and true is not None:
            rows += [{"kind": kind, **row} for row in found_numbers.compare(kind, finding, true)]
    return rows


def confusion(rows):
    """{true kind: {said kind: count}}; of a case every true kind, or `none` or `parameters`; said: itself, else what was said wrongly, else none."""
    table = {}
    for row in rows:
        physics, claimed = set(row["physics"]), set(row["claimed"])
        wrong = sorted(claimed - physics) or (["none"] if row["report"] else ["failed"])
        for kind in sorted(physics) or ["parameters" if "parameters" in row["kinds"] else "none"]:
            said = [kind] if kind in claimed else wrong
            if kind in ("none", "parameters"):
                said = sorted(claimed) or ([kind] if row["verdict"] == verdict_of(set(row["kinds"])) else [row["verdict"]])
            for name in said:
                table.setdefault(kind, {})[name] = table.setdefault(kind, {}).get(name, 0) + 1
    return table


def _share(hits, count, limit, at_least):
    low, high = wilson(hits, count)
    value = hits / count if count else math.nan
    return {"value": value, "low": low, "high": high, "hits": hits, "count": count, "limit": limit, "at_least": at_least,
            "met": count > 0 and (value >= limit if at_least else value <= limit)}


def _cut(row):
    """Share by which the error of concealed targets fell."""
    assumed, explained = row["errors"]["target"]
    return 1.0 - explained / assumed if assumed > 0 else math.nan


def figures(rows):
    """{name: {value, low, high, limit, at_least, met, ...}}: what issue 5 says must be shown, in its order."""
    out = {}
    out["named exactly"] = _share(sum(r["right"] for r in rows), len(rows), 0.85, True)
    nulls = [r for r in rows if not r["physics"]]
    out["false alarms"] = _share(sum(bool(r["claimed"]) for r in nulls), len(nulls), 0.05, False)
    outside = [r for r in rows if r["outside"]]
    out["confident wrong names outside the library"] = _share(sum(bool(set(r["claimed"]) - {"unknown"}) for r in outside), len(outside), 0.0, False)
    placed = [r["place"] for r in rows if r["place"]]
    out["places within 8 mm"] = _share(sum(p["near"] for p in placed), len(placed), 0.9, True)
    inside = [p for p in placed if p["kind"] != "unknown"]
    out["places within 8 mm, kinds of the library"] = _share(sum(p["near"] for p in inside), len(inside), 0.9, True)
    brier = [[(p - right) ** 2 for _, p, right in r["findings"]] for r in rows]
    low, high = bootstrap(brier, mean)
    value = mean([v for group in brier for v in group])
    out["Brier score"] = {"value": value, "low": low, "high": high, "limit": 0.08, "at_least": False, "met": value <= 0.08,
                          "count": sum(map(len, brier))}
    missing = [r for r in rows if set(r["physics"]) - MEASUREMENT and r["errors"]]
    cuts = [[_cut(r)] for r in missing]
    low, high = bootstrap(cuts, median)
    value = median([c[0] for c in cuts])
    out["targets' error cut, median"] = {"value": value, "low": low, "high": high, "limit": 0.6, "at_least": True, "met": value >= 0.6, "count": len(cuts)}
    return out


def summary(rows):
    judged = [j for r in rows for j in r["judged"]]
    stopped = sum(row["report"] and not row["complete"] for row in rows)
    return {"figures": figures(rows), "confusion": confusion(rows), "reliability": reliability(judged), "count": len(rows), "stopped": stopped}
