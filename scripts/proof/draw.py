"""What a case is, drawn from its seed: body, pads, markers, trials, what is true and what is assumed.

Every 30 seeds (1 to 30, 31 to 60, ...) hold each of `STRATA` once, in an order that depends on them.
"""
import math
import random

import numpy as np

from .bodies import Body
from .session import Trial

SINGLES = ["viscoelasticity", "strain-stiffening", "inclusion", "stiffness-gradient", "anisotropy", "skin", "softening", "swelling", "gravity",
           "loose-base", "sliding-actuator", "latency", "registration", "marker-slip"]
# Such pairs alone whose laws do not act on each other in a way that the contract leaves open.
PAIRS = [("viscoelasticity", "inclusion"), ("gravity", "inclusion"), ("skin", "gravity"), ("viscoelasticity", "stiffness-gradient"),
         ("viscoelasticity", "loose-base"), ("inclusion", "latency"), ("skin", "inclusion"), ("stiffness-gradient", "gravity"),
         ("anisotropy", "latency"), ("sliding-actuator", "viscoelasticity"), ("inclusion", "marker-slip"), ("strain-stiffening", "gravity")]
# Without forces the stiffness of a body that is moved by poses does not show at all, and how it changes hardly.
SHOWN_BY_FORCE = {"viscoelasticity", "strain-stiffening", "softening", "permanent-set"}
OUTSIDE = ["growing-lump", "pulsating-cavity", "pulling-cable", "permanent-set"]
STRATA = [("null", ())] * 3 + [("parameters", ())] * 3 + [("single", (kind,)) for kind in SINGLES] + [("single", ("inclusion",))] * 2 \
    + [("pair", ())] * 4 + [("outside", (kind,)) for kind in OUTSIDE]


def stratum(seed):
    block, place = divmod(seed - 1, len(STRATA))
    order = list(STRATA)
    random.Random(f"strata {block}").shuffle(order)
    return order[place]


class Case:
    """seed, stratum, body, pads [{center, normal, direction, radius}], kinds, numbers {kind: {...}}, assumed and true (E kPa, nu), trials,
    held_out, rate Hz, has_force, gaps, markers {name: nominal place}, targets {name: place}; places in mm, tissue."""


def _logarithmic(rng, low, high):
    return math.exp(rng.uniform(math.log(low), math.log(high)))


def _direction(rng):
    v = np.array([rng.gauss(0, 1) for _ in range(3)])
    return v / np.linalg.norm(v)


def _body(rng):
    shape = rng.choice(["block", "dome", "organ"])
    a = rng.uniform(58, 76)
    if shape == "block":
        return Body(shape, (a, a * rng.uniform(0.65, 0.85), a * rng.uniform(0.75, 0.95)))
    size = (a, a * rng.uniform(0.8, 1.0), a * rng.uniform(0.72, 0.9))
    return Body(shape, size, rng.uniform(0.08, 0.2), rng.uniform(0.1, 0.28)) if shape == "organ" else Body(shape, size)


def _pads(rng, body):
    count, tries = rng.randint(3, 4), 0
    radius = rng.uniform(12.5, 15.5)
    while len(body.pads) < count:
        tries += 1
        if tries > 400:
            count = max(2, len(body.pads))
            continue
        p, n = body.skin_point(rng.uniform(0.0, 1.0) if body.shape == "block" else rng.uniform(0.25, 0.66), rng.uniform(0, 2 * math.pi))
        if body.shape == "block":
            p = np.array([body.size[0] * rng.uniform(-1, 1), body.size[1] * rng.uniform(-1, 1), body.size[2]])
            if any(abs(p[k]) > body.size[k] - radius - 8 for k in (0, 1)):
                continue
        elif p[2] < radius + 6:
            continue
        if all(np.linalg.norm(p - q) > 2.5 * radius for q, _, _ in body.pads):
            body.pads.append((p, n, radius))


def _markers(rng, body):
    """Nominal places, spread over the skin clear of pads."""
    wanted, places = rng.randint(15, 25), []
    for spacing in (22.0, 19.0, 16.0, 13.0, 10.0, 8.0):
        for _ in range(1500):
            if len(places) == wanted:
                return places
            v = rng.uniform(0, 2 * math.pi)
            if body.shape != "block":
                p = body.skin_point(rng.uniform(0.0, 0.88) ** 0.7, v)[0]
            elif rng.random() < 0.7:
                p = np.array([body.size[0] * rng.uniform(-0.95, 0.95), body.size[1] * rng.uniform(-0.95, 0.95), body.size[2]])
            else:
                side, along = rng.choice([0, 1]), rng.uniform(-0.9, 0.9)
                p = np.array([body.size[0] * along, body.size[1] * along, body.size[2] * rng.uniform(0.35, 0.92)])
                p[side] = body.size[side] * rng.choice([-1, 1])
            if any(np.linalg.norm(p - c) < r + 7.0 for c, _, r in body.pads) or any(np.linalg.norm(p - q) < spacing for q in places):
                continue
            places.append(p)
    return places


def _inside(rng, body, least):
    """A place at least so deep, in the upper three quarters of the body, before the map."""
    for _ in range(5000):
        p = np.array([body.size[0] * rng.uniform(-0.7, 0.7), body.size[1] * rng.uniform(-0.7, 0.7), body.size[2] * rng.uniform(0.25, 0.85)])
        if body.depth(p) > least:
            return p
    return np.array([0.0, 0.0, 0.5 * body.size[2]])


def _ball(rng, body, low, high):
    """A lump that a pad can feel: not too deep, and not at the base."""
    radius = rng.uniform(low, high)
    for _ in range(300):
        p = _inside(rng, body, radius + 2.0)
        if p[2] > 1.3 * radius and min(np.linalg.norm(p - c) for c, _, _ in body.pads) < radius + 18.0:
            break
    return {"center": body.mapped(p)[0].tolist(), "radius": radius}


def _numbers(rng, kind, case):
    """Sizes like those of the open recordings, scaled with the tissue's own stiffness."""
    body, E = case.body, case.true["youngs_modulus"]
    draw = {
        "viscoelasticity": lambda: {"g1": rng.uniform(0.3, 0.6), "tau1": _logarithmic(rng, 0.25, 1.6)},
        "strain-stiffening": lambda: {"b": _logarithmic(rng, 3.0, 9.0)},
        "inclusion": lambda: {**_ball(rng, body, 10.5, 15.0), "ratio": _logarithmic(rng, 5.0, 10.0) if rng.random() < 0.7 else _logarithmic(rng, 0.1, 0.2)},
        "stiffness-gradient": lambda: {"k": rng.uniform(0.014, 0.03), "axis": _direction(rng).tolist()},
        "anisotropy": lambda: {"k": E * rng.uniform(0.6, 1.5), "axis": _direction(rng).tolist()},
        "skin": lambda: {"stiffness": E * _logarithmic(rng, 5.0, 14.0)},
        "softening": lambda: {"r": rng.uniform(1.2, 2.0), "w0": E * _logarithmic(rng, 0.003, 0.02)},
        "swelling": lambda: {"rate": rng.choice([-1, 1]) * rng.uniform(0.006, 0.014)},
        "gravity": lambda: {"gravity": (rng.uniform(0.6, 1.1) * _direction(rng)).tolist()},
        "loose-base": lambda: _loose(rng, body),
        "sliding-actuator": lambda: {},
        "latency": lambda: {"seconds": rng.uniform(0.05, 0.12)},
        "registration": lambda: {"rotation": (rng.uniform(2.5, 6.0) * _direction(rng)).tolist(), "shift": (rng.uniform(1.0, 4.0) * _direction(rng)).tolist()},
        "marker-slip": lambda: {"count": rng.randint(1, 2), "size": rng.uniform(1.5, 3.0)},
        "growing-lump": lambda: {**_ball(rng, body, 9.0, 13.0), "growth": rng.uniform(0.5, 1.0), "seconds": rng.uniform(1.5, 3.0)},
        "pulsating-cavity": lambda: {**_ball(rng, body, 9.0, 13.0), "swing": rng.uniform(0.35, 0.7), "period": rng.uniform(0.8, 1.6)},
        "pulling-cable": lambda: _cable(rng, body, E),
        "permanent-set": lambda: {"g": rng.uniform(0.5, 0.7), "limit": _logarithmic(rng, 0.05, 0.12)},
    }
    return draw[kind]()


def _loose(rng, body):
    angle, far = rng.uniform(0, 2 * math.pi), rng.uniform(0.4, 0.7)
    center = body.mapped([body.size[0] * far * math.cos(angle), body.size[1] * far * math.sin(angle), 0.0])[0]
    return {"center": center.tolist(), "radius": rng.uniform(0.42, 0.55) * body.size[0], "k_t": rng.choice([0.0, 0.01])}


def _cable(rng, body, E):
    for _ in range(300):
        a, b = _inside(rng, body, 9.0), _inside(rng, body, 9.0)
        if 25.0 < np.linalg.norm(a - b) < 50.0:
            break
    a, b = body.mapped(a)[0], body.mapped(b)[0]
    return {"from": a.tolist(), "to": b.tolist(), "radius": 0.5 * float(np.linalg.norm(a - b)), "thickness": 7.0,
            "center": (0.5 * (a + b)).tolist(), "tension": E * rng.uniform(1.0, 1.8), "seconds": rng.uniform(1.0, 2.5)}


def _trials(rng, case, scale):
    body, pads = case.body, list(range(len(case.pads)))
    rng.shuffle(pads)
    depth = lambda low, high: scale * body.size[2] * rng.uniform(low, high)
    rest = lambda: rng.uniform(0.3, 0.6)

    def trial(kind, own, name):
        ramp = {"slow": rng.uniform(0.9, 2.2), "fast": rng.uniform(0.22, 0.4)}[kind]
        low, high = (0.15, 0.19) if len(own) > 1 or kind == "fast" else (0.18, 0.25)
        moved = {k: depth(low, high) for k in sorted(own)}
        name = name or "a" + "".join(str(k + 1) for k in moved) + f"-{max(moved.values()):.0f}" + ("-fast" if kind == "fast" else "")
        return Trial(name, moved, ramp, rng.uniform(1.4, 2.4), rest())

    plan = [("slow", pads[:1]), ("fast", pads[1:2]), ("slow", pads[2:3] if len(pads) == 3 or rng.random() < 0.5 else pads[2:4])]
    if len(pads) == 2:
        plan[2] = ("slow", pads[1:2])
    case.trials, names = [], set()
    for kind, own in plan:
        made = trial(kind, own, None)
        while made.name in names:
            made.name += "b"
        names.add(made.name)
        case.trials.append(made)
    case.held_out = [trial("slow", pads[:2], "held-a" + "".join(str(k + 1) for k in sorted(pads[:2])))]


def draw_case(seed, scale=1.0, redraw=0):
    """scale: of all depths; redraw: another body of the same stratum, where the first could not be meshed, solved or seen."""
    rng = random.Random(f"case {seed} {redraw}")
    case = Case()
    case.seed = seed
    case.stratum, kinds = stratum(seed)
    if case.stratum == "pair":
        kinds = rng.choice(PAIRS)
    case.body = _body(rng)
    _pads(rng, case.body)
    case.assumed = {"youngs_modulus": round(_logarithmic(rng, 4.0, 12.0), 2), "poissons_ratio": rng.choice([0.44, 0.45, 0.46])}
    case.true = dict(case.assumed)
    if case.stratum == "parameters" or (case.stratum != "null" and rng.random() < 0.7):
        factor = _logarithmic(rng, 1.25, 1.6)
        case.true["youngs_modulus"] *= factor if rng.random() < 0.5 else 1.0 / factor
        case.true["poissons_ratio"] = rng.uniform(0.40, 0.475)
    case.kinds = list(kinds)
    case.numbers = {kind: _numbers(rng, kind, case) for kind in kinds}
    case.rate = rng.choice([25.0, 40.0, 50.0])
    case.has_force = case.stratum == "parameters" or bool(SHOWN_BY_FORCE & set(kinds)) or rng.random() < 0.75
    case.gaps = rng.uniform(0.08, 0.3) if rng.random() < 0.5 else 0.0
    case.pads = []
    tilt = [rng.uniform(0, 0.12) * _direction(rng) for _ in case.body.pads]
    _, normals = zip(*[_mapped_pad(case.body, pad) for pad in case.body.pads])
    for (center, _, radius), normal, tilted in zip(case.body.pads, normals, tilt):
        direction = -normal + tilted
        case.pads.append({"center": case.body.mapped(center)[0], "normal": normal, "direction": direction / np.linalg.norm(direction), "radius": radius})
    case.markers = {f"M{k + 1:02d}": p for k, p in enumerate(case.body.mapped(np.array(_markers(rng, case.body))))}
    case.targets = {f"T{k + 1}": case.body.mapped(_inside(rng, case.body, 9.0))[0] for k in range(4)}
    _trials(rng, case, scale)
    case.noise = {"marker": 0.1, "target": 0.3, "force": 0.01}
    return case


def _mapped_pad(body, pad):
    """Centre and outward normal of a pad's plate where the body was bent."""
    center, normal, _ = pad
    across = np.cross(normal, [0.0, 0.0, 1.0] if abs(normal[2]) < 0.9 else [1.0, 0.0, 0.0])
    across /= np.linalg.norm(across)
    other = np.cross(normal, across)
    p = body.mapped([center, center + 1e-3 * across, center + 1e-3 * other])
    n = np.cross(p[1] - p[0], p[2] - p[0])
    return p[0], n / np.linalg.norm(n)
