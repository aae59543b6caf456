"""Small plots as SVG: axes, dots, bars. Coordinates of the data in, pixels out."""
import math

from .intervals import wilson

WIDTH, HEIGHT, LEFT, BOTTOM, TOP, RIGHT = 340, 300, 58, 40, 24, 20
INK, SOFT, BLUE, RED = "#1c1c1c", "#d5d5d5", "#2f5d8a", "#a3262a"


class Axes:
    """x and y: (low, high); logarithmic where `log`."""

    def __init__(self, x, y, log=False, words=("", ""), width=WIDTH):
        self.x, self.y, self.log, self.width, self.parts = x, y, log, width, []
        self._label((LEFT + width - RIGHT) / 2, HEIGHT - 6, words[0])
        self.parts.append(f'<text x="12" y="{(TOP + HEIGHT - BOTTOM) / 2}" text-anchor="middle" transform="rotate(-90 12 {(TOP + HEIGHT - BOTTOM) / 2})">{words[1]}</text>')

    def _share(self, value, axis):
        low, high = axis
        if self.log:
            value, low, high = (math.log(max(v, 1e-9)) for v in (value, low, high))
        return min(1.0, max(0.0, (value - low) / (high - low)))

    def at(self, x, y):
        return (LEFT + self._share(x, self.x) * (self.width - LEFT - RIGHT), HEIGHT - BOTTOM - self._share(y, self.y) * (HEIGHT - BOTTOM - TOP))

    def _label(self, x, y, words, anchor="middle"):
        self.parts.append(f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}">{words}</text>')

    def ticks(self, xs, ys, show=str):
        for x in xs:
            px, bottom = self.at(x, self.y[0])
            self.parts.append(f'<path d="M{px:.1f} {bottom:.1f}V{TOP}" stroke="{SOFT}"/>')
            self._label(px, bottom + 15, show(x))
        for y in ys:
            left, py = self.at(self.x[0], y)
            self.parts.append(f'<path d="M{left:.1f} {py:.1f}H{self.width - RIGHT}" stroke="{SOFT}"/>')
            self._label(left - 5, py + 4, show(y), "end")

    def line(self, points, color=INK, dashed=False, width=1.2):
        way = "L".join("%.1f %.1f" % self.at(*p) for p in points)
        self.parts.append(f'<path d="M{way}" fill="none" stroke="{color}" stroke-width="{width}"{" stroke-dasharray=" + chr(34) + "4 3" + chr(34) if dashed else ""}/>')

    def dot(self, x, y, color=BLUE, radius=4.0, hollow=False):
        px, py = self.at(x, y)
        fill = "white" if hollow else color
        self.parts.append(f'<circle cx="{px:.1f}" cy="{py:.1f}" r="{radius}" fill="{fill}" fill-opacity="0.75" stroke="{color}"/>')

    def words(self, x, y, words):
        px, py = self.at(x, y)
        self.parts.append(f'<text x="{px + 7:.1f}" y="{py - 5:.1f}" fill="#555">{words}</text>')

    def svg(self):
        return (f'<svg xmlns="http://www.w3.org/2000/svg" width="{self.width}" height="{HEIGHT}" viewBox="0 0 {self.width} {HEIGHT}" '
                f'font-family="system-ui, sans-serif" font-size="11" fill="{INK}">' + "".join(self.parts) + "</svg>")


def reliability(bins):
    """bins: [(mean probability, hits, count)]."""
    axes = Axes((0.0, 1.0), (0.0, 1.0), words=("said", "right"))
    axes.ticks([0, 0.25, 0.5, 0.75, 1], [0, 0.25, 0.5, 0.75, 1], lambda v: f"{100 * v:.0f} %")
    axes.line([(0, 0), (1, 1)], SOFT, width=2)
    for p, hits, count in bins:
        low, high = wilson(hits, count)
        axes.line([(p, low), (p, high)], BLUE)
        axes.dot(p, hits / count)
        axes.words(p - (0.13 if p > 0.9 else 0.0), hits / count, count)
    return axes.svg()


def before_after(pairs, what):
    """pairs: [(assumed, explained)] mm."""
    axes = Axes((0.02, 10.0), (0.02, 10.0), log=True, words=(f"{what}, assumed model, mm", "explained model, mm"))
    axes.ticks([0.02, 0.1, 0.5, 2, 10], [0.02, 0.1, 0.5, 2, 10], lambda v: f"{v:g}")
    axes.line([(0.02, 0.02), (10, 10)], "#888")
    axes.line([(0.05, 0.02), (10, 4)], "#888", dashed=True)
    for assumed, explained in pairs:
        axes.dot(assumed, explained, BLUE if explained < assumed else RED, 3.5)
    return axes.svg()


def places(found):
    """found: [{kind, off or None, ...}]."""
    kinds = sorted({p["kind"] for p in found}) or [""]
    axes = Axes((0.0, 44.0), (-0.6, len(kinds) - 0.4), words=("from the true centre, mm", ""))
    axes.ticks([0, 8, 16, 24, 32], [])
    axes.line([(8, -0.6), (8, len(kinds) - 0.4)], "#888", dashed=True)
    for row, kind in enumerate(kinds):
        axes.parts.append('<text x="%.1f" y="%.1f" text-anchor="end" fill="#555">%s</text>' % (WIDTH - RIGHT - 4, axes.at(0, row + 0.32)[1], kind))
        own = sorted((p["off"] is None, p["off"] or 0.0) for p in found if p["kind"] == kind)
        for k, (missing, off) in enumerate(own):
            axes.dot(42.0 if missing else min(off, 38.0), row + 0.09 * (k % 3 - 1), RED if missing or off > 8.0 else BLUE, 3.5, hollow=missing)
    return axes.svg()
