// The device in three dimensions at one instant of a closing: boxes in parallel projection, painted from the back.
function deviceView(canvas, device) {
  'use strict';
  const style = getComputedStyle(document.documentElement);
  const colour = (name) => style.getPropertyValue(name).trim();
  const copper = '#b87333', corners = [[0, 1, 2, 3], [4, 7, 6, 5], [0, 4, 5, 1], [3, 2, 6, 7], [0, 3, 7, 4], [1, 5, 6, 2]];
  const normals = [[0, 0, -1], [0, 0, 1], [0, -1, 0], [0, 1, 0], [-1, 0, 0], [1, 0, 0]];
  let azimuth = 0.55, height = 0.42, travel = 0, closed = false;

  /** A box by its lower corner and its size, mm: x across the legs, y in the direction of opening, z along the stack. */
  function box(out, x, y, z, w, h, d, paint) {
    const p = [[x, y, z], [x + w, y, z], [x + w, y + h, z], [x, y + h, z], [x, y, z + d], [x + w, y, z + d], [x + w, y + h, z + d], [x, y + h, z + d]];
    corners.forEach((face, i) => out.push({ points: face.map((k) => p[k]), normal: normals[i], paint }));
  }
  function legs(out, y, h, yoke, top, paint) {
    const { centre, outer, window: gap, stack } = device, all = centre + 2 * outer + 2 * gap, left = -all / 2, z = -stack / 2;
    box(out, left, top ? y + h : y - yoke, z, all, yoke, stack, paint);
    if (h <= 0) return;
    box(out, left, y, z, outer, h, stack, paint);
    box(out, -centre / 2, y, z, centre, h, stack, paint);
    box(out, left + all - outer, y, z, outer, h, stack, paint);
  }
  function solids() {
    const out = [], d = device, rest = d.travel - travel, top = d.moving_window + d.yoke;
    legs(out, -d.fixed_window, d.fixed_window, d.yoke, false, colour('--soft'));
    const side = d.centre / 2 + 0.5;
    for (const x of [-side - d.coil, side]) box(out, x, -d.fixed_window + 1, -d.stack / 2 - 1, d.coil, d.fixed_window - 2, d.stack + 2, copper);
    legs(out, rest, d.moving_window, d.yoke, true, colour('--measured'));
    // the bridges over the moving core, one beside the other along the stack; their gap and travel are to scale
    const carrier = top + 8, thick = 1.2, pitch = d.stack / Math.max(1, d.poles - 1), seat = carrier + d.travel - d.gap - thick;
    box(out, -2, rest + top, -1.5, 4, carrier - top + 2, 3, colour('--line'));
    for (let k = 0; k < d.poles; ++k) {
      const z = (k - (d.poles - 1) / 2) * pitch - 1.5, lifted = closed || travel < d.gap ? 0 : 0.5;
      const y = carrier + d.travel - Math.min(travel, d.gap) + lifted;
      box(out, -d.half_length - 2, y, z, 2 * d.half_length + 4, thick, 3, closed ? colour('--good') : copper);
      for (const x of [-d.half_length - 4, d.half_length - 1]) box(out, x, seat, z, 5, thick, 3, colour('--soft'));
    }
    return out;
  }
  function turned(p) {
    const ca = Math.cos(azimuth), sa = Math.sin(azimuth), ch = Math.cos(height), sh = Math.sin(height);
    const x = ca * p[0] + sa * p[2], z = -sa * p[0] + ca * p[2];
    return [x, ch * p[1] - sh * z, sh * p[1] + ch * z];  // right, up, towards the eye
  }
  function draw() {
    const g = canvas.getContext('2d'), ratio = window.devicePixelRatio || 1;
    canvas.width = canvas.clientWidth * ratio;
    canvas.height = canvas.clientHeight * ratio;
    const size = device.fixed_window + device.moving_window + 2 * device.yoke + device.travel + 16;
    const scale = canvas.height / (1.25 * size), middle = (device.moving_window + 14 - device.fixed_window) / 2;
    const faces = solids().map((f) => {
      const points = f.points.map((p) => turned([p[0], p[1] - middle, p[2]])), n = turned(f.normal);
      return { points, n, paint: f.paint, depth: points.reduce((s, p) => s + p[2], 0) };
    }).filter((f) => f.n[2] > 0).sort((a, b) => a.depth - b.depth);
    g.lineWidth = ratio / 2;
    for (const f of faces) {
      g.beginPath();
      for (const p of f.points) g.lineTo(canvas.width / 2 + scale * p[0], canvas.height / 2 - scale * p[1]);
      g.closePath();
      g.fillStyle = g.strokeStyle = f.paint;
      g.fill();
      g.fillStyle = 'rgba(0,0,0,' + (0.45 * (1 - Math.max(0, 0.35 * f.n[0] + 0.8 * f.n[1] + 0.5 * f.n[2]))).toFixed(3) + ')';
      g.fill();
      g.strokeStyle = 'rgba(0,0,0,.5)';
      g.stroke();
    }
  }
  function turn(a, h) {
    azimuth += a;
    height = Math.max(-0.2, Math.min(1.4, height + h));
    draw();
  }
  canvas.addEventListener('pointermove', (e) => { if (e.buttons & 1) turn(0.01 * e.movementX, 0.01 * e.movementY); });
  canvas.addEventListener('keydown', (e) => {
    const by = { ArrowLeft: [-0.1, 0], ArrowRight: [0.1, 0], ArrowUp: [0, 0.1], ArrowDown: [0, -0.1] }[e.key];
    if (!by) return;
    e.preventDefault();
    turn(by[0], by[1]);
  });
  window.addEventListener('resize', draw);
  /** `x`: mm of travel from open; `shut`: the measured pole conducts. */
  return (x, shut) => {
    travel = x;
    closed = shut;
    draw();
  };
}
