// @ts-check
// Test: the voltage and the hold time of a single closing, beside the button that fires it.
import { $, call, field, numberOf, sentences } from './base.js';

/** @typedef {import('./base.js').State} State */
/** @typedef {'supply_volts'|'hold_time_ms'} Key */

/** @type {{id: string, key: Key, unit: string}[]} */
const fields = [{ id: 'volts', key: 'supply_volts', unit: 'V' }, { id: 'hold', key: 'hold_time_ms', unit: 'ms' }];
/** @type {{[key: string]: number}} */
const inForce = {};

/** @type {State['plan']['usual']|null} */
let usual = null;
/** Said while it is typed: afterwards it is too late. A plan's own value that nobody types is unusual too. */
function unusual() {
  if (!usual) return;
  const other = [];
  for (const { id, key, unit } of fields) {
    const value = numberOf(field(id).value), is = !Number.isNaN(value) && value !== usual[key];
    field(id).classList.toggle('other', is);
    if (is) other.push(usual[key] + ' ' + unit);
  }
  $('unusual').textContent = other.length ? 'not the usual ' + other.join(', ') : '';
}
for (const { id } of fields) field(id).addEventListener('input', unusual);

/** What a person has typed stays until it is taken. @param {State['plan']} plan */
export function show(plan) {
  for (const { id, key } of fields) {
    const input = field(id), was = input.dataset.shown;
    inForce[key] = plan[key];
    if (was === undefined || (input.value === was && document.activeElement !== input)) input.value = String(plan[key]);
    if (numberOf(input.value) === plan[key]) input.removeAttribute('aria-invalid');
    input.dataset.shown = String(plan[key]);
  }
  usual = plan.usual;
  unusual();
}

async function send() {
  /** @type {{[key: string]: number}} */
  const wanted = {};
  for (const { id, key, unit } of fields) {
    const value = numberOf(field(id).value);
    if (Number.isNaN(value)) field(id).setAttribute('aria-invalid', 'true');
    if (Number.isNaN(value)) throw ['"' + field(id).value + '" is no number of ' + unit + '.'];
    if (value !== inForce[key]) wanted[key] = value;
  }
  try {
    if (Object.keys(wanted).length) Object.assign(inForce, await call('POST', '/api/conditions', wanted));
    for (const { id } of fields) field(id).removeAttribute('aria-invalid');
  } catch (errors) {
    for (const { id, key } of fields)
      if (sentences(errors).some((e) => e.includes(key))) field(id).setAttribute('aria-invalid', 'true');
    throw errors;
  }
}
/** @type {Promise<void>} */
let sending = Promise.resolve();
/** What stands in the fields is in force, or the reason is thrown. One after the other: a change and a press may come at once. */
export function settle() {
  sending = sending.catch(() => {}).then(send);
  return sending;
}
/** @param {(errors: unknown) => void} refused */
export function whenRefused(refused) {
  // Enter fires in the field of the angle; here it takes the value
  for (const { id } of fields) field(id).addEventListener('keydown', (e) => {
    if (e.key !== 'Enter') return;
    e.preventDefault();
    settle().catch(refused);
  });
  for (const { id } of fields) field(id).addEventListener('change', () => { settle().catch(refused); });
}
