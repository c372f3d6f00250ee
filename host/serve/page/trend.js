// @ts-check
// Test: one quantity from shot to shot over a campaign, each angle with a colour and a marker of its own.
import { $, call, clear, known, rounded, scaled, unitOf } from './base.js';

/** @typedef {import('./base.js').ListedShot} ListedShot */
/** @typedef {{label: string, shots: ListedShot[]}} Angle */
/** @typedef {(g: CanvasRenderingContext2D, x: number, y: number, r: number) => void} Marker */

const longest = 500, colours = 6;
/** Their number and that of the colours have no common factor: 30 angles look different. @type {{[name: string]: Marker}} */
const markers = {
  circle: (g, x, y, r) => g.arc(x, y, r, 0, 2 * Math.PI),
  square: (g, x, y, r) => g.rect(x - 0.9 * r, y - 0.9 * r, 1.8 * r, 1.8 * r),
  triangle: (g, x, y, r) => polygon(g, x, y, 1.3 * r, 3),
  diamond: (g, x, y, r) => polygon(g, x, y, 1.3 * r, 4),
  cross: (g, x, y, r) => { g.moveTo(x - r, y - r); g.lineTo(x + r, y + r); g.moveTo(x - r, y + r); g.lineTo(x + r, y - r); }
};
const names = Object.keys(markers);
/** @param {CanvasRenderingContext2D} g @param {number} x @param {number} y @param {number} r @param {number} corners */
function polygon(g, x, y, r, corners) {
  for (let k = 0; k < corners; ++k) g.lineTo(x + r * Math.sin(2 * Math.PI * k / corners), y - r * Math.cos(2 * Math.PI * k / corners));
  g.closePath();
}
/** @param {CanvasRenderingContext2D} g @param {number} place @param {number} x @param {number} y @param {string} colour @param {number} r */
function mark(g, place, x, y, colour, r) {
  g.beginPath();
  g.strokeStyle = g.fillStyle = colour;
  g.lineWidth = 1.6;
  markers[names[place % names.length]](g, x, y, r);
  g.stroke();
  if (names[place % names.length] !== 'cross') g.fill();
}

/** @type {any} */
let graph = null;
let visible = false, campaign = 0, newest = 0;
/** @type {ListedShot[]} */
let shots = [];

const of = () => /** @type {HTMLSelectElement} */ ($('trend-of'));
const at = () => /** @type {HTMLSelectElement} */ ($('trend-at'));

/** Only what is new is asked for, and what is shown is bounded: a campaign may have thousands of shots. @param {number} id */
export async function show(id) {
  if (id !== campaign) shots = [], newest = 0, campaign = id;
  const fresh = /** @type {ListedShot[]} */ ((await call('GET', '/api/campaigns/' + id + '/shots?after=' + newest)).shots);
  for (const s of fresh) newest = Math.max(newest, s.id);
  shots = shots.concat(fresh.filter((s) => s.kind === 'measured')).slice(-longest);
  draw();
}

/** The shots that have a value, by angle. @param {string} symbol @returns {Angle[]} */
function angles(symbol) {
  /** @type {Map<number, ListedShot[]>} */
  const found = new Map();
  for (const s of shots) {
    if (!known(s.quantities[symbol].value)) continue;
    const angle = known(s.angle_deg) ? s.angle_deg : Infinity;
    found.set(angle, (found.get(angle) || []).concat(s));
  }
  return [...found].sort((a, b) => a[0] - b[0]).map(([angle, some]) => ({ label: angle === Infinity ? 'angle not known' : Math.round(100 * angle) / 100 + '°', shots: some }));
}

/** What can be chosen: all angles, or one. @param {Angle[]} all */
function choices(all) {
  const before = at().value;
  at().textContent = '';
  at().add(new Option('all angles', ''));
  for (const a of all) at().add(new Option(a.label, a.label));
  at().value = all.some((a) => a.label === before) ? before : '';
}

function draw() {
  if (!visible) return;
  const option = of().selectedOptions[0], symbol = of().value, [unit, factor] = unitOf(option.dataset.unit || 's');
  const all = angles(symbol);
  choices(all);
  const style = getComputedStyle(document.documentElement);
  const shown = all.map((a, place) => ({ ...a, place, colour: style.getPropertyValue('--angle-' + place % colours).trim() })).filter((a) => at().value === '' || a.label === at().value);
  const rows = shown.flatMap((a, column) => a.shots.map((s) => {
    const q = s.quantities[symbol];
    return [s.id, ...shown.map((_, i) => (i === column ? [scaled(q.value, factor), scaled(q.u, 2 * factor) || 0] : [null, null]))];
  })).sort((a, b) => Number(a[0]) - Number(b[0]));
  if (graph) graph.destroy();
  graph = null;
  clear('trend');
  $('trend-none').hidden = rows.length > 0;
  legend(shown, symbol, unit, factor);
  $('trend').setAttribute('aria-label', option.text + ' over the number of the shot, ' + rows.length + ' shots; ' +
    [...$('trend-angles').children].map((one) => one.textContent).join('; '));
  if (!rows.length) return;
  /** @type {{[label: string]: object}} */
  const series = {};
  for (const a of shown) {
    const point = (/** @type {any} */ _g, /** @type {string} */ _name, /** @type {CanvasRenderingContext2D} */ canvas, /** @type {number} */ x, /** @type {number} */ y) => mark(canvas, a.place, x, y, a.colour, 3.5);
    series[a.label] = { color: a.colour, drawPointCallback: point, drawHighlightPointCallback: point };
  }
  graph = new Dygraph($('trend'), rows, { labels: ['shot', ...shown.map((a) => a.label)], series, ylabel: option.text + ' / ' + unit, errorBars: true, sigma: 1, drawPoints: true,
    pointSize: 4, strokeWidth: 0.5, connectSeparatedPoints: true, includeZero: false, xRangePad: 12, yRangePad: 8,
    dateWindow: rows.length === 1 ? [Number(rows[0][0]) - 1, Number(rows[0][0]) + 1] : null,  // one point has no span of its own
    axes: { y: { axisLabelWidth: 62, axisLabelFormatter: yLabel }, x: { axisLabelFormatter: (/** @type {number} */ v) => (Number.isInteger(v) ? String(v) : '') } } });
}

/** As many digits as the span needs: no two labels are alike. @param {number} v @param {any} _g @param {any} _o @param {any} graphed */
function yLabel(v, _g, _o, graphed) {
  const [low, high] = graphed.yAxisRange();
  return v.toFixed(Math.max(0, Math.min(6, 1 - Math.floor(Math.log10(high - low)))));
}

/** Each angle with its marker, its number of shots, their mean and span. @param {(Angle & {place: number, colour: string})[]} shown @param {string} symbol @param {string} unit @param {number} factor */
function legend(shown, symbol, unit, factor) {
  clear('trend-angles');
  for (const a of shown) {
    const item = document.createElement('li'), sign = document.createElement('canvas');
    sign.width = sign.height = 14;
    sign.setAttribute('aria-hidden', 'true');
    const g = sign.getContext('2d');
    if (g) mark(g, a.place, 7, 7, a.colour, 4);
    item.dataset.colour = a.colour;
    item.dataset.marker = names[a.place % names.length];
    const values = a.shots.map((s) => factor * Number(s.quantities[symbol].value));
    const mean = values.reduce((sum, v) => sum + v, 0) / values.length, low = Math.min(...values), high = Math.max(...values);
    item.append(sign, ' ' + a.label + ': ' + (values.length === 1 ? '1 shot, ' + rounded(mean, null) :
      values.length + ' shots, mean ' + rounded(mean, null) + ', from ' + rounded(low, null) + ' to ' + rounded(high, null)) + ' ' + unit);
    $('trend-angles').append(item);
  }
}
for (const id of ['trend-of', 'trend-at']) $(id).addEventListener('change', draw);
matchMedia('(prefers-color-scheme: dark)').addEventListener('change', draw);

/** @param {boolean} on */
export function opened(on) {
  visible = on;
  draw();
}
