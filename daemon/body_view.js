// Draws the body of a diagnosis, turnable, into a canvas: a glass body with the mismatch inside as a glow, and markers,
// arrows, targets and places as lines on top of it. Orthographic; lengths are mm, z is up. No WebGL: it draws anywhere.
(function () {
  'use strict';
  const data = JSON.parse(document.getElementById('body-data').textContent);
  const canvas = document.getElementById('body-canvas');
  const pen = canvas.getContext('2d');
  const control = (name) => document.getElementById('body-' + name);

  const INK = '#1b1f24', MUTED = '#57606a', ASSUMED = '#d55e00', EXPLAINED = '#0072b2', PLACE = '#7a0019', TARGET = '#00734f';
  const SKIN = 0, PAD = 1;  // groups of triangles; 2 is the base
  const MOST_PIXELS = 800000, MOST_PIXELS_MOVING = 70000;
  const HIDDEN = 0.28;  // opacity of what lies behind the body

  const view = {yaw: data.yaw, pitch: 0.33, zoom: 1};
  const image = document.createElement('canvas');
  let settle = 0;

  const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  const add = (a, b, s) => [a[0] + s * b[0], a[1] + s * b[1], a[2] + s * b[2]];
  const minus = (a, b) => add(a, b, -1);

  const normals = (() => {
    const sums = new Float32Array(data.points.length);
    for (let t = 0; t < data.triangles.length; t += 3) {
      const corner = [0, 1, 2].map((c) => 3 * data.triangles[t + c]);
      const p = corner.map((c) => [data.points[c], data.points[c + 1], data.points[c + 2]]);
      const u = minus(p[1], p[0]), v = minus(p[2], p[0]);
      const n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
      for (const c of corner) for (let a = 0; a < 3; ++a) sums[c + a] += n[a];
    }
    for (let i = 0; i < sums.length; i += 3) {
      const length = Math.hypot(sums[i], sums[i + 1], sums[i + 2]) || 1;
      for (let a = 0; a < 3; ++a) sums[i + a] /= length;
    }
    return sums;
  })();

  const map = data.map && {
    nx: data.map.size[0], ny: data.map.size[1], nz: data.map.size[2], origin: data.map.origin, spacing: data.map.spacing,
    values: Uint8Array.from(atob(data.map.values), (c) => c.charCodeAt(0)),
  };

  // Light to dark, as data.colours: shares of the largest mismatch.
  const ramp = (() => {
    const table = new Float32Array(3 * 256), stops = data.colours;
    for (let i = 0; i < 256; ++i) {
      const at = i / 255 * (stops.length - 1), k = Math.min(Math.floor(at), stops.length - 2);
      for (let c = 0; c < 3; ++c) table[3 * i + c] = stops[k][c] + (at - k) * (stops[k + 1][c] - stops[k][c]);
    }
    return table;
  })();

  // From mm to pixels of a drawing of width x height.
  function camera(width, height) {
    const cp = Math.cos(view.pitch), sp = Math.sin(view.pitch), cy = Math.cos(view.yaw), sy = Math.sin(view.yaw);
    const toward = [cp * cy, cp * sy, sp], right = [-sy, cy, 0], up = [-sp * cy, -sp * sy, cp];
    const scale = view.zoom * Math.min(width / (2.35 * data.radius), height / (2.05 * data.radius));
    return {toward, right, up, scale, project(p) {
      const q = minus(p, data.middle);
      return [width / 2 + scale * dot(q, right), height / 2 - scale * dot(q, up), dot(q, toward)];
    }};
  }

  // The nearest and the farthest point of the surface at every pixel: depth (mm), how much it faces us, its group.
  function surface(width, height, cam) {
    const count = width * height;
    const near = new Float32Array(count).fill(-1e9), far = new Float32Array(count).fill(1e9);
    const nearFacing = new Float32Array(count), farFacing = new Float32Array(count), nearLit = new Float32Array(count);
    const nearGroup = new Uint8Array(count), farGroup = new Uint8Array(count);
    const n = data.points.length / 3, x = new Float32Array(n), y = new Float32Array(n), z = new Float32Array(n);
    const facing = new Float32Array(n), lit = new Float32Array(n);
    const light = add(add(cam.toward, cam.up, 0.9), cam.right, -0.6).map((c) => c / Math.sqrt(2.17));
    for (let i = 0; i < n; ++i) {
      [x[i], y[i], z[i]] = cam.project([data.points[3 * i], data.points[3 * i + 1], data.points[3 * i + 2]]);
      const normal = [normals[3 * i], normals[3 * i + 1], normals[3 * i + 2]];
      facing[i] = dot(normal, cam.toward);
      lit[i] = dot(normal, light);
    }
    for (let t = 0; t < data.triangles.length; t += 3) {
      const a = data.triangles[t], b = data.triangles[t + 1], c = data.triangles[t + 2], group = data.groups[t / 3];
      const area = (x[b] - x[a]) * (y[c] - y[a]) - (x[c] - x[a]) * (y[b] - y[a]);
      if (Math.abs(area) < 1e-6) continue;
      const left = Math.max(0, Math.ceil(Math.min(x[a], x[b], x[c]))), right = Math.min(width - 1, Math.max(x[a], x[b], x[c]));
      const top = Math.max(0, Math.ceil(Math.min(y[a], y[b], y[c]))), bottom = Math.min(height - 1, Math.max(y[a], y[b], y[c]));
      for (let j = top; j <= bottom; ++j) {
        for (let i = left; i <= right; ++i) {
          const wb = ((i - x[a]) * (y[c] - y[a]) - (x[c] - x[a]) * (j - y[a])) / area;
          const wc = ((x[b] - x[a]) * (j - y[a]) - (i - x[a]) * (y[b] - y[a])) / area;
          const wa = 1 - wb - wc;
          if (wa < -1e-4 || wb < -1e-4 || wc < -1e-4) continue;
          const depth = wa * z[a] + wb * z[b] + wc * z[c], at = j * width + i;
          const faces = wa * facing[a] + wb * facing[b] + wc * facing[c];
          if (depth > near[at]) {
            near[at] = depth; nearFacing[at] = faces; nearGroup[at] = group;
            nearLit[at] = wa * lit[a] + wb * lit[b] + wc * lit[c];
          }
          if (depth < far[at]) { far[at] = depth; farFacing[at] = faces; farGroup[at] = group; }
        }
      }
    }
    return {near, far, nearFacing, farFacing, nearLit, nearGroup, farGroup};
  }

  // The map at a place in samples from its origin, 0 to 255; trilinear.
  function sample(px, py, pz) {
    if (!(px >= 0 && py >= 0 && pz >= 0 && px < map.nx - 1 && py < map.ny - 1 && pz < map.nz - 1)) return 0;
    const i = px | 0, j = py | 0, k = pz | 0, row = map.nx, slab = row * map.ny, at = k * slab + j * row + i;
    const u = px - i, v = py - j, w = pz - k, m = map.values;
    const low = (m[at] * (1 - u) + m[at + 1] * u) * (1 - v) + (m[at + row] * (1 - u) + m[at + row + 1] * u) * v;
    const high = (m[at + slab] * (1 - u) + m[at + slab + 1] * u) * (1 - v) +
                 (m[at + slab + row] * (1 - u) + m[at + slab + row + 1] * u) * v;
    return low * (1 - w) + high * w;
  }

  // Adds light of colour and opacity behind what is in `sum` (red, green, blue, opacity).
  function behind(sum, red, green, blue, opacity) {
    const share = (1 - sum[3]) * opacity;
    sum[0] += share * red; sum[1] += share * green; sum[2] += share * blue; sum[3] += share;
  }

  // The glow between two depths along the ray through a pixel.
  function glow(sum, start, toward, near, far, floor) {
    const step = 0.9 * map.spacing, inverse = 1 / map.spacing, least = 255 * floor, room = 255 - least;
    const dx = toward[0] * inverse, dy = toward[1] * inverse, dz = toward[2] * inverse;
    const x = start[0] * inverse, y = start[1] * inverse, z = start[2] * inverse;
    for (let depth = near - 0.5 * step; depth > far && sum[3] < 0.97; depth -= step) {
      const value = sample(x + depth * dx, y + depth * dy, z + depth * dz);
      if (value <= least) continue;
      const share = (value - least) / room, colour = 3 * (value | 0);
      behind(sum, ramp[colour], ramp[colour + 1], ramp[colour + 2], 1 - Math.exp(-step * (0.012 + 0.16 * share * share)));
    }
  }

  const shell = [[112, 124, 138], [38, 92, 150], [120, 112, 100]];  // skin, pad, base

  function body(width, height, cam) {
    const s = surface(width, height, cam), picture = new ImageData(width, height), out = picture.data;
    const floor = Number(control('floor').value) / 100;
    const sum = new Float64Array(4), start = [0, 0, 0], corner = map && minus(data.middle, map.origin);
    for (let j = 0, at = 0; j < height; ++j) {
      for (let i = 0; i < width; ++i, ++at) {
        if (s.near[at] < -1e8) continue;
        sum.fill(0);
        const edge = 1 - Math.abs(s.nearFacing[at]), front = shell[s.nearGroup[at]];
        const shade = Math.max(0, 1 - s.nearLit[at]);
        behind(sum, front[0], front[1], front[2],
               0.05 + 0.1 * shade + 0.42 * edge * edge * edge + (s.nearGroup[at] === PAD ? 0.24 : 0));
        if (map) {
          const a = (i - width / 2) / cam.scale, b = (height / 2 - j) / cam.scale;
          for (let c = 0; c < 3; ++c) start[c] = corner[c] + a * cam.right[c] + b * cam.up[c];
          glow(sum, start, cam.toward, s.near[at], s.far[at], floor);
        }
        const back = shell[s.farGroup[at]], rim = 1 - Math.abs(s.farFacing[at]);
        behind(sum, back[0], back[1], back[2], 0.07 + 0.16 * rim * rim + (s.farGroup[at] === SKIN ? 0 : 0.1));
        for (let c = 0; c < 3; ++c) out[4 * at + c] = sum[c] / sum[3];
        out[4 * at + 3] = 255 * sum[3];
      }
    }
    return {picture, near: s.near, width, height};
  }

  // Lines and words over the body; what lies behind its front is fainter.
  function overlay(cam, drawn, width, height) {
    const hidden = (p) => {
      const i = Math.round(p[0] * drawn.width / width), j = Math.round(p[1] * drawn.height / height);
      return i >= 0 && j >= 0 && i < drawn.width && j < drawn.height && p[2] < drawn.near[j * drawn.width + i] - 3;
    };
    const stroke = (colour, wide) => { pen.strokeStyle = colour; pen.lineWidth = wide; };
    function disc(p, radius, fill, edge) {
      pen.beginPath(); pen.arc(p[0], p[1], radius, 0, 7); pen.fillStyle = fill; pen.fill();
      if (edge) { stroke(edge, 1.2); pen.stroke(); }
    }
    function words(text, x, y, colour, weight, align) {
      pen.font = weight + ' 12px system-ui, "Segoe UI", "DejaVu Sans", sans-serif';
      pen.textAlign = align || 'left';
      stroke('rgba(255,255,255,0.9)', 3.5); pen.lineJoin = 'round'; pen.strokeText(text, x, y);
      pen.fillStyle = colour; pen.fillText(text, x, y);
    }
    function arrow(from, by, colour, wide) {
      const a = cam.project(from), b = cam.project(add(from, by, 1));
      const length = Math.hypot(b[0] - a[0], b[1] - a[1]);
      if (length < 1.5) return;
      const u = (b[0] - a[0]) / length, v = (b[1] - a[1]) / length, head = Math.min(6 + wide, 0.6 * length);
      for (const [edge, extra] of [['rgba(255,255,255,0.8)', 2], [colour, 0]]) {
        stroke(edge, wide + extra); pen.fillStyle = edge; pen.lineCap = 'round';
        pen.beginPath(); pen.moveTo(a[0], a[1]); pen.lineTo(b[0] - 0.8 * head * u, b[1] - 0.8 * head * v); pen.stroke();
        pen.beginPath(); pen.moveTo(b[0] + extra * u / 2, b[1] + extra * v / 2);
        pen.lineTo(b[0] - head * u - (0.4 * head + extra / 2) * v, b[1] - head * v + (0.4 * head + extra / 2) * u);
        pen.lineTo(b[0] - head * u + (0.4 * head + extra / 2) * v, b[1] - head * v - (0.4 * head + extra / 2) * u);
        pen.closePath(); pen.fill();
      }
    }
    // Three great circles, their far halves fainter.
    function sphere(place) {
      const r = place.radius;
      for (const [u, v] of [[[1, 0, 0], [0, 1, 0]], [[0, 1, 0], [0, 0, 1]], [[0, 0, 1], [1, 0, 0]], [cam.right, cam.up]]) {
        const outline = u === cam.right;
        stroke(PLACE, outline ? 1.8 : 1);
        for (let i = 0; i < 72; ++i) {
          const points = [i, i + 1].map((k) => add(add(place.center, u, r * Math.cos(k * Math.PI / 36)), v, r * Math.sin(k * Math.PI / 36)));
          const [a, b] = points.map(cam.project), far = dot(minus(points[0], place.center), cam.toward) < -1e-6;
          pen.globalAlpha = outline ? 1 : far ? 0.15 : 0.55;
          pen.beginPath(); pen.moveTo(a[0], a[1]); pen.lineTo(b[0], b[1]); pen.stroke();
        }
      }
      pen.globalAlpha = 1;
      const middle = cam.project(place.center), side = cam.scale * r * 0.74;
      words(place.label, middle[0] + side + 5, middle[1] - side - 4, PLACE, 600);
    }
    function scale_bar() {
      const length = 20 * cam.scale, x = 14, y = height - 14;
      stroke(MUTED, 1.5); pen.beginPath();
      pen.moveTo(x, y - 4); pen.lineTo(x, y); pen.lineTo(x + length, y); pen.lineTo(x + length, y - 4); pen.stroke();
      words('20 mm', x + length / 2, y - 7, MUTED, 400, 'center');
    }
    function axes() {
      const x = width - 40, y = height - 34;
      [['x', [1, 0, 0]], ['y', [0, 1, 0]], ['z', [0, 0, 1]]].forEach(([name, axis]) => {
        const a = 22 * dot(axis, cam.right), b = -22 * dot(axis, cam.up);
        stroke(MUTED, 1.2); pen.beginPath(); pen.moveTo(x, y); pen.lineTo(x + a, y + b); pen.stroke();
        words(name, x + 1.35 * a, y + 1.35 * b + 4, MUTED, 400, 'center');
      });
    }

    const trial = data.trials[Number(control('trial').value)];
    const times = exaggeration(), left = control('arrows').value === 'left';
    for (const target of data.targets) {
      const p = cam.project(target.at);
      stroke(TARGET, 1.8); pen.beginPath();
      pen.moveTo(p[0] - 5, p[1]); pen.lineTo(p[0] + 5, p[1]); pen.moveTo(p[0], p[1] - 5); pen.lineTo(p[0], p[1] + 5); pen.stroke();
      words(target.name, p[0] + 7, p[1] + 13, TARGET, 400);
    }
    data.places.forEach(sphere);
    for (const marker of trial ? trial.markers : data.markers) {
      const p = cam.project(marker.rest);
      pen.globalAlpha = hidden(p) ? HIDDEN : 1;
      if (marker.seen) {
        const between = (to) => minus(marker.seen, to).map((c) => c * times), whole = (to) => to.map((c) => c * times);
        if (!left) arrow(marker.rest, whole(marker.seen), INK, 4.5);
        if (marker.assumed) arrow(marker.rest, left ? between(marker.assumed) : whole(marker.assumed), ASSUMED, left ? 2 : 1.6);
        if (marker.explained) arrow(marker.rest, left ? between(marker.explained) : whole(marker.explained), EXPLAINED, 1.6);
      }
      disc(p, 3.2, '#ffffff', INK);
    }
    pen.globalAlpha = 1;
    for (const pad of data.pads) {
      const away = add(pad.center, minus(pad.center, data.middle), 0.24), p = cam.project(away);
      pen.globalAlpha = hidden(cam.project(pad.center)) ? 0.45 : 1;
      words(pad.name, p[0], p[1] + 4, '#1d4e86', 700, 'center');
    }
    pen.globalAlpha = 1;
    scale_bar();
    axes();
  }

  function exaggeration() { return Math.pow(10, Number(control('times').value) / 50); }

  function draw(most) {
    const width = canvas.clientWidth, height = canvas.clientHeight, density = Math.min(window.devicePixelRatio || 1, 2);
    if (width === 0 || height === 0) return;
    if (canvas.width !== Math.round(width * density) || canvas.height !== Math.round(height * density)) {
      canvas.width = Math.round(width * density); canvas.height = Math.round(height * density);
    }
    const fine = Math.min(1.5, Math.sqrt(most / (width * height)));
    const w = Math.round(width * fine), h = Math.round(height * fine);
    const drawn = body(w, h, camera(w, h));
    image.width = w; image.height = h;
    image.getContext('2d').putImageData(drawn.picture, 0, 0);
    pen.setTransform(density, 0, 0, density, 0, 0);
    pen.clearRect(0, 0, width, height);
    pen.imageSmoothingQuality = 'high';
    pen.drawImage(image, 0, 0, width, height);
    overlay(camera(width, height), drawn, width, height);
    control('times-value').textContent = '× ' + exaggeration().toFixed(exaggeration() < 3 ? 1 : 0);
    control('floor-value').textContent = control('floor').value + ' %';
  }

  let asked = false;
  function moved() {
    clearTimeout(settle);
    settle = setTimeout(() => draw(MOST_PIXELS), 160);
    if (asked) return;
    asked = true;
    requestAnimationFrame(() => { asked = false; draw(MOST_PIXELS_MOVING); });
  }
  function turn(yaw, pitch) {
    view.yaw += yaw;
    view.pitch = Math.max(-0.5 * Math.PI, Math.min(0.5 * Math.PI, view.pitch + pitch));
    moved();
  }
  function zoom(by) { view.zoom = Math.max(0.5, Math.min(6, view.zoom * by)); moved(); }

  const fingers = new Map();
  canvas.addEventListener('pointerdown', (e) => {
    fingers.set(e.pointerId, [e.clientX, e.clientY]);
    canvas.setPointerCapture(e.pointerId);
  });
  canvas.addEventListener('pointermove', (e) => {
    const before = fingers.get(e.pointerId);
    if (!before) return;
    const now = [e.clientX, e.clientY], other = [...fingers].filter(([id]) => id !== e.pointerId).map(([, at]) => at)[0];
    fingers.set(e.pointerId, now);
    if (other) zoom(Math.hypot(now[0] - other[0], now[1] - other[1]) / Math.max(1, Math.hypot(before[0] - other[0], before[1] - other[1])));
    else turn(-0.009 * (now[0] - before[0]), 0.009 * (now[1] - before[1]));
  });
  for (const end of ['pointerup', 'pointercancel']) canvas.addEventListener(end, (e) => fingers.delete(e.pointerId));
  canvas.addEventListener('keydown', (e) => {
    const keys = {ArrowLeft: () => turn(0.12, 0), ArrowRight: () => turn(-0.12, 0), ArrowUp: () => turn(0, -0.1), ArrowDown: () => turn(0, 0.1),
                  '+': () => zoom(1.15), '=': () => zoom(1.15), '-': () => zoom(1 / 1.15), Home: () => look(data.yaw, 0.33)};
    if (!keys[e.key] || e.ctrlKey || e.metaKey || e.altKey) return;
    keys[e.key]();
    e.preventDefault();
  });
  function look(yaw, pitch) { Object.assign(view, {yaw, pitch, zoom: 1}); moved(); }
  control('start').addEventListener('click', () => look(data.yaw, 0.33));
  control('side').addEventListener('click', () => look(data.yaw, 0));
  control('top').addEventListener('click', () => look(-0.5 * Math.PI, 0.5 * Math.PI));
  control('arrows').addEventListener('change', () => {
    control('times').value = String(50 * Math.log10(control('arrows').value === 'left' ? data.times_left : data.times_whole));
    moved();
  });
  for (const name of ['trial', 'floor', 'times']) control(name).addEventListener('input', moved);
  window.addEventListener('resize', () => requestAnimationFrame(() => draw(MOST_PIXELS)));
  window.addEventListener('beforeprint', () => draw(MOST_PIXELS));
  draw(MOST_PIXELS);
})();
