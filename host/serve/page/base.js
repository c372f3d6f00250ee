// @ts-check
// What every page of the live bench uses: calls, numbers, elements.

/** @typedef {{value: number|null, u: number|null}} Measured */
/** @typedef {{symbol: string, unit: string, meaning: string, value: number|null, u: number|null, simulated: number|null,
 *   simulated_u: number|null, simulated_own: boolean, simulated_of_angle: number|null, over_U: number|null, agreement: string}} QuantityRow */
/** @typedef {{resolution_s: number|null, openings: {begin_s: number|null, length_s: number|null}[],
 *   hangs_on: {openings: number, longest_s: number, without_s: number|null}|null}} Bounce */
/** @typedef {{id: number, kind: string, angle_deg: number|null, reached_rad: Measured, outcome: string, reason: string, started: string,
 *   quantities: {[symbol: string]: Measured}}} ListedShot */
/** @typedef {{id: number, campaign: number, origin: string, kind: string, angle_deg: number|null, reached_rad: Measured,
 *   touch_rad: Measured, supply_volts: number|null, mains_hertz: number|null, hold_time_s: number|null,
 *   reached_volts: Measured, reached_hertz: Measured, simulated_basis: string|null, bounce: Bounce|null, bounce_simulated: Bounce|null, started: string, outcome: string, reason: string, has_record: boolean, quantities: QuantityRow[]}} Shot */
/** @typedef {{id: string, label: string, unit: string, per_count: number, counts: number|null}} ChannelLine */
/** @typedef {{uri: string, model: string, serial: string, firmware: string, boot_id: string, origin: string, calibration: string,
 *   calibration_expires: string, sample_rate_hz: number, programmable_source: boolean, channels: ChannelLine[]}} Rig */
/** @typedef {{answers: boolean, error: string, answer_ms: number, median_ms: number, worst_ms: number, looks: number,
 *   connections: number, lost: number}} Link */
/** @typedef {{state: string, live: boolean, gate: boolean|null, relay: boolean|null, ready: string, fault: string, phase: string, owner: string, last_error: string, mains_hertz: number|null,
 *   phase_u_deg: number|null, phase_u_ahead_deg: number|null, phase_faults: string, angle_tolerance_deg: number|null}} Status */
/** @typedef {{kind: string, name: string, campaign: number|null, doing: string, paused: boolean, ending: boolean, done: number,
 *   outside_limits: number, shots: number, hold_time_ms: number, seconds_left: number|null,
 *   aim: {touch_deg: number, closing_angle_deg: number, touch_s: number, gain: number}|null}} Job */
/** @typedef {{version: string, rig: Rig, link: Link, status: Status|null, job: Job|null, aiming: boolean, newest_shot: number|null, newest_aim_deg: number|null, newest_prediction: number|null,
 *   newest_campaign: number|null, interrupted: {shot: number, campaign: number, angle_deg: number|null}[], stop: {off: boolean, text: string, ms: number}|null, log: string[],
 *   ended: {name: string, campaign: number, done: number, shots: number, why: string}|null,
 *   plan: {name: string, specimen: string, supply_volts: number, mains_hertz: number, hold_time_ms: number, shots: number,
 *   usual: {supply_volts: number, hold_time_ms: number}}}} State */

/** @param {string} id @returns {HTMLElement} */
export function $(id) {
  const element = document.getElementById(id);
  if (!element) throw new Error('no element ' + id);
  return element;
}
/** @param {string} id */
export const field = (id) => /** @type {HTMLInputElement} */ ($(id));

let token = /** @type {HTMLMetaElement} */ (document.querySelector('meta[name="powbench-token"]')).content ||
  sessionStorage.getItem('powbench-token') || '';
/** @type {() => void} */
let tokenGiven = () => {};
/** @param {() => void} act */
export const whenTokenGiven = (act) => { tokenGiven = act; };

/** What the token may do, and one for addresses, which can only read: links are kept in histories and passed on. */
export const access = { may_fire: false, link_token: '' };

/** Asks what the token may do; false: nothing at all. */
export async function learnAccess() {
  const reply = await fetch('/api/access', { headers: token ? { Authorization: 'Bearer ' + token } : {} });
  $('token-form').hidden = reply.status !== 401;
  if (reply.ok) Object.assign(access, await reply.json());
  return reply.ok;
}
/** The token of a bench that was started anew comes with its page; one that a person has is asked for in the page, where Esc stays STOP. */
async function renewToken() {
  const page = new DOMParser().parseFromString(await (await fetch('/')).text(), 'text/html');
  const fresh = /** @type {HTMLMetaElement} */ (page.querySelector('meta[name="powbench-token"]')).content;
  if (!fresh || fresh === token) return false;
  token = fresh;
  await learnAccess();
  return true;
}
field('token-form').addEventListener('submit', async (e) => {
  e.preventDefault();
  token = field('token').value.trim();
  sessionStorage.setItem('powbench-token', token);
  $('token-says').textContent = await learnAccess() ? '' : 'The bench does not know this token.';
  tokenGiven();
});

/** An address with a token that may read, for what carries no header: links and WebSockets.
 * @param {string} path */
export const link = (path) => path + (access.link_token ? (path.includes('?') ? '&' : '?') + 'token=' + encodeURIComponent(access.link_token) : '');

/** The address of a WebSocket: through a proxy with TLS a page may open no other than an encrypted one.
 * @param {string} path */
export const stream = (path) => (location.protocol === 'https:' ? 'wss://' : 'ws://') + location.host + link(path);

/** No mistake of what was asked. */
export const unanswered = 'the bench program does not answer';

/** One HTTP call; throws the server's sentences.
 * @param {string} method @param {string} path @param {object} [body] @param {boolean} [again] @returns {Promise<any>} */
export async function call(method, path, body, again) {
  /** @type {Record<string, string>} */
  const headers = {};
  if (token) headers.Authorization = 'Bearer ' + token;
  if (body) headers['Content-Type'] = 'application/json';
  const reply = await fetch(path, { method, headers, body: body ? JSON.stringify(body) : undefined }).catch(() => { throw [unanswered]; });
  const json = await reply.json();
  if (reply.status === 401) {
    if (!again && await renewToken()) return call(method, path, body, true);
    $('token-form').hidden = false;
  }
  if (!reply.ok && path !== '/api/stop') throw json.errors || [json.error];
  return json;
}
/** Bytes. @param {string} path */
export async function bytes(path) {
  const reply = await fetch(path, { headers: token ? { Authorization: 'Bearer ' + token } : {} });
  if (!reply.ok) throw [(await reply.json()).error];
  return reply.arrayBuffer();
}
/** What was thrown, as sentences. @param {unknown} errors @returns {string[]} */
export const sentences = (errors) => (Array.isArray(errors) ? errors : [String(errors)]);

/** @param {unknown} x @returns {x is number} */
export const known = (x) => typeof x === 'number';
/** A number as people write it, with a point or a comma; NaN for anything else. @param {string} text */
export const numberOf = (text) => (/^\s*-?\d+([.,]\d*)?\s*$/.test(text) ? Number(text.replace(',', '.')) : NaN);
/** A value to the digits that its U leaves, as the report writes it. @param {number|null} value @param {number|null} U */
export function rounded(value, U) {
  if (!known(value)) return '–';
  const digits = known(U) && U > 0 ? Math.max(0, Math.min(4, 1 - Math.floor(Math.log10(U)))) : 3;
  const text = value.toFixed(digits).replace(/^-(?=[0.]+$)/, '');
  if (!known(U)) return text;
  if (/[1-9]/.test(U.toFixed(digits))) return text + ' ± ' + U.toFixed(digits);
  if (value === 0) return '0';  // a zero behind ± would claim that it is exact
  return U > 0 ? text + ' ± <' + (10 ** -digits).toFixed(digits) : text;
}
/** @type {{[unit: string]: [string, number]}} */
const readable = { s: ['ms', 1e3], m: ['mm', 1e3], A: ['mA', 1e3], N: ['N', 1], 'm/s': ['m/s', 1] };
/** The unit that people read, and its factor. @param {string} unit @returns {[string, number]} */
export const unitOf = (unit) => readable[unit] || [unit, 1];
/** @param {number|null} x @param {number} factor */
export const scaled = (x, factor) => (known(x) ? x * factor : null);
/** @param {Measured} m @param {number} factor */
export const measured = (m, factor) => rounded(scaled(m.value, factor), scaled(m.u, 2 * factor));
/** @param {number} s */
export const duration = (s) => (s < 90 ? s.toFixed(0) + ' s' : s < 5400 ? (s / 60).toFixed(0) + ' min' : (s / 3600).toFixed(1) + ' h');

/** @param {HTMLTableRowElement} row @param {(string | number | Node | [string|number|Node, string])[]} values */
export function cells(row, values) {
  for (const value of values) {
    const [content, kind] = Array.isArray(value) ? value : [value, ''];
    const cell = row.insertCell();
    cell.className = kind;
    cell.append(typeof content === 'number' ? String(content) : content);
  }
  return row;
}
/** @param {string} id */
export const newRow = (id) => /** @type {HTMLTableSectionElement} */ ($(id)).insertRow();
/** @param {string} id */
export const clear = (id) => { $(id).textContent = ''; };
/** @param {string} id @param {string[]} lines */
export function list(id, lines) {
  clear(id);
  for (const one of lines) {
    const item = document.createElement('li');
    item.textContent = one;
    $(id).append(item);
  }
}
/** Tables that are wider than their place say so: a finger finds no scroll bar. */
const widths = new ResizeObserver((all) => {
  for (const one of all) {
    const box = /** @type {HTMLElement} */ (one.target.closest('.wide'));
    box.classList.toggle('cut', box.scrollWidth > box.clientWidth + 1);
  }
});
for (const box of document.querySelectorAll('.wide')) {
  const says = document.createElement('p');
  says.className = 'aside fine';
  says.textContent = 'The table goes on to the side: drag it, or use the arrow keys.';
  box.after(says);
  /** @type {HTMLElement} */ (box).tabIndex = 0;
  box.setAttribute('role', 'group');
  box.setAttribute('aria-label', 'table');
  widths.observe(box);
  for (const table of box.children) widths.observe(table);
}

/** @type {{[state: string]: string}} */
const states = { idle: 'ready', armed: 'armed', firing: 'firing', captured: 'ready', fault: 'FAULT' };
/** What a state of the rig means to a person; its record is stored before the next closing. @param {string} state */
export const stateWord = (state) => states[state] || state;
/** The phase is not valid only because the rig has just begun to look; it passes by itself. @param {Status} s */
export const warmsUp = (s) => s.phase_faults === '1 warming_up';
/** A phase that is not valid yet hinders nobody: a shot waits for it. @param {Status} s */
export const lacksPhase = (s) => s.phase_faults !== '' && !/^0\b/.test(s.phase_faults);

/** @param {string} path @param {string} text */
export function anchor(path, text) {
  const a = document.createElement('a');
  a.href = link(path);
  a.target = '_blank';
  a.rel = 'noopener';
  a.textContent = text;
  return a;
}
/** @param {string} text @param {() => void} act */
export function button(text, act) {
  const b = document.createElement('button');
  b.type = 'button';
  b.textContent = text;
  b.addEventListener('click', act);
  return b;
}
