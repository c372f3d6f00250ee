// @ts-check
// Test: one closing, drawn at once; its quantities; the trend over its campaign.
import { $, access, button, call, clear, field, known, measured, numberOf, sentences } from './base.js';
import * as conditions from './conditions.js';
import { openings, showQuantities } from './quantities.js';
import * as trend from './trend.js';

/** @typedef {import('./base.js').State} State */
/** @typedef {import('./base.js').Shot} Shot */

const panels = typeof Dygraph === 'undefined' ? null : closingPanels($('panels'));
/** @type {any} */
let closing = null;
// what arrives while another page is looked at is drawn when this one is opened: a hidden element has no size
let visible = false, undrawn = false;
let shown = 0, drawn = 0, newest = 0, stale = false, whole = true, chosen = false;
/** The campaign of the plan that is on: its simulations are made after its last closing. */
let firing = 0, idle = false;
/** @type {Promise<void>|null} */
let drawing = null;

for (const degrees of [0, 30, 60, 90, 120, 150])
  $('quick').append(button(degrees + '°', () => { field('angle').value = String(degrees); keep(); $('angle').focus(); prepare(null); }), ' ');
document.querySelectorAll('#closer button').forEach((b) => b.addEventListener('click', () => panels && panels.actions[/** @type {HTMLElement} */ (b).dataset.do || '']()));
$('stripped').addEventListener('change', () => closing && panels && panels.draw(closing, panels.range(), field('stripped').checked));
$('fire-form').addEventListener('submit', async (e) => {
  e.preventDefault();
  clear('refused');
  if (field('fire').disabled) {
    $('refused').textContent = 'Not now: ' + field('fire').title + '.';
    return;
  }
  const angle = numberOf(field('angle').value);
  if (!(angle >= 0 && angle <= 360)) {
    $('refused').textContent = 'Not fired: "' + field('angle').value + '" is no angle from 0 to 360 deg, such as 90.5.';
    return;
  }
  try {
    await conditions.settle();
    await call('POST', '/api/fire', field('at').value === 'touch' ? { touch_deg: angle } : { angle_deg: angle });
  } catch (errors) {
    refused('Not fired: ', errors);
  }
});
/** @param {string} what @param {unknown} errors */
function refused(what, errors) {
  const said = sentences(errors).join(' ');
  $('refused').textContent = said.startsWith(what) ? said : what + said;
}
conditions.whenRefused((errors) => refused('Not taken: ', errors));

// ---- what is likely to be fired next is simulated while a person still looks at it ----

let timer = 0, prepared = '';
/** @param {State|null} state */
function prepare(state) {
  if (state) prepared = '';
  window.clearTimeout(timer);
  timer = window.setTimeout(() => {
    const angle = numberOf(field('angle').value);
    if (field('fire').disabled || field('at').value !== 'closing' || !(angle >= 0 && angle <= 360) || prepared === String(angle)) return;
    prepared = String(angle);
    call('POST', '/api/prepare', { angle_deg: angle }).catch(() => {});
  }, 100);
}
for (const id of ['angle', 'at']) $(id).addEventListener('input', () => { clear('refused'); prepare(null); });
// what is chosen stands after a reload too: an angle of the touch must not become one of the coil
field('at').value = sessionStorage.getItem('powbench-at') || field('at').value;
field('angle').value = sessionStorage.getItem('powbench-angle') || field('angle').value;
function keep() {
  sessionStorage.setItem('powbench-at', field('at').value);
  sessionStorage.setItem('powbench-angle', field('angle').value);
}
for (const id of ['angle', 'at']) $(id).addEventListener('input', keep);

/** The touch asked for of the newest closings. @type {Map<number, string>} */
const aims = new Map();
/** What a shot was asked to be: an older one had other volts than the line above says of the next. @param {Shot} shot */
const askedOf = (shot) => (known(shot.supply_volts) && known(shot.mains_hertz) ? 'asked for ' + shot.supply_volts + ' V, ' + shot.mains_hertz + ' Hz' +
  (known(shot.hold_time_s) ? ', coil on for ' + Math.round(1e4 * shot.hold_time_s) / 10 + ' ms' : '') + '; ' : '');

/** Events in words first: where a person who has never seen a closing finds touch and bounce. @param {number} id */
export async function showShot(id) {
  // asked for at once, and shown in one frame: a text painted before its curves would keep them waiting
  const [shot, waveforms] = /** @type {[Shot, any[]]} */ (await Promise.all([call('GET', '/api/shots/' + id), call('GET', '/api/shots/' + id + '/closing').catch(() => [])]));
  const angle = known(shot.angle_deg) ? String(Math.round(100 * shot.angle_deg) / 100) + '°' : 'an angle not known';
  /** @param {string} s @param {number} factor */
  const value = (s, factor) => {
    const q = shot.quantities.find((one) => one.symbol === s);
    return q ? measured(q, factor) : '–';
  };
  $('shot').hidden = false;
  $('no-shot').hidden = true;
  whole = !shot.has_record || shot.quantities.some((q) => known(q.simulated));
  const asked = aims.get(id);
  const touched = known((shot.quantities.find((q) => q.symbol === 't_ct1') || { value: null }).value);
  const found = !touched ? 'no touch was observed' : 'touch ' + value('t_ct1', 1e3) + ' ms, bounce ' + value('t_ct_bon', 1e3) + ' ms' + (shot.bounce ? ', ' + openings(shot.bounce.openings.length) : '');
  $('shot-title').textContent = 'Shot ' + shot.id + (asked ? ', touch asked ' + asked + '°, coil on at ' : ' at ') + angle + ': ' +
    (shot.has_record ? found : shot.outcome + ', nothing was recorded');
  $('shot-reason').textContent = shot.origin + ', ' + shot.outcome + (shot.reason ? ': ' + shot.reason : shot.outcome === 'NOT JUDGED' ? ' (no limit is set)' : '') + '; ' + (shot.has_record ? 'coil on at ' +
    measured(shot.reached_rad, 180 / Math.PI) + '°' + (asked ? ' to touch at ' + asked + '°' : '') + ', touched at ' + measured(shot.touch_rad, 180 / Math.PI) + '° of the mains; ' : '') +
    askedOf(shot) + (whole || shot.kind !== 'measured' ? '' : shot.campaign === firing ? 'simulated after the last closing of the plan; ' :
      idle ? 'not simulated: a plan is simulated after its last closing; ' : '') + shot.started.replace('T', ' ').replace('Z', ' UTC');
  $('shot-title').classList.toggle('bad', shot.outcome === 'FAIL');
  showQuantities(shot);
  const again = id === drawn, zoomed = again && panels ? panels.range() : null;
  closing = waveforms[0] || null;
  drawn = id;
  undrawn = !visible;
  if (panels && closing) {
    if (visible) panels.draw(closing, zoomed || closing.bounce, field('stripped').checked);
  } else $('panels').textContent = shot.has_record ? 'This program was built without the charting library.' : 'This shot has no record.';
  if (panels) await trend.show(shot.campaign);
}

/** @param {boolean} on */
export function opened(on) {
  visible = on;
  if (!panels) return;
  trend.opened(on);
  if (!on) return;
  if (closing) panels.draw(closing, (!undrawn && panels.range()) || closing.bounce, field('stripped').checked);
  undrawn = false;
}

/** Nothing is known of the rig any more, until the next state arrives. */
export function unseen() {
  field('fire').disabled = true;
  field('fire').title = 'the bench program does not answer';
}

/** A shot that somebody wants to see; it stays until the next one is fired. @param {number} id */
export async function choose(id) {
  chosen = true;
  shown = newest;
  await showShot(id);
  $('shot').scrollIntoView({ block: 'start' });
}

/** The newest shot, one at a time: what arrives while one is drawn is drawn next. @param {State} state @param {State|null} before */
export function show(state, before) {
  field('fire').disabled = !!state.job || state.aiming || !state.status || state.status.state === 'fault' || !access.may_fire;
  field('fire').title = state.job ? 'the bench is busy' : state.aiming ? 'the angle for the coil is being sought' : !state.status ? 'the rig does not answer' : state.status.state === 'fault' && !state.job ? 'the rig is in fault; acknowledge it first' : access.may_fire ? '' : 'the token may not fire';
  conditions.show(state.plan);
  $('conditions').textContent = state.plan.mains_hertz + ' Hz, specimen ' + state.plan.specimen + '; these, voltage and time as in the plan last run or saved, until they are changed here';
  const aim = state.job && state.job.aim;
  $('aimed').textContent = state.aiming ? 'The angle at which the coil must be on for the contacts to touch there is being sought by simulation; it is fired at once when found. STOP cancels it.' : !aim ? '' : 'To touch there: coil on at ' + aim.closing_angle_deg.toFixed(1) + '°; touch is predicted ' + (1e3 * aim.touch_s).toFixed(2) + ' ms later.';
  if (before && ((state.job && !before.job) || (state.aiming && !before.aiming))) clear('refused');  // it was said of an older request
  if (before && before.newest_prediction !== state.newest_prediction) stale = true;  // the simulation's U has come
  if (before && before.job && !state.job) stale = stale || !whole || !!drawing;  // the simulation is there now; what is being drawn may have been asked for before
  newest = state.newest_shot || 0;
  idle = !state.job;
  firing = state.job && state.job.kind === 'plan' ? state.job.campaign || 0 : 0;
  if (known(state.newest_aim_deg)) aims.set(newest, state.newest_aim_deg.toFixed(1));
  if (!before || before.job || !before.status || before.plan.name !== state.plan.name || before.plan.specimen !== state.plan.specimen ||
    before.plan.supply_volts !== state.plan.supply_volts || before.plan.hold_time_ms !== state.plan.hold_time_ms) prepare(state);
  if (!before && chosen) shown = newest;
  drawNewest();
}
function drawNewest() {
  if (drawing || !newest || (newest === shown && !stale)) return;
  if (location.hash.startsWith('#test/')) history.replaceState(null, '', '#test');
  shown = newest;
  stale = false;
  drawing = showShot(shown).catch(() => {}).then(() => {
    drawing = null;
    drawNewest();
  });
}
