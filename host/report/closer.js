// The closer look of the report.
(function () {
  'use strict';
  const closings = JSON.parse(document.getElementById('closings').textContent);
  const select = document.getElementById('closer-shot');
  const stripped = document.getElementById('closer-stripped');
  const panels = closingPanels(document.getElementById('closer-panels'));
  const draw = (range) => panels.draw(closings[select.selectedIndex], range, stripped.checked);
  document.querySelectorAll('#closer button').forEach((b) => b.addEventListener('click', panels.actions[b.dataset.do]));
  closings.forEach((c) => select.add(new Option(c.name)));
  select.addEventListener('change', () => draw(null));
  stripped.addEventListener('change', () => draw(panels.range()));
  document.getElementById('closer').hidden = false;
  draw(closings[0].bounce);
})();
