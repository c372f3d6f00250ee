// @ts-check
// The live bench. State arrives over one WebSocket; everything a person does is an HTTP call.
import { $, call, duration, field, known, link, sentences, whenTokenGiven } from './base.js';
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

async function stop() {
  alarm('stopping …');
  try {
    const answer = await call('POST', '/api/stop');
    alarm('STOP: ' + answer.text + ' (' + Math.round(answer.ms) + ' ms)', answer.off);
  } catch (e) {
    alarm('STOP FAILED: the bench program does not answer. Use the emergency switch of the rig.');
  }
}
/** @param {string} text @param {boolean} [done] */
function alarm(text, done) {
  $('alarm').hidden = !text;
  $('alarm').textContent = text;
  $('alarm').classList.toggle('done', !!done);
}
$('stop').addEventListener('click', stop);
document.addEventListener('keydown', (e) => {
  if (e.key === 'Escape') stop();
});

// ---- pages ----

const tabs = /** @type {HTMLElement[]} */ ([...document.querySelectorAll('[role=tab]')]);
const pages = { test, parameters, documents, rig };
/** @param {string} name */
function open(name) {
  for (const t of tabs) {
    const on = t.getAttribute('aria-controls') === name;
    t.setAttribute('aria-selected', String(on));
    t.tabIndex = on ? 0 : -1;
    $(t.getAttribute('aria-controls') || '').hidden = !on;
  }
  if (location.hash !== '#' + name) history.replaceState(null, '', '#' + name);
  for (const [key, page] of Object.entries(pages)) page.opened(key === name);
}
tabs.forEach((t, i) => {
  t.addEventListener('click', () => open(t.getAttribute('aria-controls') || 'test'));
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

/** @param {State} s */
function showJob(s) {
  const { status, job } = s;
  $('state').textContent = status ? status.state : 'no answer';
  $('state').className = 'state' + (status ? (status.live ? ' live' : '') : ' gone');
  $('job').textContent = !s.link.answers ? s.link.error : !job ? '' : job.kind === 'single' ? job.doing :
    job.name + ': ' + job.done + ' of ' + job.shots + ', ' + (job.ending ? 'last shot' : job.doing) +
    (known(job.seconds_left) ? ', ' + duration(job.seconds_left) + ' left' : '') +
    (job.outside_limits ? ', ' + job.outside_limits + ' OUTSIDE LIMITS' : '');
  const plan = !!job && job.kind !== 'single';
  $('progress').hidden = $('pause').hidden = $('end').hidden = !plan;
  if (job) /** @type {HTMLProgressElement} */ ($('progress')).value = job.done / job.shots;
  field('end').disabled = !!job && job.ending;
  $('pause').textContent = job && job.paused ? 'Go on' : 'Pause';
}

/** @param {State} next */
function show(next) {
  const before = state;
  state = next;
  $('origin').textContent = next.rig.origin;
  $('rig-name').textContent = next.rig.model + ' ' + next.rig.serial;
  document.title = next.rig.origin + ', ' + (next.job ? next.job.doing : next.status ? next.status.state : 'no answer') + ': powbench';
  showJob(next);
  if (next.stop && !(before && before.stop)) alarm('STOP: ' + next.stop.text, next.stop.off);
  if (!next.stop && before && before.stop) alarm('');
  const outside = next.job ? next.job.outside_limits : 0;
  if (outside > (before && before.job ? before.job.outside_limits : 0)) alarm('Outside limits: ' + outside + ' of ' + (next.job ? next.job.done : 0) + ' shots of ' + (next.job ? next.job.name : ''));
  for (const page of Object.values(pages)) page.show(next, before);
}

function listen() {
  if (socket) socket.onclose = null;
  socket = new WebSocket('ws://' + location.host + link('/api/live'));
  socket.onmessage = (m) => show(JSON.parse(m.data));
  socket.onclose = () => {
    $('state').textContent = 'no bench';
    $('state').className = 'state gone';
    $('job').textContent = 'the bench program does not answer; trying again';
    window.setTimeout(listen, 500);
  };
}
whenTokenGiven(listen);
parameters.whenRun(() => { alarm(''); open('test'); });
documents.whenShot((id) => { open('test'); test.showShot(id); });

const wanted = location.hash.slice(1);
open(wanted in pages ? wanted : 'test');
call('GET', '/api/bench').then(show).catch(() => {});
listen();
