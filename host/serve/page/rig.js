// @ts-check
// Rig: who it is, how it is, its attributes, and a scope on the raw channels of the last records.
import { $, bytes, call, cells, clear, field, known, lacksPhase, list, newRow, sentences, stream, unitOf, warmsUp } from './base.js';

/** @typedef {import('./base.js').State} State */
/** @typedef {{name: string, unit: string, scale: number, offset: number, clip_low: number, clip_high: number, counts: Int16Array}} Trace */
/** @typedef {{shot: number, origin: string, rate_hz: number, samples: number, fire_sample: number, channels: Trace[]}} Frame */

const kept = 20, height = 78;
let gutter = 64;
/** @type {Frame[]} */
let frames = [];
/** @type {WebSocket|null} */
let socket = null;
let visible = false, wanted = false, drawn = 0;

/** @param {ArrayBuffer} data @returns {Frame} */
function unpack(data) {
  const length = new DataView(data).getUint32(0, true);
  const frame = JSON.parse(new TextDecoder().decode(new Uint8Array(data, 4, length)));
  frame.channels.forEach((/** @type {Trace} */ c, /** @type {number} */ i) => { c.counts = new Int16Array(data, 4 + length + 2 * i * frame.samples, frame.samples); });
  return frame;
}

/** Sample at which the trigger's channel crosses its level; -1: it does not. @param {Frame} f */
function triggerOf(f) {
  const name = field('trigger').value;
  if (name === 'fire') return f.fire_sample;
  const c = f.channels.find((one) => one.name === name);
  if (!c) return -1;
  const level = Number(field('level').value) / c.scale - c.offset, up = (field('slope').value === 'rising') === (c.scale > 0);
  for (let i = 1; i < f.samples; ++i)
    if (up ? c.counts[i - 1] < level && c.counts[i] >= level : c.counts[i - 1] > level && c.counts[i] <= level) return i;
  return -1;
}

/** Smallest and largest count within each column of the picture. @param {CanvasRenderingContext2D} g @param {Trace} c @param {number} from
 *  @param {number} span @param {number} width @param {(v: number) => number} y */
function trace(g, c, from, span, width, y) {
  g.beginPath();
  const each = span / width;
  for (let x = 0; x < width; ++x) {
    const a = Math.max(0, Math.floor(from + x * each)), b = Math.min(c.counts.length, Math.max(a + 1, Math.ceil(from + (x + 1) * each)));
    if (b <= a || from + x * each < 0) continue;
    let low = c.counts[a], high = low;
    for (let i = a + 1; i < b; ++i) {
      if (c.counts[i] < low) low = c.counts[i];
      if (c.counts[i] > high) high = c.counts[i];
    }
    g.lineTo(gutter + x, y(low));
    g.lineTo(gutter + x, y(high));
  }
  g.stroke();
}

/** Lowest and highest count, and their values to a hundredth of what lies between them. @param {Trace|undefined} c */
function scaleOf(c) {
  if (!c) return null;
  let low = Infinity, high = -Infinity;
  for (const v of c.counts) { if (v < low) low = v; if (v > high) high = v; }
  const clipped = low <= c.clip_low || high >= c.clip_high;
  if (high === low) { ++high; --low; }
  const [unit, factor] = unitOf(c.unit), step = Math.abs((high - low) * c.scale * factor) / 100;
  const digits = Math.max(0, Math.min(9, -Math.floor(Math.log10(step))));
  const labels = [low, high].map((v) => ((v + c.offset) * c.scale * factor).toFixed(digits).replace(/^-(?=[0.]+$)/, '') + ' ' + unit);
  return { low, high, clipped, labels };
}

function draw() {
  wanted = false;
  const canvas = /** @type {HTMLCanvasElement} */ (/** @type {unknown} */ ($('scope'))), g = canvas.getContext('2d');
  if (!g || !frames.length || !visible) return;
  const at = frames.length - 1 - Math.min(frames.length - 1, Number(field('back').value));
  const several = field('persist').checked ? frames.slice(Math.max(0, at - 7), at + 1) : [frames[at]], newest = frames[at];
  const names = [...document.querySelectorAll('#scope-channels input:checked')].map((e) => /** @type {HTMLInputElement} */ (e).value);
  canvas.width = canvas.clientWidth;
  canvas.height = Math.max(1, names.length) * height + 20;
  const style = getComputedStyle(document.documentElement), ink = style.getPropertyValue('--soft').trim(), line = style.getPropertyValue('--measured').trim();
  const span = Number(field('span').value) || newest.samples / newest.rate_hz * 1e3, share = 0.2;
  g.font = '12px sans-serif';
  const scales = names.map((name) => scaleOf(newest.channels.find((c) => c.name === name)));
  gutter = 6 + Math.max(40, ...scales.flatMap((s) => s ? s.labels.map((text) => Math.ceil(g.measureText(text).width)) : []));
  canvas.dataset.labels = scales.flatMap((s) => s ? s.labels : []).join(', ');
  canvas.dataset.gutter = String(gutter);
  const width = canvas.width - gutter;
  names.forEach((name, row) => {
    const top = row * height, shown = newest.channels.find((c) => c.name === name), scale = scales[row];
    if (!shown || !scale) return;
    const { low, high, clipped } = scale;
    const y = (/** @type {number} */ v) => top + height - 6 - (v - low) / (high - low) * (height - 14);
    g.strokeStyle = style.getPropertyValue('--line').trim();
    g.strokeRect(gutter, top + 2, width, height - 4);
    g.fillStyle = clipped ? style.getPropertyValue('--bad').trim() : ink;
    g.fillText(name + (clipped ? ' CLIPPED' : ''), gutter + 4, top + 14);
    g.textAlign = 'right';
    [low, high].forEach((v, i) => g.fillText(scale.labels[i], gutter - 3, y(v) + 4));
    g.textAlign = 'left';
    several.forEach((f, i) => {
      const c = f.channels.find((one) => one.name === name), t = triggerOf(f);
      if (!c || t < 0) return;
      g.globalAlpha = i === several.length - 1 ? 1 : 0.25;
      g.strokeStyle = line;
      const samples = span * 1e-3 * f.rate_hz;
      trace(g, c, t - share * samples, samples, width, y);
      g.globalAlpha = 1;
    });
    g.strokeStyle = g.fillStyle = style.getPropertyValue('--simulated').trim();
    if (name === field('trigger').value) {
      const level = y(Number(field('level').value) / shown.scale - shown.offset);
      g.beginPath();
      g.moveTo(gutter, level);
      g.lineTo(gutter + width, level);
      g.stroke();
    }
  });
  g.strokeStyle = g.fillStyle = style.getPropertyValue('--simulated').trim();
  g.beginPath();
  g.moveTo(gutter + share * width, 0);
  g.lineTo(gutter + share * width, canvas.height - 20);
  g.stroke();
  g.fillText('trigger', gutter + share * width + 3, canvas.height - 24);
  g.fillStyle = ink;
  for (let k = 0; k <= 5; ++k) {
    g.textAlign = k === 5 ? 'right' : k ? 'center' : 'left';
    g.fillText((span * (k / 5 - share)).toFixed(1) + (k === 5 ? ' ms' : ''), gutter + width * k / 5, canvas.height - 5);
  }
  g.textAlign = 'left';
  const missed = triggerOf(newest) < 0 ? '; the trigger was not met' : '';
  $('scope-says').textContent = 'Shot ' + newest.shot + ', ' + newest.origin + ', ' + newest.samples + ' samples at ' + newest.rate_hz / 1e3 + ' kS/s' + missed;
  canvas.setAttribute('aria-label', 'raw channels of shot ' + newest.shot + ': ' + names.join(', ') + missed);
  canvas.dataset.drawn = String(++drawn);
}
function redraw() {
  if (wanted) return;
  wanted = true;
  requestAnimationFrame(draw);
}

/** @param {Frame} f */
function add(f) {
  if (frames.some((one) => one.shot === f.shot && f.shot !== 0)) return;
  const first = !frames.length;
  frames = frames.concat(f).slice(-kept);
  $('no-record').hidden = true;
  $('scope').hidden = false;
  field('back').max = String(frames.length - 1);
  if (first) {
    const select = /** @type {HTMLSelectElement} */ (/** @type {unknown} */ ($('trigger')));
    for (const c of f.channels) {
      select.add(new Option(c.name, c.name));
      const label = document.createElement('label'), tick = document.createElement('input');
      tick.type = 'checkbox';
      tick.value = c.name;
      tick.checked = !['aux', 'mains_voltage'].includes(c.name);
      tick.addEventListener('change', redraw);
      label.append(tick, ' ' + c.name);
      $('scope-channels').append(label, ' ');
    }
  }
  redraw();
}
function listen() {
  if (!visible || socket) return;
  socket = new WebSocket(stream('/api/scope'));
  socket.binaryType = 'arraybuffer';
  socket.onmessage = (m) => { if (field('running').checked) add(unpack(m.data)); };
  socket.onclose = () => {
    socket = null;
    window.setTimeout(listen, 1000);
  };
}
for (const id of ['trigger', 'slope', 'level', 'span', 'persist', 'back']) $(id).addEventListener('input', redraw);
$('trigger').addEventListener('change', () => {
  const c = frames.length ? frames[frames.length - 1].channels.find((one) => one.name === field('trigger').value) : null;
  $('level-unit').textContent = c ? c.unit : '';
  if (!c) return;
  let low = Infinity, high = -Infinity;
  for (const v of c.counts) { low = Math.min(low, v); high = Math.max(high, v); }
  field('level').value = (((low + high) / 2 + c.offset) * c.scale).toPrecision(3);
  redraw();
});
$('fetch-shot').addEventListener('submit', async (e) => {
  e.preventDefault();
  try {
    add(unpack(await bytes('/api/shots/' + field('shot-number').value + '/record')));
  } catch (errors) {
    $('scope-says').textContent = sentences(errors).join(' ');
  }
});
$('read-attributes').addEventListener('click', async () => {
  try {
    const all = await call('GET', '/api/rig/attributes');
    clear('attributes');
    for (const a of all) cells(newRow('attributes'), [a.name, a.value]);
    $('attributes-say').textContent = all.length + ' attributes';
  } catch (errors) {
    $('attributes-say').textContent = sentences(errors).join(' ');
  }
});

/** @param {[string, string][]} rows @param {string} id */
function facts(id, rows) {
  clear(id);
  for (const [name, value] of rows) cells(newRow(id), [name, value]);
}
/** @param {number|null} x @param {number} digits @param {string} unit */
const text = (x, digits, unit) => (known(x) ? x.toFixed(digits) + ' ' + unit : 'not known');

/** @param {import('./base.js').Status} s */
function tracker(s) {
  facts('tracker', [['mains frequency', text(s.mains_hertz, 3, 'Hz')], ['uncertainty u of the phase now', text(s.phase_u_deg, 3, '°')],
    ['uncertainty u of the phase 20 ms ahead', text(s.phase_u_ahead_deg, 3, '°')], ['tolerance of the angle', text(s.angle_tolerance_deg, 3, '°')],
    ['what is wrong with the mains', s.phase_faults || 'not known'], ['in words', s.phase]]);
}

/** Everything that stands between a press and the coil. @param {import('./base.js').Status} s @param {boolean} sets a shot sets its source first */
function wouldFire(s, sets) {
  if (s.state === 'fault') return 'no: fault ' + s.fault;
  if (s.ready && s.ready !== 'yes') return 'no: ' + s.ready;
  if (lacksPhase(s) && sets && !warmsUp(s)) return 'yes, if the voltage and frequency of the shot are those of the rig: it sets them first; with those of the last one the phase is ' + s.phase;
  if (lacksPhase(s)) return 'not yet: the phase is ' + s.phase + '; a shot waits until it is';
  if (!known(s.phase_u_ahead_deg) || !known(s.angle_tolerance_deg)) return 'not known';
  const three = 3 * s.phase_u_ahead_deg;
  return three <= s.angle_tolerance_deg ? 'yes: nothing is in the way, and 3 u of the phase is within the tolerance' : 'no: 3 u = ' + three.toFixed(3) + '° is more than the tolerance';
}
/** @param {boolean|null} flag @param {string} yes @param {string} no */
const either = (flag, yes, no) => (flag === null ? 'not known: the rig does not tell' : flag ? yes : no);
/** @typedef {{number: number, name: string, watched: string, reaction: string, limit: string, when: string, cleared: string, advice: string}} Interlock */
/** @type {Interlock[]} */
let interlocks = [];
/** @param {import('./base.js').Status} s @param {boolean} sets */
function guards(s, sets) {
  const latched = parseInt(s.fault, 10) || 0;
  const row = interlocks.find((i) => i.number === latched);
  facts('guards', [['would it fire now', wouldFire(s, sets)], ['gate of the coil', either(s.gate, 'ON: the coil is energised', 'off')],
    ['safety relay', either(s.relay, 'told to close', 'told to open')],
    ['fault', latched ? s.fault + (row ? ': ' + row.advice : '') : 'none is latched'], ['last refusal', s.last_error]]);
  clear('interlocks');
  for (const i of interlocks)
    cells(newRow('interlocks'), [[i.number, 'n'], i.name, i.watched, i.reaction, i.limit, i.when, i.cleared === 'abort' ? 'acknowledging' : i.cleared.replace('abort, ', 'acknowledging, '),
      i.number === latched ? ['LATCHED', 'bad'] : '']);
}

/** @param {boolean} on */
export function opened(on) {
  visible = on;
  if (on && !interlocks.length) call('GET', '/api/rig/interlocks').then((all) => {
    interlocks = all;
    if (newest) show(newest);
  }).catch(() => {});
  if (on) { listen(); redraw(); }
  else if (socket) {
    socket.onclose = null;
    socket.close();
    socket = null;
  }
}
/** Nothing is known of the rig any more: what was read before would be taken for what is. */
export function unseen() {
  newest = null;
  for (const id of ['facts', 'tracker', 'guards', 'link']) facts(id, [['not known', 'the bench program does not answer']]);
  clear('channels');
  clear('interlocks');
}
/** @type {State|null} */
let newest = null;
/** @param {State} state */
export function show(state) {
  newest = state;
  if (!visible) return;
  const { rig, status, link: line } = state;
  facts('facts', [['rig', rig.uri + ', ' + rig.model + ' ' + rig.serial], ['origin', rig.origin], ['firmware', rig.firmware + ', boot ' + rig.boot_id],
    ['calibration', rig.calibration + (rig.calibration_expires ? ', valid until ' + rig.calibration_expires : '')],
    ['sampling', rig.sample_rate_hz / 1e3 + ' kS/s'], ['state', status ? status.state + (status.state === 'captured' ? ' (record taken, ready for the next closing)' : '') : 'no answer'],
    ['owner', status ? status.owner : 'not known']]);
  if (status) {
    tracker(status);
    guards(status, rig.programmable_source);
  } else for (const id of ['tracker', 'guards']) facts(id, [['not known', 'the rig does not answer']]);
  facts('link', [['answers', line.answers ? 'yes' : 'NO: ' + line.error], ['time of one answer', line.answer_ms.toFixed(1) + ' ms; median of 100 ' +
    line.median_ms.toFixed(1) + ' ms, worst ' + line.worst_ms.toFixed(1) + ' ms'], ['times asked', String(line.looks)],
    ['connections', line.connections + ', lost ' + line.lost]]);
  clear('channels');
  for (const c of rig.channels)
    cells(newRow('channels'), [c.id, c.label, [known(c.counts) ? String(c.counts) : '–', 'n'], [known(c.counts) ? (c.counts * c.per_count).toPrecision(4) : '–', 'n'], c.unit, [c.per_count.toPrecision(6), 'n']]);
  list('log', state.log.slice().reverse());
}
