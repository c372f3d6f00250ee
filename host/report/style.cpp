#include "host/report/sections.h"

namespace powbench::host {
namespace {

// No ampersands or angle brackets in here: the same bytes then mean the same to an HTML and an XML reader.
constexpr std::string_view css = R"(
:root { --ink: #1f2933; --soft: #5b6875; --line: #d7dde3; --faint: #f3f5f7; --measured: #0072B2; --simulated: #B34E00;
  --cited: #00795A; --paper: #fff; --good: #1b6b3a; --bad: #a3261b; --doubt: #8a5a00; --alarm: #fbeeec;
  --well: #e6f2ea; }
* { box-sizing: border-box; }
html { background: #eceff2; }
body { margin: 0; color: var(--ink); font: 15px/1.5 Inter, "Source Sans 3", "Segoe UI", Roboto, "Helvetica Neue", Arial,
  "Liberation Sans", "DejaVu Sans", sans-serif; font-variant-numeric: tabular-nums; -webkit-print-color-adjust: exact;
  print-color-adjust: exact; }
main { max-width: 1080px; margin: 0 auto; background: var(--paper); padding: 44px 52px 36px; }
header { display: flex; justify-content: space-between; align-items: flex-start; gap: 32px;
  border-bottom: 2px solid var(--ink); padding-bottom: 18px; }
.kicker { margin: 0 0 4px; color: var(--soft); font-size: 13px; letter-spacing: .04em; }
h1 { margin: 0; font-size: 30px; line-height: 1.2; font-weight: 650; overflow-wrap: anywhere; }
h2 { margin: 0 0 14px; font-size: 21px; font-weight: 650; line-height: 1.3; }
h3 { margin: 26px 0 8px; font-size: 15px; font-weight: 650; }
.subtitle { margin: 6px 0 0; color: var(--soft); }
.origin { margin: 8px 0 0; }
.origin b { padding: 1px 8px; margin-right: 6px; border: 2px solid var(--ink); border-radius: 3px;
  letter-spacing: .04em; }
.aside { margin-left: 12px; font-size: 14px; font-weight: 400; color: var(--soft); }
.verdict { flex: none; padding: 10px 26px; border-radius: 6px; font-size: 24px; font-weight: 700; letter-spacing: .06em;
  color: #fff; }
.verdict.pass { background: var(--good); }
.verdict.fail { background: var(--bad); }
.verdict.error { background: var(--doubt); }
.verdict.open { background: #5b6875; }
.answers { display: grid; grid-template-columns: 0.8fr 1.2fr 1.2fr; gap: 0 28px; margin-top: 14px; }
.answer h3 { margin: 8px 0 2px; color: var(--soft); font-weight: 600; }
.answer .main { margin: 0; font-size: 19px; line-height: 1.3; font-weight: 650; }
.grid { display: grid; grid-template-columns: 1fr 1fr; gap: 6px 22px; }
tr.best th, tr.best td { background: var(--faint); font-weight: 650; }
h2.appendix { margin: 56px 0 0; padding-top: 20px; border-top: 2px solid var(--ink); font-size: 24px; }
section { margin-top: 26px; }
#answers, #limits { margin-top: 12px; }
table { border-collapse: collapse; width: 100%; font-size: 13.5px; line-height: 1.35; }
table + table { margin-top: 14px; }
th, td { padding: 5px 8px; text-align: right; vertical-align: baseline; border-bottom: 1px solid var(--line); }
thead th { color: var(--soft); font-weight: 600; vertical-align: bottom; border-bottom: 1.5px solid var(--ink); }
tbody th, th:first-child, th.left { text-align: left; font-weight: 400; }
thead th:first-child { font-weight: 600; }
th.sym { font-weight: 600; white-space: nowrap; padding-right: 4px; }
td.left { text-align: left; width: 36%; }
.nowrap { white-space: nowrap; }
.unit { color: var(--soft); text-align: left; }
td.key { color: var(--measured); font-weight: 600; white-space: nowrap; }
.events td:not(.left) { white-space: nowrap; }
.events td.left { width: auto; }
td.sim { color: var(--simulated); }
td.pub { color: var(--cited); }
tr.bad td, tr.bad th { background: var(--alarm); }
.warn { color: var(--bad); font-weight: 600; }
.fine { margin: 8px 0 0; color: var(--soft); font-size: 13px; }
.badge { display: inline-block; white-space: nowrap; min-width: 4.2em; padding: 0 7px; border-radius: 3px;
  text-align: center; font-size: 12px;
  font-weight: 650; letter-spacing: .03em; }
.badge.pass { color: var(--good); background: var(--well); }
.badge.fail { color: #fff; background: var(--bad); }
.badge.error { color: #fff; background: var(--doubt); }
.badge.open { color: var(--soft); background: var(--faint); }
.code { font-family: ui-monospace, SFMono-Regular, Menlo, Consolas, "DejaVu Sans Mono", monospace; font-size: 12px; }
.shots td:first-child { text-align: right; }
.shots th:last-child { text-align: left; }
.shots td.left { width: 30%; color: var(--soft); }
figure { margin: 0 0 18px; }
figure h3 { margin: 0 0 2px; }
figcaption { color: var(--soft); font-size: 13px; }
.closer-panel { width: 100%; height: 140px; margin-bottom: 2px; }
.closer-panel.last { height: 172px; }
#device-view { width: 100%; height: 340px; touch-action: none; }
#device-time { width: 40%; min-width: 160px; }
.closer-panel .dygraph-legend { width: auto; background: none; font-size: 12px; right: 8px; left: auto !important; }
.closer-panel .dygraph-axis-label, .closer-panel .dygraph-label { color: var(--soft); font-size: 12px;
  font-weight: 400; }
.controls { display: flex; flex-wrap: wrap; gap: 6px 10px; align-items: center; font-size: 14px; }
.controls button, .controls select { font: inherit; color: var(--ink); background: var(--faint);
  border: 1px solid var(--line);
  border-radius: 4px; padding: 3px 10px; }
svg.plot { display: block; width: 100%; height: auto; font-size: 13px; }
svg.plot text { fill: var(--soft); }
svg.plot text.t { fill: var(--ink); }
dl { margin: 0; }
dt { font-weight: 600; }
dd { margin: 0; }
#definitions dl { display: grid; grid-template-columns: 11em 1fr; gap: 6px 18px; }
.provenance { display: grid; grid-template-columns: 1fr 1fr; gap: 0 34px; }
.provenance div { display: flex; gap: 14px; border-bottom: 1px solid var(--line); padding: 4px 0; }
.provenance dt { flex: 0 0 8.2em; color: var(--soft); font-weight: 400; }
.provenance dd { min-width: 0; overflow-wrap: anywhere; }
.columns { columns: 2; column-gap: 34px; }
.parameters { font-size: 13px; }
.parameters td { text-align: left; }
.parameters tr { break-inside: avoid; }
.sign { display: none; }
@media screen { #shots { overflow-x: auto; } }
footer { margin-top: 36px; color: var(--soft); font-size: 13px; }
@media screen and (max-width: 760px) {
  body { font-size: 16px; }
  main { padding: 18px 14px; }
  header { flex-direction: column; gap: 14px; }
  .answers, .grid, .provenance, #definitions dl { grid-template-columns: minmax(0, 1fr); }
  .columns { columns: 1; }
  .limits th, .limits td { padding: 5px 4px; }
  .limits .left { display: none; }
  section { overflow-x: auto; }
  svg.plot { min-width: 620px; }
  .grid svg.plot { min-width: 0; font-size: 14px; }
  .closer-panel .dygraph-legend { top: 18px !important; font-size: 11px; }
}
@media screen { section.angle { content-visibility: auto; contain-intrinsic-size: auto 1180px; } }
@media screen and (prefers-color-scheme: dark) {
  :root { --ink: #e4e9ee; --soft: #9fadba; --line: #3a444e; --faint: #26303a; --measured: #56b4e9; --simulated: #f28e2b;
    --cited: #4fc49d; --paper: #161c22; --good: #67c58f; --bad: #f0776b; --doubt: #dba63b; --alarm: #43211f;
    --well: #1d3528; }
  html { background: #0d1115; }
  .verdict, .badge.fail, .badge.error { color: #10151a; }
  .verdict.open { color: #fff; }
  svg [stroke="#0072B2"] { stroke: #56b4e9; }
  svg [fill="#0072B2"] { fill: #56b4e9; }
  svg [stroke="#D55E00"] { stroke: #f28e2b; }
  svg [fill="#D55E00"] { fill: #f28e2b; }
  svg [stroke="#00795A"] { stroke: #4fc49d; }
  svg [fill="#00795A"] { fill: #4fc49d; }
  svg [stroke="#1f2933"] { stroke: #e4e9ee; }
  svg [stroke="#5b6875"] { stroke: #9fadba; }
  svg [stroke="#b8c1ca"] { stroke: #55616d; }
  svg [stroke="#e6eaee"] { stroke: #2a333c; }
  svg [fill="#ffffff"] { fill: #161c22; }
}
@page { size: A4; margin: 12mm 12mm 13mm;
  @bottom-left { content: "powbench"; font-size: 8pt; color: #5b6875; }
  @bottom-right { content: counter(page) " / " counter(pages); font-size: 8pt; color: #5b6875; } }
@media print {
  .screen { display: none; }
  html { background: #fff; }
  body { font-size: 9pt; line-height: 1.4; }
  main { max-width: none; padding: 0; }
  h1 { font-size: 17pt; }
  h2 { font-size: 12.5pt; margin-bottom: 4pt; }
  h3 { font-size: 9.4pt; margin: 9pt 0 2pt; }
  header { padding-bottom: 8pt; }
  table { font-size: 7.6pt; }
  th, td { padding: 1.6pt 4pt; }
  .badge, .code { font-size: 7pt; }
  .answer .main { font-size: 12pt; }
  figcaption, .fine, .aside, .kicker { font-size: 7.6pt; }
  .verdict { font-size: 15pt; padding: 5pt 14pt; }
  .provenance, .parameters { font-size: 7.6pt; }
  .provenance div { padding: 1.5pt 0; }
  #definitions dl { font-size: 8pt; gap: 2pt 12pt; }
  .columns { columns: 3; column-gap: 14pt; }
  .parameters th, .parameters td { padding: 1pt 3pt; }
  footer { display: none; }
  .sign { display: grid; grid-template-columns: 1fr 1fr 1fr; gap: 14pt; margin-top: 26pt; }
  .sign p { border-top: 1px solid var(--soft); margin: 0; padding-top: 2pt; font-size: 7.6pt; color: var(--soft); }
  section { margin-top: 12pt; }
  h2.appendix { break-before: page; margin: 0; padding: 0; border: 0; }
  section.angle { break-inside: avoid; margin-top: 4pt; }
  figure, tr, .answers, .provenance div, .together, #definitions, #limits { break-inside: avoid; }
  .times th, .times td { padding: 1.6pt 2.5pt; white-space: nowrap; }
  figure { margin-bottom: 5pt; }
  .grid { gap: 2pt 14pt; }
  h2, h3 { break-after: avoid; }
  thead { display: table-header-group; }
  section.angle svg.plot { max-height: 138mm; }
  section.angle .badge { font-size: 6pt; padding: 0 3pt; }
  #typical svg.plot { max-height: 130mm; }
}
)";

}  // namespace

const Markup& page_style() {
  static const Markup style = [] {
    Markup m;
    m.verbatim("style", css);
    return m;
  }();
  return style;
}

}  // namespace powbench::host
