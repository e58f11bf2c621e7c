// walk.js - the tab "The packet's walk": a packet goes down a tree, decision by decision, and figure 3 of the paper.
//
//   walk_start(section, module)   brings the section to life; module is a WebAssembly one with the exports of walk.c
//
// What is shown is in the address: see walk_data.js.
import { addresses, byId, moduleCode } from "./page.js";
import { modelShown } from "./look.js";
import {
  along, brief, clamp, corner, E, figure, hashOf, leadsToFigure, makePacket, makeWorld, many, pointOf, PRESETS,
  projection, raysText, replay, sentence, SHOWN, SHOWN_STATE, sizeOf, stateOf, tidy, trace, traceEnd, TYPES, VERDICTS, WALK_DEFAULTS,
  within,
} from "./walk_data.js";

export function walk_start(section, module) {
  const find = (selector) => section.querySelector(selector);
  const all = (selector) => [...section.querySelectorAll(selector)];
  const [view, bar, strip, picture, slider, log, figureCanvas] =
    ["view", "bar", "strip", "picture", "slider", "log", "figure"].map((name) => find(`.walk-${name}`));
  // Whoever comes without a state sees the walk in 3D.
  const named = () => /^#walk\?/.test(location.hash);
  const stateNamed = () => ({ ...stateOf(location.hash), ...(named() ? {} : { view: "3d" }) });
  let state = stateNamed(), world, rays, events, now, totals;
  let zoom = 1, pan = [0, 0], yaw = 0.5, pitch = 0.45, timer = 0, colours = {};
  let fromBehind = 0.5; // the angle from which a scene of the first tab is seen at first
  const worlds = {};
  let packets = 0, met = []; // how many there have been; triangles of the leaves that this one meets
  const shadow = () => state.packet === "shadow";

  // ---- colours and canvases ----

  function readColours() {
    const style = getComputedStyle(section);
    colours = new Proxy({}, { get: (known, name) => known[name] ??= style.getPropertyValue(name).trim() });
  }
  // Fits a canvas to its place on the screen; returns its context, in CSS pixels, and its size.
  function begin(canvas, height) {
    const ratio = window.devicePixelRatio || 1;
    if (height) canvas.style.height = `${height}px`;
    const w = canvas.clientWidth, h = canvas.clientHeight;
    if (canvas.width !== Math.round(w * ratio) || canvas.height !== Math.round(h * ratio))
      canvas.width = Math.round(w * ratio), canvas.height = Math.round(h * ratio);
    const c = canvas.getContext("2d");
    c.setTransform(ratio, 0, 0, ratio, 0, 0), c.clearRect(0, 0, w, h);
    return { c, w, h };
  }

  // ---- the view ----

  let still = null, stillOf = ""; // what does not change from event to event, drawn once

  // Finds how the world comes onto the canvas: all of it, with where rays begin, or the node whose children are at
  // hand.
  function placing(w, h) {
    const project = projection(state.view, yaw, pitch), node = world.nodeBox(now.opened[now.opened.length - 1]);
    const box = state.follow && node ? node : { lo: [...world.lo], hi: [...world.hi] };
    if (world.isShown && box !== node) box.lo = [...rays[0]?.origin ?? world.lo], box.hi = [...rays[0]?.origin ?? world.hi];
    for (const ray of box === node ? [] : rays)
      for (const point of !world.isShown ? [ray.origin] : [ray.origin, along(ray, shadow() ? 1 : ray.hits ? ray.t : 0)])
        for (let a = 0; a < 3; a++) box.lo[a] = Math.min(box.lo[a], point[a]), box.hi[a] = Math.max(box.hi[a], point[a]);
    let u0 = Infinity, u1 = -Infinity, v0 = Infinity, v1 = -Infinity;
    for (let i = 0; i < 8; i++) {
      const [u, v] = project(corner(box, i));
      u0 = Math.min(u0, u), u1 = Math.max(u1, u), v0 = Math.min(v0, v), v1 = Math.max(v1, v);
    }
    const margin = box === node || world.isShown ? 0.25 * Math.min(w, h) : 24;
    const scale = zoom * Math.min((w - margin) / (u1 - u0), (h - margin) / (v1 - v0));
    const cu = (u0 + u1) / 2 + pan[0], cv = (v0 + v1) / 2 + pan[1];
    const to = (p) => {
      const [u, v] = project(p);
      return [w / 2 + (u - cu) * scale, h / 2 - (v - cv) * scale];
    };
    return { to, scale, key: [scale, cu, cv].join() };
  }
  function pathBox(c, to, b) {
    const p = Array.from({ length: 8 }, (_, i) => to(corner(b, i)));
    if (state.view !== "3d") {
      const x = p.map((q) => q[0]), y = p.map((q) => q[1]), x0 = Math.min(...x), y0 = Math.min(...y);
      c.rect(x0, y0, Math.max(Math.max(...x) - x0, 1), Math.max(Math.max(...y) - y0, 1));
      return;
    }
    for (let i = 0; i < 8; i++)
      for (const bit of [1, 2, 4]) if (!(i & bit)) c.moveTo(...p[i]), c.lineTo(...p[i | bit]);
  }
  function pathPoints(c, points) {
    points.forEach((p, k) => c[k ? "lineTo" : "moveTo"](...p));
    c.closePath();
  }
  function fillBox(c, to, b) { // in 3D its three sides that face us, or all: they are translucent
    c.beginPath();
    if (state.view !== "3d") pathBox(c, to, b);
    else
      for (const face of [[0, 1, 3, 2], [4, 5, 7, 6], [0, 1, 5, 4], [2, 3, 7, 6], [0, 2, 6, 4], [1, 3, 7, 5]])
        pathPoints(c, face.map((i) => to(corner(b, i))));
    c.fill();
  }
  function drawStill(w, h, { to, key }) {
    const mesh = find("[name=walk-mesh]").checked, tree = find("[name=walk-tree]").checked;
    const ratio = window.devicePixelRatio || 1;
    const all = [key, w, h, ratio, state.scene, packets, state.view, yaw, pitch, mesh, tree, colours["--walk-mesh"]].join();
    if (all === stillOf) return still;
    stillOf = all, still ??= document.createElement("canvas");
    still.width = Math.round(w * ratio), still.height = Math.round(h * ratio);
    const c = still.getContext("2d");
    c.setTransform(ratio, 0, 0, ratio, 0, 0), c.lineWidth = 0.7;
    if (mesh) { // two edges of each triangle: its neighbour has the third
      for (const { shade, at } of world.seen) { // what the camera sees, by points
        const [x, y] = to(at);
        c.fillStyle = colours[`--walk-seen-${shade >> 6}`], c.fillRect(x - 1, y - 1, 2, 2);
      }
      c.strokeStyle = colours[world.isShown ? "--walk-tree" : "--walk-mesh"], c.beginPath();
      for (const t of world.isShown ? met : world.triangles) c.moveTo(...to(t)), c.lineTo(...to(t.slice(3))), c.lineTo(...to(t.slice(6)));
      c.stroke();
    }
    if (tree) {
      c.strokeStyle = colours["--walk-tree"], c.beginPath();
      for (const b of world.boxes) if (!world.isShown || !b.triangles) pathBox(c, to, b); // of many boxes not the leaves
      c.stroke();
    }
    return still;
  }
  function drawRays(c, to) {
    const colour = VERDICTS[now.event.kind]?.colour || "--walk-ray";
    const reach = Math.hypot(...world.hi.map((x, a) => x - world.lo[a]));
    const end = (ray, i) => {
      if (Number.isFinite(now.t[i])) return now.t[i];
      const inside = within(ray, world.lo, world.hi, Infinity);
      return inside ? inside[1] : reach / Math.hypot(...ray.direction);
    };
    const draw = (ray, i) => (c.moveTo(...to(ray.origin)), c.lineTo(...to(along(ray, end(ray, i)))));
    const active = (i) => i >= now.first && i <= now.last && !now.done[i];
    const sets = [
      ["--walk-idle", 1, (i) => !active(i) && now.event.kind !== E.END],
      ["--walk-ray", 0.6, (i) => (active(i) && !now.inBox[i]) || now.event.kind === E.END],
      [colour, 1, (i) => active(i) && now.inBox[i]],
      [colour, 2.5, (i) => i === now.first && active(i)],
    ];
    for (const [name, width, chosen] of sets) {
      c.strokeStyle = colours[name], c.lineWidth = width, c.beginPath();
      rays.forEach((ray, i) => chosen(i) && draw(ray, i));
      c.stroke();
    }
    c.fillStyle = colours["--walk-hit"];
    rays.forEach((ray, i) => {
      if (!now.hit[i]) return;
      const [x, y] = to(along(ray, now.t[i])), r = now.event.kind === E.HIT && now.event.ray === i ? 4 : 1.6;
      c.beginPath(), c.arc(x, y, r, 0, 7), c.fill();
    });
  }
  function drawView() {
    const { c, w, h } = begin(view), placed = placing(w, h), { to } = placed;
    if (!w || !h) return;
    c.drawImage(drawStill(w, h, placed), 0, 0, w, h);
    const past = find("[name=walk-past]").checked;
    c.lineWidth = 1;
    for (const [kind, style] of Object.entries(VERDICTS)) { // those so far, faintly
      if (!past) break;
      c.strokeStyle = colours[style.colour], c.setLineDash(style.dash), c.globalAlpha = 0.55, c.beginPath();
      for (const [id, verdict] of now.verdicts) if (verdict === Number(kind)) pathBox(c, to, world.boxes[id]);
      c.stroke();
    }
    c.globalAlpha = 1, c.setLineDash([2, 2]), c.strokeStyle = colours["--walk-wait"], c.beginPath();
    for (const b of now.waiting.values()) if (b.node === now.opened[now.opened.length - 1]) pathBox(c, to, b);
    c.stroke();
    c.setLineDash([]), c.strokeStyle = colours["--walk-node"], c.lineWidth = 1.2, c.beginPath(); // the nodes above
    for (const index of now.opened) pathBox(c, to, world.nodeBox(index));
    c.stroke();
    drawRays(c, to);
    if (now.box) {
      const style = VERDICTS[now.event.kind] || { colour: "--walk-node", dash: [] };
      c.strokeStyle = c.fillStyle = colours[style.colour];
      c.globalAlpha = 0.16, fillBox(c, to, now.box), c.globalAlpha = 1;
      c.lineWidth = 3, c.setLineDash(style.dash.map((x) => 1.5 * x));
      c.beginPath(), pathBox(c, to, now.box), c.stroke(), c.setLineDash([]);
    }
    if (now.event.kind === E.HIT) {
      const t = world.cornersOf(now.event.index).find((one) => one.lane === now.event.child).at;
      c.fillStyle = colours["--walk-later"], c.beginPath();
      pathPoints(c, [0, 3, 6].map((k) => to(t.slice(k, k + 3)))), c.fill();
    }
    const caption = { yz: "from the side: z to the left, y up", xz: "from above: x to the right, z down",
      xy: "from the front: x to the right, y up", "3d": "drag to turn" }[state.view];
    c.fillStyle = colours["--walk-back"], c.font = "12px system-ui, sans-serif"; // over what lies behind it
    c.globalAlpha = 0.8, c.fillRect(6, h - 21, c.measureText(caption).width + 8, 17), c.globalAlpha = 1;
    c.fillStyle = colours["--walk-soft"], c.fillText(caption, 10, h - 8);
  }

  // ---- the range ----

  function drawBar() {
    const n = Math.max(rays.length, 1), perRow = Math.min(n, bar.clientWidth < 600 ? 32 : 64), high = 26;
    const { c, w } = begin(bar, Math.ceil(n / perRow) * high + 2), cell = Math.min(w / perRow, 26);
    const colour = colours[VERDICTS[now.event.kind]?.colour || "--walk-ray"];
    const group = [E.LEAF_TEST, E.HIT].includes(now.event.kind) ? now.event.ray >> 3 : -1;
    rays.forEach((_, i) => {
      const x = i % perRow * cell, y = Math.floor(i / perRow) * high + 6, size = cell * (i % 8 === 7 ? 0.8 : 0.94);
      const inRange = i >= now.first && i <= now.last;
      c.fillStyle = colours["--walk-ink"];
      if (i >> 3 === group) c.fillRect(x, y + 17.5, size, 2);
      c.strokeStyle = inRange ? colour : colours["--walk-line"], c.fillStyle = colour, c.lineWidth = 1;
      c.globalAlpha = now.inBox[i] ? 1 : 0.25;
      if (inRange && !now.done[i]) c.fillRect(x, y, size, 16);
      c.globalAlpha = now.done[i] ? 0.35 : 1;
      c.strokeRect(x + 0.5, y + 0.5, size - 1, 15);
      c.globalAlpha = 1;
      if (i === now.first && now.last >= now.first) {
        const middle = x + size / 2;
        c.fillStyle = colours["--walk-ink"], c.beginPath();
        pathPoints(c, [[middle, y + 1], [middle - 4, y - 6], [middle + 4, y - 6]]), c.fill();
      }
      if (now.hit[i]) {
        c.fillStyle = colours["--walk-hit"], c.strokeStyle = colours["--walk-back"];
        c.beginPath(), c.arc(x + size / 2, y + 12, Math.min(2.4, size / 3), 0, 7), c.fill(), c.stroke();
      }
    });
    const hits = now.inBox.filter((yes, i) => yes && i >= now.first && i <= now.last).length;
    bar.setAttribute("aria-label", now.last < now.first ? "No active range"
      : `Active range: ${raysText(now.first, now.last)} of ${n}; ${hits} of them hit the box at hand`);
  }
  function drawStrip() {
    const { c, w, h } = begin(strip), n = events.length;
    events.forEach((e, i) => {
      if (!VERDICTS[e.kind] && e.kind !== E.HIT) return;
      c.fillStyle = colours[VERDICTS[e.kind]?.colour || "--walk-hit"];
      const x = 8 + (w - 16) * i / n; // the slider's thumb has a width, too
      if (e.kind === E.HIT) c.fillRect(x, h - 4, Math.max((w - 16) / n, 0.6), 4);
      else c.fillRect(x, 0, Math.max((w - 16) / n, 0.8), h - 5);
    });
    c.fillStyle = colours["--walk-ink"], c.fillRect(8 + (w - 16) * (state.event + 0.5) / n - 1, 0, 2, h);
  }

  // ---- text ----

  function tellLog() {
    const lines = 11, from = clamp(state.event - 5, 0, Math.max(events.length - lines, 0));
    log.replaceChildren(...events.slice(from, from + lines).map((e, k) => {
      const li = document.createElement("li"), i = from + k;
      li.textContent = brief(e), li.style.textIndent = `${0.9 * e.depth}em`, li.dataset.event = i;
      if (VERDICTS[e.kind]) li.style.borderLeftColor = `var(${VERDICTS[e.kind].colour})`;
      if (i === state.event) li.setAttribute("aria-current", "step");
      return li;
    }));
  }
  function row(head, cells, swatch) {
    const tr = document.createElement("tr"), th = document.createElement("th");
    th.scope = "row";
    if (swatch) {
      const mark = document.createElement("span");
      mark.className = "walk-swatch", mark.style.borderColor = `var(${swatch.colour})`;
      if (swatch.dash.length) mark.style.borderStyle = "dashed";
      else mark.style.background = `var(${swatch.colour})`;
      th.append(mark);
    }
    th.append(head), tr.append(th);
    for (const text of cells) tr.append(Object.assign(document.createElement("td"), { textContent: text }));
    return tr;
  }
  function tellCounts() {
    const end = events[events.length - 1], kinds = Object.keys(VERDICTS).map(Number);
    const shown = kinds.filter((kind) => kind !== E.NONE_LEFT || shadow());
    find(".walk-verdicts tbody").replaceChildren(...shown.map((kind) =>
      row(VERDICTS[kind].text, [now.counts[kind] || 0, `of ${totals.verdicts[kind] || 0}`], VERDICTS[kind])));
    const e = now.event, n = Math.max(rays.length, 1);
    const work = [["nodes opened", (x) => x.nodes], ["box tests", (x) => x.boxes], ["box vectors", (x) => x.boxVectors],
      ["triangle tests", (x) => x.triangles], ["triangle vectors", (x) => x.triangleVectors],
      ["vectors a ray", (x) => ((x.boxVectors + x.triangleVectors) / n).toFixed(1)]];
    find(".walk-counters tbody").replaceChildren(...work.map(([name, of]) =>
      row(name, [e, end, totals.all, totals[2007], totals.none].map(of))));
    const hits = rays.filter((ray) => ray.hits).length;
    find(".walk-count").textContent = rays.length === 0 ? "No ray: the camera's meet nothing here."
      : `${many(rays.length, "ray")}, ${hits} ${shadow() ? "in shadow" : `${hits === 1 ? "hits" : "hit"} something`}.`;
  }

  // ---- the picture to choose from ----

  function drawPicture() {
    const { width, height, shades } = world.picture, [across] = world.size, part = width / across;
    picture.width = width, picture.height = height;
    const c = picture.getContext("2d"), image = c.createImageData(width, height);
    shades.forEach((shade, i) => {
      image.data.set(shade ? [shade, shade, shade, 255] : [40, 44, 60, 255], 4 * i);
    });
    c.putImageData(image, 0, 0);
    const size = part * state.size * state.spacing, x = part * state.x - 0.5, y = part * state.y - 0.5;
    c.strokeStyle = "#fff", c.lineWidth = 3, c.strokeRect(x, y, size + 1, size + 1);
    c.strokeStyle = "#d60", c.lineWidth = 1.5, c.strokeRect(x, y, size + 1, size + 1);
  }

  // ---- figure 3 ----

  let places = []; // of the squares, to be clicked

  function drawFigure() {
    const members = figure(module, state.assembly, state.met), packets = [];
    for (const m of members) (packets[m.packet] ??= { type: m.type, rays: [] }).rays.push(m.ray);
    const dark = matchMedia("(prefers-color-scheme: dark)").matches;
    const colour = (k) => `hsl(${Math.floor(k * 222.5) % 360},75%,${dark ? (k % 2 ? 72 : 60) : k % 2 ? 34 : 45}%)`;
    const find3 = (type, ray) => packets.findIndex((p) => (p.type === type || p.type === 4) && p.rays.includes(ray));
    const { c, w, h } = begin(figureCanvas), unit = Math.min(w / 17.5, 70), left = Math.max((w - 17.5 * unit) / 2, 1);
    const y = h * 0.58, eye = [left + 0.2 * unit, 18], light = [left + 5 * unit, 18];
    const fills = { d: "--walk-diffuse", f: "--walk-floor", m: "--walk-metal", g: "--walk-glass", ".": "--walk-back" };
    const arrow = (x0, y0, dx, dy, length, k, dot) => {
      const l = length / Math.hypot(dx, dy), x = x0 + l * dx, y1 = y0 + l * dy, a = Math.atan2(dy, dx);
      c.strokeStyle = c.fillStyle = colour(k), c.lineWidth = 2.5;
      c.beginPath(), c.moveTo(x0, y0), c.lineTo(x, y1), c.stroke(), c.beginPath();
      if (dot) c.arc(x, y1, 3.5, 0, 7);
      else for (const d of [0, 2.6, -2.6]) c.lineTo(x + 7 * Math.cos(a + d), y1 + 7 * Math.sin(a + d));
      c.fill();
    };
    places = [], c.textAlign = "center", c.font = `${unit < 24 ? 10 : 12}px system-ui, sans-serif`;
    for (let i = 0; i < 16; i++) {
      const x = left + (i + 0.5) * unit;
      c.strokeStyle = colours["--walk-line"], c.lineWidth = 1;
      c.beginPath(), c.moveTo(...eye), c.lineTo(x, y), c.stroke();
      c.fillStyle = colours[fills[state.met[i]]];
      for (const paint of ["fillRect", "strokeRect"]) c[paint](x - unit / 2 + 1, y, unit - 2, 20);
      c.fillStyle = colours[state.met[i] === "." ? "--walk-soft" : "--walk-ink"], c.fillText(i + 1, x, y + 14);
      places.push([x - unit / 2, x + unit / 2]);
    }
    for (let i = 0; i < 16; i++) {
      const x = left + (i + 0.5) * unit, dx = x - eye[0], dy = y - eye[1], met = state.met[i];
      const shadowPacket = "df".includes(met) ? find3(1, i) : -1;
      const reflected = "fmg".includes(met) ? find3(2, i) : -1, refracted = met === "g" ? find3(3, i) : -1;
      if (shadowPacket >= 0) arrow(x, y, light[0] - x, light[1] - y, h * 0.26, shadowPacket, true);
      const length = Math.min(h * 0.2, 2 * unit);
      if (reflected >= 0) arrow(x, y, 0.7 * dx, -dy, length, reflected, false);
      if (refracted >= 0) arrow(x, y + 20, 0.35 * dx, dy, length, refracted, false);
    }
    c.fillStyle = colours["--walk-ink"], c.beginPath(), c.arc(...eye, 5, 0, 7), c.fill();
    c.fillStyle = colours["--walk-light"], c.beginPath(), c.arc(...light, 7, 0, 7), c.fill();
    c.fillStyle = colours["--walk-soft"], c.textAlign = "left", c.font = "12px system-ui, sans-serif";
    c.fillText("eye", eye[0] + 9, 16), c.fillText("light", light[0] + 11, 16);
    const text = find(".walk-figure-text"), order = packets.map((p, k) => ({ ...p, k }))
      .sort((a, b) => a.type - b.type || a.rays[0] - b.rays[0]);
    text.replaceChildren(`${many(members.length, "ray")} in ${many(packets.length, "packet")}: `);
    order.forEach((p, i) => {
      if (!i || order[i - 1].type !== p.type) text.append(`${i ? "; " : ""}${TYPES[p.type]} `);
      const chip = document.createElement("span");
      chip.className = "walk-chip", chip.style.borderColor = colour(p.k);
      chip.textContent = `(${p.rays.map((r) => r + 1).join(", ")})`;
      text.append(chip);
    });
  }

  // ---- keeping it all together ----

  let hashTimer = 0, hashWritten = "";
  function writeHash() { // not at once: browsers count such calls
    clearTimeout(hashTimer);
    if (tour) return;
    hashTimer = setTimeout(() => {
      hashWritten = hashOf(state);
      if (section.offsetParent !== null) history.replaceState(null, "", hashWritten);
    }, 250);
  }
  let notice = ""; // what is said before the event, until something is chosen
  function showEvent() {
    state.event = clamp(state.event, 0, events.length - 1);
    now = replay(world, rays, events, state.event, shadow());
    const said = sentence(now.event, world, rays.length, shadow());
    const numbered = `Event ${state.event + 1} of ${events.length}. ${said}`, told = find(".walk-sentence");
    const mark = `var(${VERDICTS[now.event.kind]?.colour || "--walk-line"})`;
    told.textContent = notice + numbered, told.style.setProperty("--walk-mark", mark);
    const from = { yz: "from the side", xz: "from above", xy: "from the front", "3d": "in space" }[state.view];
    view.setAttribute("aria-label", `Boxes of the tree and ${many(rays.length, "ray")}, ${from}. ${numbered}`);
    slider.max = events.length - 1, slider.value = state.event, slider.setAttribute("aria-valuetext", numbered);
    if (!tour) find(".walk-caption").textContent = numbered; // which stands there where nothing else does
    drawView(), drawBar(), drawStrip(), tellLog(), tellCounts(), writeHash();
  }
  // Opens a scene of the first tab in this module, as far as it is another one, and looks at it as the state says.
  let opened = "", posed = "", looked = "";
  function shownWorld() {
    const model = state.scene === "model" ? modelShown() : null, [width, height] = sizeOf(state);
    const nowOpened = [state.scene, model?.number, state.light].join(), nowPosed = [nowOpened, state.time].join();
    const nowLooked = [nowPosed, state.eye, state.target, state.picture].join();
    if (nowLooked === looked) return worlds.shown;
    const known = nowPosed === posed ? worlds.shown : null;
    looked = posed = ""; // unless all goes well
    if (nowOpened !== opened) {
      opened = "";
      openScene(module, { scene: SHOWN.indexOf(state.scene), light: state.light, model });
    }
    mustOpen(module, module._web_pose(state.time, 0));
    const own = [...module.HEAPF32.slice(module._web_first_camera() >> 2, (module._web_first_camera() >> 2) + 6)];
    const eye = pointOf(state.eye) ?? own.slice(0, 3), target = pointOf(state.target) ?? own.slice(3);
    module._web_camera(...eye, ...target, 0, 0);
    if (module._walk_show(width, height)) throw new Error("there is not enough memory for the scene");
    opened = nowOpened, posed = nowPosed, looked = nowLooked;
    fromBehind = Math.atan2(eye[0] - target[0], eye[2] - target[2]) + 0.9;
    return worlds.shown = makeWorld(module, state.scene, [width, height], eye, known);
  }
  // After a change of the packet or its steps: all is traced anew.
  function showPacket() {
    try {
      world = SHOWN.includes(state.scene) ? shownWorld() : null;
    } catch (error) {
      notice = `This scene cannot be shown: ${error.message}. `;
      Object.assign(state, { scene: WALK_DEFAULTS.scene, event: 0 }), tidy(state), showControls();
    }
    world ??= worlds[state.scene] ??= makeWorld(module, state.scene);
    rays = makePacket(module, state);
    packets++;
    totals = { verdicts: {} };
    for (const [name, steps] of Object.entries(PRESETS)) totals[name] = traceEnd(module, steps);
    events = trace(module, state.steps);
    const leaves = new Set(events.filter((e) => world.isShown && e.kind === E.LEAF).map((e) => e.index));
    met = [...leaves].flatMap((leaf) => world.cornersOf(leaf).map((one) => one.at));
    for (const e of events) totals.verdicts[e.kind] = (totals.verdicts[e.kind] || 0) + 1;
    for (const [name, most] of [["x", world.size[0]], ["y", world.size[1]]]) find(`[name=walk-${name}]`).max = most - 1;
    drawPicture(), showEvent();
  }
  function turnBack() {
    zoom = 1, pan = [0, 0], yaw = world.isShown ? fromBehind : 0.5, pitch = 0.45;
  }
  function showControls(typing) { // all but the one that is being typed into
    const scenes = find("[name=walk-scene]"), last = scenes.options[scenes.length - 1];
    if (modelShown() && last.value !== "model") scenes.add(new Option(modelShown().name, "model"));
    else if (last.value === "model" && modelShown()) last.text = modelShown().name;
    else if (last.value === "model") last.remove();
    for (const name of ["scene", "packet", "size", "x", "y", "spacing", "order", "met"]) {
      const control = find(`[name=walk-${name}]`);
      if (control !== typing) control.value = state[name];
    }
    for (const name of ["view", "assembly"]) find(`[name=walk-${name}][value="${state[name]}"]`).checked = true;
    for (const box of all(".walk-steps input")) box.checked = (state.steps & Number(box.value)) !== 0;
    find("[name=walk-follow]").checked = state.follow !== 0;
    for (const button of all("[data-steps]"))
      button.setAttribute("aria-pressed", Number(button.dataset.steps) === state.steps);
  }
  function change(what, typing) {
    const old = { ...state };
    notice = "";
    Object.assign(state, what), tidy(state), showControls(typing);
    const differ = (names) => names.some((name) => state[name] !== old[name]);
    const packet = differ(["scene", "packet", "size", "x", "y", "spacing", "order", "steps"]);
    if (differ(["scene"])) {
      play(false);
      state.event = 0;
      for (const name of SHOWN_STATE) state[name] = WALK_DEFAULTS[name];
    }
    if (differ(["scene"])) tidy(state), showControls(typing);
    if (differ(["view", "follow", "scene"])) pan = [0, 0], zoom = 1;
    if (packet) showPacket();
    if (differ(["scene"])) turnBack(), drawView();
    if (!packet) showEvent();
    if (differ(["assembly", "met"])) drawFigure();
  }
  function showAll() {
    const gone = state.scene === "model" && !modelShown();
    if (gone) {
      Object.assign(state, { scene: WALK_DEFAULTS.scene, event: 0 });
      notice = "The model has gone with the page of before; choose its file once more. This is another scene. ";
    }
    readColours(), tidy(state), showControls(), stillOf = "", showPacket(), turnBack(), drawView(), drawFigure();
  }
  function followAddress() { // as far as figure 3, if it is about that
    if (leadsToFigure(location.hash)) byId("walk-figure-title").scrollIntoView();
  }

  // ---- playing ----

  function play(on) {
    const button = find("[data-do=play]");
    clearTimeout(timer), timer = 0;
    button.setAttribute("aria-pressed", on), button.textContent = on ? "pause" : "play";
    find(".walk-sentence").setAttribute("aria-live", on ? "off" : "polite");
    if (!on) return;
    if (state.event >= events.length - 1) change({ event: 0 });
    const tick = () => {
      if (section.offsetParent === null || state.event >= events.length - 1) return play(false);
      const rate = Number(find("[name=walk-speed]").value), atOnce = Math.max(1, Math.round(rate / 30));
      change({ event: Math.min(state.event + atOnce, events.length - 1) });
      timer = setTimeout(tick, 1000 * atOnce / rate);
    };
    timer = setTimeout(tick, 150);
  }
  const ACTIONS = {
    first: () => (play(false), change({ event: 0 })),
    back: () => (play(false), change({ event: Math.max(state.event - 1, 0) })),
    step: () => (play(false), change({ event: state.event + 1 })),
    last: () => (play(false), change({ event: events.length - 1 })),
    play: () => play(!timer),
    in: () => (zoom = Math.min(zoom * 1.4, 60), drawView()),
    out: () => (zoom = Math.max(zoom / 1.4, 0.4), drawView()),
    fit: () => (turnBack(), drawView()),
    paper: () => change({ met: WALK_DEFAULTS.met }),
    full: () => (document.fullscreenElement ? document.exitFullscreen() : find(".walk-frame").requestFullscreen()),
  };

  // ---- the tour ----

  let tour = null; // {began, frame} while it plays
  const FROM = { camera: "start at an eye and go through neighbouring pixels", mirror: "start where a mirror is seen",
    shadow: "go to the lamp from what is seen" };
  const FROM_ONE = { camera: "starts at an eye and goes through a pixel", mirror: "starts where a mirror is seen",
    shadow: "goes to the lamp from what is seen" };
  function startOf() {
    if (rays.length === 1) return `This ray ${FROM_ONE[state.packet]}. It is a packet by itself.`;
    const from = state.spacing === 1 ? FROM[state.packet] : FROM[state.packet].replace("neighbouring pixels", `pixels that are ${state.spacing} apart`);
    return `These ${rays.length} rays ${from}. They travel together, as a packet.`;
  }
  function endOf() {
    if (shadow()) return "At the end each ray knows whether something is in its way.";
    if (rays.every((ray) => ray.hits)) return "At the end each ray has found what it hits.";
    return "At the end each ray knows what it hits, or that it hits nothing.";
  }
  const TOUR = [ // how long a part of it lasts, in milliseconds, and what it says
    [4000, startOf],
    [4000, () => "The scene's triangles lie in boxes, and these in larger boxes. That is the tree."],
    [9000, () => "The packet walks down the tree. Where it misses a box, it skips all that is inside, for all rays at once."],
    [6000, () => `${endOf()} That took ${events[events.length - 1].triangles.toLocaleString("en")} tests ` +
      `of a ray against a triangle. To test all would have taken ${(rays.length * world.boxes.reduce((sum, b) => sum + b.triangles, 0)).toLocaleString("en")}.`],
  ];
  function endTour() {
    if (!tour) return;
    cancelAnimationFrame(tour.frame);
    tour = null;
    find("[name=walk-tree]").checked = false;
    find(".walk-caption").hidden = !document.fullscreenElement;
    find(".walk-sentence").setAttribute("aria-live", "polite");
    find("[data-do=tour]").setAttribute("aria-pressed", false);
    showEvent();
  }
  function beginTour() {
    play(false), endTour();
    change({ view: "3d", event: 0, follow: 0 }), turnBack();
    tour = { began: performance.now(), frame: 0, part: -1, turned: yaw - 0.5, drawn: 0 };
    find("[data-do=tour]").setAttribute("aria-pressed", true);
    find(".walk-sentence").setAttribute("aria-live", "off");
    find(".walk-caption").hidden = false;
    const draw = (now) => {
      if (section.offsetParent === null) return endTour();
      tour.frame = requestAnimationFrame(draw);
      if (now - tour.drawn < 30) return;
      tour.drawn = now;
      let at = Math.max(0, now - tour.began), part = 0;
      yaw = tour.turned + 0.5 * Math.cos(at / 5000);
      while (part < TOUR.length && at >= TOUR[part][0]) at -= TOUR[part++][0];
      if (part === TOUR.length) return endTour();
      if (part !== tour.part) find(".walk-caption").textContent = TOUR[part][1]();
      tour.part = part;
      find("[name=walk-tree]").checked = part === 1;
      const event = part < 2 ? 0 : part > 2 ? events.length - 1 : Math.floor(at / TOUR[2][0] * events.length);
      if (event !== state.event) change({ event });
      else drawView();
    };
    tour.frame = requestAnimationFrame(draw);
  }
  // The first touch ends it, and does what it does. A press of its own button is left to that.
  const pressesTour = (event) => event.target.closest("[data-do=tour]") && (event.type === "pointerdown" || [" ", "Enter"].includes(event.key));
  for (const kind of ["pointerdown", "wheel"])
    section.addEventListener(kind, (event) => pressesTour(event) || endTour(), { capture: true, passive: true });
  ACTIONS.tour = () => (tour ? endTour() : beginTour());

  // ---- what one does ----

  section.addEventListener("click", (event) => {
    const button = event.target.closest("button"), line = event.target.closest(".walk-log li");
    if (line) play(false), change({ event: Number(line.dataset.event) });
    if (button?.dataset.do) ACTIONS[button.dataset.do]();
    if (button?.dataset.steps) change({ steps: Number(button.dataset.steps) });
  });
  section.addEventListener("input", (event) => {
    const control = event.target, name = control.name?.replace("walk-", "");
    const steps = () => all(".walk-steps input").reduce((sum, x) => sum + (x.checked ? Number(x.value) : 0), 0);
    if (control === slider) play(false), change({ event: Number(slider.value) });
    else if (control.closest(".walk-steps")) change({ steps: steps() || PRESETS.none });
    else if (name === "follow") change({ follow: Number(control.checked) });
    else if (["mesh", "tree", "past"].includes(name)) drawView();
    else if (name !== "met" && name in WALK_DEFAULTS && control.value !== "") {
      const value = typeof WALK_DEFAULTS[name] === "number" ? Number(control.value) : control.value;
      change({ [name]: value }, control.type === "number" ? control : null);
    }
  });
  section.addEventListener("change", (event) => { // what was typed is complete
    if (event.target.name === "walk-met") change({ met: event.target.value });
    else if (event.target.type === "number") showControls();
  });
  document.addEventListener("keydown", (event) => {
    const at = event.target;
    if (section.offsetParent === null || event.ctrlKey || event.altKey || event.metaKey) return;
    if (!pressesTour(event)) endTour();
    if (at !== document.body && !section.contains(at)) return;
    const typed = at.closest("input:not([type=checkbox]), select"), pressed = at.closest("button, input");
    const action = { ArrowLeft: "back", ArrowRight: "step", " ": "play", Home: "first", End: "last" }[event.key];
    if (!action || typed || (event.key === " " && pressed)) return;
    event.preventDefault(), ACTIONS[action]();
  });

  // Dragging moves the view, or turns it in 3D; two fingers and the wheel make it larger.
  const fingers = new Map();
  view.addEventListener("pointerdown", (event) => {
    fingers.set(event.pointerId, [event.clientX, event.clientY]), view.setPointerCapture(event.pointerId);
  });
  view.addEventListener("pointermove", (event) => {
    const before = fingers.get(event.pointerId);
    if (!before) return;
    const dx = event.clientX - before[0], dy = event.clientY - before[1];
    const { scale } = placing(view.clientWidth, view.clientHeight);
    if (fingers.size === 2) {
      const [, [x, y]] = [...fingers].find(([id]) => id !== event.pointerId);
      const was = Math.max(Math.hypot(before[0] - x, before[1] - y), 1);
      zoom = clamp(zoom * Math.hypot(event.clientX - x, event.clientY - y) / was, 0.4, 60);
    } else if (state.view === "3d" && !event.shiftKey) yaw -= dx / 150, pitch = clamp(pitch + dy / 150, -1.5, 1.5);
    else pan = [pan[0] - dx / scale, pan[1] + dy / scale];
    fingers.set(event.pointerId, [event.clientX, event.clientY]);
    drawView();
  });
  for (const name of ["pointerup", "pointercancel"])
    view.addEventListener(name, (event) => fingers.delete(event.pointerId));
  view.addEventListener("wheel", (event) => {
    if (document.activeElement !== view && !event.ctrlKey) return; // else the page scrolls
    event.preventDefault();
    const r = view.getBoundingClientRect();
    const x = event.clientX - r.left - r.width / 2, y = event.clientY - r.top - r.height / 2;
    const before = placing(r.width, r.height).scale;
    zoom = clamp(zoom * Math.exp(-event.deltaY / 500), 0.4, 60);
    const after = placing(r.width, r.height).scale;
    pan = [pan[0] + x / before - x / after, pan[1] - y / before + y / after];
    drawView();
  }, { passive: false });

  const choose = (event) => {
    const r = picture.getBoundingClientRect(), half = state.size * state.spacing / 2;
    const to = (at, of) => Math.max(Math.round(at * of - half), 0);
    change({ x: to((event.clientX - r.left) / r.width, world.size[0]), y: to((event.clientY - r.top) / r.height, world.size[1]) });
  };
  picture.addEventListener("pointerdown", (event) => {
    play(false), picture.setPointerCapture(event.pointerId), choose(event);
  });
  picture.addEventListener("pointermove", (event) => event.buttons && choose(event));
  figureCanvas.addEventListener("click", (event) => {
    const x = event.clientX - figureCanvas.getBoundingClientRect().left;
    const i = places.findIndex(([x0, x1]) => x >= x0 && x < x1);
    if (i < 0) return;
    const next = "dfmg."[("dfmg.".indexOf(state.met[i]) + 1) % 5];
    change({ met: state.met.slice(0, i) + next + state.met.slice(i + 1) });
  });

  // ---- the address, other tabs, and what else changes around ----

  addEventListener("hashchange", () => {
    if (!location.hash.startsWith("#walk") || location.hash === hashWritten) return;
    play(false), endTour(), state = stateNamed(), showAll(), followAddress();
  });
  section.addEventListener("shown", showAll);
  section.addEventListener("hidden", () => {
    play(false), endTour(), clearTimeout(hashTimer);
  });
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", showAll);
  new ResizeObserver(() => section.offsetParent !== null && drawView()).observe(view);
  new ResizeObserver(() => section.offsetParent !== null && (showEvent(), drawFigure())).observe(section);
  document.addEventListener("fullscreenchange", () => { find(".walk-caption").hidden = !document.fullscreenElement && !tour; });
  addresses.walk = () => hashOf(state);
  const comes = !named(); // before the address is written
  showAll(), followAddress();
  if (comes && !matchMedia("(prefers-reduced-motion: reduce)").matches) beginTour();
}

// page.js says when the section is shown, and has the compiled module; this is an instance of its own.
async function start() {
  try {
    const load = (src) => new Promise((good, bad) => {
      document.head.append(Object.assign(document.createElement("script"), { src, onload: good, onerror: bad }));
    });
    const [code] = await Promise.all([moduleCode(), load("pktrt.js"), load("open.js")]);
    walk_start(section, await pktrt({
      instantiateWasm(imports, done) {
        WebAssembly.instantiate(code, imports).then(done);
        return {};
      },
    }));
  } catch (error) {
    const why = error.message || "pktrt.js did not load";
    section.querySelector(".walk-sentence").textContent = `This cannot be shown: ${why}.`;
  }
}

const section = byId("walk");
section.addEventListener("shown", start, { once: true });
