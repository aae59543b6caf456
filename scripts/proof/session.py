"""A session: how pads move, when the truth is solved along their way, and what a tracker makes of it. Times s, lengths mm."""
import bisect
import math


class Trial:
    """pads: {pad: depth mm}; ramp, hold, rest: s of the way in and out, of the hold, and of what follows."""

    def __init__(self, name, pads, ramp, hold, rest):
        self.name, self.pads, self.ramp, self.hold, self.rest = name, pads, ramp, hold, rest
        self.duration = 2 * ramp + hold + rest

    def share(self, t):
        """Of the depth, at a time: 0 to 1."""
        return max(0.0, min(1.0, t / self.ramp, (2 * self.ramp + self.hold - t) / self.ramp))

    def phases(self):
        """[(begin, end)] of way in, hold, way out, rest."""
        ends = [0.0, self.ramp, self.ramp + self.hold, 2 * self.ramp + self.hold, self.duration]
        return list(zip(ends[:-1], ends[1:]))

    def keys(self, travel):
        """Times at which a history is solved: every `travel` mm of the way, in holds at times that grow."""
        steps = max(4, math.ceil(max(self.pads.values()) / travel))
        times = [0.0]
        for phase, (begin, end) in enumerate(self.phases()):
            if phase % 2 == 0:
                times += [begin + (end - begin) * (k + 1) / steps for k in range(steps)]
                continue
            step, at = 0.06, begin
            while at + 1.5 * step < end:
                at += step
                times.append(at)
                step *= 1.9
            times.append(end)
        return times

    def frames(self, rate):
        return [f / rate for f in range(int(round(self.duration * rate)) + 1)]


def lagrange(xs, x):
    """Weights of values at places xs for the polynomial through them, at x."""
    return [math.prod((x - other) / (own - other) for j, other in enumerate(xs) if j != i) for i, own in enumerate(xs)]


def in_time(trial, keys, t):
    """[(key, weight)]: a cubic through the four nearest keys of the phase that t lies in."""
    t = max(0.0, min(t, trial.duration))
    begin, end = next(p for p in trial.phases() if t <= p[1] + 1e-12)
    own = [k for k, at in enumerate(keys) if begin - 1e-9 <= at <= end + 1e-9]
    first = bisect.bisect([keys[k] for k in own], t) - 2
    own = own[max(0, min(first, len(own) - 4)):][:4]
    return list(zip(own, lagrange([keys[k] for k in own], t)))


def nexus_csv(rate, subject, frames, forces, positions):
    """A Nexus-style export. forces: {pad: [(x, y, z) a frame]} or None; positions: {label: [(x, y, z) or None a frame]}."""
    lines = []
    if forces:
        lines += ["Devices", f"{rate:g}", ",," + ",".join(f"{pad} - Force,," for pad in forces),
                  "Frame,Sub Frame," + ",".join("Fx,Fy,Fz" for _ in forces), ",," + ",".join("N,N,N" for _ in forces)]
        for f in range(frames):
            lines.append(f"{f + 1},0," + ",".join("%.4f,%.4f,%.4f" % tuple(values[f]) for values in forces.values()))
        lines.append("")
    lines += ["Trajectories", f"{rate:g}", ",," + ",".join(f"{subject}:{label},," for label in positions),
              "Frame,Sub Frame," + ",".join("X,Y,Z" for _ in positions), ",," + ",".join("mm,mm,mm" for _ in positions)]
    for f in range(frames):
        cells = ("%.3f,%.3f,%.3f" % tuple(p[f]) if p[f] is not None else ",," for p in positions.values())
        lines.append(f"{f + 1},0," + ",".join(cells))
    return "\n".join(lines) + "\n"


def rotation_matrix(degrees):
    """Rows of the rotation by a vector of degrees about the origin."""
    angle = math.radians(math.sqrt(sum(d * d for d in degrees)))
    if angle == 0.0:
        return [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
    x, y, z = (math.radians(d) / angle for d in degrees)
    c, s = math.cos(angle), math.sin(angle)
    return [[c + x * x * (1 - c), x * y * (1 - c) - z * s, x * z * (1 - c) + y * s],
            [y * x * (1 - c) + z * s, c + y * y * (1 - c), y * z * (1 - c) - x * s],
            [z * x * (1 - c) - y * s, z * y * (1 - c) + x * s, c + z * z * (1 - c)]]
