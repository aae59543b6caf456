"""How far the numbers of a rightly named finding are from the truth, each in words a person can judge."""
import math


def _value(finding, name):
    spec = finding.get("parameters", {}).get(name)
    return None if spec is None else spec["value"]


def _sd(finding, name):
    spec = finding.get("parameters", {}).get(name)
    return None if spec is None else spec.get("sd")


def _norm(v):
    return math.sqrt(sum(x * x for x in v))


def _ratio(name, unit=""):
    def compare(finding, true):
        found, real = _value(finding, name), true.get(name)
        if found is None or not real:
            return None
        return {"what": name, "true": real, "found": found, "error": found / real - 1.0, "relative": True, "unit": unit, "sd": _sd(finding, name)}
    return compare


def _distance(name, unit):
    def compare(finding, true):
        found = _value(finding, name)
        if found is None or name not in true:
            return None
        return {"what": name, "true": true[name], "found": found, "error": math.dist(found, true[name]), "relative": False, "unit": unit}
    return compare


def _angle(finding, true):
    """Between axes, whose sign means nothing, degrees."""
    found = _value(finding, "axis")
    if found is None or _norm(found) == 0.0:
        return None
    cosine = abs(sum(a * b for a, b in zip(found, true["axis"]))) / _norm(found) / _norm(true["axis"])
    return {"what": "axis", "true": true["axis"], "found": found, "error": math.degrees(math.acos(min(1.0, cosine))), "relative": False, "unit": "deg"}


def _slope(finding, true):
    """Of a stiffness that varies: the vector k axis, relative to its length."""
    k, axis = _value(finding, "k"), _value(finding, "axis")
    if k is None or axis is None:
        return None
    found, real = [k * x for x in axis], [true["k"] * x for x in true["axis"]]
    return {"what": "k axis", "true": real, "found": found, "error": math.dist(found, real) / _norm(real), "relative": True, "unit": ""}


def _slipped(finding, true):
    """Share of markers that are in one of both sets only."""
    found, real = set(_value(finding, "markers") or []), set(true["markers"])
    return {"what": "markers", "true": sorted(real), "found": sorted(found), "error": len(found ^ real) / len(real), "relative": True, "unit": ""}


COMPARED = {
    "parameters": [_ratio("youngs_modulus", "kPa"), _ratio("poissons_ratio")],
    "viscoelasticity": [_ratio("g1"), _ratio("tau1", "s")],
    "strain-stiffening": [_ratio("b")],
    "inclusion": [_distance("center", "mm"), _ratio("radius", "mm"), _ratio("ratio")],
    "stiffness-gradient": [_slope],
    "anisotropy": [_ratio("k", "kPa"), _angle],
    "skin": [_ratio("stiffness", "kPa mm")],
    "softening": [_ratio("r"), _ratio("w0", "kPa")],
    "swelling": [_ratio("rate", "1/s")],
    "gravity": [_distance("gravity", "g0")],
    "loose-base": [_distance("center", "mm"), _ratio("radius", "mm")],
    "latency": [_ratio("seconds", "s")],
    "registration": [_distance("rotation", "deg"), _distance("shift", "mm")],
    "marker-slip": [_slipped],
}


def compare(kind, finding, true):
    """[{what, true, found, error, relative, unit, sd?}] of a finding and the true numbers of its kind."""
    return [row for row in (f(finding, true) for f in COMPARED.get(kind, [])) if row is not None]
