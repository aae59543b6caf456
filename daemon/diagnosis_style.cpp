#include "daemon/diagnosis_style.hpp"

namespace tissued::daemon {

const char* const kDiagnosisStyle = R"(
html.diagnosis {
  color-scheme: light;
  --bg: #ffffff; --fg: #1b1f24; --muted: #57606a; --rule: #d8dee4; --card: #f6f8fa; --notice: #fff8e1; --notice-edge: #d9a400;
  --c0: #d55e00; --c1: #0072b2; --c4: #b8860b; --c7: #444444; --place: #7a0019; --target: #00734f; --pad: #1d4e86;
}
main { max-width: 1120px; }
header { display: flex; justify-content: space-between; gap: 16px; color: var(--muted); font-size: 0.9rem; padding-bottom: 10px; border-bottom: 1px solid var(--rule); }
header b { color: var(--fg); }
.verdict { display: grid; grid-template-columns: minmax(0, 1.5fr) minmax(0, 1fr); gap: 16px 44px; align-items: start; margin: 30px 0 8px; }
.verdict.lone { grid-template-columns: 1fr; }
.kicker { margin: 0 0 6px; font-size: 0.8rem; font-weight: 700; letter-spacing: 0.06em; text-transform: uppercase; color: var(--accent); }
.good { --accent: #1a7f37; } .found { --accent: #a40e26; } .open { --accent: #8a5a00; }
.verdict h1 { font-size: 2.1rem; line-height: 1.18; letter-spacing: -0.01em; margin: 0 0 12px; text-wrap: balance; }
.sure { display: inline-block; margin: 0 0 10px; padding: 3px 12px; border-radius: 999px; font-weight: 600; color: #ffffff; background: var(--accent); }
.card { background: var(--card); border: 1px solid var(--rule); border-radius: 10px; padding: 14px 18px 10px; }
.card h2 { font-size: 0.95rem; margin: 0 0 10px; padding: 0; border: 0; }
.bars { list-style: none; margin: 0; padding: 0; font-size: 0.9rem; font-variant-numeric: tabular-nums; }
.bars li { display: grid; grid-template-columns: 9.2em minmax(60px, 1fr) 4.6em; gap: 10px; align-items: center; padding: 4px 0; }
.bars .value { text-align: right; white-space: nowrap; }
.bars .track { position: relative; display: block; height: 12px; background: #e8ecf0; border-radius: 3px; }
.bars .track i { position: absolute; left: 0; top: 0; bottom: 0; min-width: 1px; border-radius: 3px; }
.bars .track i.tick { top: -3px; bottom: -3px; width: 0; border-left: 2px solid var(--fg); border-radius: 0; }
.card p { font-size: 0.84rem; margin: 8px 0 2px; }
.wide-names li { grid-template-columns: minmax(14em, 1fr) 1fr 8.5em; border-bottom: 1px solid var(--rule); padding: 7px 0; }
.wide-names .words { display: block; color: var(--muted); font-size: 0.86rem; line-height: 1.3; }
figure.body { display: grid; grid-template-columns: minmax(0, 1fr) 270px; margin: 8px 0 10px; border: 1px solid var(--rule); border-radius: 10px; overflow: hidden; }
.stage { position: relative; min-height: 540px; background: radial-gradient(ellipse at 50% 45%, #ffffff 55%, #f1f4f7 100%); }
.stage canvas { position: absolute; inset: 0; width: 100%; height: 100%; object-fit: contain; cursor: grab; touch-action: pan-y; }
.stage canvas:active { cursor: grabbing; }
.stage canvas:focus-visible { outline: 2px solid var(--c1); outline-offset: -2px; }
.beside { padding: 16px 18px; background: var(--card); border-left: 1px solid var(--rule); font-size: 0.86rem; }
.controls { display: grid; gap: 12px; }
.controls label { display: grid; grid-template-columns: 1fr auto; gap: 4px 8px; }
.controls select, .controls input { grid-column: 1 / -1; grid-row: 2; width: 100%; margin: 0; }
.controls select, .controls button { font: inherit; color: inherit; background: #ffffff; border: 1px solid #b6bec8; border-radius: 6px; padding: 3px 9px; }
.controls button:hover { background: var(--card); }
.controls input { accent-color: var(--c1); }
.controls output { color: var(--muted); font-variant-numeric: tabular-nums; }
.controls .views { display: flex; gap: 6px; }
.controls .views button { flex: 1; }
.absent { display: none !important; }
.key { display: grid; gap: 5px; margin: 16px 0 0; padding: 14px 0 0; border-top: 1px solid var(--rule); }
.key li { display: grid; grid-template-columns: 24px 1fr; line-height: 1.3; }
.key .ramp { grid-column: 1 / -1; width: 100%; margin-bottom: 4px; }
.key li.wide { display: block; margin-top: 4px; }
.ramp { display: inline-block; width: 70px; height: 10px; border-radius: 2px; vertical-align: 0; background: linear-gradient(90deg, rgb(255,240,180), rgb(254,196,88), rgb(244,120,48), rgb(206,34,36), rgb(128,0,38)); }
.level { display: inline-block; width: 30px; margin-right: 6px; border-top: 2px dotted var(--fg); vertical-align: 4px; }
.apart { margin: 14px 0 4px; font-weight: 600; font-size: 0.92rem; }
.load { display: inline-block; width: 26px; height: 12px; margin-right: 6px; background: var(--rule); opacity: 0.7; vertical-align: -1px; }
.panels { grid-template-columns: repeat(auto-fill, minmax(min(330px, 100%), 1fr)); }
.slices { align-items: end; }
.slice .inside { fill: #eef1f4; stroke: #eef1f4; stroke-width: 0.6; }
.slice .band { stroke-width: 0.5; }
.slice .rind { fill: none; stroke: #6b7683; stroke-width: 1.4; stroke-linecap: round; }
.slice .rind.base { stroke: #57606a; stroke-width: 4; }
.slice .rind.pad { stroke: var(--pad); stroke-width: 4; }
.slice text.pad { fill: var(--pad); font-weight: 700; }
.slice .place { fill: none; stroke: var(--place); stroke-width: 1.8; }
.slice path.target { fill: none; stroke: var(--target); stroke-width: 1.6; }
.slice text.target { fill: var(--target); paint-order: stroke; stroke: #ffffff; stroke-width: 2.5px; }
.slice .rule { fill: none; stroke: var(--muted); }
.pair { display: flex; flex-wrap: wrap; gap: 4px 60px; }
.pair figure { margin: 8px 0; }
.pair figcaption { margin: 0 0 2px; color: var(--fg); font-weight: 600; }
.dot { display: inline-block; width: 10px; height: 10px; border-radius: 50%; margin-right: 8px; }
.next { font-size: 1.08rem; border-left: 4px solid var(--c1); padding: 4px 16px; }
.remarks { padding-left: 20px; max-width: 78ch; }
footer { margin-top: 52px; padding-top: 12px; border-top: 2px solid var(--rule); color: var(--muted); font-size: 0.88rem; }
footer b { color: var(--fg); }
@media (max-width: 760px) {
  main { padding: 18px 16px 40px; }
  .verdict { grid-template-columns: 1fr; margin-top: 20px; }
  .verdict h1 { font-size: 1.6rem; }
  .stage { min-height: 380px; }
  figure.body { grid-template-columns: 1fr; }
  .beside { border-left: 0; border-top: 1px solid var(--rule); }
  .wide-names li { grid-template-columns: 1fr 7.5em; gap: 3px 10px; }
  .wide-names .name { grid-column: 1 / -1; }
  h2 { margin-top: 36px; }
}
@media print {
  * { -webkit-print-color-adjust: exact; print-color-adjust: exact; }
  .controls { display: none; }
  .verdict { grid-template-columns: 1.4fr 1fr; margin: 14px 0 0; }
  .verdict h1 { font-size: 1.7rem; }
  h2 { margin-top: 22px; padding-top: 10px; }
  figure.body { grid-template-columns: 1fr; }
  .beside { border: 0; padding: 8px 14px; font-size: 0.8rem; }
  .key { display: flex; flex-wrap: wrap; gap: 2px 18px; margin: 0; padding: 0; border: 0; }
  .key .ramp { width: 90px; margin: 0 8px 0 0; }
  .stage { min-height: 380px; }
  .panels, .slices { grid-template-columns: 1fr 1fr 1fr; gap: 6px 10px; }
  .wide-names li { grid-template-columns: minmax(16em, 1fr) 1fr 6em; }
  .wide-names .name { grid-column: auto; }
  table { font-size: 9pt; }
  .card, .slice, .bars li { break-inside: avoid; }
}
)";

}  // namespace tissued::daemon
