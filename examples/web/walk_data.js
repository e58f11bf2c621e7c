// walk_data.js - what the tab "The packet's walk" knows without a page: events, states, sentences. Node reads it as well.
//
// A state is what one can link to: #walk?packet=shadow&size=16&steps=2007&event=40. Its names are those of WALK_DEFAULTS,
// and what is not named is as there. steps: "all", "2007", "none", or names of STEPS with + between them. event: counted
// from 1 on there, as on the page. Whoever names an assembly, or what rays meet, and no event is led to figure 3. In a scene
// of the first tab, pixels are those of a picture of that size, seen from an eye towards a target, at a time.

// What the words of walk.c are: u a number, f a float, a digit before it how many.
const KINDS = {
  box: "node:u child:u index:u triangles:u lo:3f hi:3f",
  corners: "at:9f",
  corner: "lane:u at:9f",
  point: "shade:u t:f direction:3f",
  ray: "origin:3f direction:3f tmax:f t:f x:u y:u hits:u",
  event: "kind:u index:u child:u ray:u active:u tested:u tree:u packet:u depth:u nodes:u boxes:u boxVectors:u " +
    "triangles:u triangleVectors:u triangle:u t:f",
  member: "packet:u type:u ray:u",
};
const EVENTS = ["NODE", "FIRST_HIT", "INTERVAL_CULL", "FRUSTUM_CULL", "LATER_HIT", "ALL_MISS", "LEAF", "HIT",
  "NONE_LEFT", "TRIM", "LEAF_TEST", "END"];
export const E = Object.fromEntries(EVENTS.map((name, i) => [name, i]));
// Verdicts on a child: the variable that has its colour, how its outline is dashed, and what it says.
export const VERDICTS = {
  [E.FIRST_HIT]: { colour: "--walk-first", dash: [], text: "entered: the first active ray hits" },
  [E.LATER_HIT]: { colour: "--walk-later", dash: [], text: "entered: a later ray hits" },
  [E.INTERVAL_CULL]: { colour: "--walk-interval", dash: [7, 3], text: "dropped by intervals" },
  [E.FRUSTUM_CULL]: { colour: "--walk-frustum", dash: [2, 3], text: "dropped by planes" },
  [E.ALL_MISS]: { colour: "--walk-miss", dash: [9, 3, 2, 3], text: "dropped: all rays miss" },
  [E.NONE_LEFT]: { colour: "--walk-none", dash: [1, 5], text: "dropped: no ray is left" },
};
const STEPS = { group: 1, intervals: 2, frustum: 4, trim: 8, leafboxes: 16, order: 32 };
export const PRESETS = { all: 63, 2007: 35, none: 64 };
const ASSEMBLIES = { types: 0, runs: 1, groups: 2, octants: 3, blind: 4, none: 5 };
export const TYPES = ["primary", "shadow", "reflection", "refraction", "all types"];
const NONE = 0xffffffff;
const MOST_CHOSEN_FROM = 320; // pixels across the picture to choose from

export const WALK_DEFAULTS = { scene: "course", packet: "camera", size: 8, x: 96, y: 32, spacing: 1, order: "rows",
  steps: 63, view: "yz", follow: 0, event: 0, assembly: "groups", met: "ddddffmmggmmgggg",
  picture: "256x192", eye: "", target: "", time: 0, light: 1 };
export const SHOWN = ["poolhall", "conference", "rtrt", "model"]; // scenes of the first tab
// What belongs to such a scene alone.
export const SHOWN_STATE = ["picture", "eye", "target", "time", "light"];
const CHOICES = { scene: ["course", "boxes", ...SHOWN], packet: ["camera", "shadow", "mirror"], size: [1, 2, 4, 8, 16],
  order: ["rows", "morton"], view: ["yz", "xz", "xy", "3d"], assembly: Object.keys(ASSEMBLIES) };

// ---- what walk.c gives ----

const number = new Uint32Array(1), float = new Float32Array(number.buffer); // the same word

// Reads a list of things at a pointer, all of them or some at the end. The view of the memory is looked up each time,
// for growth replaces it.
function readList(module, pointer, kind, most = Infinity) {
  const words = module.HEAPU32, things = [];
  const fields = KINDS[kind].split(" ").map((field) => {
    const [, name, count, type] = /^(\w+):(\d*)([uf])$/.exec(field);
    return { name, count: Number(count), type };
  });
  const size = fields.reduce((sum, field) => sum + (field.count || 1), 0), all = words[pointer >>> 2];
  let at = (pointer >>> 2) + 1 + size * Math.max(all - most, 0);
  const next = (type) => {
    number[0] = words[at++];
    return type === "u" ? number[0] : float[0];
  };
  for (let i = Math.min(all, most); i > 0; i--) {
    const thing = {};
    for (const { name, count, type } of fields)
      thing[name] = count ? Array.from({ length: count }, () => next(type)) : next(type);
    things.push(thing);
  }
  return things;
}

const sceneNumber = (scene) => Math.min(CHOICES.scene.indexOf(scene), 2);

// Makes the packet of a state and traces it: its rays and events.
export function makePacket(module, s) {
  const index = (name) => CHOICES[name].indexOf(s[name]);
  return readList(module,
    module._walk_packet(sceneNumber(s.scene), index("packet"), s.size, s.x, s.y, s.spacing, index("order")), "ray");
}
export const trace = (module, steps) => readList(module, module._walk_trace(steps), "event");
export const traceEnd = (module, steps) => readList(module, module._walk_trace(steps), "event", 1)[0];

// Gives the members of figure 3's packets, for what sixteen rays meet.
export function figure(module, assembly, met) {
  const bits = (from) => [...met.slice(from, from + 8)].reduce((sum, c, i) => sum + "dfmg.".indexOf(c) * 8 ** i, 0);
  return readList(module, module._walk_figure(ASSEMBLIES[assembly], bits(0), bits(8)), "member");
}

// Writes a thing as walk_events.c does, word by word.
export function words(thing, kind) {
  return KINDS[kind].split(" ").map((field) => {
    const [name, type] = field.split(":");
    return [thing[name]].flat().map((value) => {
      if (type.endsWith("u")) return value;
      float[0] = value;
      return number[0];
    });
  }).flat().join(" ");
}

// ---- the state and the address ----

export const clamp = (x, lo, hi) => Math.min(Math.max(x, lo), hi);

// Reads steps: "all", "2007", "none", or names with + between them. Without any: 64, as the library has it.
export function stepsOf(text) {
  if (Object.hasOwn(PRESETS, text)) return PRESETS[text];
  return text.split(/[+ ]/).reduce((bits, name) => bits | (Object.hasOwn(STEPS, name) ? STEPS[name] : 0), 0) || PRESETS.none;
}
export function stepsText(bits) {
  const preset = Object.keys(PRESETS).find((name) => PRESETS[name] === bits);
  return preset || Object.keys(STEPS).filter((name) => bits & STEPS[name]).join("+");
}

export const sizeOf = (s) => s.picture.split("x").map(Number);
export const pointOf = (text) => (text === "" ? null : text.split(",").map(Number));
const isPoint = (text) => /^[^,]+,[^,]+,[^,]+$/.test(text) && pointOf(text).every((x) => Number.isFinite(x) && Math.abs(x) < 1e6);

// What is possible, nearest to what is asked for; the packet lies within the picture.
export function tidy(s) {
  for (const [name, choices] of Object.entries(CHOICES)) if (!choices.includes(s[name])) s[name] = WALK_DEFAULTS[name];
  const whole = (name, lo, hi) => s[name] = clamp(Math.floor(Number(s[name])) || 0, lo, hi);
  whole("spacing", 1, 12), whole("event", 0, 1e9), whole("follow", 0, 1);
  if (!/^[1-9][0-9]{2,3}x[1-9][0-9]{2,3}$/.test(s.picture)) s.picture = WALK_DEFAULTS.picture;
  if (!isPoint(s.eye) || !isPoint(s.target) || `${pointOf(s.eye)}` === `${pointOf(s.target)}`) s.eye = s.target = "";
  s.time = clamp(Number(s.time) || 0, 0, 1), s.light = clamp(Number(s.light) || 1, 0.25, 4);
  if (!SHOWN.includes(s.scene)) for (const name of SHOWN_STATE) s[name] = WALK_DEFAULTS[name];
  const [width, height] = sizeOf(s);
  s.spacing = Math.min(s.spacing, Math.floor(Math.min(width, height) / s.size));
  whole("x", 0, width - s.size * s.spacing), whole("y", 0, height - s.size * s.spacing);
  s.met = [...s.met.toLowerCase()].filter((c) => "dfmg.".includes(c)).join("").slice(0, 16).padEnd(16, ".");
  return s;
}
export function stateOf(hash) {
  const s = { ...WALK_DEFAULTS }, given = new URLSearchParams(/^#walk\?(.*)/.exec(hash)?.[1]);
  for (const [name, value] of given)
    if (name === "steps") s.steps = stepsOf(value);
    else if (name === "event") s.event = Number(value) - 1;
    else if (Object.hasOwn(s, name)) s[name] = typeof s[name] === "number" ? Number(value) : value;
  return tidy(s);
}
export const leadsToFigure = (hash) => /^#walk\?(.*&)?(assembly|met)=/.test(hash) && !/[?&]event=/.test(hash);
export function hashOf(s) {
  const value = (name) => name === "steps" ? stepsText(s.steps) : name === "event" ? s.event + 1 : s[name];
  const text = Object.keys(s).filter((name) => s[name] !== WALK_DEFAULTS[name]).map((name) => `${name}=${value(name)}`);
  return text.length ? `#walk?${text.join("&")}` : "#walk";
}

// ---- words ----

export const many = (n, thing) => `${n} ${thing}${n === 1 ? "" : "s"}`;
export const raysText = (first, last) => first === last ? `ray ${first}` : `rays ${first} to ${last}`;

// Says an event in a sentence or two. `world` has the boxes.
export function sentence(e, world, n, shadow) {
  const child = world.childOf(e.index, e.child), last = e.ray + e.active - 1, range = raysText(e.ray, last);
  const leaf = () => `leaf ${child.index} with ${many(child.triangles, "triangle")}`;
  const kind = !child ? "" : child.triangles ? leaf() : `node ${child.index}`;
  const name = `Child ${e.child} of node ${e.index}, ${kind},`;
  const price = `${e.tested ? `${many(e.tested, "ray")} tested` : "No further test"} for that.`;
  switch (e.kind) {
  case E.NODE: {
    const waiting = world.childrenOf(e.index).length;
    return `Node ${e.index}${e.depth ? "" : ", the root,"} is opened for ${range}: ` +
      (waiting === 1 ? "one child waits." : `${waiting} children wait.`);
  }
  case E.FIRST_HIT:
    return `${name} is entered by ${range}: the first active one, ${e.ray}, hits it. ${price}`;
  case E.LATER_HIT:
    return `${name} is entered by ${range}: ${e.ray} is the first to hit it, and the first active one below. ` +
      price;
  case E.INTERVAL_CULL:
    return `${name} is dropped: interval arithmetic shows that ${range} ` +
      `${e.active === 1 ? "misses" : "all miss"} it. ${price}`;
  case E.FRUSTUM_CULL:
    return `${name} is dropped: it lies outside one of the four planes around the rays. ${price}`;
  case E.ALL_MISS: return `${name} is dropped: ${e.active === 1 ? range : `of ${range} each one`} misses it. ${price}`;
  case E.NONE_LEFT: return `${name} is dropped: all its rays have found something in their way.`;
  case E.TRIM:
    return `The range ends at ray ${last}: those behind it miss child ${e.child} of node ${e.index}. ${price}`;
  case E.LEAF: return `Leaf ${e.index} is met by ${range}, with ${many(world.trianglesOf(e.index), "triangle")}.`;
  case E.LEAF_TEST: {
    const group = raysText(e.ray, Math.min(e.ray | 7, n - 1)), meet = e.active === 1 ? "meets" : "meet";
    return `In leaf ${e.index}, of ${group}: ${e.active || "none"} ${meet} the triangles.`;
  }
  case E.HIT:
    return shadow ? `Ray ${e.ray} is done: triangle ${e.triangle} is in its way to the light.`
      : `Ray ${e.ray} hits triangle ${e.triangle} at t = ${e.t.toPrecision(4)}, nearer than anything before.`;
  default:
    return `The walk is over: ${many(e.nodes, "node")} opened, ${many(e.boxes, "test")} of a ray against a box, ` +
      `${e.triangles} against a triangle, for ${many(n, "ray")}.`;
  }
}
// The same in a few words, for the list.
export function brief(e) {
  const of = `child ${e.child} of node ${e.index}`, last = e.ray + e.active - 1;
  if (VERDICTS[e.kind]) return `${of} ${VERDICTS[e.kind].text}${e.kind === E.LATER_HIT ? `, ray ${e.ray}` : ""}`;
  switch (e.kind) {
  case E.NODE: return `node ${e.index} is opened, ${raysText(e.ray, last)}`;
  case E.LEAF: return `leaf ${e.index}, ${raysText(e.ray, last)}`;
  case E.LEAF_TEST: return `group of ray ${e.ray}: ${e.active} meet the triangles`;
  case E.HIT: return `ray ${e.ray} hits triangle ${e.triangle}`;
  case E.TRIM: return `${of}: the range ends at ray ${last}`;
  default: return "the walk is over";
  }
}

// ---- the tree, and what has happened up to an event ----

// Of a scene, with a picture of so many pixels to choose from. One of the first tab has been opened before, and is seen from
// `eye`; boxes are those of `known`, a world of it, if there is one.
export function makeWorld(module, scene, size = [256, 192], eye = null, known = null) {
  const number = sceneNumber(scene), isShown = SHOWN.includes(scene);
  const step = Math.ceil(size[0] / MOST_CHOSEN_FROM), points = readList(module, module._walk_picture(number, step), "point");
  const leaves = new Map();
  const cornersOf = (leaf) => {
    if (!leaves.has(leaf)) leaves.set(leaf, readList(module, module._walk_leaf(number, leaf), "corner"));
    return leaves.get(leaf);
  };
  return {
    ...(known ?? makeBoxes(module, number)),
    isShown, size, eye, cornersOf,
    triangles: isShown ? [] : readList(module, module._walk_triangles(number), "corners").map((t) => t.at),
    picture: { width: Math.floor(size[0] / step), height: Math.floor(size[1] / step), shades: points.map((p) => p.shade) },
    seen: !isShown ? [] : points.filter((p) => p.shade)
      .map(({ shade, t, direction }) => ({ shade, at: eye.map((x, a) => x + t * direction[a]) })),
  };
}

function makeBoxes(module, number) {
  const boxes = readList(module, module._walk_boxes(number), "box");
  const children = new Map(), node = new Map(), leaf = new Map();
  boxes.forEach((b, i) => {
    b.id = i;
    if (!children.has(b.node)) children.set(b.node, []);
    children.get(b.node).push(b);
    (b.triangles ? leaf : node).set(b.index, b);
  });
  const lo = [Infinity, Infinity, Infinity], hi = [-Infinity, -Infinity, -Infinity];
  for (const [index, of] of children) {
    if (node.has(index)) continue;
    const root = { lo: [...of[0].lo], hi: [...of[0].hi], id: -1, node: NONE, index, triangles: 0 };
    for (const b of of)
      for (let a = 0; a < 3; a++) root.lo[a] = Math.min(root.lo[a], b.lo[a]), root.hi[a] = Math.max(root.hi[a], b.hi[a]);
    node.set(index, root);
    for (let a = 0; a < 3; a++) lo[a] = Math.min(lo[a], root.lo[a]), hi[a] = Math.max(hi[a], root.hi[a]);
  }
  return {
    boxes, lo, hi,
    nodeBox: (index) => node.get(index),
    leafBox: (index) => leaf.get(index),
    childrenOf: (index) => children.get(index) || [],
    childOf: (index, place) => (children.get(index) || []).find((b) => b.child === place),
    trianglesOf: (index) => leaf.get(index)?.triangles || 0,
  };
}

// The box that an event is about.
export function boxOf(world, e) {
  if (e.kind === E.END) return null;
  if (e.kind === E.NODE) return world.nodeBox(e.index);
  const inLeaf = [E.LEAF, E.HIT, E.LEAF_TEST].includes(e.kind);
  return inLeaf ? world.leafBox(e.index) : world.childOf(e.index, e.child);
}

// Where a ray is in a box, [near, far], within [0, t]; null: nowhere.
export function within(ray, lo, hi, t) {
  let near = 0, far = t;
  for (let a = 0; a < 3; a++) {
    const x = (lo[a] - ray.origin[a]) / ray.direction[a], y = (hi[a] - ray.origin[a]) / ray.direction[a];
    if (Number.isNaN(x) || Number.isNaN(y)) continue;
    near = Math.max(near, Math.min(x, y)), far = Math.min(far, Math.max(x, y));
  }
  return near <= far ? [near, far] : null;
}

// Replays events up to `at`: verdicts by box, the nodes opened, how far rays still reach, the active range.
export function replay(world, rays, events, at, shadow) {
  const r = { verdicts: new Map(), waiting: new Map(), counts: {}, opened: [], first: 0, last: rays.length - 1,
    t: rays.map((ray) => ray.tmax), done: rays.map(() => false), hit: rays.map(() => false) };
  for (let i = 0; i <= at; i++) {
    const e = events[i];
    if (VERDICTS[e.kind]) {
      const box = world.childOf(e.index, e.child);
      r.verdicts.set(box.id, e.kind), r.waiting.delete(box.id);
      r.counts[e.kind] = (r.counts[e.kind] || 0) + 1;
    }
    if (e.kind === E.NODE) {
      for (const b of world.childrenOf(e.index)) r.waiting.set(b.id, b);
      r.opened.length = e.depth, r.opened.push(e.index);
    } else if (VERDICTS[e.kind] || e.kind === E.TRIM) r.opened.length = e.depth;
    if (e.kind === E.HIT) r.hit[e.ray] = true, r.t[e.ray] = e.t, r.done[e.ray] = shadow;
    else if (e.kind === E.END) r.first = 0, r.last = -1;
    else if (e.kind !== E.LEAF_TEST) r.first = e.ray, r.last = e.ray + e.active - 1;
  }
  const e = events[at], box = boxOf(world, e);
  r.event = e, r.box = box;
  r.inBox = rays.map((ray, i) => box !== null && !r.done[i] && within(ray, box.lo, box.hi, r.t[i]) !== null);
  return r;
}

// ---- projections ----

// A view takes a point to (u, v), v upwards.
export function projection(view, yaw, pitch) {
  if (view === "xy") return (p) => [p[0], p[1]];
  if (view === "xz") return (p) => [p[0], -p[2]];
  if (view === "yz") return (p) => [-p[2], p[1]];
  const ca = Math.cos(yaw), sa = Math.sin(yaw), cp = Math.cos(pitch), sp = Math.sin(pitch);
  return (p) => [p[0] * ca - p[2] * sa, p[1] * cp - (p[0] * sa + p[2] * ca) * sp];
}
export const corner = (b, i) => [i & 1 ? b.hi[0] : b.lo[0], i & 2 ? b.hi[1] : b.lo[1], i & 4 ? b.hi[2] : b.lo[2]];
export const along = (ray, t) => ray.origin.map((o, a) => o + t * ray.direction[a]);
