// @ts-check
// Documents: campaigns and their shots, reports and exports, two campaigns compared, additions to the test record.
import { $, anchor, button, call, cells, clear, field, known, list, measured, newRow, numberOf, rounded, scaled, sentences, unitOf } from './base.js';

/** @typedef {import('./base.js').State} State */
/** @typedef {import('./base.js').ListedShot} ListedShot */
/** @typedef {{id: number, name: string, created: string, origin: string, rig: string, specimen: string, test: string, angles_deg: number[], shots: number,
 *   outcomes: {[outcome: string]: number}, outside_limits: number, planned_shots: number, finished: boolean, resumable: boolean,
 *   missing: {angle_deg: number, shots: number}[]}} Campaign */
/** @typedef {{value: number|null, u: number|null, U: number|null}} Mean */
/** @typedef {{quantity: string, unit: string, closing_angle_deg: number|null, n: number[], first: Mean, second: Mean,
 *   difference: number|null, U: number|null, over_U: number|null, agreement: string}} PairRow */

const mostShots = 2000;
/** @type {Campaign[]} */
let campaigns = [];
/** @type {ListedShot[]} */
let shots = [];
let shownCampaign = 0, running = 0, visible = false;
/** @type {(id: number) => void} */
let look = () => {};
/** @param {(id: number) => void} act */
export const whenShot = (act) => { look = act; };

const wantedAngle = () => (field('find-angle').value.trim() === '' ? null : numberOf(field('find-angle').value));
/** @param {number|null} a @param {number} b */
const near = (a, b) => known(a) && Math.abs(((a - b + 540) % 360) - 180) < 0.5;

async function load() {
  campaigns = await call('GET', '/api/campaigns');
  for (const id of ['first', 'second']) {
    const select = /** @type {HTMLSelectElement} */ (/** @type {unknown} */ ($(id))), before = select.value;
    select.textContent = '';
    for (const c of campaigns) select.add(new Option(c.id + ' ' + c.name + ', ' + c.created.slice(0, 16).replace('T', ' ') + ', ' + c.shots + (c.shots === 1 ? ' shot' : ' shots'), String(c.id)));
    if (before) select.value = before;
    else if (id === 'first' && campaigns.length > 1) select.selectedIndex = 1;
  }
  showCampaigns();
}
/** Without limits none is outside of them. @param {Campaign} c */
const judged = (c) => !!(c.outcomes.PASS || c.outcomes.FAIL);
const anglesNamed = 6;
/** What a plan still lacks: how many closings of which angle. @param {Campaign} c */
function missing(c) {
  if (!c.missing.length) return '';
  const some = c.missing.slice(0, anglesNamed).map((m) => m.shots + ' × ' + Number(m.angle_deg.toFixed(2)) + '°');
  return ': ' + some.join(', ') + (c.missing.length > anglesNamed ? ' and ' + (c.missing.length - anglesNamed) + ' more angles' : '') + ' missing';
}
function showCampaigns() {
  const words = field('search').value.toLowerCase().split(/\s+/), outcome = field('find-outcome').value, angle = wantedAngle();
  clear('campaigns');
  let n = 0;
  for (const c of campaigns) {
    const all = [c.id, c.name, c.created, c.specimen, c.origin, c.rig, c.test].join(' ').toLowerCase();
    if (!words.every((w) => all.includes(w)) || (outcome && !c.outcomes[outcome])) continue;
    if (angle !== null && !c.angles_deg.some((a) => near(a, angle))) continue;
    ++n;
    const links = document.createElement('span');
    links.append(anchor('/api/campaigns/' + c.id + '/report.html', 'report'), ' ', anchor('/api/campaigns/' + c.id + '/report.pdf', 'PDF'),
      ' ', anchor('/api/campaigns/' + c.id + '/shots.csv', 'CSV'), ' ', anchor('/api/campaigns/' + c.id + '/junit.xml', 'JUnit'));
    const count = document.createElement('span');
    const without = ['NOT OBSERVED', 'ERROR', 'TIMEOUT', 'ABORTED'].filter((o) => c.outcomes[o]).map((o) => ', ' + c.outcomes[o] + ' ' + o);
    count.append(c.shots + (c.resumable ? ' of ' + c.planned_shots : '') + without.join('') + (c.resumable ? ', unfinished' + missing(c) : ''));
    if (c.resumable && c.id !== running) count.append(' ', restButton(c));
    cells(newRow('campaigns'), [button(String(c.id), () => { opening(c.id); open(c.id); }), c.name, c.created.slice(0, 16).replace('T', ' '), c.specimen, c.origin,
      [count, 'n'], [judged(c) ? c.outside_limits : '–', c.outside_limits ? 'n bad' : 'n'], links]);
  }
  $('found').textContent = Number.isNaN(angle) ? '"' + field('find-angle').value + '" is no angle, such as 90.5' : campaigns.length === 0 ? 'No campaign yet: fire one closing on the page Test.' : n ? n + ' of ' + campaigns.length + ' campaigns' : 'no campaign matches, of ' + campaigns.length;
}

/** @type {() => void} */
let ran = () => {};
/** @param {() => void} act */
export const whenRun = (act) => { ran = act; };
/** The campaign whose button was pressed once; the list may be made anew between two presses. @type {number|null} */
let asked = null;
let forget = 0;
const askedFor = 6;
const restWords = 'Fire the rest';
/** Asks in its own words before it fires; no dialog, which would take Esc from STOP. @param {Campaign} c */
function restButton(c) {
  const question = restWords + ' of campaign ' + c.id + ' now';
  const rest = button(asked === c.id ? question : restWords, () => {
    const sure = asked === c.id;
    noLongerAsked();
    if (sure) {
      fireRest(c.id);
      return;
    }
    asked = c.id;
    rest.textContent = question;
    $('not-resumed').textContent = 'Press once more within ' + askedFor + ' s to fire.';
    forget = window.setTimeout(() => {
      noLongerAsked();
      $('not-resumed').textContent = 'Nothing was fired: the button must be pressed twice within ' + askedFor + ' s.';
    }, 1000 * askedFor);
  });
  return rest;
}
/** At a STOP: a second press must not fire what was asked before it. */
export function takeBackAtStop() {
  if (asked === null) return;
  noLongerAsked();
  $('not-resumed').textContent = 'Nothing was fired: the STOP came between the two presses. They begin anew.';
}
function noLongerAsked() {
  if (asked !== null) clear('not-resumed');
  window.clearTimeout(forget);
  asked = null;
  for (const b of document.querySelectorAll('#campaigns button')) if (b.textContent?.startsWith(restWords)) b.textContent = restWords;
}
/** What a plan that was not fired to its end lacks. @param {number} id */
async function fireRest(id) {
  clear('not-resumed');
  try {
    await call('POST', '/api/campaigns/' + id + '/resume', {});
    ran();
  } catch (errors) {
    $('not-resumed').textContent = sentences(errors).join(' ');
  }
}
/** @type {(id: number) => void} */
let opening = () => {};
/** @param {(id: number) => void} act */
export const whenCampaign = (act) => { opening = act; };
/** The campaign whose shots are listed; 0: none. */
export const shown = () => shownCampaign;
/** It is listed when the page is opened next. @param {number} id */
export function choose(id) {
  shownCampaign = id;
  $('campaign').hidden = true;
}
/** @param {number} id */
async function open(id) {
  const c = await call('GET', '/api/campaigns/' + id + '/shots');
  if (id !== shownCampaign) clear('noted');
  shownCampaign = id;
  shots = c.shots;
  $('campaign').hidden = false;
  $('campaign-title').textContent = 'Campaign ' + c.campaign + ', ' + c.name + ', ' + c.origin;
  showShots();
  notes();
}
function showShots() {
  const outcome = field('find-outcome').value, angle = wantedAngle();
  clear('shots');
  const some = shots.filter((s) => (!outcome || s.outcome === outcome) && (angle === null || near(s.angle_deg, angle)));
  for (const s of some.slice(0, mostShots)) {
    const q = s.quantities, files = document.createElement('span');
    files.append(anchor('/api/shots/' + s.id + '/waveforms.csv', 'CSV'), ' ', anchor('/api/shots/' + s.id + '/events.json', 'JSON'));
    cells(newRow('shots'), [button(String(s.id), () => look(s.id)), s.kind, [known(s.angle_deg) ? s.angle_deg.toFixed(2) : '–', 'n'],
      [measured(s.reached_rad, 180 / Math.PI), 'n'], [measured(q.t_ct1, 1e3), 'n'], [measured(q.t_ct_bon, 1e3), 'n'], [measured(q.t_ct2, 1e3), 'n'],
      s.outcome + (s.reason ? ': ' + s.reason : s.kind === 'simulated' ? ': at the conditions asked for' : ''), files]);
  }
  const fired = some.filter((s) => s.kind === 'measured').length;
  $('found-shots').textContent = (some.length < shots.length ? some.length + ' of ' : '') + shots.length + (shots.length === 1 ? ' shot' : ' shots') + (fired < some.length ? ', ' + (some.length - fired) + ' of them simulated' : '') + (some.length > mostShots ? ', the first ' + mostShots + ' are shown; CSV has all' : '') +
    (some.length ? '; numbers are those of the store, which counts simulated closings too' : '');
}
async function notes() {
  const all = await call('GET', '/api/campaigns/' + shownCampaign + '/annotations');
  list('notes', all.map((/** @type {{created: string, key: string, text: string}} */ n) => n.created + ' ' + n.key + ': ' + n.text));
}
$('annotate').addEventListener('submit', async (e) => {
  e.preventDefault();
  try {
    await call('POST', '/api/campaigns/' + shownCampaign + '/annotations', { key: field('note-key').value, text: field('note-text').value });
    $('noted').textContent = 'added';
    field('note-text').value = '';
    notes();
  } catch (errors) {
    $('noted').textContent = sentences(errors).join(' ');
  }
});
for (const id of ['search', 'find-outcome', 'find-angle'])
  $(id).addEventListener('input', () => { showCampaigns(); showShots(); });

$('compare').addEventListener('submit', async (e) => {
  e.preventDefault();
  clear('pair');
  $('pair-table').hidden = true;
  try {
    const c = await call('GET', '/api/compare?first=' + field('first').value + '&second=' + field('second').value);
    const rows = /** @type {PairRow[]} */ (c.rows), differ = rows.filter((r) => r.agreement === 'differs').length;
    $('pair-title').textContent = 'Campaign ' + c.second.id + ' (' + c.second.origin + ') against ' + c.first.id + ' (' + c.first.origin + '): ' +
      differ + ' of ' + rows.filter((r) => known(r.over_U)).length + ' comparisons differ by more than U' + (c.unlike.length ? '. The two were not alike in ' + c.unlike.join('; ') : '') +
      (c.same_records ? '. ' + c.same_records_sentence : '');
    for (const r of rows) {
      const [unit, factor] = unitOf(r.unit), two = (/** @type {Mean} */ m) => rounded(scaled(m.value, factor), scaled(m.U, factor));
      cells(newRow('pair'), [r.quantity, [known(r.closing_angle_deg) ? r.closing_angle_deg.toFixed(1) : '–', 'n'], [r.n.join(', '), 'n'], [two(r.first), 'n'], [two(r.second), 'n'],
        [rounded(scaled(r.difference, factor), scaled(r.U, factor)), 'n'], unit, [known(r.over_U) ? r.over_U.toFixed(2) : '–', 'n'],
        [r.agreement, r.agreement === 'differs' ? 'bad' : '']]);
    }
    $('pair-table').hidden = false;
  } catch (errors) {
    $('pair-title').textContent = sentences(errors).join(' ');
  }
});

/** @param {boolean} on */
export function opened(on) {
  visible = on;
  if (on) again();
}
/** @param {State} state @param {State|null} before */
export function show(state, before) {
  const was = running;
  running = (state.job && state.job.campaign) || 0;
  if (visible && before && ((before.job && !state.job) || was !== running)) again();
}
function again() {
  load();
  if (shownCampaign) open(shownCampaign).catch((e) => { if (Array.isArray(e)) choose(0); });  // the address may name none of this store
}
