// @ts-check
// A list of choices of our own in the place of a native drop-down: of an open native one the browser takes Esc for itself, and on a
// phone it covers the page. Here Esc reaches the page, and the list lies under the top line with STOP. The select stays, unseen: it
// holds options and value.

const list = document.createElement('ul');
list.id = 'choices';
list.setAttribute('role', 'listbox');
list.hidden = true;
document.querySelector('main')?.append(list);

/** @typedef {{select: HTMLSelectElement, button: HTMLButtonElement}} Choice */
/** @type {Choice|null} */
let open = null;
let active = 0, typed = '', timer = 0;

/** @param {number} to */
function mark(to) {
  if (!open) return;
  active = Math.max(0, Math.min(list.children.length - 1, to));
  [...list.children].forEach((one, i) => one.classList.toggle('active', i === active));
  const item = list.children[active];
  if (!item) return;
  open.button.setAttribute('aria-activedescendant', item.id);
  item.scrollIntoView({ block: 'nearest' });
}
function close() {
  if (!open) return;
  open.button.setAttribute('aria-expanded', 'false');
  open.button.removeAttribute('aria-activedescendant');
  open.button.removeAttribute('aria-controls');
  open = null;
  list.hidden = true;
}
/** @param {number} index */
function take(index) {
  if (!open) return;
  const { select } = open, other = select.selectedIndex !== index;
  close();
  if (!other) return;
  select.selectedIndex = index;
  for (const event of ['input', 'change']) select.dispatchEvent(new Event(event, { bubbles: true }));
}
/** @param {Choice} choice */
function fill({ select, button }) {
  list.textContent = '';
  list.setAttribute('aria-label', button.getAttribute('aria-label') || '');
  [...select.options].forEach((option, i) => {
    const item = document.createElement('li');
    item.id = 'choice-' + i;
    item.setAttribute('role', 'option');
    item.setAttribute('aria-selected', String(i === select.selectedIndex));
    item.textContent = option.text;
    item.addEventListener('click', () => take(i));
    list.append(item);
  });
}
/** @param {Choice} choice */
function show(choice) {
  close();
  if (choice.button.disabled || !choice.select.options.length) return;
  open = choice;
  fill(choice);
  list.hidden = false;
  const box = choice.button.getBoundingClientRect();
  list.style.minWidth = box.width + 'px';
  list.style.left = scrollX + Math.max(4, Math.min(box.left, document.documentElement.clientWidth - list.offsetWidth - 4)) + 'px';
  const above = box.bottom + 2 + list.offsetHeight > innerHeight && box.top > innerHeight - box.bottom;  // a list that ends off the screen hides choices
  list.style.top = scrollY + (above ? box.top - 2 - list.offsetHeight : box.bottom + 2) + 'px';
  choice.button.setAttribute('aria-expanded', 'true');
  choice.button.setAttribute('aria-controls', list.id);
  mark(choice.select.selectedIndex);
}
/** The option that begins with what is typed, from the active one on. @param {string} letter @param {Choice} choice */
function find(letter, { select }) {
  window.clearTimeout(timer);
  timer = window.setTimeout(() => { typed = ''; }, 700);
  typed += letter.toLowerCase();
  const n = select.options.length, from = typed.length === 1 ? active + 1 : active;
  for (let i = 0; i < n; ++i)
    if (select.options[(from + i) % n].text.toLowerCase().startsWith(typed)) return mark((from + i) % n);
}
/** @param {KeyboardEvent} e @param {Choice} choice */
function pressed(e, choice) {
  if (e.key === 'Escape') return close();  // and on it goes: Esc is STOP
  if (e.ctrlKey || e.metaKey || (e.altKey && e.key.length === 1)) return;
  const letter = e.key.length === 1 && e.key !== ' ';
  if (!open) {
    if (e.key !== 'ArrowDown' && e.key !== 'ArrowUp' && !letter) return;  // Enter and the blank are a click
    show(choice);
    if (letter) find(e.key, choice);
  } else if (e.key === 'Tab') return take(active);
  else if (e.key === 'Enter' || e.key === ' ') take(active);
  else if (e.key === 'ArrowDown') mark(active + 1);
  else if (e.key === 'ArrowUp') mark(active - 1);
  else if (e.key === 'Home') mark(0);
  else if (e.key === 'End') mark(list.children.length - 1);
  else if (letter) find(e.key, choice);
  else return;
  e.preventDefault();
}

/** What changes a select from a script shows on its button too. @param {HTMLSelectElement} select @param {() => void} shown */
function follow(select, shown) {
  for (const name of ['value', 'selectedIndex']) {
    const own = /** @type {PropertyDescriptor} */ (Object.getOwnPropertyDescriptor(HTMLSelectElement.prototype, name));
    Object.defineProperty(select, name, {
      get() { return own.get?.call(select); },
      set(to) { own.set?.call(select, to); shown(); },
    });
  }
  new MutationObserver(shown).observe(select, { childList: true });
  select.addEventListener('change', shown);
}

/** @param {HTMLSelectElement} select */
function replace(select) {
  const label = select.closest('label'), named = /** @type {HTMLElement|null} */ (label?.cloneNode(true));
  named?.querySelectorAll('select').forEach((one) => one.remove());
  const button = document.createElement('button'), choice = { select, button };
  button.type = 'button';
  button.className = 'choice';
  button.setAttribute('role', 'combobox');
  button.setAttribute('aria-haspopup', 'listbox');
  button.setAttribute('aria-expanded', 'false');
  button.setAttribute('aria-label', (named?.textContent || '').replace(/\s+/g, ' ').trim());
  const shown = () => {
    button.textContent = select.selectedOptions[0]?.text || 'none';
    if (open === choice) fill(choice), mark(active);
  };
  button.addEventListener('click', () => (open === choice ? close() : show(choice)));
  button.addEventListener('keydown', (e) => pressed(e, choice));
  button.addEventListener('blur', close);
  select.hidden = true;
  select.before(button);  // the first of its label: a press on the label's words opens it
  follow(select, shown);
  shown();
}
list.addEventListener('mousedown', (e) => e.preventDefault());  // the focus stays where the keys are heard
window.addEventListener('resize', close);
document.querySelectorAll('select').forEach(replace);
export {};
