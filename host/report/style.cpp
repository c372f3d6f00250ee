#include "host/report/sections.h"

namespace powbench::host {
namespace {

// No ampersands or angle brackets in here: the same bytes then mean the same to an HTML and an XML reader.
constexpr std::string_view css = R"(
:root { --ink: #1f2933; --soft: #5b6875; --line: #d7dde3; --faint: #f3f5f7; --measured: #0072B2; --simulated: #B34E00;
  --published: #00795A; --good: #1b6b3a; --bad: #a3261b; --doubt: #8a5a00; }
* { box-sizing: border-box; }
html { background: #eceff2; }
body { margin: 0; color: var(--ink); font: 15px/1.5 Inter, "Source Sans 3", "Segoe UI", Roboto, "Helvetica Neue", Arial,
  "Liberation Sans", "DejaVu Sans", sans-serif; font-variant-numeric: tabular-nums; -webkit-print-color-adjust: exact;
  print-color-adjust: exact; }
main { max-width: 1080px; margin: 0 auto; background: #fff; padding: 44px 52px 36px; }
header { display: flex; justify-content: space-between; align-items: flex-start; gap: 32px;
  border-bottom: 2px solid var(--ink); padding-bottom: 18px; }
.kicker { margin: 0 0 4px; color: var(--soft); font-size: 13px; letter-spacing: .04em; }
h1 { margin: 0; font-size: 30px; line-height: 1.2; font-weight: 650; overflow-wrap: anywhere; }
h2 { margin: 0 0 14px; font-size: 21px; font-weight: 650; line-height: 1.3; }
h3 { margin: 26px 0 8px; font-size: 15px; font-weight: 650; }
.subtitle { margin: 6px 0 0; color: var(--soft); }
.origin { margin: 8px 0 0; }
.origin b { padding: 1px 8px; margin-right: 6px; border: 2px solid var(--ink); border-radius: 3px; letter-spacing: .04em; }
.aside { margin-left: 12px; font-size: 14px; font-weight: 400; color: var(--soft); }
.verdict { flex: none; padding: 10px 26px; border-radius: 6px; font-size: 24px; font-weight: 700; letter-spacing: .06em;
  color: #fff; }
.verdict.pass { background: var(--good); }
.verdict.fail { background: var(--bad); }
.verdict.error { background: var(--doubt); }
.verdict.open { background: #5b6875; }
.tiles { display: grid; grid-template-columns: repeat(6, 1fr); gap: 1px; margin: 22px 0 4px; background: var(--line);
  border: 1px solid var(--line); border-radius: 6px; overflow: hidden; }
.tile { background: #fff; padding: 12px 14px 10px; }
.tile b { display: block; font-size: 25px; line-height: 1.15; font-weight: 600; }
.tile span { color: var(--soft); font-size: 13px; }
.tile.good b { color: var(--good); }
.tile.bad b { color: var(--bad); }
section.page { margin-top: 46px; border-top: 1px solid var(--line); padding-top: 26px; }
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
td.sim { color: var(--simulated); }
td.pub { color: var(--published); }
tr.bad td, tr.bad th { background: #fbeeec; }
.warn { color: var(--bad); font-weight: 600; }
.fine { margin: 8px 0 0; color: var(--soft); font-size: 13px; }
.badge { display: inline-block; min-width: 4.2em; padding: 0 7px; border-radius: 3px; text-align: center; font-size: 12px;
  font-weight: 650; letter-spacing: .03em; }
.badge.pass { color: var(--good); background: #e6f2ea; }
.badge.fail { color: #fff; background: var(--bad); }
.badge.error { color: #fff; background: var(--doubt); }
.badge.open { color: var(--soft); background: var(--faint); }
.code { font-family: ui-monospace, SFMono-Regular, Menlo, Consolas, "DejaVu Sans Mono", monospace; font-size: 12px; }
.shots td:first-child { text-align: right; }
.shots th:last-child { text-align: left; }
.shots td.left { width: 26%; color: var(--soft); }
figure { margin: 0 0 18px; }
figure h3 { margin: 0 0 2px; }
figcaption { color: var(--soft); font-size: 13px; }
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
footer { margin-top: 36px; color: var(--soft); font-size: 13px; }
@media screen and (max-width: 760px) {
  main { padding: 22px 16px; }
  header { flex-direction: column; gap: 14px; }
  .tiles { grid-template-columns: repeat(3, 1fr); }
  .provenance, #definitions dl { grid-template-columns: 1fr; }
  section { overflow-x: auto; }
}
@page { size: A4; margin: 13mm 12mm 14mm;
  @bottom-right { content: counter(page); font-size: 8pt; color: #5b6875; } }
@media print {
  html { background: #fff; }
  body { font-size: 9.2pt; }
  main { max-width: none; padding: 0; }
  h1 { font-size: 18pt; }
  h2 { font-size: 13.5pt; margin-bottom: 6pt; }
  h3 { font-size: 9.6pt; margin: 12pt 0 3pt; }
  table { font-size: 7.6pt; }
  th, td { padding: 2pt 4pt; }
  .badge, .code { font-size: 7pt; }
  .tile b { font-size: 15pt; }
  .tile { padding: 6pt 8pt; }
  .tile span, figcaption, .fine, .aside, .kicker { font-size: 7.8pt; }
  .verdict { font-size: 14pt; padding: 6pt 16pt; }
  .provenance, .parameters { font-size: 8pt; }
  section.page { break-before: page; margin-top: 0; border-top: 0; padding-top: 0; }
  figure, tr, .tiles, .provenance div { break-inside: avoid; }
  figure { margin-bottom: 8pt; }
  h2, h3 { break-after: avoid; }
  thead { display: table-header-group; }
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
