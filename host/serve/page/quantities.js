// @ts-check
// Test: the quantities of one closing, measured beside simulated, and the openings of its bounce.
import { $, cells, clear, known, measured, newRow, rounded, scaled, unitOf } from './base.js';

/** @typedef {import('./base.js').Shot} Shot */
/** @typedef {import('./base.js').Bounce} Bounce */
/** @typedef {import('./base.js').QuantityRow} QuantityRow */

/** @param {number} n */
export const openings = (n) => n + (n === 1 ? ' opening' : ' openings');
/** @param {string} text */
function small(text) {
  const element = document.createElement('small');
  element.textContent = text;
  return element;
}

/** A difference within a U that is as large as the values tells nothing. @param {QuantityRow} q @returns {[string, string]} */
function verdict(q) {
  if (q.agreement === 'differs') return [q.agreement, 'bad'];
  const scale = Math.max(Math.abs(q.value || 0), Math.abs(q.simulated || 0));
  if (q.agreement === 'agrees' && Math.hypot(q.u || 0, q.simulated_u || 0) > scale / 2) return ['not resolved', ''];
  return [q.agreement, ''];
}

/** The simulated value: of this closing where it was simulated under its own conditions, else of its angle. @param {QuantityRow} q */
function simulatedCell(q) {
  const [, factor] = unitOf(q.unit), U = scaled(q.simulated_u, 2 * factor), cell = document.createElement('span');
  const text = rounded(scaled(q.simulated, factor), U), ofAngle = rounded(scaled(q.simulated_of_angle, factor), U);
  cell.append(text);
  if (q.simulated_own && ofAngle !== text) cell.append(document.createElement('br'), small('angle: ' + ofAngle));
  return cell;
}

/** Times that stand on what the channel only just resolves say so. @param {string} who @param {Bounce|null} b */
function hanging(who, b) {
  if (!b || !b.hangs_on || !known(b.hangs_on.without_s)) return [];
  const n = b.hangs_on.openings;
  return [document.createElement('br'), small(who + ': hangs on ' + (n === 1 ? 'a last opening of ' : n + ' last openings of at most ') +
    (1e6 * b.hangs_on.longest_s).toFixed(0) + ' µs, without ' + (n === 1 ? 'it ' : 'them ') + (1e3 * b.hangs_on.without_s).toFixed(2) + ' ms')];
}
/** @param {QuantityRow} q @param {Shot} shot */
function meaning(q, shot) {
  const cell = document.createElement('span');
  cell.append(q.meaning);
  if (q.symbol !== 't_ct_bon') return cell;
  if (shot.bounce) cell.append('; ' + openings(shot.bounce.openings.length) + (shot.bounce_simulated ? ', simulated ' + shot.bounce_simulated.openings.length : ''));
  cell.append(...hanging('measured', shot.bounce), ...hanging('simulated for the angle', shot.bounce_simulated));
  return cell;
}

/** @param {Shot} shot */
function showOpenings(shot) {
  const one = shot.bounce ? shot.bounce.openings : [], two = shot.bounce_simulated ? shot.bounce_simulated.openings : [];
  $('openings').hidden = !one.length && !two.length;
  $('openings-says').textContent = 'Openings in the bounce: ' + one.length + ' measured' + (shot.bounce_simulated ? ', ' + two.length + ' simulated for the angle' : '') +
    (shot.bounce && known(shot.bounce.resolution_s) ? '; the shortest that this channel resolves has ' + (1e6 * shot.bounce.resolution_s).toFixed(0) + ' µs' : '');
  clear('openings-list');
  for (let i = 0; i < Math.max(one.length, two.length); ++i)
    cells(newRow('openings-list'), [[i + 1, 'n'], ...[one[i], two[i]].flatMap((o) => /** @type {[string, string][]} */ ([
      [rounded(o ? scaled(o.begin_s, 1e3) : null, null), 'n'], [o && known(o.length_s) ? (1e6 * o.length_s).toFixed(0) : '–', 'n']]))]);
}

/** @param {Shot} shot */
export function showQuantities(shot) {
  clear('quantities');
  for (const q of shot.quantities) {
    const [unit, factor] = unitOf(q.unit);
    cells(newRow('quantities'), [q.symbol, meaning(q, shot), [measured(q, factor), 'n'], [simulatedCell(q), 'n sim'], unit,
      [known(q.over_U) ? q.over_U.toFixed(2) : '–', 'n'], verdict(q)]);
  }
  const own = shot.quantities.some((q) => q.simulated_own);
  $('simulated-of').textContent = !shot.simulated_basis ? '' : (own ? 'Simulated: for this closing, at the ' +
    measured(shot.reached_rad, 180 / Math.PI) + '°, ' + measured(shot.reached_volts, 1) + ' V and ' + measured(shot.reached_hertz, 1) + ' Hz that it had. "angle": ' :
    'Simulated: ') + 'for the angle, one simulation ' + shot.simulated_basis + '; the simulated curves, Documents and the report show that one.' +
    (shot.origin === 'SIMULATED RIG' ? ' The simulated rig is made of the same model: here agreement says nothing of a real contactor.' : '');
  showOpenings(shot);
}
