
  // ---- a map that goes on ------------------------------------------------------------------------------------------

  // Above the tiles what the map around the robot is now, then the path and the robot.
  map.createPane('latest').style.zIndex = 300;
  const latest_canvas = canvas_of(1, 1);
  const latest_layer = L.svgOverlay(latest_canvas, [[0, 0], [0, 0]], {pane: 'latest', interactive: false});
  const robot = L.marker([0, 0], {interactive: false, keyboard: false, icon: L.divIcon({
    className: '', iconSize: [32, 32],
    html: '<svg viewBox="-16 -16 32 32" width="32" height="32"><path d="M13 0L-9 -9L-4 0L-9 9Z" fill="#fff" ' +
      `stroke="rgb(${p.path.rgb})" stroke-width="2.5" stroke-linejoin="round"/></svg>`})});
  const paths = ['#fff', `rgb(${p.path.rgb})`].map((color, k) => L.polyline([], {color, weight: 6 - 3 * k}));
  const follow = L.layerGroup().addTo(map);
  ways.addLayer(paths[0]).addLayer(paths[1]).addLayer(robot).addTo(map);
  switches.addOverlay(ways, 'Robot and path');
  switches.addOverlay(follow, 'Follow the robot');
  map.on('dragstart', () => map.removeLayer(follow));

  const base_layers = Object.values(base), base_shown = () => base_layers.find(layer => map.hasLayer(layer));
  const bounds_of = (x, y, width, height) => [[top_y_m - (y + height) * d.resolution_m, d.min_x_m + x * d.resolution_m],
    [top_y_m - y * d.resolution_m, d.min_x_m + (x + width) * d.resolution_m]];

  function show_latest() {
    const {tile, x, y} = latest, image = painted(tile, base_shown().colour, tile.width, tile.height);
    latest_canvas.width = tile.width;
    latest_canvas.height = tile.height;
    latest_canvas.getContext('2d').drawImage(image, 0, 0);
    latest_layer.setBounds(bounds_of(x, y, tile.width, tile.height));
  }

  // The colours of heights reach as far as what was seen around the robot.
  let is_first = true;
  function widen(tile) {
    const heights = [];
    for (let p = 0; p < tile.ground.length; p += 4 * 97) heights.push(ground_of(tile, p));
    const [low, high] = range_of(heights), before = ground_range_m, step_m = 0.5;
    if (!heights.some(h => !isNaN(h)) || (!is_first && low >= before[0] && high <= before[1])) return;
    const range = [Math.floor(low / step_m) * step_m, Math.ceil(high / step_m) * step_m];
    ground_range_m = is_first ? range : [Math.min(before[0], range[0]), Math.max(before[1], range[1])];
    base['Ground'].redraw();
    show_legend();
  }

  // Tiles that came, drawn together: column and row of each by its key.
  const fresh = new Map();
  setInterval(() => {
    const tiles = [...fresh.values()], layer = base_shown();
    fresh.clear();
    if (tiles.length) for (const {el, coords} of Object.values(layer._tiles)) layer.draw(el, coords, tiles);
  }, 500);

  let latest_at = NaN, is_connected = false, waiting = null;
  async function show_now(now) {
    const place = [now.y_m, now.x_m];
    robot.setLatLng(place);
    show_paths();
    robot.getElement()?.firstChild.style.setProperty('transform', `rotate(${-now.yaw_rad}rad)`);
    d.about = `${now.driven_m} m driven, ${now.frames} scans`;
    legend.querySelector('p').textContent = d.about;
    if (now.cells) {
      const tile = await tile_of(now.cells);
      latest = {tile, x: now.cells[0], y: now.cells[1]};
      widen(tile);
      show_latest();
      latest_layer.addTo(map);
      if (is_first) map.fitBounds(latest_layer.getBounds(), {animate: false});
      else if (map.hasLayer(follow)) map.panTo(place, {animate: false});
      is_first = false;
      document.body.dataset.live = now.frames;
    }
  }
  // One after the other; of those that come meanwhile the newest.
  async function show_next(now) {
    const is_busy = waiting !== null;
    waiting = now;
    if (is_busy) return;
    for (let shown = null; shown !== waiting;) await show_now(shown = waiting);
    waiting = null;
  }

  // The last of them leads to the robot.
  const path_parts = [];
  function show_paths() {
    const lines = path_parts.filter(Boolean).map(parts => parts.filter(Boolean).flat());
    if (lines.length && latest) lines[lines.length - 1].push(robot.getLatLng());
    for (const line of paths) line.setLatLngs(lines);
  }

  function forget() {
    stored.clear();
    decoded.clear();
    fresh.clear();
    path_parts.length = 0;
    show_paths();
    base_shown().redraw();
  }

  // ---- what comes --------------------------------------------------------------------------------------------------

  let shown_map = null;
  const heard = {
    begin: ({run, map}) => {
      if (run !== d.run) location.reload();
      else if (shown_map !== null && map !== shown_map) forget();
      shown_map = map;
    },
    tile: tile => {
      const key = tile[0] + ',' + tile[1];
      stored.set(key, tile);
      decoded.delete(key);
      fresh.set(key, tile);
    },
    path: ({way, part, points}) => {
      (path_parts[way] ||= [])[part] = points.map(([x, y]) => [y, x]);
      show_paths();
    }
  };
  const since = age => {
    latest_at = age ? performance.now() - 1000 * age : NaN;
    show_state();
  };
  function connect() {
    const events = new EventSource('events');
    for (const [kind, show] of Object.entries(heard)) events.addEventListener(kind, e => show(JSON.parse(e.data)));
    events.addEventListener('now', e => {
      const [age, now] = e.data.split('\n');
      since(age);
      show_next(JSON.parse(now));
    });
    events.addEventListener('idle', e => since(e.data));
    events.onopen = () => {
      is_connected = true;
      show_state();
    };
    events.onerror = () => {
      is_connected = false;
      if (events.readyState === EventSource.CLOSED) setTimeout(connect, 2000);  // it was refused
    };
  }

  const state = L.control({position: 'topleft'});
  state.onAdd = () => Object.assign(L.DomUtil.create('div', 'live'), {id: 'live'});
  state.addTo(map);
  const late_s = 2;
  function show_state() {
    const age_s = (performance.now() - latest_at) / 1000, box = state.getContainer();
    box.textContent = !is_connected ? 'no connection' : isNaN(age_s) ? 'no scan yet'
      : age_s < late_s ? `live, ${age_s.toFixed(1)} s` : `no data for ${age_text(age_s)}`;
    box.classList.toggle('late', !(is_connected && age_s < late_s));
  }
  setInterval(show_state, 200);
  show_state();
  map.on('baselayerchange', () => { if (latest) show_latest(); });
  connect();
