// Models from files that someone drops on the page: .obj with .mtl, .stl, .ply, .glb and .gltf with .bin.
//
//   readModel([{ name, bytes }, ...], { zUp })   the model of these files, or an Error whose message is one sentence
//   describe(model)                              the sentence that says what it is
//
// Files come from anywhere: no count, offset or index is believed before it has been compared with what is there, so
// work and memory are bounded by the limits below. A model is at most 2 m large, stands on y = 0 around the y axis, and
// is a list of triangles with three corners each: see finish().
export const MOST_BYTES = 100e6; // of all files together
export const MOST_TRIANGLES = 1e6;
const MOST_VERTICES = 3 * MOST_TRIANGLES;
const MOST_MATERIALS = 10000;
const MOST_NODES = 1e6;
const MOST_PARTS = 100000;     // primitives that nodes of a glTF file show
const MOST_LINE = 1e6;         // characters of a line of text
const MOST_HEADER = 100000;    // bytes before the data of a PLY file
const MOST_COORDINATE = 1e30;
const MOST_RADIANCE = 1e6;
const MOST_TEXCOORD = 1e4;     // beyond, single precision has no texels left
const MOST_FACES_SMOOTHED = 64; // around a vertex; where there are more, they are flat
const SIZE = 2;                // of a model
const SMOOTH_COSINE = 0.5;     // normals are smoothed between faces up to 60 degrees apart
const COAT_ROUGHNESS = 0.3;    // what is not metal and smoother gets a coat that reflects
const MOST_IMAGES = 16;
const MOST_PIXELS = 2 ** 26;   // of an image as it is in its file
export const MATERIAL_WORDS = 13;
export const IMAGE_WORD = 11;

export const READABLE = [".obj", ".stl", ".ply", ".glb", ".gltf"];

class Refused extends Error {}
const refuse = (sentence) => { throw new Refused(sentence); };

const counted = (n, word, words = `${word}s`) => `${n.toLocaleString("en")} ${n === 1 ? word : words}`;
const refuseMore = (most, words) => refuse(`it has more than ${counted(most, words, words)}`);
const extension = (name) => /\.[^.]*$/.exec(name.toLowerCase())?.[0] ?? "";
const brief = (word) => (word.length > 40 ? `${word.slice(0, 40)}...` : word);
const whole = (x) => Number.isInteger(x) && x >= 0;
const clamp = (x) => Math.max(0, Math.min(1, x));

// --- triangles ---

// Points of three numbers, as many as come.
class Points {
  constructor() {
    this.values = new Float64Array(3072);
    this.count = 0;
  }

  add(x, y, z) {
    const at = 3 * this.count;
    if (this.count >= MOST_VERTICES) refuseMore(MOST_VERTICES, "vertices");
    if (at === this.values.length) {
      const grown = new Float64Array(2 * at);
      grown.set(this.values);
      this.values = grown;
    }
    this.values[at] = x;
    this.values[at + 1] = y;
    this.values[at + 2] = z;
    this.count++;
  }
}

const usable = (x) => Math.abs(x) <= MOST_COORDINATE; // false for NaN

function checkPoint(where, x, y, z) {
  if (!usable(x) || !usable(y) || !usable(z)) refuse(`${where}: a coordinate is not a number, or too large`);
}

// Triangles with three corners each, so that every corner has a normal of its own. A zero normal is one to be found.
class Triangles {
  constructor() {
    this.count = 0;
    this.resize(1024);
  }

  resize(room) {
    const { points, normals, materials, texcoords } = this;
    this.points = new Float64Array(9 * room);
    this.normals = new Float32Array(9 * room);
    this.materials = new Uint32Array(room);
    if (texcoords) (this.texcoords = new Float32Array(6 * room)).set(texcoords);
    if (!points) return;
    this.points.set(points);
    this.normals.set(normals);
    this.materials.set(materials);
  }

  // Adds a triangle of three points. `which` names their normals, if there are any.
  add(points, corners, normals, which, material) {
    if (this.count >= MOST_TRIANGLES) refuseMore(MOST_TRIANGLES, "triangles");
    if (this.count === this.materials.length) this.resize(2 * this.count);
    for (let k = 0; k < 3; k++)
      for (let a = 0; a < 3; a++) {
        this.points[9 * this.count + 3 * k + a] = points[3 * corners[k] + a];
        if (normals && which[k] >= 0) this.normals[9 * this.count + 3 * k + a] = normals[3 * which[k] + a];
      }
    this.materials[this.count++] = material;
  }

  // Gives the triangle that was added last coordinates in its image: two at each of `which`. Row 0 is at v = 0.
  map(texcoords, which) {
    this.texcoords ??= new Float32Array(6 * this.materials.length);
    for (let k = 0; k < 6; k++) {
      const x = texcoords[2 * which[k >> 1] + k % 2];
      this.texcoords[6 * (this.count - 1) + k] = Math.abs(x) < MOST_TEXCOORD ? x : 0;
    }
  }
}

// Turns z up into y up.
function turnUp(values, count) {
  for (let at = 0; at < 3 * count; at += 3) {
    const y = values[at + 1];
    values[at + 1] = values[at + 2];
    values[at + 2] = -y;
  }
}

// Scales points to the size of a model, and puts them where it stands.
function place(points, count) {
  const lo = [Infinity, Infinity, Infinity], hi = [-Infinity, -Infinity, -Infinity];
  for (let at = 0; at < 3 * count; at++) {
    const a = at % 3;
    lo[a] = Math.min(lo[a], points[at]);
    hi[a] = Math.max(hi[a], points[at]);
  }
  const scale = SIZE / Math.max(...hi.map((x, a) => x - lo[a]));
  if (!(scale < Infinity)) refuse("all its triangles lie in one point");
  const from = [(lo[0] + hi[0]) / 2, lo[1], (lo[2] + hi[2]) / 2], placed = new Float32Array(3 * count);
  for (let at = 0; at < 3 * count; at++) placed[at] = (points[at] - from[at % 3]) * scale + 0; // no -0
  return placed;
}

// Numbers the points that differ: { vertex: of each corner, count }.
function weld(points, corners) {
  const bits = new Uint32Array(points.buffer), vertex = new Uint32Array(corners);
  const room = 2 ** Math.ceil(Math.log2(2 * corners + 2)), table = new Int32Array(room).fill(-1);
  let count = 0;
  for (let i = 0; i < corners; i++) {
    let at = 0;
    for (let a = 0; a < 3; a++) at = Math.imul(at ^ (at >>> 15) ^ bits[3 * i + a], 0x2c1b3c6d);
    at = (at ^ (at >>> 13)) & (room - 1);
    for (;; at = (at + 1) & (room - 1)) {
      const other = table[at];
      if (other < 0) {
        table[at] = i;
        vertex[i] = count++;
        break;
      }
      if (bits[3 * i] === bits[3 * other] && bits[3 * i + 1] === bits[3 * other + 1] &&
        bits[3 * i + 2] === bits[3 * other + 2]) {
        vertex[i] = vertex[other];
        break;
      }
    }
  }
  return { vertex, count };
}

// Makes normals unit, and fills in those that are zero or not finite: the mean of the faces around a corner that are
// turned little from its own, weighted by their area.
function smooth(points, normals, triangles) {
  const missing = new Uint8Array(3 * triangles);
  let any = false;
  for (let i = 0; i < 3 * triangles; i++) {
    const size = Math.hypot(normals[3 * i], normals[3 * i + 1], normals[3 * i + 2]);
    if (size > 1e-20 && size < 1e20) for (let a = 0; a < 3; a++) normals[3 * i + a] /= size;
    else missing[i] = any = 1;
  }
  if (!any) return;

  // Of each face twice the area along its normal, and the normal.
  const areas = new Float64Array(3 * triangles), units = new Float64Array(3 * triangles);
  for (let f = 0; f < triangles; f++) {
    const p = points.subarray(9 * f, 9 * f + 9);
    for (let a = 0; a < 3; a++) {
      const b = (a + 1) % 3, c = (a + 2) % 3;
      areas[3 * f + a] = (p[3 + b] - p[b]) * (p[6 + c] - p[c]) - (p[3 + c] - p[c]) * (p[6 + b] - p[b]);
    }
    const size = Math.hypot(areas[3 * f], areas[3 * f + 1], areas[3 * f + 2]);
    for (let a = 0; a < 3; a++) units[3 * f + a] = size > 0 ? areas[3 * f + a] / size : a === 1 ? 1 : 0;
  }

  const { vertex, count } = weld(points, 3 * triangles);
  const first = new Int32Array(count).fill(-1), next = new Int32Array(3 * triangles), faces = new Uint32Array(count);
  for (let i = 0; i < 3 * triangles; i++) {
    next[i] = first[vertex[i]];
    first[vertex[i]] = i;
    faces[vertex[i]]++;
  }
  for (let i = 0; i < 3 * triangles; i++) {
    if (!missing[i]) continue;
    const own = 3 * Math.floor(i / 3), sum = [0, 0, 0];
    for (let j = faces[vertex[i]] > MOST_FACES_SMOOTHED ? -1 : first[vertex[i]]; j >= 0; j = next[j]) {
      const other = 3 * Math.floor(j / 3);
      const cosine = units[own] * units[other] + units[own + 1] * units[other + 1] + units[own + 2] * units[other + 2];
      if (cosine >= SMOOTH_COSINE) for (let a = 0; a < 3; a++) sum[a] += areas[other + a];
    }
    const size = Math.hypot(...sum);
    for (let a = 0; a < 3; a++) normals[3 * i + a] = size > 0 ? sum[a] / size : units[own + a];
  }
}

// --- materials ---

const GREY = { base: [0.8, 0.8, 0.8], metallic: 0, roughness: 1, emission: [0, 0, 0], image: null };

// Width and height of a PNG or JPEG image, from its first bytes; null if it is another one, or one that is too large.
export function imageSize(bytes) {
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.length);
  let size = null;
  if (bytes.length >= 24 && view.getUint32(0) === 0x89504e47) size = [view.getUint32(16), view.getUint32(20)];
  else if (bytes.length >= 4 && view.getUint16(0) === 0xffd8)
    for (let at = 2; at + 9 <= bytes.length && bytes[at] === 0xff && !size; at += 2 + view.getUint16(at + 2))
      if (bytes[at + 1] >= 0xc0 && bytes[at + 1] <= 0xcf && ![0xc4, 0xc8, 0xcc].includes(bytes[at + 1]))
        size = [view.getUint16(at + 7), view.getUint16(at + 5)];
  return size && size[0] * size[1] > 0 && size[0] * size[1] <= MOST_PIXELS ? size : null;
}

// The place of a material's image among those that are used; -1: none.
function imageNumber({ image }, images, unused) {
  if (!image) return -1;
  const known = images.findIndex((one) => one === image.bytes);
  if (known >= 0) return known;
  if (images.length < MOST_IMAGES && imageSize(image.bytes)) return images.push(image.bytes) - 1;
  unused.add("textures");
  return -1;
}

// What the module is told of a material: albedo, reflectance, radiance, exponent of the Phong lobe (-1: none), index of
// the coat (0: none), number of the image (-1: none), whether there is nothing where the image is transparent.
//
// What is metal reflects its base colour, but for the square of its roughness, by which it stays diffuse. The exponent
// is 1 / (2 roughness^4) - 1/2: about the lobe around the mirror's direction of a microfacet surface with alpha =
// roughness^2.
export function materialWords({ base, metallic, roughness, emission, cutout = false }, image = -1) {
  const mirror = metallic * (1 - roughness * roughness);
  const coat = metallic === 0 && roughness < COAT_ROUGHNESS ? 1.5 : 0;
  const exponent = Math.min(1e6, 0.5 / Math.max(roughness, 0.01) ** 4 - 0.5);
  return [...base.map((x) => x * (1 - mirror)), ...base.map((x) => x * mirror), ...emission,
    (mirror || coat) && roughness > 0.05 ? exponent : -1, coat, image, cutout];
}

// The model as the page and its workers want it: points, normals and, unless they are null, texture coordinates of all
// corners, the material of each triangle and its words, images, and what describe() says. `unused` is what the file has
// and the page leaves out.
function finish(name, triangles, materials, unused, remark, zUp) {
  const count = triangles.count;
  if (count === 0) refuse("it has no triangles");
  const normals = triangles.normals.slice(0, 9 * count);
  if (zUp) {
    turnUp(triangles.points, 3 * count);
    turnUp(normals, 3 * count);
  }
  const points = place(triangles.points, 3 * count);
  smooth(points, normals, count);

  const used = [...new Set(triangles.materials.subarray(0, count))].filter((i) => materials[i] !== GREY).length;
  const words = new Float32Array(MATERIAL_WORDS * materials.length), images = [];
  const texcoords = triangles.texcoords?.slice(0, 6 * count) ?? null;
  materials.forEach((one, i) =>
    words.set(materialWords(one, texcoords ? imageNumber(one, images, unused) : -1), MATERIAL_WORDS * i));
  return { name, count, used, unused, remark, points, normals, texcoords, words, images, zUp,
    materials: triangles.materials.slice(0, count) };
}

export function describe({ name, count, used, unused, remark }) {
  return `${name}: ${counted(count, "triangle")}${used ? `, ${counted(used, "material")}` : ""}` +
    `${unused.size ? `; not used: ${[...unused].join(", ")}` : ""}${remark ? `; ${remark}` : ""}`;
}

function checkMaterials(materials) {
  if (materials.length > MOST_MATERIALS) refuseMore(MOST_MATERIALS, "materials");
}

// --- text ---

// Calls `take` with the words, the number and the text of each line that has any. A "\" at its end joins it with the
// next one, and they count as one.
function eachLine(bytes, take) {
  let text = new TextDecoder().decode(bytes);
  if (text.includes("\\")) text = text.replace(/\\\r?\n/g, " ");
  for (let at = 0, number = 1; at < text.length; number++) {
    const next = text.indexOf("\n", at), end = next < 0 ? text.length : next;
    if (end - at > MOST_LINE) refuse(`line ${number} has more than ${counted(MOST_LINE, "character")}`);
    const line = text.slice(at, end).trim();
    if (line && line[0] !== "#") take(line.split(/\s+/), number, line);
    at = end + 1;
  }
}

const numbersOf = (words, from, count) => Array.from({ length: count }, (_, i) => Number(words[from + i]));

// --- .obj and .mtl ---

// A file that was dropped along, by the name at the end of a path.
const droppedAlong = (others, way) => others.find((one) => one.name === way.split(/[/\\]/).pop());

// Adds what a .mtl file says of materials to `known`: colour, its image, and what shines.
function readMtl(bytes, known, others, unused) {
  let one = null;
  eachLine(bytes, ([key, ...words], number, line) => {
    const colour = () => {
      const values = numbersOf(words, 0, words.length > 1 ? 3 : 1);
      if (!values.every(Number.isFinite)) refuse(`line ${number} of its .mtl file: ${brief(line)} is not a colour`);
      return [0, 1, 2].map((a) => values[a] ?? values[0]);
    };
    if (key === "newmtl") known.set(line.slice(6).trim(), one = { ...GREY, base: [...GREY.base] });
    else if (!one) return;
    else if (key === "Kd") one.base = colour().map(clamp);
    else if (key === "Ke") one.emission = colour().map((x) => Math.max(0, Math.min(MOST_RADIANCE, x)));
    else if (key === "map_Kd" && words[0] && !words[0].startsWith("-") && droppedAlong(others, line.slice(6).trim()))
      one.image = droppedAlong(others, line.slice(6).trim());
    else if (/^(map_|bump|disp|decal|refl)/.test(key)) unused.add("textures");
    else if (key === "Ks" && colour().some((x) => x > 0)) unused.add("highlights");
    else if (key === "d" ? Number(words[0]) < 1 : key === "Tr" && Number(words[0]) > 0) unused.add("transparency");
  });
}

function readObj(file, others, options) {
  const points = new Points(), normals = new Points(), texcoords = [], triangles = new Triangles(), unused = new Set();
  const known = new Map(), materials = [GREY], numbers = new Map(), libraries = new Set();
  let material = 0;
  for (const other of others.filter((one) => extension(one.name) === ".mtl"))
    readMtl(other.bytes, known, others, unused);

  // The place of a vertex or normal that a face names: from 1 on, or backwards from -1 on.
  const placeOf = (word, of, number) => {
    const index = Number(word), at = index < 0 ? of.count + index : index - 1;
    if (!Number.isInteger(index) || !(at >= 0 && at < of.count))
      refuse(`line ${number}: a face names ${of === points ? "vertex" : "normal"} ${brief(word)} of ${of.count}`);
    return at;
  };
  eachLine(file.bytes, (words, number, line) => {
    const key = words[0];
    if (key === "v" || key === "vn") {
      const [x, y, z] = numbersOf(words, 1, 3);
      checkPoint(`line ${number}`, x, y, z);
      (key === "v" ? points : normals).add(x, y, z);
      if (key === "v" && words.length > 6) unused.add("vertex colours");
    } else if (key === "vt") {
      if (texcoords.length < 2 * MOST_VERTICES) texcoords.push(Number(words[1]), 1 - Number(words[2]));
    } else if (key === "f") {
      const corners = [], which = [], mapped = [];
      for (let i = 1; i < words.length; i++) {
        const [v, t, n] = words[i].split("/");
        corners.push(placeOf(v, points, number));
        if (t) mapped.push(t < 0 ? texcoords.length / 2 + Number(t) : t - 1);
        which.push(n ? placeOf(n, normals, number) : -1);
      }
      if (corners.length < 3) unused.add("points and lines");
      for (let i = 2; i < corners.length; i++) {
        const three = [0, i - 1, i];
        triangles.add(points.values, three.map((k) => corners[k]), normals.values, three.map((k) => which[k]), material);
        if (mapped.length === corners.length && materials[material].image)
          triangles.map(texcoords, three.map((k) => mapped[k]));
      }
    } else if (key === "usemtl") {
      const name = line.slice(6).trim();
      if (!numbers.has(name)) {
        checkMaterials(materials);
        numbers.set(name, known.has(name) ? materials.push(known.get(name)) - 1 : 0);
      }
      material = numbers.get(name);
    } else if (key === "mtllib") libraries.add(line.slice(6).trim());
    else if (key === "l" || key === "p") unused.add("points and lines");
    else if (/^(curv|surf|cstype|parm|bmat)/.test(key)) unused.add("curves and surfaces");
  });
  const without = [...numbers.values()].some((at) => at === 0) && [...libraries].length > 0;
  const missing = brief([...libraries].join(", "));
  const remark = without ? `grey, for want of its materials: drop ${missing} along with it` : "";
  return finish(file.name, triangles, materials, unused, remark, options.zUp ?? false);
}

// --- .stl ---

function readStl(file, others, options) {
  const { bytes } = file, view = new DataView(bytes.buffer, bytes.byteOffset, bytes.length);
  const text = new TextDecoder().decode(bytes.subarray(0, 80)).trimStart().startsWith("solid");
  const announced = bytes.length >= 84 ? view.getUint32(80, true) : 0, triangles = new Triangles();
  if (!text || bytes.length === 84 + 50 * announced) readBinaryStl(view, announced, triangles);
  else readTextStl(bytes, triangles);
  return finish(file.name, triangles, [GREY], new Set(), "", options.zUp ?? true); // as machines that print have it
}

function readBinaryStl(view, announced, triangles) {
  if (view.byteLength < 84) refuse("it is too short for an .stl file");
  if (view.byteLength < 84 + 50 * announced)
    refuse(`it announces ${counted(announced, "triangle")}, which take ${counted(84 + 50 * announced, "byte")}, but ` +
      `has ${counted(view.byteLength, "byte")}`);
  const corner = new Float64Array(9);
  for (let i = 0; i < announced; i++) {
    for (let k = 0; k < 9; k++) corner[k] = view.getFloat32(84 + 50 * i + 12 + 4 * k, true);
    for (let k = 0; k < 9; k += 3) checkPoint(`triangle ${i}`, corner[k], corner[k + 1], corner[k + 2]);
    triangles.add(corner, [0, 1, 2], null, null, 0);
  }
}

function readTextStl(bytes, triangles) {
  const corner = new Float64Array(9);
  let corners = 0, inside = false, ended = false;
  eachLine(bytes, (words, number) => {
    const key = words[0].toLowerCase();
    if (key === "outer") {
      if (inside) refuse(`line ${number}: a facet begins within another`);
      inside = true;
      corners = 0;
    } else if (key === "vertex") {
      const [x, y, z] = numbersOf(words, 1, 3);
      checkPoint(`line ${number}`, x, y, z);
      if (!inside || corners === 3) refuse(`line ${number}: a facet has three vertices, here is another`);
      corner.set([x, y, z], 3 * corners++);
    } else if (key === "endloop") {
      if (!inside || corners !== 3) refuse(`line ${number}: a facet ends after ${corners} of its three vertices`);
      triangles.add(corner, [0, 1, 2], null, null, 0);
      inside = false;
    } else if (key === "endsolid") ended = true;
  });
  if (!ended || inside) refuse("it ends before its endsolid");
}

// --- .ply ---

const PLY_TYPES = { // size, and how a DataView reads it
  char: [1, "getInt8"], int8: [1, "getInt8"], uchar: [1, "getUint8"], uint8: [1, "getUint8"],
  short: [2, "getInt16"], int16: [2, "getInt16"], ushort: [2, "getUint16"], uint16: [2, "getUint16"],
  int: [4, "getInt32"], int32: [4, "getInt32"], uint: [4, "getUint32"], uint32: [4, "getUint32"],
  float: [4, "getFloat32"], float32: [4, "getFloat32"], double: [8, "getFloat64"], float64: [8, "getFloat64"],
};

// { format, elements: [{ name, count, properties: [{ name, type, list: type of its length or null }] }], data: where }
function readPlyHeader(bytes) {
  const text = new TextDecoder("latin1").decode(bytes.subarray(0, MOST_HEADER));
  const end = /\nend_header[ \t\r]*\n/.exec(text);
  if (!/^ply\s/.test(text)) refuse("it does not begin as a .ply file");
  if (!end) refuse("its header has no end");
  const header = { format: "", elements: [], data: end.index + end[0].length };
  const typeOf = (word) =>
    (Object.hasOwn(PLY_TYPES, word) ? PLY_TYPES[word] : refuse(`it has a property of type ${brief(word)}`));
  for (const line of text.slice(0, end.index).split("\n")) {
    const words = line.trim().split(/\s+/), last = header.elements[header.elements.length - 1];
    if (words[0] === "format") header.format = words[1];
    else if (words[0] === "element") {
      const count = Number(words[2]);
      if (!whole(count)) refuse(`it announces ${brief(words[2] ?? "")} of ${brief(words[1] ?? "")}`);
      header.elements.push({ name: words[1], count, properties: [] });
    } else if (words[0] === "property") {
      if (!last || words.length < 3) refuse("it has a property that belongs to nothing");
      const list = words[1] === "list" ? typeOf(words[2]) : null;
      last.properties.push({ name: words[list ? 4 : 2], list, type: typeOf(words[list ? 3 : 1]) });
    }
  }
  return header;
}

// A function that reads the next value, given its type. Less than what is asked for is an error.
function plyReader(format, bytes, data) {
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.length), little = format === "binary_little_endian";
  let at = data;
  if (format !== "ascii")
    return ([size, get]) => {
      if (at + size > bytes.length) refuse("it ends before its data do");
      at += size;
      return view[get](at - size, little);
    };
  return () => {
    while (at < bytes.length && bytes[at] <= 32) at++;
    const from = at;
    while (at < bytes.length && bytes[at] > 32) at++;
    if (from === at) refuse("it ends before its data do");
    return at - from > 64 ? NaN : Number(String.fromCharCode(...bytes.subarray(from, at)));
  };
}

function readPly(file, others, options) {
  const { format, elements, data } = readPlyHeader(file.bytes), unused = new Set(), triangles = new Triangles();
  if (!/^(ascii|binary_(little|big)_endian)$/.test(format)) refuse(`it has the format "${brief(String(format))}"`);
  const next = plyReader(format, file.bytes, data);
  let points = new Float64Array(0), normals = null, vertices = 0, faces = 0;

  function readVertex(properties, i) {
    for (const { name, type, place: at } of properties) {
      const value = next(type);
      if (at >= 3) normals[3 * i + at - 3] = value;
      else if (at >= 0) points[3 * i + at] = value;
      else if (/^(red|green|blue|diffuse_)/.test(name)) unused.add("vertex colours");
      else if (/^(s|t|u|v|texture_.)$/.test(name)) unused.add("textures");
    }
    checkPoint(`vertex ${i}`, points[3 * i], points[3 * i + 1], points[3 * i + 2]);
  }
  // Reads a list, of which triangles are made if it is one of vertices.
  function readList({ list, type, polygon }, i) {
    const size = next(list), corners = [0, 0, 0];
    if (!whole(size)) refuse(`face ${i} has ${size} corners`);
    for (let k = 0; k < size; k++) {
      const index = next(type);
      if (!polygon) continue;
      if (!whole(index) || index >= vertices) refuse(`face ${i} names vertex ${index} of ${vertices}`);
      if (k > 2) corners[1] = corners[2];
      corners[Math.min(k, 2)] = index;
      if (k >= 2) triangles.add(points, corners, normals, corners, 0);
    }
  }

  for (const { name, count, properties } of elements) {
    if (count === 0 || properties.length === 0) continue;
    // What each takes at least: a character and a space, or the bytes of its types, of lists their lengths.
    const least = properties.reduce((sum, { list, type }) => sum + (format === "ascii" ? 2 : (list ?? type)[0]), 0);
    if (count * least > file.bytes.length - data + 1)
      refuse(`it announces ${counted(count, "element")} ${brief(name)}, but has ${file.bytes.length} bytes`);
    if (name === "vertex") {
      if (count > MOST_VERTICES) refuseMore(MOST_VERTICES, "vertices");
      const names = properties.map((one) => one.name);
      properties.forEach((one) => { one.place = one.list ? -1 : ["x", "y", "z", "nx", "ny", "nz"].indexOf(one.name); });
      if (!["x", "y", "z"].every((one) => names.includes(one))) refuse("its vertices have no x, y and z");
      points = new Float64Array(3 * count);
      if (names.includes("nx")) normals = new Float64Array(3 * count);
      if (!normals) properties.forEach((one) => { if (one.place >= 3) one.place = -1; });
      if (properties.some((one) => one.list)) refuse("its vertices have lists");
      vertices = count;
      for (let i = 0; i < count; i++) readVertex(properties, i);
      continue;
    }
    if (name === "face") faces = count;
    else unused.add(`elements ${brief(name)}`);
    for (const one of properties) one.polygon = name === "face" && /^vertex_ind(ex|ices)$/.test(one.name);
    for (let i = 0; i < count; i++)
      for (const one of properties)
        if (one.list) readList(one, i);
        else next(one.type);
  }
  if (!faces) refuse("it has no faces");
  return finish(file.name, triangles, [GREY], unused, "", options.zUp ?? false);
}

// --- .glb and .gltf ---

const COMPONENTS = { // size, how a DataView reads it, and what 1 is where it is normalized
  5120: [1, "getInt8", 127], 5121: [1, "getUint8", 255], 5122: [2, "getInt16", 32767], 5123: [2, "getUint16", 65535],
  5125: [4, "getUint32", 4294967295], 5126: [4, "getFloat32", 1],
};
const SCALARS = { SCALAR: 1, VEC2: 2, VEC3: 3, VEC4: 4 };
// What a file may require and the page can do without.
const HARMLESS = /^(KHR_(mesh_quantization|texture_.*|lights_punctual|materials_.*)|EXT_texture_webp)$/;

const named = (list, index, what) =>
  (whole(index) && Array.isArray(list) && list[index] !== null && typeof list[index] === "object" ? list[index]
    : refuse(`it names ${what} ${brief(String(index))}, which it does not have`));
const numberOr = (x, other) =>
  (x === undefined ? other : Number.isFinite(x) ? x : refuse("it has a factor that is no number"));
const numbersOr = (list, other) => (list === undefined ? other
  : Array.isArray(list) && list.length >= other.length ? other.map((x, i) => numberOr(list[i], x))
    : refuse(`it has ${brief(JSON.stringify(list) ?? "")} where ${other.length} numbers should be`));

// The JSON text and, of a .glb file, the binary part.
function glbParts({ bytes }) {
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.length);
  if (bytes.length < 20 || view.getUint32(0, true) !== 0x46546c67) refuse("it does not begin as a .glb file");
  if (view.getUint32(4, true) !== 2) refuse(`it is of version ${view.getUint32(4, true)}, not 2`);
  const announced = view.getUint32(8, true);
  if (announced > bytes.length) refuse(`it announces ${counted(announced, "byte")}, but has ${bytes.length}`);
  const parts = {};
  for (let at = 12; at + 8 <= bytes.length;) {
    const size = view.getUint32(at, true), kind = view.getUint32(at + 4, true);
    if (at + 8 + size > bytes.length) refuse("it ends within one of its parts");
    if (kind === 0x4e4f534a) parts.json ??= bytes.subarray(at + 8, at + 8 + size);
    if (kind === 0x004e4942) parts.binary ??= bytes.subarray(at + 8, at + 8 + size);
    at += 8 + size;
  }
  return parts.json ? parts : refuse("it has no JSON part");
}

// The bytes that an address leads to: embedded, or of a file that was dropped along.
function bytesAt(uri, index, others) {
  if (typeof uri !== "string") refuse(`buffer ${index} has an address that is no text`);
  if (uri.startsWith("data:")) {
    const comma = uri.indexOf(",");
    if (comma < 0 || !/;base64$/i.test(uri.slice(0, comma))) refuse(`buffer ${index} is embedded, but not in base 64`);
    let text = "";
    try {
      text = atob(uri.slice(comma + 1));
    } catch {
      refuse(`buffer ${index} is not in base 64`);
    }
    const bytes = new Uint8Array(text.length);
    for (let i = 0; i < text.length; i++) bytes[i] = text.charCodeAt(i);
    return bytes;
  }
  let name = uri;
  try {
    name = decodeURIComponent(uri);
  } catch { /* it is a name with a % */ }
  return droppedAlong(others, name)?.bytes ?? refuse(`it needs ${brief(name.split(/[/\\]/).pop())}: drop both together`);
}

function parseGltf(text) {
  let gltf = null;
  try {
    gltf = JSON.parse(new TextDecoder().decode(text));
  } catch {
    refuse("its JSON cannot be read");
  }
  if (gltf === null || typeof gltf !== "object") refuse("its JSON is no scene");
  const version = String(gltf.asset?.version);
  if (!/^2(\.|$)/.test(version)) refuse(`it is of version ${brief(version)}, not 2`);
  for (const needed of Array.isArray(gltf.extensionsRequired) ? gltf.extensionsRequired : [])
    if (!HARMLESS.test(needed)) refuse(`it requires ${brief(String(needed))}, which this page does not read`);
  return gltf;
}

// Two functions. accessor(number, size): { count, at(i, k) }, of `size` numbers each, which are read when asked for.
// image(reference to a texture): its { bytes }.
function accessorReader(gltf, binary, others, unused) {
  const buffers = new Map(), known = new Map();
  const bufferOf = (index) => {
    if (!buffers.has(index)) {
      const { uri } = named(gltf.buffers, index, "buffer");
      buffers.set(index, uri !== undefined ? bytesAt(uri, index, others)
        : (index === 0 && binary) || refuse(`it has no data for buffer ${index}`));
    }
    return buffers.get(index);
  };
  function open(index, size) {
    const accessor = named(gltf.accessors, index, "accessor");
    const { componentType, count, type, byteOffset = 0 } = accessor;
    if (!Object.hasOwn(COMPONENTS, componentType) || !Object.hasOwn(SCALARS, type) || SCALARS[type] < size)
      refuse(`accessor ${index} is not of ${counted(size, "number")}`);
    if (accessor.sparse) unused.add("sparse accessors");
    if (accessor.bufferView === undefined) refuse(`accessor ${index} has no data, or sparse ones alone`);
    const view = named(gltf.bufferViews, accessor.bufferView, "bufferView"), bytes = bufferOf(view.buffer);
    const [width, get, one] = COMPONENTS[componentType], item = width * SCALARS[type];
    const first = view.byteOffset ?? 0, room = view.byteLength, stride = view.byteStride ?? item;
    if (![first, room, stride, byteOffset, count].every(whole) || stride < item || first + room > bytes.length ||
        (count > 0 && byteOffset + stride * (count - 1) + item > room))
      refuse(`accessor ${index} goes beyond its buffer`);
    const data = new DataView(bytes.buffer, bytes.byteOffset, bytes.length), from = first + byteOffset;
    const at = (i, k) => data[get](from + stride * i + width * k, true);
    return { count, at: accessor.normalized ? (i, k) => Math.max(-1, at(i, k) / one) : at };
  }
  const accessor = (index, size) => {
    const key = `${index} ${size}`;
    if (!known.has(key)) known.set(key, open(index, size));
    return known.get(key);
  };
  // The bytes of an image; null if they cannot be had.
  const image = ({ index }) => {
    const { source } = named(gltf.textures, index, "texture");
    if (source === undefined) return null;
    if (known.has(`image ${source}`)) return known.get(`image ${source}`);
    const { uri, bufferView } = named(gltf.images, source, "image");
    let bytes = null;
    if (bufferView !== undefined) {
      const { buffer, byteOffset = 0, byteLength } = named(gltf.bufferViews, bufferView, "bufferView");
      const all = bufferOf(buffer);
      if (![byteOffset, byteLength].every(whole) || byteOffset + byteLength > all.length)
        refuse(`image ${source} goes beyond its buffer`);
      bytes = all.subarray(byteOffset, byteOffset + byteLength);
    } else if (typeof uri === "string" && (uri.startsWith("data:") || droppedAlong(others, uri)))
      bytes = bytesAt(uri, source, others);
    known.set(`image ${source}`, bytes && { bytes });
    return known.get(`image ${source}`);
  };
  return { accessor, image };
}

// Matrices as glTF has them: column by column, three rows of four columns.
function matrixOf(node) {
  if (node.matrix !== undefined) {
    const m = numbersOr(node.matrix, new Array(16).fill(0));
    return [0, 1, 2, 3].flatMap((c) => m.slice(4 * c, 4 * c + 3));
  }
  const t = numbersOr(node.translation, [0, 0, 0]), s = numbersOr(node.scale, [1, 1, 1]);
  const [x, y, z, w] = numbersOr(node.rotation, [0, 0, 0, 1]);
  const columns = [
    [1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w)],
    [2 * (x * y - z * w), 1 - 2 * (x * x + z * z), 2 * (y * z + x * w)],
    [2 * (x * z + y * w), 2 * (y * z - x * w), 1 - 2 * (x * x + y * y)]];
  return [...columns.flatMap((column, c) => column.map((value) => value * s[c])), ...t];
}
const turned = (m, x, y, z, a) => m[a] * x + m[3 + a] * y + m[6 + a] * z;
const times = (m, n) => [0, 3, 6, 9].flatMap((c) =>
  [0, 1, 2].map((a) => turned(m, n[c], n[c + 1], n[c + 2], a) + (c === 9 ? m[9 + a] : 0)));
// For normals: a matrix's cofactors, which are its inverse, transposed, times its determinant.
const cofactors = (m) => [0, 3, 6].flatMap((c) => [0, 1, 2].map((a) => {
  const d = (c + 3) % 9, e = (c + 6) % 9, b = (a + 1) % 3, f = (a + 2) % 3;
  return m[d + b] * m[e + f] - m[d + f] * m[e + b];
}));

// What textures would say is taken as it is most often: not metallic, rough, and dark where nothing shines.
function gltfMaterial(from, imageOf, unused) {
  const pbr = from.pbrMetallicRoughness ?? {}, extensions = from.extensions ?? {};
  const strength = numberOr(extensions.KHR_materials_emissive_strength?.emissiveStrength, 1);
  const plain = !pbr.metallicRoughnessTexture, dark = Boolean(from.emissiveTexture);
  const image = pbr.baseColorTexture ? imageOf(pbr.baseColorTexture) : null;
  if (pbr.baseColorTexture && !image) unused.add("textures");
  if (!plain || dark || from.normalTexture || from.occlusionTexture) unused.add("textures of other kinds than colour");
  const cutout = image !== null && /^(BLEND|MASK)$/.test(from.alphaMode); // where it is more than half transparent
  if (from.alphaMode === "BLEND" || extensions.KHR_materials_transmission) unused.add("transparency");
  const place = pbr.baseColorTexture?.extensions?.KHR_texture_transform ?? {};
  return {
    image,
    cutout,
    texCoord: place.texCoord ?? pbr.baseColorTexture?.texCoord ?? 0,
    offset: numbersOr(place.offset, [0, 0]),
    scale: numbersOr(place.scale, [1, 1]),
    rotation: numberOr(place.rotation, 0), // counter-clockwise, as images are seen
    base: numbersOr(pbr.baseColorFactor, [1, 1, 1, 1]).slice(0, 3).map(clamp),
    metallic: plain ? clamp(numberOr(pbr.metallicFactor, 1)) : 0,
    roughness: plain ? clamp(numberOr(pbr.roughnessFactor, 1)) : 1,
    emission: numbersOr(from.emissiveFactor, [0, 0, 0])
      .map((x) => (dark ? 0 : Math.max(0, Math.min(MOST_RADIANCE, x * strength)))),
  };
}

// Adds the triangles of a primitive as a node shows it.
function addPrimitive(primitive, matrix, accessor, number, material, triangles, unused) {
  const mode = primitive.mode ?? 4, attributes = primitive.attributes ?? {};
  if (![4, 5, 6].includes(mode)) {
    unused.add("points and lines");
    return;
  }
  if (primitive.targets) unused.add("morph targets");
  if (attributes.COLOR_0 !== undefined) unused.add("vertex colours");
  if (attributes.POSITION === undefined) refuse("a primitive has no positions");
  const from = accessor(attributes.POSITION, 3);
  const fromNormal = attributes.NORMAL === undefined ? null : accessor(attributes.NORMAL, 3);
  if (fromNormal && fromNormal.count !== from.count)
    refuse(`a primitive has ${fromNormal.count} normals for ${from.count} vertices`);
  const place = material.image ? attributes[`TEXCOORD_${material.texCoord}`] : undefined;
  const fromImage = place === undefined ? null : accessor(place, 2);
  if (fromImage && fromImage.count !== from.count)
    refuse(`a primitive has ${fromImage.count} texture coordinates for ${from.count} vertices`);
  const indices = primitive.indices === undefined ? null : accessor(primitive.indices, 1);
  const corners = indices ? indices.count : from.count;
  const made = mode === 4 ? Math.floor(corners / 3) : Math.max(0, corners - 2);

  const cofactor = cofactors(matrix);
  const mirrored = matrix[0] * cofactor[0] + matrix[1] * cofactor[1] + matrix[2] * cofactor[2] < 0;
  const size = (Math.max(...cofactor.map(Math.abs)) || 1) * (mirrored ? -1 : 1);
  const points = new Float64Array(9), normals = fromNormal && new Float64Array(9), three = [0, 1, 2];
  const texcoords = new Float64Array(6), [cos, sin] = [Math.cos(material.rotation), Math.sin(material.rotation)];
  function readCorner(k, i) {
    const index = indices ? indices.at(i, 0) : i;
    if (!whole(index) || index >= from.count) refuse(`a primitive names vertex ${index} of ${from.count}`);
    const [x, y, z] = three.map((a) => from.at(index, a));
    for (const a of three) points[3 * k + a] = turned(matrix, x, y, z, a) + matrix[9 + a];
    checkPoint(`vertex ${index} of a primitive`, points[3 * k], points[3 * k + 1], points[3 * k + 2]);
    if (fromImage) {
      const [s, t] = material.scale.map((scale, a) => scale * fromImage.at(index, a));
      texcoords[2 * k] = cos * s + sin * t + material.offset[0];
      texcoords[2 * k + 1] = cos * t - sin * s + material.offset[1];
    }
    if (!normals) return;
    const [u, v, w] = three.map((a) => fromNormal.at(index, a));
    for (const a of three) normals[3 * k + a] = turned(cofactor, u, v, w, a) / size;
  }
  for (let i = 0; i < made; i++) {
    const [a, b, c] = cornersOf(mode, i);
    readCorner(0, a);
    readCorner(1, mirrored ? c : b);
    readCorner(2, mirrored ? b : c);
    triangles.add(points, three, normals, three, number);
    if (fromImage) triangles.map(texcoords, three);
  }
}

// Which vertices a triangle has: of a list (4), a strip (5) or a fan (6).
function cornersOf(mode, i) {
  if (mode === 4) return [3 * i, 3 * i + 1, 3 * i + 2];
  if (mode === 6) return [0, i + 1, i + 2];
  return i % 2 ? [i + 1, i, i + 2] : [i, i + 1, i + 2];
}

function readGltf(file, others, options) {
  const { json, binary } = extension(file.name) === ".glb" ? glbParts(file) : { json: file.bytes };
  const gltf = parseGltf(json), unused = new Set();
  const { accessor, image } = accessorReader(gltf, binary, others, unused);
  const triangles = new Triangles(), materials = [GREY], numbers = new Map();
  const listed = (list) => (Array.isArray(list) ? list : []);
  for (const what of ["animations", "skins", "cameras"]) if (listed(gltf[what]).length) unused.add(what);
  if (gltf.extensions?.KHR_lights_punctual) unused.add("lights");

  const materialOf = (index) => {
    if (index === undefined) return 0;
    if (!numbers.has(index)) {
      checkMaterials(materials);
      numbers.set(index, materials.push(gltfMaterial(named(gltf.materials, index, "material"), image, unused)) - 1);
    }
    return numbers.get(index);
  };

  // Nodes are trees: who comes to one for the second time goes in a circle, or would go many ways to it.
  const nodes = listed(gltf.nodes), seen = new Set();
  if (nodes.length > MOST_NODES) refuseMore(MOST_NODES, "nodes");
  const children = new Set(nodes.flatMap((node) => listed(node?.children)));
  const roots = gltf.scenes === undefined ? nodes.map((_, i) => i).filter((i) => !children.has(i))
    : listed(named(gltf.scenes, gltf.scene ?? 0, "scene").nodes);
  const waiting = roots.map((index) => ({ index, above: [1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0] }));
  let parts = 0;
  while (waiting.length) {
    const { index, above } = waiting.pop(), node = named(nodes, index, "node");
    if (seen.has(index)) refuse(`node ${index} is reached twice: its nodes are no tree`);
    seen.add(index);
    const matrix = times(above, matrixOf(node));
    for (const child of listed(node.children)) waiting.push({ index: child, above: matrix });
    if (node.mesh === undefined) continue;
    for (const primitive of listed(named(gltf.meshes, node.mesh, "mesh").primitives)) {
      if (++parts > MOST_PARTS) refuseMore(MOST_PARTS, "parts");
      const number = materialOf(primitive?.material);
      addPrimitive(primitive ?? {}, matrix, accessor, number, materials[number], triangles, unused);
    }
  }
  return finish(file.name, triangles, materials, unused, "", options.zUp ?? false);
}

// --- any of them ---

const READERS = { ".obj": readObj, ".stl": readStl, ".ply": readPly, ".glb": readGltf, ".gltf": readGltf };

// Of files {name, size} the one that is a model; an Error if there is none, or several.
export function modelOf(files) {
  const models = files.filter((one) => READABLE.includes(extension(one.name))), list = READABLE.join(", ");
  if (!models.length) throw new Error(`${brief(files[0]?.name ?? "This")} is no model that this page reads: ${list}`);
  const name = brief(models[0].name);
  if (models.length > 1) throw new Error(`${name} and ${brief(models[1].name)} are two models: drop one of them`);
  const bytes = files.reduce((sum, one) => sum + one.size, 0);
  if (bytes > MOST_BYTES) throw new Error(`${name} is refused: all together, that is more than ${MOST_BYTES / 1e6} MB`);
  return models[0];
}

export function readModel(files, options = {}) {
  const { name } = modelOf(files.map((one) => ({ name: one.name, size: one.bytes.length })));
  const file = files.find((one) => one.name === name);
  try {
    return READERS[extension(name)](file, files.filter((one) => one !== file), options);
  } catch (error) {
    // What nobody has thought of is refused as well.
    const memory = error instanceof RangeError ? "there is not enough memory for it" : "it is not what its name says";
    throw new Error(`${brief(name)} is refused: ${error instanceof Refused ? error.message : memory}`);
  }
}
