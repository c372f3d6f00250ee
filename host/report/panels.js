// Closings over one time axis, all channels zoomed together; for the report and for the live page.
function closingPanels(root) {
  'use strict';
  const style = getComputedStyle(document.documentElement);
  const colour = (name) => style.getPropertyValue(name).trim();
  // By label of a series; of the theme that is on when a closing is drawn.
  let colours = {};
  let graphs = [], whole = [0, 1], shown = null, withRaw = false, cursor = null, looked = () => {};

  function values(series) {
    if (series.values) return series.values;
    const bytes = atob(series.data), out = new Float64Array(bytes.length / 2);
    for (let i = 0; i < out.length; ++i) {
      const count = ((bytes.charCodeAt(2 * i) | bytes.charCodeAt(2 * i + 1) << 8) << 16) >> 16;
      out[i] = count === -32768 ? NaN : series.middle + count * series.step;
    }
    return (series.values = out);
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
    if (cursor === null) return;
    const x = graph.toDomXCoord(cursor);
    if (x < area.x || x > area.x + area.w) return;
    canvas.strokeStyle = colour('--ink');
    canvas.beginPath();
    canvas.moveTo(x, area.y);
    canvas.lineTo(x, area.y + area.h);
    canvas.stroke();
  }

  // what the inputs' uncertainty leaves open of a simulated curve
  function band(canvas, area, graph, channel) {
    const curve = channel.band && channel.series.find((s) => s.label === 'simulated');
    if (!curve) return;
    const { t0, dt, half } = channel.band, middle = values(curve);
    const upper = [], lower = [];
    const fill = () => {
      if (upper.length) {
        canvas.beginPath();
        upper.concat(lower.reverse()).forEach(([x, y], i) => (i ? canvas.lineTo(x, y) : canvas.moveTo(x, y)));
        canvas.fill();
      }
      upper.length = lower.length = 0;
    };
    canvas.save();
    canvas.beginPath();
    canvas.rect(area.x, area.y, area.w, area.h);
    canvas.clip();
    canvas.fillStyle = colours.simulated;
    canvas.globalAlpha = 0.25;
    half.forEach((h, k) => {
      const t = t0 + (k + 0.5) * dt, y = middle[Math.round((t - shown.t0) / shown.dt)];
      if (h === null || y === undefined || Number.isNaN(y)) return fill();
      upper.push([graph.toDomXCoord(t), graph.toDomYCoord(y + h)]);
      lower.push([graph.toDomXCoord(t), graph.toDomYCoord(y - h)]);
    });
    fill();
    canvas.restore();
  }

  /// Draws `closing`; `range`: [from, to] in ms, null for the whole; `stripped`: with raw films, and these minus the measured ones.
  function draw(closing, range, stripped) {
    const names = (one) => one.channels.map((c) => c.name + ' / ' + c.unit).join();
    const same = shown && graphs.length && names(shown) === names(closing) && graphs[0].size().width === root.firstChild.clientWidth;
    if (!same) {
      graphs.forEach((g) => g.destroy());
      graphs = [];
      root.textContent = '';
    }
    shown = closing;
    withRaw = stripped;
    colours = { measured: colour('--measured'), simulated: colour('--simulated'), raw: colour('--soft'), 'raw minus measured': colour('--cited') };
    const time = Array.from({ length: shown.n }, (_, i) => shown.t0 + i * shown.dt);
    whole = [time[0], time[time.length - 1]];
    const files = shown.channels.map((channel, index) => {
      const last = index === shown.channels.length - 1;
      const list = channel.series.filter((s) => stripped || !['raw', 'raw minus measured'].includes(s.label));
      const columns = list.map(values);
      const file = time.map((t, i) => {
        const row = [t];
        for (const c of columns) row.push(c[i]);
        return row;
      });
      const box = same ? root.children[index] : document.createElement('div');
      const labels = ['ms'].concat(list.map((s) => s.label)), colors = list.map((s) => colours[s.label]);
      box.setAttribute('aria-label', channel.name + ' in ' + channel.unit + ' over time, ' + list.map((s) => s.label).join(', '));
      if (same) {  // all of them before any is drawn: each draws the others where their windows differ
        graphs[index].updateOptions({ labels, colors, dateWindow: range }, true);
        return file;
      }
      box.className = 'closer-panel' + (last ? ' last' : '');
      box.setAttribute('role', 'img');
      root.appendChild(box);
      graphs.push(new Dygraph(box, file, {
        labels, colors,
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
        highlightCallback: (event, x) => looked(x),
        underlayCallback: (canvas, area, graph) => {
          band(canvas, area, graph, shown.channels[index]);
          marks(canvas, area, graph, index === 0);
        }
      }));
      return file;
    });
    root.dataset.closing = shown.name;
    if (same) graphs.forEach((g, index) => g.updateOptions({ file: files[index] }));
    else if (graphs.length > 1) Dygraph.synchronize(graphs, { zoom: true, selection: true, range: false });
  }

  const show = (range) => graphs.length && graphs[0].updateOptions({ dateWindow: range });
  const range = () => (graphs.length ? graphs[0].xAxisRange() : null);
  function change(factor, shift) {
    if (!graphs.length) return;
    const now = range(), middle = (now[0] + now[1]) / 2 + shift * (now[1] - now[0]), half = factor * (now[1] - now[0]) / 2;
    show([Math.max(whole[0], middle - half), Math.min(whole[1], middle + half)]);
  }
  /// What the buttons of a page do, by the value of their `data-do`.
  const actions = {
    whole: () => show(whole), bounce: () => shown && show(shown.bounce), 'in': () => change(0.5, 0), out: () => change(2, 0),
    left: () => change(1, -0.25), right: () => change(1, 0.25)
  };
  /** The value of a channel at `t`, ms, measured where there is a measured one; null: not known. */
  function at(name, t) {
    const channel = shown && shown.channels.find((c) => c.name === name);
    const series = channel && (channel.series.find((s) => s.label === 'measured') || channel.series[0]);
    const i = shown ? Math.round((t - shown.t0) / shown.dt) : -1;
    if (!series || i < 0 || i >= shown.n) return null;
    return Number.isNaN(values(series)[i]) ? null : series.values[i];
  }
  matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => shown && draw(shown, range(), withRaw));
  /** A line at `t` through all panels. */
  function mark(t) {
    cursor = t;
    graphs.forEach((g) => g.updateOptions({}, false));
  }
  return { draw, range, actions, at, mark, whole: () => whole, whenLooked: (act) => { looked = act; } };
}
