// The closer look of the report.
(function () {
  'use strict';
  const closings = JSON.parse(document.getElementById('closings').textContent);
  const select = document.getElementById('closer-shot');
  const stripped = document.getElementById('closer-stripped');
  const panels = closingPanels(document.getElementById('closer-panels'));
  const time = document.getElementById('device-time'), says = document.getElementById('device-says'), play = document.getElementById('device-play');
  const device = document.getElementById('device'), view = device && deviceView(document.getElementById('device-view'), JSON.parse(device.textContent));
  let playing = 0;

  /** The device as it stood at `t`, ms: travel from the laser, contacts from their voltage. */
  function show(t, line) {
    if (!view) return;
    const travel = panels.at('travel', t), contact = panels.at('contact', t), level = closings[select.selectedIndex].contact_level_V;
    const known = contact !== null && level !== null, shut = known && Math.abs(contact) < level;
    time.value = String(t);
    view(travel === null ? 0 : travel, shut);
    says.textContent = t.toFixed(2) + ' ms after switch-on: travel ' + (travel === null ? 'not known' : travel.toFixed(2) + ' mm') + ', contacts ' +
      (!known ? 'not known' : shut ? 'closed' : 'open');
    if (line) panels.mark(t);
  }
  function step() {
    const end = Number(time.max), next = Number(time.value) + 0.05;
    show(next > end ? Number(time.min) : next, true);
    playing = requestAnimationFrame(step);
  }
  function draw(range) {
    panels.draw(closings[select.selectedIndex], range, stripped.checked);
    if (!view) return;
    [time.min, time.max] = panels.whole().map((t) => t.toFixed(3));
    show(Math.min(Number(time.max), Math.max(Number(time.min), closings[select.selectedIndex].bounce[0] + 1)), false);
  }
  if (view) {
    time.addEventListener('input', () => show(Number(time.value), true));
    panels.whenLooked((t) => show(t, false));
    play.addEventListener('click', () => {
      if (playing) cancelAnimationFrame(playing), playing = 0;
      else step();
      play.textContent = playing ? 'stop' : 'play, 300 times slower';
    });
  }
  document.querySelectorAll('#closer button').forEach((b) => b.addEventListener('click', panels.actions[b.dataset.do]));
  closings.forEach((c) => select.add(new Option(c.name)));
  select.addEventListener('change', () => draw(null));
  stripped.addEventListener('change', () => draw(panels.range()));
  document.getElementById('closer').hidden = false;
  if (device) document.getElementById('device-box').hidden = false;
  draw(closings[0].bounce);
})();
