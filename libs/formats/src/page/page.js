'use strict';
// The map of `map_data`: tiles whose pixels are cells, decoded where they are looked at. Libraries: Leaflet (L).
(function (d) {
  const side = d.tile_cells;
  const top_y_m = d.min_y_m + d.cells_y * d.resolution_m;
  const stored = new Map(d.tiles.map(t => [t[0] + ',' + t[1], t]));

  // ---- cells -------------------------------------------------------------------------------------------------------

  function pixels_of(base64) {
    return new Promise((done, failed) => {
      const image = new Image();
      image.onload = () => {
        const canvas = document.createElement('canvas');
        canvas.width = image.width;
        canvas.height = image.height;
        const context = canvas.getContext('2d', {willReadFrequently: true, colorSpace: 'srgb'});
        context.drawImage(image, 0, 0);
        done(context.getImageData(0, 0, image.width, image.height));
      };
      image.onerror = failed;
      image.src = 'data:image/png;base64,' + base64;
    });
  }

  async function tile_of([, , lowest_m, step_m, ground, more, changes, channels]) {
    const [g, m, c, ...values] = await Promise.all(
      [pixels_of(ground), pixels_of(more), changes ? pixels_of(changes) : null, ...channels.map(pixels_of)]);
    return {
      width: g.width, height: g.height, lowest_m, step_m, ground: g.data, more: m.data, changes: c && c.data,
      channels: values.map(v => v.data)};
  }

  // Decoded tiles, those that were not looked at for the longest time leave.
  const decoded = new Map(), max_decoded = 150 * (512 / side) ** 2;
  function tile_at(column, row) {
    const key = column + ',' + row;
    if (!stored.has(key)) return Promise.resolve(null);
    const tile = decoded.get(key) || tile_of(stored.get(key));
    decoded.delete(key);
    decoded.set(key, tile);
    if (decoded.size > max_decoded) decoded.delete(decoded.keys().next().value);
    return tile;
  }

  // NaN where nothing is known. `p`: where the pixel of a cell begins.
  function ground_of(tile, p) {
    const height = tile.ground[p] * 256 + tile.ground[p + 1];
    return height === 0 ? NaN : tile.lowest_m + (height - 1) * tile.step_m;
  }

  // What a cell holds; null where nothing is known.
  function cell_of(tile, p) {
    const ground_m = ground_of(tile, p);
    if (isNaN(ground_m)) return null;
    const score = tile.ground[p + 2], age = tile.more[p + 1], bits = tile.more[p + 2];
    return {
      ground_m,
      traversability: score === 255 ? NaN : score / 254,
      tall_m: tile.more[p] * d.tall_step_m,
      age_s: age === 255 ? NaN : Math.pow(2, age / d.age_steps) - 1,
      state: bits & 7, drops: (bits & 8) !== 0, light: (bits >> 4) / 15,
      change: tile.changes ? tile.changes[p] : 0,
      change_m: tile.changes ? tile.changes[p + 1] * d.change_step_m : 0,
      tile, p
    };
  }

  // Of a cell the value of a layer of the channels; NaN where there is none.
  function value_of(c, k) {
    const code = c.tile.channels[Math.floor(k / 3)][c.p + k % 3];
    return code === 0 ? NaN : d.channels[k].lowest + (code - 1) * d.channels[k].step;
  }

  // Of a tile whose first cell is (x0, y0).
  function cell_in(tile, x, y, x0, y0) {
    if (!tile || x < x0 || y < y0 || x >= x0 + tile.width || y >= y0 + tile.height) return null;
    return cell_of(tile, 4 * ((y - y0) * tile.width + x - x0));
  }

  let latest = null;  // of a map that goes on the cells around the robot, and the first of them: {tile, x, y}
  async function cell_at(x_m, y_m) {
    const x = Math.floor((x_m - d.min_x_m) / d.resolution_m), y = Math.floor((top_y_m - y_m) / d.resolution_m);
    const column = Math.floor(x / side), row = Math.floor(y / side);
    const cell = latest && cell_in(latest.tile, x, y, latest.x, latest.y);
    return cell || cell_in(await tile_at(column, row), x, y, column * side, row * side);
  }

  // ---- layers ------------------------------------------------------------------------------------------------------

  const level_light = 0.7071;
  const p = d.palette;  // each a word and its colour
  const lit = (c, light) => c.map(v => v * (0.4 + 0.6 * light / level_light));
  const pale = c => c.map(v => (v + 255) / 2);
  const scale = (colours, t) => colours[Math.round(255 * Math.min(1, Math.max(0, t)))];
  let ground_range_m = [0, 1];

  const nothing = c => lit([225, 225, 225], c.light);
  const layers = {
    'Traversability': c => {
      if (c.tall_m > 0 && !(c.traversability > 0.5)) return p.stands.rgb;
      const colour = isNaN(c.traversability) ? p.not_judged.rgb : scale(d.scores, c.traversability);
      return c.state === 1 ? lit(colour, c.light) : lit(pale(colour), (c.light + level_light) / 2);
    },
    'Ground': c => lit(scale(d.heights, (c.ground_m - ground_range_m[0]) / (ground_range_m[1] - ground_range_m[0])), c.light),
    'Hill-shade': c => Array(3).fill(Math.min(255, 255 * c.light)),
    'What stands': c => c.tall_m > 0 ? scale(d.heights, c.tall_m / 3) : nothing(c),
    'State': c => d.states[c.state].rgb
  };
  if (d.has_age) layers['Age'] = c => isNaN(c.age_s) ? nothing(c)
    : scale(d.heights, 1 - Math.log2(1 + c.age_s) / Math.log2(2 + d.oldest_s));
  if (d.has_drops) layers['Drops'] = c => c.drops ? p.may_drop.rgb : nothing(c);
  // Layers of channels: classes have a colour each, and red, green and blue together are one.
  const class_colours = [
    [127, 127, 127], [31, 119, 180], [174, 199, 232], [0, 90, 110], [214, 39, 40], [255, 152, 150], [148, 103, 189],
    [197, 176, 213], [227, 119, 194], [140, 86, 75], [188, 189, 34], [219, 219, 141], [44, 160, 44], [152, 223, 138],
    [196, 156, 148], [23, 190, 207]];
  const title_of = channel => channel.name.replace(/_standing$/, ', what stands');
  d.channels.forEach((channel, k) => {
    layers[title_of(channel)] = c => {
      const v = value_of(c, k), range = channel.highest - channel.lowest;
      if (isNaN(v)) return nothing(c);
      return channel.is_class ? class_colours[v] : scale(d.heights, range > 0 ? (v - channel.lowest) / range : 0.5);
    };
  });
  const colour_places = end => ['red', 'green', 'blue'].map(n => d.channels.findIndex(c => c.name === n + end));
  const ground_colour = colour_places(''), standing_colour = colour_places('_standing');
  const has_colour = ground_colour.every(k => k >= 0);
  if (has_colour) layers['Colour'] = c => {
    for (const places of [standing_colour, ground_colour]) {
      const rgb = places.map(k => value_of(c, k));
      if (!rgb.some(isNaN)) return rgb;
    }
    return nothing(c);
  };
  const changes_colour = c => c.change ? d.changes[c.change].rgb : null;

  const canvas_of = (width, height) => Object.assign(document.createElement('canvas'), {width, height});

  // Of a tile as many columns and rows, from the upper left.
  function painted(tile, colour, columns, rows) {
    const width = Math.min(columns, tile.width), height = Math.min(rows, tile.height);
    const canvas = canvas_of(width, height), context = canvas.getContext('2d');
    const image = context.createImageData(width, height);
    for (let i = 0; i < width * height; ++i) {
      const cell = cell_of(tile, 4 * (Math.floor(i / width) * tile.width + i % width)), rgb = cell && colour(cell);
      if (!rgb) continue;
      for (let k = 0; k < 3; ++k) image.data[4 * i + k] = rgb[k];
      image.data[4 * i + 3] = 255;
    }
    context.putImageData(image, 0, 0);
    return canvas;
  }

  // At zoom 0 a cell has a pixel.
  const min_zoom = -Math.max(0, Math.ceil(Math.log2(Math.max(d.cells_x, d.cells_y) / side)));
  const overlap = 2;
  const zooms = {minZoom: min_zoom - 1, maxZoom: 5};

  const CellLayer = L.GridLayer.extend({
    options: {tileSize: side, minNativeZoom: min_zoom, maxNativeZoom: 0, ...zooms},
    initialize: function (colour, options) {
      L.GridLayer.prototype.initialize.call(this, options);
      this.colour = colour;
    },
    // A tile lies over the edges of those right and below, or a seam shows between them.
    _initTile: function (tile) {
      L.GridLayer.prototype._initTile.call(this, tile);
      tile.style.width = tile.style.height = side + overlap + 'px';
    },
    // A tile of a zoom below 0 is made of several stored ones. `tiles`: of these.
    draw: function (canvas, at, tiles) {
      const context = canvas.getContext('2d');
      const along = Math.pow(2, -at.z), cells = k => k < along ? side : overlap * along;
      return Promise.all(tiles.map(async ([column, row]) => {
        const x = column - at.x * along, y = row - at.y * along;
        if (x < 0 || y < 0 || x > along || y > along) return;
        const part = painted(await tile_at(column, row), this.colour, cells(x), cells(y));
        const place = [x * side / along, y * side / along, part.width / along, part.height / along];
        context.clearRect(...place);
        context.drawImage(part, ...place);
      }));
    },
    createTile: function (at, done) {
      const canvas = canvas_of(side + overlap, side + overlap);
      this.draw(canvas, at, [...stored.values()]).then(() => done(null, canvas), error => done(error, canvas));
      return canvas;
    }
  });

  // Names are text, also where HTML is made of them.
  const escaped = text => String(text).replace(/[&<>"']/g, c => '&#' + c.charCodeAt(0) + ';');
  const named = items => Object.fromEntries(Object.entries(items).map(([name, item]) => [escaped(name), item]));

  // ---- the map -----------------------------------------------------------------------------------------------------

  // Places are (y, x) in metres.
  const crs = L.extend({}, L.CRS.Simple, {
    transformation: new L.Transformation(
      1 / d.resolution_m, -d.min_x_m / d.resolution_m, -1 / d.resolution_m, top_y_m / d.resolution_m)
  });
  const map = L.map('map', {crs, ...zooms, zoomSnap: 0.25, zoomControl: true, attributionControl: false});
  window.talus_map = map;  // for who looks into it from a console
  const base = {}, overlays = {};
  for (const [name, colour] of Object.entries(layers))
    base[name] = new CellLayer(colour);
  const changes = d.has_changes && new CellLayer(changes_colour, {zIndex: 5});
  const ways = L.layerGroup([['#fff', 6], [`rgb(${p.path.rgb})`, 3]].flatMap(([color, weight]) =>
    d.ways.map(way => L.polyline(way.map(at => [at[1], at[0]]), {color, weight}))));
  if (d.ways.length) overlays['Path driven'] = ways;
  if (changes) overlays['Changes'] = changes;

  const boxes = d.tiles.map(t => [
    [top_y_m - t[1] * side * d.resolution_m, d.min_x_m + t[0] * side * d.resolution_m],
    [Math.max(d.min_y_m, top_y_m - (t[1] + 1) * side * d.resolution_m),
     Math.min(d.min_x_m + d.cells_x * d.resolution_m, d.min_x_m + (t[0] + 1) * side * d.resolution_m)]]);
  if (boxes.length) map.fitBounds(L.latLngBounds(boxes.flat()));
  else map.setView([0, 0], 0);
  new ResizeObserver(() => map.invalidateSize({pan: false})).observe(map.getContainer());
  const switches = L.control.layers(named(base), named(overlays), {collapsed: false}).addTo(map);

  const scale_bar = L.control({position: 'topleft'});
  scale_bar.onAdd = () => L.DomUtil.create('div', 'leaflet-control-scale-line');
  scale_bar.addTo(map);
  function show_scale() {
    const metre_pixels = Math.pow(2, map.getZoom()) / d.resolution_m;
    let length_m = Math.pow(10, Math.floor(Math.log10(150 / metre_pixels)));
    for (const more of [5, 2]) if (length_m * more * metre_pixels <= 150) { length_m *= more; break; }
    const line = scale_bar.getContainer();
    line.style.width = length_m * metre_pixels + 'px';
    line.textContent = Number(length_m.toPrecision(2)) + ' m';
  }
  map.on('zoomend', show_scale);
  show_scale();

  if (changes) {
    const slider = L.control({position: 'topright'});
    slider.onAdd = () => {
      const box = L.DomUtil.create('div', 'leaflet-control-layers leaflet-control-layers-expanded');
      box.innerHTML = '<label>Changes <input id="changes" type="range" min="0" max="100" value="80"></label>';
      L.DomEvent.disableClickPropagation(box);
      box.querySelector('input').oninput = e => changes.setOpacity(e.target.value / 100);
      return box;
    };
    slider.addTo(map);
    changes.setOpacity(0.8).addTo(map);
  }

  // ---- legend ------------------------------------------------------------------------------------------------------

  const legend = document.getElementById('legend');
  const swatch = (rgb, word) => `<div class="swatch"><i style="background:rgb(${rgb.map(Math.round)})"></i>${escaped(word)}</div>`;
  const of_palette = c => swatch(c.rgb, c.word);
  function bar(colours, low, high) {
    const canvas = canvas_of(256, 1), context = canvas.getContext('2d');
    colours.forEach((c, x) => { context.fillStyle = `rgb(${c})`; context.fillRect(x, 0, 1, 1); });
    return `<img alt="" src="${canvas.toDataURL()}" style="width:200px;height:12px;display:block">` +
      `<div class="ends"><span>${escaped(low)}</span><span>${escaped(high)}</span></div>`;
  }
  const legends = {
    'Traversability': () => bar(d.scores, p.blocked.word, p.free.word) +
      [p.stands, p.inferred, p.guessed].map(of_palette).join(''),
    'Ground': () => bar(d.heights, ground_range_m[0].toFixed(2) + ' m', ground_range_m[1].toFixed(2) + ' m'),
    'Hill-shade': () => '',
    'What stands': () => bar(d.heights, '0 m', '3 m and more'),
    'State': () => d.states.slice(1).map(of_palette).join(''),
    'Age': () => bar(d.heights, age_text(d.oldest_s) + ' old', 'newest'),
    'Drops': () => of_palette(p.may_drop)
  };
  if (has_colour) legends['Colour'] = () => 'of what stands, else of the ground';
  for (const channel of d.channels)
    legends[title_of(channel)] = () => channel.is_class
      ? class_colours.map((rgb, k) => k < channel.lowest || k > channel.highest ? '' : swatch(rgb, 'class ' + k)).join('')
      : bar(d.heights, channel.lowest.toPrecision(4), channel.highest.toPrecision(4));
  let shown = 'Traversability';
  function show_legend() {
    legend.innerHTML = `<b>${escaped(d.title)}</b><p>${escaped(d.about)}</p><b>${escaped(shown)}</b>` +
      legends[shown]() + (changes ? d.changes.slice(1).map(of_palette).join('') : '');
  }
  map.on('baselayerchange', e => { shown = Object.keys(base).find(name => base[name] === e.layer); show_legend(); });

  // ---- values under the pointer ------------------------------------------------------------------------------------

  const rows = list => '<table>' + list.map(r => `<tr>${r.map(v => `<td>${escaped(v)}</td>`).join('')}</tr>`).join('') + '</table>';
  function age_text(s) {
    return s < 90 ? s.toFixed(0) + ' s' : s < 5400 ? (s / 60).toFixed(0) + ' min'
      : s < 172800 ? (s / 3600).toFixed(1) + ' h' : (s / 86400).toFixed(1) + ' days';
  }
  // On a sphere around the origin of the map frame: good to a centimetre for each kilometre.
  function place_on_earth(x_m, y_m) {
    const turn = d.origin.heading_deg * Math.PI / 180, degrees = 180 / Math.PI;
    const east = x_m * Math.cos(turn) - y_m * Math.sin(turn), north = x_m * Math.sin(turn) + y_m * Math.cos(turn);
    const s = Math.sin(d.origin.latitude_deg / degrees), w = Math.sqrt(1 - 0.00669437999 * s * s);
    const meridian_m = 6378137 * (1 - 0.00669437999) / (w * w * w);
    const parallel_m = 6378137 / w * Math.cos(d.origin.latitude_deg / degrees);
    return (d.origin.latitude_deg + north / meridian_m * degrees).toFixed(7) + ', ' +
      (d.origin.longitude_deg + east / parallel_m * degrees).toFixed(7);
  }
  async function show_values(place) {
    const list = [['x, y', place.lng.toFixed(2) + ', ' + place.lat.toFixed(2) + ' m']];
    if (d.origin) list.push(['latitude, longitude', place_on_earth(place.lng, place.lat)]);
    const c = await cell_at(place.lng, place.lat);
    if (!c) list.push(['', 'not seen']);
    else {
      list.push(['ground', c.ground_m.toFixed(2) + ' m']);
      list.push(['stands on it', c.tall_m ? c.tall_m.toFixed(2) + ' m' : 'nothing']);
      list.push(['traversability', isNaN(c.traversability) ? 'not judged' : c.traversability.toFixed(2)]);
      list.push(['state', d.states[c.state].word]);
      if (d.has_drops) list.push(['may drop', c.drops ? 'yes' : 'no']);
      if (d.has_age) list.push(['age', isNaN(c.age_s) ? '' : age_text(c.age_s)]);
      d.channels.forEach((channel, k) => {
        const v = value_of(c, k);
        if (!isNaN(v)) list.push([title_of(channel), channel.step === 1 ? v.toFixed(0) : v.toPrecision(4)]);
      });
      if (c.change) list.push([d.changes[c.change].word, c.change_m.toFixed(2) + ' m']);
    }
    document.getElementById('values').innerHTML = rows(list);
  }
  const touched = navigator.maxTouchPoints > 0 && matchMedia('(hover: none)').matches;
  document.getElementById('values').textContent = touched
    ? 'Tap a place for its values, then another one for the profile between them.'
    : 'Point at a place for its values. Click two places for the profile between them.';
  map.on('mousemove', e => show_values(e.latlng));

  // ---- distance and profile between two clicks ---------------------------------------------------------------------

  const marks = L.layerGroup().addTo(map), panel = document.getElementById('profile');
  let from = null;
  async function profile(a, b) {
    const length_m = Math.hypot(b.lng - a.lng, b.lat - a.lat);
    const count = Math.max(2, Math.min(600, Math.ceil(length_m / d.resolution_m)));
    const points = [];
    for (let k = 0; k <= count; ++k) {
      const t = k / count, c = await cell_at(a.lng + t * (b.lng - a.lng), a.lat + t * (b.lat - a.lat));
      points.push({s_m: t * length_m, ground_m: c ? c.ground_m : NaN, top_m: c ? c.ground_m + c.tall_m : NaN});
    }
    return {length_m, points};
  }
  function drawing_of(points, length_m) {
    const width = 420, height = 130, known = points.filter(p => !isNaN(p.ground_m));
    if (!known.length) return '';
    const low = Math.min(...known.map(p => p.ground_m)), high = Math.max(low + 0.5, ...known.map(p => p.top_m));
    const x = p => 50 + (width - 60) * p.s_m / (length_m || 1), y = z => 10 + (height - 30) * (high - z) / (high - low);
    const line = (key, colour) => {
      let path = '', pen = false;
      for (const p of points) {
        if (!isNaN(p[key])) path += (pen ? 'L' : 'M') + x(p).toFixed(1) + ' ' + y(p[key]).toFixed(1);
        pen = !isNaN(p[key]);
      }
      return `<path d="${path}" fill="none" stroke="${colour}" stroke-width="1.5"/>`;
    };
    const word = (at, z) => `<text x="46" y="${at}" font-size="11" text-anchor="end">${z.toFixed(2)} m</text>`;
    return `<svg viewBox="0 0 ${width} ${height}">` + word(14, high) + word(height - 18, low) +
      `<text x="50" y="${height - 4}" font-size="11">0</text>` +
      `<text x="${width - 10}" y="${height - 4}" font-size="11" text-anchor="end">${length_m.toFixed(1)} m</text>` +
      line('top_m', `rgb(${p.stands.rgb})`) + line('ground_m', `rgb(${p.path.rgb})`) + '</svg>';
  }
  async function measure(a, b) {
    const {length_m, points} = await profile(a, b);
    const known = points.filter(p => !isNaN(p.ground_m));
    const list = [['distance', length_m.toFixed(2) + ' m']];
    if (known.length > 1) {
      const rise_m = known[known.length - 1].ground_m - known[0].ground_m;
      list.push(['ground rises by', rise_m.toFixed(2) + ' m']);
      list.push(['not seen', (100 - 100 * known.length / points.length).toFixed(0) + ' %']);
    }
    panel.hidden = false;
    panel.innerHTML = rows(list) + drawing_of(points, length_m);
  }
  map.on('click', e => {
    show_values(e.latlng);
    if (!from) {
      from = e.latlng;
      marks.clearLayers();
      L.circleMarker(from, {radius: 4, color: '#a01428'}).addTo(marks);
      panel.hidden = false;
      panel.textContent = (touched ? 'Tap' : 'Click') + ' where the profile ends.';
      return;
    }
    L.circleMarker(e.latlng, {radius: 4, color: '#a01428'}).addTo(marks);
    L.polyline([from, e.latlng], {color: '#a01428', weight: 2, dashArray: '6 4'}).addTo(marks);
    measure(from, e.latlng);
    from = null;
  });

  // ---- begin -------------------------------------------------------------------------------------------------------

  // The colours of heights reach from the lowest to the highest 1 % of the ground.
  function range_of(heights) {
    const sorted = heights.filter(h => !isNaN(h)).sort((a, b) => a - b);
    const at = t => sorted[Math.floor(t * (sorted.length - 1))] || 0;
    const low = at(0.01), high = at(0.99), spare = Math.max(0, 0.5 - (high - low)) / 2;
    return [low - spare, high + spare];
  }
  async function find_ground_range() {
    const heights = [];
    for (const [column, row] of d.tiles) {
      const tile = await tile_at(column, row);
      for (let p = 0; p < tile.ground.length; p += 4 * 97) heights.push(ground_of(tile, p));
    }
    ground_range_m = range_of(heights);
  }
  find_ground_range().then(() => {
    base['Traversability'].addTo(map);
    if (d.ways.length) ways.addTo(map);
    show_legend();
    document.body.dataset.ready = 'yes';
  });
  document.title = d.title || 'talus';
  /* live.js */
})(map_data);
