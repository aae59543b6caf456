#include "daemon/page_style.hpp"

namespace tissued::daemon {

const char* const kPageStyle = R"(
:root {
  color-scheme: light dark;
  --bg: #ffffff; --fg: #1b1f24; --muted: #57606a; --rule: #d8dee4; --card: #f6f8fa; --notice: #fff8e1; --notice-edge: #d9a400;
  --c0: #d55e00; --c1: #0072b2; --c2: #cc79a7; --c3: #009e73; --c4: #b8860b; --c5: #56b4e9; --c6: #7f5fb5; --c7: #444444;
}
@media (prefers-color-scheme: dark) {
  :root {
    --bg: #14171b; --fg: #e6e9ed; --muted: #9aa4af; --rule: #333a43; --card: #1c2127; --notice: #2b2510; --notice-edge: #d9a400;
    --c0: #ff8a3c; --c1: #5ab4f0; --c2: #e8a3c8; --c3: #34c79b; --c4: #e6b93c; --c5: #9fd6f5; --c6: #b79ce6; --c7: #c8c8c8;
  }
}
* { box-sizing: border-box; }
body { margin: 0; background: var(--bg); color: var(--fg); font: 15px/1.5 system-ui, "Segoe UI", "DejaVu Sans", sans-serif; }
main { max-width: 1140px; margin: 0 auto; padding: 28px 24px 64px; }
h1 { font-size: 1.75rem; line-height: 1.2; margin: 0 0 4px; }
h2 { font-size: 1.35rem; margin: 48px 0 8px; padding-top: 16px; border-top: 2px solid var(--rule); }
h3 { font-size: 1.08rem; margin: 32px 0 6px; }
p { max-width: 78ch; margin: 6px 0 10px; }
.lead, figcaption { color: var(--muted); }
.notice { background: var(--notice); border-left: 4px solid var(--notice-edge); padding: 8px 14px; margin: 16px 0; font-weight: 600; }
code { font: 0.9em ui-monospace, "DejaVu Sans Mono", monospace; }
.table { overflow-x: auto; margin-top: 6px; }
table { border-collapse: collapse; font-size: 0.88rem; font-variant-numeric: tabular-nums; }
th, td { padding: 4px 12px 4px 0; text-align: left; vertical-align: bottom; border-bottom: 1px solid var(--rule); white-space: nowrap; }
th { font-weight: 600; white-space: normal; }
th.number, td.number { text-align: right; padding: 4px 8px; }
thead th { border-bottom: 2px solid var(--muted); }
tr.total td { border-top: 2px solid var(--muted); font-weight: 600; }
td b { color: var(--fg); background: var(--card); padding: 1px 4px; border-radius: 3px; }
.printed { font-style: italic; }
figure { margin: 14px 0 26px; }
.panels { display: grid; grid-template-columns: repeat(auto-fill, minmax(430px, 1fr)); gap: 10px 16px; }
.wide .panels { grid-template-columns: 1fr; }
figcaption { font-size: 0.88rem; max-width: 100ch; margin-top: 6px; }
.legend { list-style: none; display: flex; flex-wrap: wrap; gap: 4px 20px; margin: 0 0 6px; padding: 0; font-size: 0.88rem; }
.legend svg.swatch { width: 34px; height: 12px; margin-right: 6px; vertical-align: -1px; }
svg { width: 100%; height: auto; display: block; }
svg.swatch { display: inline; }
svg text { fill: var(--fg); font: 11px system-ui, "Segoe UI", "DejaVu Sans", sans-serif; }
svg .title { font-size: 12.5px; font-weight: 600; }
svg .label { fill: var(--muted); }
svg .tick { fill: var(--muted); }
svg .middle { text-anchor: middle; }
svg .end { text-anchor: end; }
svg .grid { stroke: var(--rule); stroke-width: 0.7; }
svg .reference { stroke: var(--fg); stroke-width: 1; stroke-dasharray: 1 3; }
svg .series { fill: none; stroke-width: 1.8; stroke-linejoin: round; }
svg .mark { stroke-width: 1.6; }
svg .area { fill: var(--rule); opacity: 0.55; stroke: none; }
@media (max-width: 520px) { .panels { grid-template-columns: 1fr; } }
@media print {
  :root {
    --bg: #ffffff; --fg: #000000; --muted: #444444; --rule: #cccccc; --card: #f0f0f0; --notice: #ffffff;
    --c0: #d55e00; --c1: #0072b2; --c2: #cc79a7; --c3: #009e73; --c4: #b8860b; --c5: #56b4e9; --c6: #7f5fb5; --c7: #444444;
  }
  body { font-size: 10pt; }
  main { max-width: none; padding: 0; }
  .panels { grid-template-columns: 1fr 1fr; }
  .table { overflow: visible; }
  table { font-size: 7.5pt; }
  figure, tr, .notice { break-inside: avoid; }
  h2, h3 { break-after: avoid; }
}
)";

}  // namespace tissued::daemon
