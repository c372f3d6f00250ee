// @ts-check
// Parameters: plan, specimen and rig file as text and as a list of keys, with the checks of the files.
import { $, access, button, call, cells, clear, duration, field, newRow, sentences, unanswered } from './base.js';

/** @typedef {{section: string, section_meaning: string, key: string, unit: string, allowed: string, meaning: string, value: string,
 *   default: string, required: boolean}} Key */
/** @typedef {{name: string, seconds: number, coil_on_s: number, coil_on_percent: number, shots: {number: number, repeat: number,
 *   at_s: number, angle_deg: number, supply_volts: number, mains_hertz: number}[]}} Fired */

const mostShots = 500;
const texts = /** @type {{[kind: string]: {text: string, saved: string, template: string, file: string|null}}} */ ({});
let kind = 'plan', checks = 0, timer = 0, mistakes = true, why = '';
/** @type {Key[]} */
let keys = [];
/** @type {() => void} */
let ran = () => {};
/** @param {() => void} act */
export const whenRun = (act) => { ran = act; };

const area = /** @type {HTMLTextAreaElement} */ (/** @type {unknown} */ ($('text')));

async function load() {
  const of = kind;
  if (!texts[of]) {
    const file = await call('GET', '/api/files/' + of);
    const draft = sessionStorage.getItem(draftOf(of)), back = draft !== null && draft !== file.text;
    texts[of] = { text: back ? draft : file.text, saved: file.text, template: file.template, file: file.file };
    if (back) $('noted-file').textContent = 'Your text that was not saved is back; Discard my changes takes what the bench has.';
  }
  if (of === kind) put(texts[of].text);
}
/** What is typed outlives a reload of the page: a dialog that asks would take Esc from STOP. @param {string} of */
const draftOf = (of) => 'powbench-text-' + of;
function keep() {
  const t = texts[kind];
  if (t.text === t.saved) sessionStorage.removeItem(draftOf(kind));
  else sessionStorage.setItem(draftOf(kind), t.text);
}
/** @param {string} text */
function put(text) {
  area.value = texts[kind].text = text;
  keep();
  showFile();
  check();
}
function showFile() {
  const t = texts[kind];
  $('file').textContent = t.file ? t.file + (t.text === t.saved ? '' : ', changed and not saved') :
    'no ' + kind + ' file was named when the bench was started: Download keeps the text';
  field('save').disabled = !t.file;
  $('run').hidden = kind !== 'plan';
  $('text-label').textContent = { plan: 'Plan: what is fired', specimen: 'Specimen: one contactor, as it is simulated', rig: 'Rig: the simulated bench' }[kind] || '';
}

/** @param {Fired} p */
function showFired(p) {
  $('planned').textContent = p.name + ': ' + p.shots.length + ' shots in about ' + duration(p.seconds) + ', coil on for ' +
    p.coil_on_s.toFixed(1) + ' s, ' + p.coil_on_percent.toFixed(0) + ' % of the time. No mistakes found.';
  clear('shots-planned');
  for (const s of p.shots.slice(0, mostShots))
    cells(newRow('shots-planned'), [s.number, s.repeat, [s.at_s.toFixed(1) + ' s', 'n'], [s.angle_deg.toFixed(2) + '°', 'n'], [s.supply_volts + ' V', 'n'], [s.mains_hertz + ' Hz', 'n']]);
  $('fired').hidden = false;
  $('more-planned').textContent = p.shots.length > mostShots ? 'and ' + (p.shots.length - mostShots) + ' more' : '';
}

/** Mistakes by the key of the line they are of. @type {Map<string, {typed: string, says: string}>} */
let wrong = new Map();
/** @param {string} error */
const lineOf = (error) => Number((/^[^:]*:(\d+): /.exec(error) || [])[1] || 0);

/** Each sentence goes to its line. @param {string[]} errors */
function showErrors(errors) {
  clear('errors');
  for (const error of errors) {
    const item = document.createElement('li'), line = lineOf(error);
    item.append(line ? button(error, () => goTo(line)) : error);
    $('errors').append(item);
  }
}
/** @param {number} line */
function goTo(line) {
  const lines = area.value.split('\n'), begin = lines.slice(0, line - 1).reduce((sum, one) => sum + one.length + 1, 0);
  area.focus();
  area.setSelectionRange(begin, begin + (lines[line - 1] || '').length);
  area.scrollTop = Math.max(0, (line - 4) * area.scrollHeight / Math.max(1, lines.length));
}
/** What stands wrong in the text is shown in its field, with the reason: it does not vanish. @param {string[]} errors */
function findWrong(errors) {
  wrong = new Map();
  const lines = area.value.split('\n');
  for (const error of errors) {
    const line = lineOf(error), found = /^\s*([\w.-]+)\s*=\s*("(?:[^"\\]|\\.)*"|[^#]*)/.exec(lines[line - 1] || '');
    if (!found) continue;
    const heads = lines.slice(0, line).map((one) => /^\s*\[([^\]]*)\]/.exec(one)).filter((one) => one), head = heads[heads.length - 1];
    wrong.set('key ' + (head ? head[1].trim() : '') + ' ' + found[1], { typed: found[2].trim(), says: error.replace(/^[^:]*:/, 'line ') });
  }
}

function mayRun() {
  field('run').disabled = mistakes || why !== '';
  field('run').title = mistakes ? 'the plan has mistakes' : why;
}
/** Every mistake at once, or the keys and what would be fired. */
async function check() {
  const mine = ++checks;
  let reply;
  try {
    reply = await call('POST', '/api/files/' + kind + '/check', { text: area.value });
  } catch (errors) {
    reply = { errors: sentences(errors) };
  }
  if (mine !== checks) return;
  if (reply.errors[0] === unanswered) {
    $('planned').textContent = 'Not checked: ' + unanswered + '.';
    return;
  }
  showErrors(reply.errors);
  findWrong(reply.errors);
  mistakes = reply.errors.length > 0;
  mayRun();
  area.setAttribute('aria-invalid', String(reply.errors.length > 0));
  $('fired').hidden = true;
  $('planned').textContent = reply.errors.length ? reply.errors.length + (reply.errors.length === 1 ? ' mistake' : ' mistakes') : 'No mistakes found.';
  if (reply.fired) showFired(reply.fired);
  if (reply.keys) keys = reply.keys;
  const old = $('keys-old');
  old.hidden = !mistakes;
  old.textContent = !mistakes ? '' : keys.length ? 'Old values: the text has mistakes, and this list is of the last text without one.' :
    'No list yet: the text has mistakes.';
  $('keys-table').classList.toggle('old', mistakes);
  showKeys();
}

function showKeys() {
  const words = field('key-search').value.toLowerCase().split(/\s+/), active = document.activeElement && document.activeElement.id;
  clear('keys');
  let section = '';
  for (const k of keys) {
    const all = [k.section, k.key, k.meaning, k.section_meaning].join(' ').toLowerCase();
    if (!words.every((w) => all.includes(w)) || (field('key-changed').checked && k.value === k.default && !wrong.has('key ' + k.section + ' ' + k.key))) continue;
    if (k.section !== section) {
      const head = document.createElement('th');
      head.colSpan = 4;
      head.textContent = '[' + k.section + '] ' + k.section_meaning;
      newRow('keys').append(head);
      section = k.section;
    }
    const input = document.createElement('input');
    input.id = 'key ' + k.section + ' ' + k.key;
    input.autocomplete = 'off';
    input.value = k.value;
    input.placeholder = k.required ? 'must be given' : k.default || 'not set';
    input.setAttribute('aria-label', (k.section ? k.section + '.' : '') + k.key);
    input.addEventListener('change', () => set(k, input.value.trim()));
    const mistake = wrong.get(input.id), entry = document.createElement('span');
    entry.append(input);
    if (mistake) {
      const says = document.createElement('small');
      says.id = ('wrong ' + k.section + ' ' + k.key).replace(/ /g, '-');
      says.textContent = mistake.says;
      entry.append(says);
      input.value = mistake.typed;
      input.setAttribute('aria-invalid', 'true');
      input.setAttribute('aria-describedby', says.id);
    }
    const row = cells(newRow('keys'), [k.key, entry, k.unit, k.meaning + (k.allowed ? '; allowed ' + k.allowed : '')]);
    row.classList.toggle('wrong', !!mistake);
    row.classList.toggle('changed', k.value !== k.default);
  }
  const again = active ? document.getElementById(active) : null;
  if (again && again.closest('#keys')) again.focus();
}
/** @param {Key} k @param {string} value */
async function set(k, value) {
  try {
    put((await call('POST', '/api/files/' + kind + '/set', { text: area.value, section: k.section, key: k.key, value })).text);
  } catch (errors) {
    showErrors(sentences(errors));
  }
}

area.addEventListener('input', () => {
  if (!texts[kind]) return;
  texts[kind].text = area.value;
  keep();
  showFile();
  window.clearTimeout(timer);
  timer = window.setTimeout(check, 250);
});
for (const one of ['plan', 'specimen', 'rig'])
  $('file-' + one).addEventListener('change', () => { kind = one; keys = []; noLongerAsked(); $('noted-file').textContent = ''; load(); });
/** Text of one's own is replaced only on a second press; no dialog, which would take Esc from STOP. */
let forget = 0;
function noLongerAsked() {
  window.clearTimeout(forget);
  forget = 0;
  $('template').textContent = 'Start from a template';
}
$('template').addEventListener('click', () => {
  const t = texts[kind];
  if (!t) return;
  if (area.value !== t.saved && area.value !== t.template && area.value.trim() && !forget) {
    $('template').textContent = 'Replace my text by the template';
    forget = window.setTimeout(noLongerAsked, 6000);
    return;
  }
  noLongerAsked();
  put(t.template);
});
$('reload').addEventListener('click', () => {
  delete texts[kind];
  sessionStorage.removeItem(draftOf(kind));
  $('noted-file').textContent = '';
  load();
});
$('check').addEventListener('click', check);
$('key-search').addEventListener('input', showKeys);
$('key-changed').addEventListener('change', showKeys);
$('download').addEventListener('click', () => {
  const a = document.createElement('a');
  a.href = URL.createObjectURL(new Blob([area.value], { type: 'text/plain' }));
  a.download = texts[kind].file || 'lab.' + kind + '.toml';
  a.click();
  URL.revokeObjectURL(a.href);
});
/** @param {string} path @param {(reply: any) => void} done */
async function send(path, done) {
  try {
    done(await call('POST', path, { text: area.value }));
  } catch (errors) {
    showErrors(sentences(errors));
  }
}
$('save').addEventListener('click', () => send('/api/files/' + kind + '/save', (reply) => {
  texts[kind].saved = texts[kind].text;
  keep();
  showFile();
  $('noted-file').textContent = reply.file + ' saved: ' + reply.note;
}));
$('run').addEventListener('click', () => send('/api/plan/run', ran));

/** @param {boolean} on */
export function opened(on) {
  if (on) load();
}
/** @param {import('./base.js').State} state */
export function show(state) {
  why = state.job ? 'the bench is busy' : !state.status ? 'the rig does not answer' : state.status.state === 'fault' && !state.job ? 'the rig is in fault; acknowledge it first' : access.may_fire ? '' : 'the token may not fire';
  mayRun();
}
