// @ts-check
// The live bench. State arrives over one WebSocket; everything a person does is an HTTP call.
import { $, access, call, duration, field, known, lacksPhase, learnAccess, sentences, stateWord, stream, warmsUp, whenTokenGiven } from './base.js';
import './choice.js';
import * as documents from './documents.js';
import * as parameters from './parameters.js';
import * as rig from './rig.js';
import * as test from './test.js';

/** @typedef {import('./base.js').State} State */
/** @type {State|null} */
let state = null;
/** @type {WebSocket|null} */
let socket = null;

// ---- stop: from every page, with one key ----

/** As everywhere in the bench. */
const clock = () => new Date().toISOString().slice(11, 19) + ' UTC';
/** When a stop was asked for that nothing has confirmed yet; unheard: the bench program has not even got it. */
let unconfirmed = '', unheard = false;
/** The confirmation that a state has brought since the last press: its answer may come behind the next closing. */
let said = '';

/** @param {{text: string, ms: number}} answer */
const stopWords = (answer) => 'STOP: ' + answer.text + ' (' + (answer.ms < 1 ? 'in less than 1' : 'in ' + Math.round(answer.ms)) + ' ms)';

async function stop() {
  unconfirmed = clock();
  said = '';
  documents.takeBackAtStop();
  alarm('stopping …');
  try {
    const answer = await call('POST', '/api/stop');
    unheard = false;
    if (answer.off) unconfirmed = '';
    if (answer.text !== said) alarm(stopWords(answer), answer.off ? 'done' : '');
  } catch (e) {
    unheard = true;
    alarm('STOP FAILED: the bench program does not answer. Use the emergency switch of the rig.');
  }
}
/** A stop that failed is true of its moment only: what did not get it is told again, and the rig's own word ends the alarm. @param {State} s */
function stopAgain(s) {
  if (!unconfirmed) return;
  if (unheard) {
    unheard = false;
    stop();
  } else if (s.stop && !s.stop.off && s.status && !s.status.live) {
    alarm('The STOP of ' + unconfirmed + ' was not confirmed in time. The rig answers again: ' + stateWord(s.status.state) + ', its coil is off.', 'done');
    unconfirmed = '';
  }
}
/** Red asks for an act; green is a coil confirmed off; amber is to be known. @param {string} text @param {'' | 'done' | 'notice'} [kind] */
function alarm(text, kind = '') {
  $('alarm').hidden = !text;
  $('alarm').textContent = text;
  $('alarm').className = kind;
}
/** What the rig confirmed was true while it was seen. */
function confirmationEnds() {
  if ($('alarm').className) alarm('');
}
$('stop').addEventListener('click', stop);
// before anything on the page can take the key for itself
window.addEventListener('keydown', (e) => {
  if (e.key === 'Escape') stop();
}, true);
/** Esc is heard only while the page has the focus: not in another window, in the address or the find bar, or in a dialog of the browser. */
function whetherHeard() {
  const heard = document.hasFocus();
  $('stop-key').textContent = heard ? 'Esc' : 'Esc: click the page first';
  $('stop').classList.toggle('deaf', !heard);
}
for (const event of ['focus', 'blur']) window.addEventListener(event, whetherHeard);
whetherHeard();

// ---- pages ----

const tabs = /** @type {HTMLElement[]} */ ([...document.querySelectorAll('[role=tab]')]);
const pages = { test, parameters, documents, rig };
/** The state is the bench's newest; without a connection nothing is known of it. */
let seen = false;
/** What the address names: a page, and the campaign of Documents or the shot of Test that was opened there. */
function named() {
  const [name, id] = location.hash.slice(1).split('/');
  return { name: name in pages ? name : 'test', id: Number(id) || 0 };
}
/** Back and forward go through what was opened, and do not leave the bench at the first press. @param {string} place */
function remember(place) {
  if (location.hash !== '#' + place) history.pushState(null, '', '#' + place);
}
/** @param {string} name */
function open(name) {
  for (const t of tabs) {
    const on = t.getAttribute('aria-controls') === name;
    t.setAttribute('aria-selected', String(on));
    t.tabIndex = on ? 0 : -1;
    $(t.getAttribute('aria-controls') || '').hidden = !on;
  }
  for (const [key, page] of Object.entries(pages)) page.opened(key === name);
  if (state && seen) for (const page of Object.values(pages)) page.show(state, state);
}
/** @param {string} name */
function go(name) {
  open(name);
  const campaign = name === 'documents' ? documents.shown() : 0;
  remember(name + (campaign ? '/' + campaign : ''));
}
/** What the address names, as after Back. */
function follow() {
  const { name, id } = named();
  if (name === 'documents') documents.choose(id);
  open(name);
  if (name === 'test' && id) test.choose(id);
}
window.addEventListener('popstate', follow);
documents.whenCampaign((id) => remember('documents/' + id));
tabs.forEach((t, i) => {
  t.addEventListener('click', () => go(t.getAttribute('aria-controls') || 'test'));
  t.addEventListener('keydown', (e) => {
    const step = e.key === 'ArrowRight' ? 1 : e.key === 'ArrowLeft' ? -1 : 0;
    if (!step) return;
    const next = tabs[(i + step + tabs.length) % tabs.length];
    next.focus();
    next.click();
  });
});

// ---- the job, on every page ----

/** @param {() => Promise<any>} act */
async function attempt(act) {
  try {
    alarm('');
    await act();
  } catch (errors) {
    alarm(sentences(errors).join(' '));
  }
}
$('pause').addEventListener('click', () => attempt(() => call('POST', '/api/plan/pause', { on: !(state && state.job && state.job.paused) })));
$('end').addEventListener('click', () => attempt(() => call('POST', '/api/plan/end', {})));

/** @param {State['ended']} ended */
function endedText(ended) {
  if (!ended) return '';
  if (ended.done >= ended.shots) return ended.name + ': all ' + ended.shots + ' done';
  const rest = 'the page Documents has a button for the rest';
  return ended.name + ': ' + ended.done + ' of ' + ended.shots + ' recorded; ' + (ended.why.includes('Documents') ? ended.why : (ended.why ? ended.why + '; ' : '') + rest);
}

/** The rig has switched off by itself, or does not arm: why, and the way out. @param {State} s */
function showFault(s) {
  const latched = !!s.status && s.status.state === 'fault';
  $('fault').hidden = !latched;
  if (!latched || !s.status) return;
  $('fault-says').textContent = 'FAULT ' + parseInt(s.status.fault, 10) + ': ' + s.status.last_error + '. ' + (s.status.gate === false ? 'The coil is off. ' : '') + 'Nothing is fired before that.' +
    (s.plan.supply_volts === s.plan.usual.supply_volts ? '' : ' The voltage asked for is ' + s.plan.supply_volts + ' V, not the usual ' + s.plan.usual.supply_volts + ' V' +
      (parseInt(s.status.fault, 10) === 1 && s.plan.supply_volts < 0.3 * s.plan.usual.supply_volts ? ': the rig takes so low a mains for lost.' : '.'));
  $('acknowledge').hidden = !access.may_fire || !!s.job;
}
$('acknowledge').addEventListener('click', () => attempt(() => call('POST', '/api/acknowledge', { fault: parseInt(state && state.status ? state.status.fault : '', 10) })));

/** @param {State} s */
function showJob(s) {
  const { status, job, ended } = s;
  // between two looks at the rig a shot may begin and end: "ready" would be the word of before
  const busy = (!!job || s.aiming) && !!status && !status.live && !(job && job.doing === 'paused');
  const on = !!status && status.gate === true;
  // the rig tells what it would refuse; a phase that is not there yet is waited for
  const ready = !status || status.ready === '' || status.ready === 'yes' || (status.state !== 'idle' && status.state !== 'captured');
  const word = status ? stateWord(status.state) : '', lacks = word === 'ready' && !!status && lacksPhase(status),
    bad = lacks && !warmsUp(status) && !s.rig.programmable_source;  // warming up passes by itself; a source is set by each shot
  $('state').textContent = !status ? 'no answer' : on ? 'COIL ON' : busy ? 'busy' : job && job.paused && !status.live ? 'paused' : !ready ? 'not ready' : bad ? 'phase not valid' : word;
  $('state').title = !status ? '' : !ready ? status.ready : lacks ? 'the phase is ' + status.phase + '; a shot waits until it is' : '';
  $('state').className = 'state' + (status ? (on || status.live || (busy && job && job.doing === 'firing') ? ' live' : !busy && status.state === 'fault' ? ' fault' : '') : ' gone');
  const doing = job && on ? 'coil on for ' + job.hold_time_ms + ' ms' + (s.rig.origin === 'SIMULATED RIG' ? ' of simulated time' : '') : job ? job.doing : '';
  $('job').textContent = !s.link.answers ? s.link.error : !job ? (s.aiming ? 'seeking the angle for the coil, then firing' : endedText(ended)) : job.kind === 'single' ? doing :
    job.name + ': ' + job.done + ' of ' + job.shots + ', ' + (job.ending ? 'last shot' : doing) +
    (known(job.seconds_left) ? ', ' + duration(job.seconds_left) + ' left' : '') +
    (job.outside_limits ? ', ' + job.outside_limits + ' OUTSIDE LIMITS' : '');
  const plan = !!job && job.kind !== 'single';
  $('progress').hidden = $('pause').hidden = $('end').hidden = !plan;
  if (job) /** @type {HTMLProgressElement} */ ($('progress')).value = job.done / job.shots;
  field('end').disabled = !!job && job.ending;
  field('pause').disabled = false;
  $('pause').textContent = job && job.paused ? 'Continue' : 'Pause';
}

/** When the connection was lost while the coil was on, or could be. */
let lostLive = '';
/** Nothing is known any more: what was last read would be taken for what is. */
function unseen() {
  const status = state && state.status;
  if (seen && state && (state.job || (status && (status.gate || status.live)))) {
    lostLive = clock();
    alarm('The bench program does not answer since ' + lostLive + ', in the middle of a job: ' +
      (status && status.gate ? 'THE COIL WAS ON' : 'the coil may be on') + ', and whether it is off by now is not known. Use the emergency switch of the rig.');
  } else if (seen) confirmationEnds();
  seen = false;
  field('pause').disabled = field('end').disabled = true;
  test.unseen();
  rig.unseen();
  $('state').textContent = 'no connection';
  $('state').className = 'state gone';
  $('job').textContent = 'the bench program does not answer; trying again';
}
/** What the program found of its last end. @param {State} s */
const interruptedText = (s) => s.interrupted.map((i) => ' Shot ' + i.shot + ' of campaign ' + i.campaign +
  (known(i.angle_deg) ? ', coil on at ' + Number(i.angle_deg.toFixed(2)) + '°,' : '') + ' was on when the program ended: it stands there as ERROR.').join('') +
  (s.newest_campaign ? '' : ' A plan that was not fired to its end can be gone on with on the page Documents.');
/** @param {State} s */
function seenAgain(s) {
  seen = true;
  if (!lostLive || !s.status || s.status.live || s.status.gate) return;
  alarm('The bench answers again, which it did not since ' + lostLive + ': the rig is ' + (s.job ? 'at work' : stateWord(s.status.state)) + ', its coil is off.' +
    (s.job ? '' : interruptedText(s)), !s.job && s.interrupted.length ? 'notice' : 'done');
  lostLive = '';
}

/** @param {State} next */
function show(next) {
  const before = state;
  state = next;
  $('origin').textContent = next.rig.origin;
  $('rig-name').textContent = next.rig.model + ' ' + next.rig.serial;
  document.title = next.rig.origin + ', ' + (next.status && next.status.gate ? 'COIL ON' : next.job ? next.job.doing : next.status ? stateWord(next.status.state) : 'no answer') + ': powbench';
  showJob(next);
  showFault(next);
  if (next.stop && next.stop.text !== before?.stop?.text) {
    documents.takeBackAtStop();
    if (!next.stop.off && !unconfirmed) unconfirmed = clock();
    said = next.stop.text;
    alarm(stopWords(next.stop), next.stop.off ? 'done' : '');
  }
  if (!next.stop && before && before.stop) alarm('');
  if (!next.status) confirmationEnds();
  if (next.job && before && !before.job) confirmationEnds();
  if (!before && next.interrupted.length && !next.newest_campaign && !next.stop) alarm(interruptedText(next).trim(), 'notice');
  stopAgain(next);
  seenAgain(next);
  // stays until the next job begins: a stop or a pause takes nothing back
  if (next.job && !(before && before.job)) $('outside').hidden = true;
  if (next.job && next.job.outside_limits) {
    $('outside').hidden = false;
    $('outside').textContent = 'Outside limits: ' + next.job.outside_limits + ' of ' + next.job.done + (next.job.kind === 'single' ? ' single closings' : ' shots of ' + next.job.name);
  }
  for (const page of Object.values(pages)) page.show(next, before);
}

function listen() {
  if (socket) socket.onclose = null;
  socket = new WebSocket(stream('/api/live'));
  socket.onmessage = (m) => show(JSON.parse(m.data));
  socket.onclose = () => {
    const again = () => window.setTimeout(listen, 500);
    learnAccess().then((known) => {
      if (!known) {
        unseen();
        $('job').textContent = 'the bench answers, and wants a token';
      }
      again();
    }, () => {
      unseen();
      again();
    });
  };
}
whenTokenGiven(listen);
for (const page of [parameters, documents]) page.whenRun(() => { alarm(''); go('test'); });
documents.whenShot((id) => {
  open('test');
  remember('test/' + id);
  test.choose(id);
});

if (!location.hash) history.replaceState(null, '', '#test');
follow();
learnAccess().then(() => call('GET', '/api/bench')).then(show).catch(() => {}).then(listen);
