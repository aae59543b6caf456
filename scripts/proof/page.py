"""The result for people: a table on the terminal, and one HTML page that loads nothing."""
import html as text
import math

from . import plots

STYLE = """
body { font: 15px/1.5 system-ui, sans-serif; color: #1c1c1c; max-width: 1080px; margin: 2.5em auto; padding: 0 1.5em; }
h1 { font-size: 1.6em; margin-bottom: .2em; } h2 { font-size: 1.15em; margin: 2.2em 0 .5em; border-bottom: 1px solid #ccc; padding-bottom: .2em; }
p.lead { color: #444; max-width: 52em; } .small { font-size: .86em; color: #555; }
table { border-collapse: collapse; font-variant-numeric: tabular-nums; } th { text-align: left; font-weight: 600; }
td, th { padding: .22em .8em .22em 0; border-bottom: 1px solid #e4e4e4; vertical-align: top; }
td.n, th.n { text-align: right; } .wrong { color: #a3262a; } .right { color: #2c6e49; }
table.matrix td, table.matrix th { padding: .15em .45em; text-align: center; font-size: .84em; border: 1px solid #eee; }
table.matrix th.row { text-align: right; } table.matrix th.column { height: 9.5em; vertical-align: bottom; padding: 0 0 .3em 0; width: 2em; }
table.matrix th.column span { writing-mode: vertical-rl; transform: rotate(180deg); }
.plots { display: flex; flex-wrap: wrap; gap: 1.5em 2.5em; } figure { margin: 0; } figcaption { font-size: .86em; color: #555; max-width: 30em; }
code { font-size: .92em; overflow-wrap: anywhere; } .scroll { overflow-x: auto; }
"""
ORDER = ["none", "parameters", "viscoelasticity", "strain-stiffening", "inclusion", "stiffness-gradient", "anisotropy", "skin", "softening", "swelling",
         "gravity", "loose-base", "sliding-actuator", "damping", "attached-mass", "latency", "registration", "marker-slip", "unknown"]
SHARES = {"Brier score": False}


def _figure(value, is_share=True):
    if value is None or math.isnan(value):
        return "-"
    return f"{100 * value:.0f} %" if is_share else f"{value:.3f}"


def _figure_row(name, f):
    """(name, value, interval, limit, met) in words."""
    is_share = SHARES.get(name, True)
    count = f" ({f['hits']} of {f['count']})" if "hits" in f else f" ({f['count']})"
    limit = ("at least " if f["at_least"] else "at most ") + _figure(f["limit"], is_share)
    return name, _figure(f["value"], is_share) + count, f"{_figure(f['low'], is_share)} to {_figure(f['high'], is_share)}", limit, f["met"]


def _truth(row):
    return " + ".join(row["outside"] or row["physics"]) or ("parameters" if "parameters" in row["kinds"] else "none")


def _said(row):
    if not row["report"]:
        return "no report"
    return ", ".join(f"{kind} {100 * p:.0f} %" for kind, p, _ in row["findings"]) or row["verdict"]


def _errors(row, what):
    return "-" if not row["errors"] else "{:.2f} → {:.2f}".format(*row["errors"][what])


def _noise(row):
    fit = row["fit"].get("trials", {}).get("explained", {})
    return fit.get("marker_rms")


def _place(row):
    if not row["place"]:
        return ""
    return "not placed" if row["place"]["off"] is None else f"{row['place']['off']:.1f}"


def _case_cells(row):
    left = _noise(row)
    return [row["name"][:8], _truth(row), _said(row), "" if row["right"] else "wrong", _place(row), _errors(row, "target"), _errors(row, "marker"),
            "-" if left is None else f"{left:.3f}", "-" if math.isnan(row["seconds"]) else f"{row['seconds']:.0f}"]


CASE_HEADS = ["case", "truth", "said", "", "place off, mm", "targets, mm", "markers, mm", "left, mm", "s"]


def print_table(result):
    rows = [CASE_HEADS] + [_case_cells(row) for row in result["rows"]]
    widths = [min(60, max(len(r[k]) for r in rows)) for k in range(len(CASE_HEADS))]
    for r in rows:
        print("  ".join(cell.ljust(width) for cell, width in zip(r, widths)).rstrip())
    print()
    if result["summary"]["stopped"]:
        print(_stopped(result["summary"]))
    for name, f in result["summary"]["figures"].items():
        name, value, interval, limit, met = _figure_row(name, f)
        print(f"{name:42s} {value:>18s}   95 %: {interval:16s} {limit:18s} {'met' if met else 'not met'}")


def _stopped(summary):
    return f"{summary['stopped']} of {summary['count']} diagnoses were stopped by their budget before all explanations were tried."


def _cell(value, kind="td", style=""):
    return f"<{kind}{style}>{text.escape(str(value))}</{kind}>"


def _table(heads, rows, numeric=()):
    style = lambda k: ' class="n"' if k in numeric else ""
    out = ["<table><tr>" + "".join(_cell(h, "th", style(k)) for k, h in enumerate(heads)) + "</tr>"]
    out += ["<tr>" + "".join(c if c.startswith("<td") else _cell(c, "td", style(k)) for k, c in enumerate(row)) + "</tr>" for row in rows]
    return "\n".join(out) + "</table>"


def _figures(figures):
    rows = []
    for name, f in figures.items():
        name, value, interval, limit, met = _figure_row(name, f)
        word = "right" if met else "wrong"
        rows.append([name, value, interval, limit, f'<td class="{word}">{"met" if met else "not met"}</td>'])
    return _table(["", "here", "95 % interval", "asked for", ""], rows)


def _matrix(table):
    place = lambda kind: (ORDER.index(kind) if kind in ORDER else len(ORDER), kind)
    rows = sorted(table, key=place)
    columns = sorted({c for row in table.values() for c in row} | set(rows), key=place)
    out = ['<table class="matrix"><tr><th class="row">truth \\ said</th>'] + [f'<th class="column"><span>{text.escape(c)}</span></th>' for c in columns]
    out.append("</tr>")
    for kind in rows:
        total = sum(table[kind].values())
        out.append(f'<tr><th class="row">{text.escape(kind)}</th>')
        for column in columns:
            count = table[kind].get(column, 0)
            color = "44,110,73" if column == kind else "163,38,42"
            shade = f' style="background: rgba({color},{0.12 + 0.5 * count / total:.2f})"' if count else ""
            out.append(f"<td{shade}>{count or ''}</td>")
        out.append("</tr>")
    return "".join(out) + "</table>"


def _numbers(rows):
    """A line a number: how often, and how far from the truth it was."""
    groups = {}
    for row in rows:
        for entry in row["numbers"]:
            groups.setdefault((entry["kind"], entry["what"], entry["relative"], entry["unit"]), []).append(entry)
    lines = []
    for (kind, what, relative, unit), entries in sorted(groups.items(), key=lambda item: (ORDER.index(item[0][0]), item[0][1])):
        sizes = sorted(abs(e["error"]) for e in entries)
        show = (lambda x: f"{100 * x:.1f} %") if relative else (lambda x: f"{x:.2f} {unit}")
        sure = [abs(e["error"] * e["true"]) <= 2 * e["sd"] for e in entries if isinstance(e.get("sd"), (int, float)) and isinstance(e["true"], (int, float))]
        lines.append([kind, what, str(len(entries)), show(sizes[len(sizes) // 2]), show(sizes[-1]), f"{sum(sure)} of {len(sure)}" if sure else ""])
    return _table(["kind", "number", "times", "median error", "largest", "within 2 stated sd"], lines, numeric=(2, 3, 4, 5))


def _misses(rows):
    wrong = [row for row in rows if not row["right"]]
    if not wrong:
        return "<p>None.</p>"
    return _table(["case", "body", "truth", "its size", "said", "verdict"],
                  [[row["name"][:8], row["shape"] + ("" if row["has_force"] else ", no forces"), _truth(row), _size(row), _said(row), row["verdict"]] for row in wrong])


def _size(row):
    parts = []
    for kind, values in row["true_numbers"].items():
        kept = {k: v for k, v in values.items() if isinstance(v, (int, float))}
        parts.append(kind + ": " + ", ".join(f"{k} {v:.3g}" for k, v in kept.items()))
    seen = [f"moves markers by {v['marker_mm']:.2f} mm" for v in (row["visible"] or {}).values()]
    return "; ".join(parts + seen)


def html(result, words):
    rows, summary = result["rows"], result["summary"]
    missing = [row for row in rows if row["errors"] and set(row["physics"]) - {"latency", "registration", "marker-slip"}]
    cases = [[f'<td class="{"right" if c[3] == "" else "wrong"}">{text.escape(c[2])}</td>' if k == 2 else c[k] for k in range(len(c)) if k != 3]
             for c in map(_case_cells, rows)]
    part = "" if result["wanted"] == len(rows) else f" {result['wanted'] - len(rows)} more are not diagnosed yet."
    return f"""<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><title>Blind proof of the diagnosis</title><style>{STYLE}</style></head><body>
<h1>Blind proof of the diagnosis</h1>
<p class="lead">{len(rows)} sessions on blocks, domes and organs, computed by FEniCSx (quadratic tetrahedra on meshes of their own), seeds
{result['seeds'][0]} to {result['seeds'][1]}.{part} Only skin markers were seen, with 0.1 mm of noise, placed to half a millimetre; the tissue's stiffness
and compressibility were wrong as well in most. {_stopped(summary) if summary['stopped'] else ''} The answers were sealed before anything was diagnosed; the program {text.escape(words)}.</p>
<p class="small">SHA-256 of all seals: <code>{result['seal']}</code></p>
<h2>What was to be shown</h2>
{_figures(summary['figures'])}
<p class="small">Named exactly: every kind that is there and no other was said with at least 50 %. Shares have Wilson's interval, the others are
bootstrapped over cases.</p>
<h2>Which kinds are taken for which</h2>
<div class="scroll">{_matrix(summary['confusion'])}</div>
<h2>Can the probabilities be trusted, and what does an explanation gain?</h2>
<div class="plots">
<figure>{plots.reliability(summary['reliability'])}<figcaption>How often what was said with a probability was right; bars are 95 % intervals, numbers the
count. Findings and alternatives.</figcaption></figure>
<figure>{plots.before_after([row['errors']['target'] for row in missing], 'targets')}<figcaption>Error of the concealed targets in held-out pushes, RMS per axis,
where physics was missing: each case with the assumed model and with the explained one. Below the line is better; the dashed line is a cut of 60 %.</figcaption></figure>
<figure>{plots.before_after([row['errors']['marker'] for row in missing], 'markers')}<figcaption>The same of the markers, which were concealed there too.</figcaption></figure>
<figure>{plots.places([row['place'] for row in rows if row['place']])}<figcaption>How far findings are from where the lump, the loose support or the unnamed effect
was; 8 mm was asked for. To the right: not placed.</figcaption></figure>
</div>
<h2>Numbers</h2>
{_numbers(rows)}
<h2>What was named wrongly</h2>
{_misses(rows)}
<h2>All cases</h2>
<p class="small">Targets and markers: error in held-out pushes, assumed model and explained model, RMS per axis. Left: what the explained model leaves of the
fitted trials' markers.</p>
<div class="scroll">{_table([h for k, h in enumerate(CASE_HEADS) if k != 3], cases, numeric=(3, 4, 5, 6, 7))}</div>
</body></html>
"""
