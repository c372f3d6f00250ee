// The live bench. State arrives over one WebSocket; everything a person does is an HTTP call.
(function () {
  'use strict';
  const $ = (id) => document.getElementById(id);
  let token = document.querySelector('meta[name="powbench-token"]').content || sessionStorage.getItem('powbench-token') || '';
  let state = null, shownShot = 0, shownCampaign = 0, socket = null;

  // ---- calls ----

  async function call(method, path, body) {
    const headers = {};
    if (token) headers.Authorization = 'Bearer ' + token;
    if (body) headers['Content-Type'] = 'application/json';
    const reply = await fetch(path, { method, headers, body: body ? JSON.stringify(body) : undefined });
    const json = await reply.json();
    if (reply.status === 401) askToken();
    if (!reply.ok && path !== '/api/stop') throw json.errors || [json.error];
    return json;
  }
  function askToken() {
    const given = window.prompt('This bench wants a token:');
    if (!given) return;
    token = given.trim();
    sessionStorage.setItem('powbench-token', token);
    listen();
  }
  const link = (path) => path + (token ? '?token=' + encodeURIComponent(token) : '');

  // ---- stop: from every page, with one key ----

  async function stop() {
    alarm('stopping …');
    try {
      const answer = await call('POST', '/api/stop');
      alarm('STOP: ' + answer.text + ' (' + Math.round(answer.ms) + ' ms)', answer.off);
    } catch (e) {
      alarm('STOP FAILED: the bench program does not answer. Use the emergency switch of the rig.');
    }
  }
  function alarm(text, done) {
    $('alarm').hidden = !text;
    $('alarm').textContent = text || '';
    $('alarm').classList.toggle('done', !!done);
  }
  $('stop').addEventListener('click', stop);
  document.addEventListener('keydown', (e) => {
    if (e.key === 'Escape') stop();
  });

  // ---- pages ----

  const tabs = [...document.querySelectorAll('[role=tab]')];
  function open(name) {
    for (const t of tabs) {
      const on = t.getAttribute('aria-controls') === name;
      t.setAttribute('aria-selected', String(on));
      t.tabIndex = on ? 0 : -1;
      $(t.getAttribute('aria-controls')).hidden = !on;
    }
    if (location.hash !== '#' + name) history.replaceState(null, '', '#' + name);
    if (name === 'documents') campaigns();
    if (name === 'plan' && !$('text').value) planInForce();
  }
  tabs.forEach((t, i) => {
    t.addEventListener('click', () => open(t.getAttribute('aria-controls')));
    t.addEventListener('keydown', (e) => {
      const step = { ArrowRight: 1, ArrowLeft: -1 }[e.key];
      if (!step) return;
      const next = tabs[(i + step + tabs.length) % tabs.length];
      next.focus();
      next.click();
    });
  });

  // ---- numbers ----

  const known = (x) => typeof x === 'number';
  function rounded(value, U) {
    if (!known(value)) return '–';
    const digits = known(U) && U > 0 ? Math.max(0, Math.min(6, 1 - Math.floor(Math.log10(U)))) : 3;
    return value.toFixed(digits) + (known(U) ? ' ± ' + U.toFixed(digits) : '');
  }
  const units = { s: ['ms', 1e3], m: ['mm', 1e3], A: ['A', 1], N: ['N', 1], 'm/s': ['m/s', 1] };
  const scaled = (x, factor) => (known(x) ? x * factor : null);
  const measured = (m, factor) => rounded(scaled(m.value, factor), scaled(m.u, 2 * factor));

  function cells(row, values) {
    for (const [text, kind] of values) {
      const cell = row.insertCell();
      cell.className = kind || '';
      if (text instanceof Node) cell.append(text);
      else cell.textContent = text;
    }
    return row;
  }
  function anchor(href, text) {
    const a = document.createElement('a');
    a.href = href;
    a.target = '_blank';
    a.rel = 'noopener';
    a.textContent = text;
    return a;
  }
  function button(text, act) {
    const b = document.createElement('button');
    b.type = 'button';
    b.textContent = text;
    b.addEventListener('click', act);
    return b;
  }

  // ---- test ----

  const panels = typeof Dygraph === 'undefined' ? null : closingPanels($('panels'));
  let closing = null, trend = null;
  for (const degrees of [0, 30, 60, 90, 120, 150])
    $('quick').append(button(degrees + '°', () => { $('angle').value = degrees; $('angle').focus(); }), ' ');
  document.querySelectorAll('#closer button').forEach((b) => b.addEventListener('click', () => panels && panels.actions[b.dataset.do]()));
  $('stripped').addEventListener('change', () => closing && panels.draw(closing, panels.range(), $('stripped').checked));
  $('fire-form').addEventListener('submit', async (e) => {
    e.preventDefault();
    $('refused').textContent = '';
    alarm('');
    try {
      await call('POST', '/api/fire', { angle_deg: Number($('angle').value) });
    } catch (errors) {
      $('refused').textContent = [].concat(errors).join(' ');
    }
  });

  async function showShot(id) {
    const shot = await call('GET', '/api/shots/' + id);
    const angle = known(shot.angle_deg) ? shot.angle_deg.toFixed(1) + '°' : 'an angle not known';
    const value = (s, factor) => measured(shot.quantities.find((q) => q.symbol === s), factor);
    $('shot').hidden = false;
    $('no-shot').hidden = true;
    $('shot-title').textContent = 'Shot ' + shot.id + ' at ' + angle + ': touch ' + value('t_ct1', 1e3) + ' ms, bounce ' +
      value('t_ct_bon', 1e3) + ' ms';
    $('shot-reason').textContent = shot.origin + ', ' + shot.outcome + (shot.reason ? ': ' + shot.reason : '') + '; reached ' +
      measured(shot.reached_rad, 180 / Math.PI) + ' deg, ' + shot.started + ' UTC';
    $('shot-title').classList.toggle('bad', shot.outcome === 'FAIL');
    if (shot.outcome === 'FAIL' && id === shownShot) alarm('Outside limits: shot ' + id + ', ' + shot.reason);
    $('quantities').textContent = '';
    for (const q of shot.quantities) {
      const [unit, factor] = units[q.unit] || [q.unit, 1];
      cells($('quantities').insertRow(), [[q.symbol], [q.meaning], [measured(q, factor), 'n'],
        [rounded(scaled(q.simulated, factor)), 'n sim'], [unit]]);
    }
    closing = shot.has_record ? (await call('GET', '/api/shots/' + id + '/closing'))[0] || null : null;
    if (panels && closing) panels.draw(closing, closing.bounce, $('stripped').checked);
    else $('panels').textContent = shot.has_record ? 'This program was built without the charting library.' : '';
    await showTrend(shot.campaign);
  }
  async function showTrend(campaign) {
    if (!panels) return;
    const list = (await call('GET', '/api/campaigns/' + campaign + '/shots')).shots.filter((s) => s.kind === 'measured');
    const rows = list.map((s, i) => [i + 1, [scaled(s.quantities.t_ct1.value, 1e3), scaled(s.quantities.t_ct1.u, 2e3) || 0]]);
    if (trend) trend.destroy();
    trend = null;
    $('trend').textContent = '';
    if (rows.some((r) => r[1][0] !== null))
      trend = new Dygraph($('trend'), rows, { labels: ['shot', 'touch / ms'], errorBars: true, sigma: 1, drawPoints: true,
        pointSize: 3, strokeWidth: 0.4, colors: [getComputedStyle(document.documentElement).getPropertyValue('--measured').trim()],
        axes: { y: { axisLabelWidth: 54 } }, includeZero: false });
  }

  // ---- plan ----

  const planInForce = async () => { $('text').value = (await call('GET', '/api/plan')).text; };
  $('reload').addEventListener('click', planInForce);
  $('template').addEventListener('click', async () => { $('text').value = (await call('GET', '/api/plan/template')).text; });
  async function plan(path, done) {
    $('errors').textContent = $('planned').textContent = $('shots-planned').textContent = '';
    try {
      const reply = await call('POST', path, { text: $('text').value });
      if (reply.errors) throw reply.errors;
      done(reply);
    } catch (errors) {
      for (const one of [].concat(errors)) {
        const item = document.createElement('li');
        item.textContent = one;
        $('errors').append(item);
      }
    }
  }
  $('check').addEventListener('click', () => plan('/api/plan/check', (p) => {
    $('planned').textContent = p.name + ': ' + p.shots.length + ' shots in about ' + duration(p.seconds) + ', coil on ' +
      p.coil_on_percent.toFixed(0) + ' % of the time. No mistakes found.';
    for (const s of p.shots.slice(0, 500))
      cells($('shots-planned').insertRow(), [['shot ' + s.number], [s.angle_deg.toFixed(2) + '°', 'n'], [s.supply_volts + ' V', 'n'],
        [s.mains_hertz + ' Hz', 'n']]);
  }));
  $('run').addEventListener('click', () => { alarm(''); plan('/api/plan/run', () => open('test')); });
  $('hold').addEventListener('click', () => call('POST', '/api/plan/hold', { on: !state.job.held }));
  $('end').addEventListener('click', () => call('POST', '/api/plan/end', {}));
  const duration = (s) => (s < 90 ? s.toFixed(0) + ' s' : (s / 60).toFixed(0) + ' min');

  // ---- documents ----

  async function campaigns() {
    const words = $('search').value.toLowerCase().split(/\s+/);
    const list = await call('GET', '/api/campaigns');
    $('campaigns').textContent = '';
    for (const c of list) {
      const all = [c.id, c.name, c.created, c.specimen, c.origin, c.rig].join(' ').toLowerCase();
      if (!words.every((w) => all.includes(w))) continue;
      cells($('campaigns').insertRow(), [[button(String(c.id), () => campaign(c.id))], [c.name], [c.created], [c.specimen], [c.origin],
        [c.shots, 'n'], [c.outside_limits, 'n'], [anchor(link('/api/campaigns/' + c.id + '/report.html'), 'report')]]);
    }
  }
  async function campaign(id) {
    const c = await call('GET', '/api/campaigns/' + id + '/shots');
    shownCampaign = id;
    $('campaign').hidden = false;
    $('campaign-title').textContent = 'Campaign ' + c.campaign + ', ' + c.name + ', ' + c.origin;
    $('shots').textContent = '';
    for (const s of c.shots.slice(0, 2000)) {
      const q = s.quantities;
      cells($('shots').insertRow(), [[button(String(s.id), () => { open('test'); showShot(s.id); })], [s.kind],
        [known(s.angle_deg) ? s.angle_deg.toFixed(2) : '–', 'n'], [measured(s.reached_rad, 180 / Math.PI), 'n'],
        [measured(q.t_ct1, 1e3), 'n'], [measured(q.t_ct_bon, 1e3), 'n'], [measured(q.t_ct2, 1e3), 'n'],
        [s.outcome + (s.reason ? ': ' + s.reason : '')], [anchor(link('/api/shots/' + s.id + '/waveforms.csv'), 'CSV')]]);
    }
    notes();
  }
  async function notes() {
    $('notes').textContent = '';
    for (const n of await call('GET', '/api/campaigns/' + shownCampaign + '/annotations')) {
      const item = document.createElement('li');
      item.textContent = n.created + ' ' + n.key + ': ' + n.text;
      $('notes').append(item);
    }
  }
  $('annotate').addEventListener('submit', async (e) => {
    e.preventDefault();
    try {
      await call('POST', '/api/campaigns/' + shownCampaign + '/annotations', { key: $('note-key').value, text: $('note-text').value });
      $('noted').textContent = 'added';
      $('note-text').value = '';
      notes();
    } catch (errors) {
      $('noted').textContent = [].concat(errors).join(' ');
    }
  });
  $('search').addEventListener('input', campaigns);

  // ---- state ----

  function fact(name, value) {
    cells($('facts').insertRow(), [[name], [value]]);
  }
  function show(next) {
    const before = state;
    state = next;
    const { rig, status, job, link: line } = state;
    $('origin').textContent = rig.origin;
    $('rig').textContent = rig.model + ' ' + rig.serial;
    document.title = rig.origin + ', ' + (job ? job.doing : status ? status.state : 'no answer') + ': powbench';
    $('state').textContent = status ? status.state : 'no answer';
    $('state').className = 'state' + (status ? (status.live ? ' live' : '') : ' gone');
    $('job').textContent = !line.answers ? line.error : !job ? '' : job.kind === 'single' ? job.doing :
      job.name + ': ' + job.done + ' of ' + job.shots + ', ' + (job.ending ? 'last shot' : job.doing) +
      (known(job.seconds_left) ? ', ' + duration(job.seconds_left) + ' left' : '');
    $('progress').hidden = !job || job.kind === 'single';
    if (job) $('progress').value = job.done / job.shots;
    $('fire').disabled = $('run').disabled = !!job;
    $('hold').disabled = $('end').disabled = !job || job.kind === 'single';
    $('hold').textContent = job && job.held ? 'Go on' : 'Hold';
    $('conditions').textContent = state.plan.supply_volts + ' V, ' + state.plan.mains_hertz + ' Hz, hold ' + state.plan.hold_time_ms +
      ' ms, specimen ' + state.plan.specimen + ' (from the plan)';
    if (state.stop && (!before || !before.stop)) alarm('STOP: ' + state.stop.text, state.stop.off);
    if (!state.stop && before && before.stop) alarm('');
    const ended = before && before.job && !job;
    if (state.newest_shot && (state.newest_shot !== shownShot || ended)) {
      shownShot = state.newest_shot;
      showShot(shownShot).catch(() => {});
    }
    $('facts').textContent = $('channels').textContent = $('log').textContent = '';
    fact('rig', rig.uri + ', ' + rig.model + ' ' + rig.serial);
    fact('origin', rig.origin);
    fact('firmware', rig.firmware + ', boot ' + rig.boot_id);
    fact('calibration', rig.calibration + (rig.calibration_expires ? ', valid until ' + rig.calibration_expires : ''));
    fact('sampling', rig.sample_rate_hz / 1e3 + ' kS/s');
    fact('link', line.answers ? 'answers in ' + line.answer_ms.toFixed(1) + ' ms' : line.error);
    if (status) {
      fact('state', status.state);
      fact('fault', status.fault);
      fact('mains phase', status.phase);
      fact('owner', status.owner);
      fact('last refusal', status.last_error);
    }
    for (const c of rig.channels) cells($('channels').insertRow(), [[c.id], [c.label], [c.unit], [c.per_count.toPrecision(6), 'n']]);
    for (const line of state.log.slice().reverse()) {
      const item = document.createElement('li');
      item.textContent = line;
      $('log').append(item);
    }
  }
  function listen() {
    if (socket) socket.onclose = null;
    socket = new WebSocket('ws://' + location.host + link('/api/live'));
    socket.onmessage = (m) => show(JSON.parse(m.data));
    socket.onclose = () => {
      $('state').textContent = 'no bench';
      $('state').className = 'state gone';
      $('job').textContent = 'the bench program does not answer; trying again';
      window.setTimeout(listen, 500);
    };
  }

  open(['test', 'plan', 'documents', 'debug'].includes(location.hash.slice(1)) ? location.hash.slice(1) : 'test');
  call('GET', '/api/bench').then(show).catch(() => {});
  listen();
})();
