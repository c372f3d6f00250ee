// The closer look of the report: one closing, all channels over one time axis, zoomed together.
(function () {
  'use strict';
  const closings = JSON.parse(document.getElementById('closings').textContent);
  const root = document.getElementById('closer-panels');
  const select = document.getElementById('closer-shot');
  const stripped = document.getElementById('closer-stripped');
  const style = getComputedStyle(document.documentElement);
  const colour = (name) => style.getPropertyValue(name).trim();
  const colours = { measured: colour('--measured'), simulated: colour('--simulated'), raw: colour('--soft'), 'stripped off': colour('--cited') };
  let graphs = [], whole = [0, 1], shown = closings[0];

  function values(series) {
    const bytes = Uint8Array.from(atob(series.data), (c) => c.charCodeAt(0));
    const counts = new Int16Array(bytes.buffer);
    return Array.from(counts, (c) => (c === -32768 ? NaN : series.middle + c * series.step));
  }

  function marks(canvas, area, graph, named) {
    canvas.font = '11px sans-serif';
    for (const m of shown.marks) {
      const x = graph.toDomXCoord(m.at);
      if (x < area.x || x > area.x + area.w) continue;
      canvas.strokeStyle = canvas.fillStyle = m.simulated ? colours.simulated : colours.measured;
      canvas.globalAlpha = m.simulated ? 0.5 : 0.8;
      canvas.setLineDash(m.simulated ? [4, 3] : []);
      canvas.beginPath();
      canvas.moveTo(x, area.y);
      canvas.lineTo(x, area.y + area.h);
      canvas.stroke();
      if (m.text && named) canvas.fillText(m.text, x + 3, area.y + 10);
    }
    canvas.setLineDash([]);
    canvas.globalAlpha = 1;
  }

  function draw(range) {
    graphs.forEach((g) => g.destroy());
    graphs = [];
    root.textContent = '';
    shown = closings[select.selectedIndex];
    const time = Array.from({ length: shown.n }, (_, i) => shown.t0 + i * shown.dt);
    whole = [time[0], time[time.length - 1]];
    shown.channels.forEach((channel, index) => {
      const last = index === shown.channels.length - 1;
      const list = channel.series.filter((s) => stripped.checked || !['raw', 'stripped off'].includes(s.label));
      const columns = list.map(values);
      const box = document.createElement('div');
      box.className = 'closer-panel' + (last ? ' last' : '');
      box.setAttribute('role', 'img');
      box.setAttribute('aria-label', channel.name + ' in ' + channel.unit + ' over time, ' + list.map((s) => s.label).join(', '));
      root.appendChild(box);
      graphs.push(new Dygraph(box, time.map((t, i) => [t].concat(columns.map((c) => c[i]))), {
        labels: ['ms'].concat(list.map((s) => s.label)),
        colors: list.map((s) => colours[s.label]),
        ylabel: channel.name + ' / ' + channel.unit,
        xlabel: last ? 'time after switch-on / ms' : '',
        legend: 'always',
        labelsSeparateLines: false,
        dateWindow: range,
        axes: {
          x: { drawAxis: last, axisLabelFormatter: (v) => String(Math.round(v * 1000) / 1000), valueFormatter: (v) => v.toFixed(3) + ' ms' },
          y: { axisLabelWidth: 54, valueFormatter: (v) => v.toPrecision(5) + ' ' + channel.unit }
        },
        xLabelHeight: 16, yLabelWidth: 16, strokeWidth: 1.2, connectSeparatedPoints: false, animatedZooms: false,
        underlayCallback: (canvas, area, graph) => marks(canvas, area, graph, index === 0)
      }));
    });
    if (graphs.length > 1) Dygraph.synchronize(graphs, { zoom: true, selection: true, range: false });
  }

  function show(range) {
    graphs[0].updateOptions({ dateWindow: range });
  }
  function change(factor, shift) {
    const now = graphs[0].xAxisRange(), middle = (now[0] + now[1]) / 2 + shift * (now[1] - now[0]), half = factor * (now[1] - now[0]) / 2;
    show([Math.max(whole[0], middle - half), Math.min(whole[1], middle + half)]);
  }
  const actions = {
    whole: () => show(whole), bounce: () => show(shown.bounce), 'in': () => change(0.5, 0), out: () => change(2, 0),
    left: () => change(1, -0.25), right: () => change(1, 0.25)
  };
  document.querySelectorAll('#closer button').forEach((b) => b.addEventListener('click', actions[b.dataset.do]));
  closings.forEach((c) => select.add(new Option(c.name)));
  select.addEventListener('change', () => draw(null));
  stripped.addEventListener('change', () => draw(graphs[0].xAxisRange()));
  document.getElementById('closer').hidden = false;
  draw(shown.bounce);
})();
