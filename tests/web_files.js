// Looks after how the web page reads dropped models: each format by a tiny file made here, files that lie about what they
// hold, and whether the module opens a model, shows all of it, and keeps the scene of before where it cannot.
// node tests/web_files.js out/web [--quick], which leaves out a model of a million triangles
"use strict";
const fs = require("fs");
const path = require("path");

const [folder, quick] = process.argv.slice(2);
let files = null, failures = 0;

function check(good, sentence, told = "") {
  console.log(`${good ? "passed" : "FAILED"}  ${sentence}${told === "" ? "" : `: ${told}`}`);
  if (!good) failures++;
}

// The milliseconds of processor time that this process has taken: what else the machine does says nothing of the code.
function processorTime() {
  const { user, system } = process.cpuUsage();
  return (user + system) / 1000;
}

// --- files ---

const text = (name, ...lines) => ({ name, bytes: new TextEncoder().encode(lines.join("\n") + "\n") });
const binary = (name, ...parts) => ({ name, bytes: new Uint8Array(Buffer.concat(parts.map((part) => Buffer.from(part)))) });
const floats = (values) => Float32Array.from(values).buffer;

// A tetrahedron whose corners stand 1 apart along the axes.
const corners = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], faces = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
const objLines = [...corners.map((p) => `v ${p.join(" ")}`), ...faces.map((f) => `f ${f.map((i) => i + 1).join(" ")}`)];

function binaryStl(triangles, announced = triangles.length, cut = 0) {
  const bytes = Buffer.alloc(84 + 50 * triangles.length - cut), whole = Buffer.alloc(84 + 50 * triangles.length);
  whole.write("solid, as some programs begin a binary one");
  whole.writeUInt32LE(announced, 80);
  triangles.forEach((t, i) => t.flat().forEach((x, k) => whole.writeFloatLE(x, 84 + 50 * i + 12 + 4 * k)));
  whole.copy(bytes);
  return { name: "t.stl", bytes: new Uint8Array(bytes) };
}
const soup = faces.map((f) => f.map((i) => corners[i]));
const textStl = (...more) => text("t.stl", "solid t", ...soup.flatMap((t) => ["facet normal 0 0 0", "outer loop",
  ...t.map((p) => `vertex ${p.join(" ")}`), "endloop", "endfacet"]), ...more);

const plyHeader = (format, vertices, polygons, more = []) => ["ply", `format ${format} 1.0`, "comment of a test", ...more,
  `element vertex ${vertices}`, "property float x", "property float y", "property double z", `element face ${polygons}`,
  "property list uchar int vertex_indices", "end_header"];
const textPly = (vertices = 4, polygons = 4, points = corners, lists = faces) => text("t.ply",
  ...plyHeader("ascii", vertices, polygons), ...points.map((p) => p.join(" ")), ...lists.map((f) => `${f.length} ${f.join(" ")}`));
function binaryPly(little, { vertices = 4, polygons = 4, last = 3, cut = 0, size = 3 } = {}) {
  const data = Buffer.alloc(4 * 16 + 4 * 13), put = (kind, x, at) => data[`write${kind}${little ? "LE" : "BE"}`](x, at);
  corners.forEach(([x, y, z], i) => (put("Float", x, 16 * i), put("Float", y, 16 * i + 4), put("Double", z, 16 * i + 8)));
  faces.forEach((f, i) => {
    data.writeUInt8(i === 3 ? size : 3, 64 + 13 * i);
    f.forEach((v, k) => put("Int32", i === 3 && k === 2 ? last : v, 64 + 13 * i + 1 + 4 * k));
  });
  const header = plyHeader(`binary_${little ? "little" : "big"}_endian`, vertices, polygons).join("\n") + "\n";
  return binary("t.ply", Buffer.from(header), data.subarray(0, data.length - cut));
}

// A glTF file of one triangle, as JSON: positions are floats with a stride of 16, indices bytes, normals normalized bytes.
const gltfBytes = Buffer.concat([floats([0, 0, 0, 9, 1, 0, 0, 9, 0, 1, 0, 9]), Uint8Array.of(0, 1, 2, 0),
  Int8Array.of(0, 0, 127, 0, 0, 0, 127, 0, 0, 0, 127, 0)].map((part) => Buffer.from(part.buffer ?? part)));
function gltf(change = () => {}) {
  const json = {
    asset: { version: "2.0" },
    scene: 0,
    scenes: [{ nodes: [0] }],
    nodes: [{ children: [1], translation: [10, 0, 0] }, { mesh: 0, scale: [2, 1, 1] }],
    meshes: [{ primitives: [{ attributes: { POSITION: 0, NORMAL: 1 }, indices: 2, material: 0 }] }],
    materials: [{ pbrMetallicRoughness: { baseColorFactor: [1, 0.5, 0, 1], metallicFactor: 0, roughnessFactor: 1 },
      emissiveFactor: [0, 0.25, 0] }],
    accessors: [
      { bufferView: 0, componentType: 5126, count: 3, type: "VEC3" },
      { bufferView: 2, componentType: 5120, normalized: true, count: 3, type: "VEC3" },
      { bufferView: 1, componentType: 5121, count: 3, type: "SCALAR" }],
    bufferViews: [{ buffer: 0, byteLength: 48, byteStride: 16 }, { buffer: 0, byteOffset: 48, byteLength: 3 },
      { buffer: 0, byteOffset: 52, byteLength: 12, byteStride: 4 }],
    buffers: [{ byteLength: gltfBytes.length, uri: `data:application/octet-stream;base64,${gltfBytes.toString("base64")}` }],
  };
  change(json);
  return json;
}
const gltfFile = (change) => text("t.gltf", JSON.stringify(gltf(change)));
function glb({ change = () => {}, announced = null, cut = 0, version = 2 } = {}) {
  const json = Buffer.from(JSON.stringify(gltf((it) => {
    delete it.buffers[0].uri;
    change(it);
  })));
  const padded = Buffer.concat([json, Buffer.alloc(-json.length & 3, " ")]);
  const part = (kind, bytes) => Buffer.concat([Buffer.from(Uint32Array.of(bytes.length, kind).buffer), bytes]);
  const parts = Buffer.concat([part(0x4e4f534a, padded), part(0x004e4942, gltfBytes)]);
  const head = Buffer.from(Uint32Array.of(0x46546c67, version, announced ?? 12 + parts.length).buffer);
  const all = Buffer.concat([head, parts]);
  return binary("t.glb", all.subarray(0, all.length - cut));
}

// --- what is read ---

const same = (a, b, slack = 1e-6) => a.length === b.length && [...a].every((x, i) => Math.abs(x - b[i]) <= slack);
const cornersOf = (model) => model.points;

function reads(sentence, given, said, good = () => true) {
  let model = null, error = "";
  try {
    model = files.readModel(Array.isArray(given) ? given : [given]);
  } catch (failed) {
    error = failed.message;
  }
  const told = model ? files.describe(model) : error;
  check(told === said && good(model), sentence, told);
}
function refuses(sentence, given, pattern, slowest = 1000) {
  const began = processorTime();
  let told = "it has been read";
  try {
    files.readModel(Array.isArray(given) ? given : [given]);
  } catch (failed) {
    told = failed.message;
  }
  const took = processorTime() - began;
  check(pattern.test(told) && took < slowest, sentence, `${told}${took < slowest ? "" : `, after ${took.toFixed(0)} ms`}`);
}

function testFormats() {
  // Twice as large, from -1 to 1 and from the ground up.
  const placed = soup.flat().flatMap(([x, y, z]) => [2 * x - 1, 2 * y, 2 * z - 1]);
  const turned = soup.flat().flatMap(([x, y, z]) => [2 * x - 1, 2 * z, 1 - 2 * y]); // z up
  const upright = (model) => same(cornersOf(model), placed) && !model.zUp;

  reads("an .obj file", text("t.obj", "# a comment", ...objLines), "t.obj: 4 triangles", upright);
  reads("one that counts backwards, has texture coordinates, ends of lines of two characters and joined lines",
    text("t.obj", ...objLines.slice(0, 4).map((line) => `${line}\r`), "vt 0 0\r", "f -4/1 -2/1 \\\r", "-3/1\r", "f 1 2 4", "f 1 4 3",
      "f 2 3 4"), "t.obj: 4 triangles", upright);
  reads("a square is two triangles, lines are not used", text("t.obj", "v 0 0 0", "v 1 0 0", "v 1 1 0", "v 0 1 0", "f 1 2 3 4",
    "l 1 2"), "t.obj: 2 triangles; not used: points and lines",
  (model) => same(cornersOf(model), [-1, 0, 0, 1, 0, 0, 1, 2, 0, -1, 0, 0, 1, 2, 0, -1, 2, 0]));
  const two = text("t.obj", "mtllib some.mtl", ...objLines.slice(0, 4), "usemtl red one", "f 1 3 2", "usemtl lamp", "f 1 2 4");
  const mtl = text("some.mtl", "newmtl red one", "Kd 0.5 0.25 2", "map_Kd red.png", "newmtl lamp", "Ke 3 2 1", "d 0.5");
  reads("with its .mtl file", [two, mtl], "t.obj: 2 triangles, 2 materials; not used: textures, transparency",
    ({ words, materials }) => same(materials, [1, 2]) && same(words.slice(13, 16), [0.5, 0.25, 1]) && same(words.slice(32, 35), [3, 2, 1]));
  reads("without it", two, "t.obj: 2 triangles; grey, for want of its materials: drop some.mtl along with it");
  reads("with normals of its own", text("t.obj", ...objLines.slice(0, 4), "vn 0 0 -2", "vn 0 0 0", "f 1//1 3//1 2//2"),
    "t.obj: 1 triangle", ({ normals }) => same(normals, [0, 0, -1, 0, 0, -1, 0, 0, -1]));

  reads("a binary .stl file", binaryStl(soup), "t.stl: 4 triangles", (model) => same(cornersOf(model), turned) && model.zUp);
  reads("a text .stl file", textStl("endsolid t"), "t.stl: 4 triangles", (model) => same(cornersOf(model), turned) && model.zUp);
  check(same(files.readModel([binaryStl(soup)], { zUp: false }).points, placed), "the same, its y axis up");
  reads("a text .ply file", textPly(), "t.ply: 4 triangles", upright);
  reads("a binary .ply file, little endian", binaryPly(true), "t.ply: 4 triangles", upright);
  reads("a binary .ply file, big endian", binaryPly(false), "t.ply: 4 triangles", upright);
  reads("a .ply file with other elements", text("t.ply", ...plyHeader("ascii", 3, 1, ["element sensor 2", "property int id",
    "property list int int seen"]), "7 2 1 1", "8 0", "0 0 0", "1 0 0", "0 1 0", "3 0 1 2"),
  "t.ply: 1 triangle; not used: elements sensor");

  // The triangle lies from x = 10 to 12, of which the model's size makes 2.
  const triangle = (model) => same(cornersOf(model), [-1, 0, 0, 1, 0, 0, -1, 1, 0]) && same(model.normals, [0, 0, 1, 0, 0, 1, 0, 0, 1]) &&
    same(model.words.slice(13), [1, 0.5, 0, 0, 0, 0, 0, 0.25, 0, -1, 0, -1, 0]);
  reads("a .gltf file with data of its own", gltfFile(), "t.gltf: 1 triangle, 1 material", triangle);
  reads("a .glb file", glb(), "t.glb: 1 triangle, 1 material", triangle);
  const apart = gltfFile((it) => { it.buffers[0].uri = "the%20data.bin"; });
  reads("a .gltf file with its .bin", [apart, binary("the data.bin", gltfBytes)], "t.gltf: 1 triangle, 1 material", triangle);
  refuses("without it", apart, /^t\.gltf is refused: it needs the data\.bin: drop both together$/);
  reads("a node that mirrors", gltfFile((it) => { it.nodes[1].scale = [-2, 1, 1]; }), "t.gltf: 1 triangle, 1 material",
    (model) => same(cornersOf(model), [1, 0, 0, 1, 1, 0, -1, 0, 0]) && model.normals[2] === 1);
  reads("a node that turns, by a matrix", gltfFile((it) => {
    it.nodes[1] = { mesh: 0, matrix: [0, 1, 0, 0, -1, 0, 0, 0, 0, 0, 1, 0, 5, 5, 5, 1] };
  }), "t.gltf: 1 triangle, 1 material", (model) => same(cornersOf(model), [1, 0, 0, 1, 2, 0, -1, 0, 0]));
  reads("a node that turns, by a quaternion", gltfFile((it) => {
    it.nodes[1] = { mesh: 0, rotation: [0, 0, Math.SQRT1_2, Math.SQRT1_2] };
  }), "t.gltf: 1 triangle, 1 material", (model) => same(cornersOf(model), [1, 0, 0, 1, 2, 0, -1, 0, 0]));
  reads("a node that is turned, below one that is scaled", gltfFile((it) => {
    it.nodes = [{ children: [1], scale: [2, 1, 1] }, { mesh: 0, rotation: [0, 0, Math.SQRT1_2, Math.SQRT1_2] }];
  }), "t.gltf: 1 triangle, 1 material", (model) => same(cornersOf(model), [1, 0, 0, 1, 1, 0, -1, 0, 0]));
  reads("a strip without indices", gltfFile((it) => {
    it.meshes[0].primitives = [{ attributes: { POSITION: 0 }, mode: 5 }, { attributes: { POSITION: 0 }, mode: 0 }];
  }), "t.gltf: 1 triangle; not used: points and lines");
  reads("what is not used is said", gltfFile((it) => {
    it.animations = [{}];
    it.materials[0].normalTexture = { index: 0 };
    it.materials[0].alphaMode = "BLEND";
  }), "t.gltf: 1 triangle, 1 material; not used: animations, textures of other kinds than colour, transparency");
  const metal = files.materialWords({ base: [1, 0.5, 0], metallic: 1, roughness: 0.5, emission: [0, 0, 0] });
  check(same(metal, [0.25, 0.125, 0, 0.75, 0.375, 0, 0, 0, 0, 7.5, 0, -1, 0]), "metal reflects its colour", metal.join(" "));
  check(files.materialWords({ base: [1, 1, 1], metallic: 0, roughness: 0.1, emission: [0, 0, 0] })[10] === 1.5,
    "what is smooth and not metal has a coat");
}

// The first bytes of images: of a PNG, and of a JPEG with a segment before the one that says how large it is.
function png(width, height) {
  const bytes = Buffer.alloc(24);
  bytes.writeUInt32BE(0x89504e47);
  bytes.writeUInt32BE(width, 16);
  bytes.writeUInt32BE(height, 20);
  return bytes;
}
const jpeg = (width, height) => Buffer.from([0xff, 0xd8, 0xff, 0xe0, 0, 4, 1, 2, 0xff, 0xc2, 0, 17, 8, height >> 8, height & 255, width >> 8,
  width & 255, 3]);

function testImages() {
  check(same(files.imageSize(png(300, 7)), [300, 7]), "the size of a PNG image");
  check(same(files.imageSize(jpeg(300, 7)), [300, 7]), "the size of a JPEG image");
  for (const [what, bytes] of [["one that is too large", png(8193, 8192)], ["one without pixels", jpeg(0, 9)], ["one that ends early", png(9, 9).subarray(0, 23)],
    ["a JPEG that ends early", jpeg(9, 9).subarray(0, 16)], ["one of another kind", Buffer.from("RIFF....WEBPVP8 ............")],
    ["a JPEG with tables alone", Buffer.from([0xff, 0xd8, 0xff, 0xc4, 0, 17, 8, 0, 9, 0, 9, 3])], ["a JPEG of nothing but lengths of 0", Buffer.from([0xff, 0xd8, ...new Array(1000).fill([0xff, 0xe0, 0, 0]).flat()])]])
    check(files.imageSize(bytes) === null, `${what} is not used`);

  const lines = [...objLines.slice(0, 4), "vt 0.25 0.75", "vt 1 0", "vt 1e9 x", "usemtl a", "f 1/1 3/-2 2/3", "usemtl b", "f 1/1 2/2 4/2"];
  const mtl = text("a.mtl", "newmtl a", "Kd 1 1 1", "map_Kd some\\where/a b.png", "newmtl b", "map_Kd other.png");
  const image = binary("a b.png", png(2, 2));
  reads("an .obj file with an image", [text("t.obj", ...lines), mtl, image], "t.obj: 2 triangles, 2 materials; not used: textures",
    ({ images, words, texcoords }) => images.length === 1 && words[24] === 0 && words[37] === -1 &&
      same(texcoords, [0.25, 0.25, 1, 1, 0, 0, 0, 0, 0, 0, 0, 0]));
  reads("without it", [text("t.obj", ...lines), mtl], "t.obj: 2 triangles, 2 materials; not used: textures", (model) => !model.texcoords);
  const mapped = (change = () => {}) => gltfFile((it) => {
    const bytes = Buffer.concat([gltfBytes, Buffer.from(Uint8Array.of(0, 0, 255, 0, 0, 51)), png(2, 2)]);
    it.buffers[0] = { byteLength: bytes.length, uri: `data:;base64,${bytes.toString("base64")}` };
    it.bufferViews.push({ buffer: 0, byteOffset: gltfBytes.length, byteLength: 6 }, { buffer: 0, byteOffset: gltfBytes.length + 6, byteLength: 24 });
    it.accessors.push({ bufferView: 3, componentType: 5121, normalized: true, count: 3, type: "VEC2" });
    it.images = [{ bufferView: 4, mimeType: "image/png" }];
    it.textures = [{ source: 0 }];
    it.materials[0].pbrMetallicRoughness.baseColorTexture = { index: 0, texCoord: 1 };
    it.meshes[0].primitives[0].attributes.TEXCOORD_1 = 3;
    change(it);
  });
  reads("a .gltf file with an image", mapped(), "t.gltf: 1 triangle, 1 material", ({ images, words, texcoords }) =>
    images.length === 1 && same(files.imageSize(images[0]), [2, 2]) && words[24] === 0 && words[25] === 0 && same(texcoords, [0, 0, 1, 0, 0, 0.2]));
  for (const [what, change] of [["in a file that is not there", (it) => { it.images = [{ uri: "a.png" }]; }], ["of an unknown kind", (it) => { it.bufferViews[4].byteOffset = 0; }]])
    reads(`an image ${what} is not used`, mapped(change), "t.gltf: 1 triangle, 1 material; not used: textures", ({ words }) => words[24] === -1);
  reads("an image that is scaled, turned and moved", mapped((it) => {
    it.materials[0].pbrMetallicRoughness.baseColorTexture.extensions = { KHR_texture_transform: { scale: [2, 1], offset: [0.5, 0],
      rotation: Math.PI / 2 } };
  }), "t.gltf: 1 triangle, 1 material", ({ texcoords }) => same(texcoords, [0.5, 0, 0.5, -2, 0.7, 0]));
  reads("two materials with one image", mapped((it) => {
    it.materials.push({ pbrMetallicRoughness: { baseColorTexture: { index: 0 } } });
    it.meshes[0].primitives.push({ ...it.meshes[0].primitives[0], material: 1 });
  }), "t.gltf: 2 triangles, 2 materials", ({ images, words }) => images.length === 1 && words[files.IMAGE_WORD + 13] === 0 && words[37] === 0);
  reads("an image with holes", mapped((it) => { it.materials[0].alphaMode = "MASK"; }), "t.gltf: 1 triangle, 1 material",
    ({ words }) => words[25] === 1);
  for (const [what, change, pattern] of [["a texture that is not there", (it) => { it.textures = []; }, /it names texture 0/],
    ["an image that is not there", (it) => { it.images = []; }, /it names image 0/],
    ["an image beyond its buffer", (it) => { it.bufferViews[4].byteLength = 25; }, /image 0 goes beyond its buffer/],
    ["texture coordinates beyond theirs", (it) => { it.accessors[3].count = 4; }, /accessor 3 goes beyond/],
    ["fewer texture coordinates than vertices", (it) => { it.accessors[3].count = 2; }, /a primitive has 2 texture coordinates for 3 vertices/]])
    refuses(what, mapped(change), pattern);
}

function testNormals() {
  const bent = (degrees) => {
    const [x, z] = [Math.cos(degrees * Math.PI / 180), Math.sin(degrees * Math.PI / 180)];
    return files.readModel([text("t.obj", "v 0 0 0", "v 0 1 0", "v -1 0 0", `v ${x} 0 ${z}`, "f 1 2 3", "f 1 4 2")]).normals;
  };
  const cosine = (n) => n[0] * n[18 - 9] + n[1] * n[19 - 9] + n[2] * n[20 - 9]; // of the corners at vertex 1
  check(cosine(bent(50)) > 0.999999, "an edge of 50 degrees is smoothed", cosine(bent(50)).toFixed(6));
  check(Math.abs(cosine(bent(70)) - Math.cos(70 * Math.PI / 180)) < 1e-3, "one of 70 degrees is not", cosine(bent(70)).toFixed(4));
}

// --- what is refused ---

function testHostile() {
  const obj = (...lines) => text("t.obj", ...objLines.slice(0, 4), ...lines);
  refuses("a vertex that is not there", obj("f 1 2 5"), /line 5: a face names vertex 5 of 4/);
  refuses("vertex 0", obj("f 0 1 2"), /line 5: a face names vertex 0 of 4/);
  refuses("too far back", obj("f -5 1 2"), /line 5: a face names vertex -5 of 4/);
  refuses("a vertex between two", obj("f 1.5 1 2"), /line 5: a face names vertex 1\.5/);
  refuses("a normal that is not there", obj("f 1//1 2//1 3//1"), /line 5: a face names normal 1 of 0/);
  refuses("a coordinate that is NaN", obj("v nan 0 0", "f 1 2 3"), /line 5: a coordinate is not a number/);
  refuses("one that is infinite", obj("v 1e999 0 0", "f 1 2 3"), /line 5: a coordinate is not a number, or too large/);
  refuses("one that is missing", obj("v 1 0", "f 1 2 3"), /line 5: a coordinate is not a number/);
  refuses("no triangle", obj(), /it has no triangles/);
  refuses("triangles in one point", text("t.obj", "v 1 1 1", "f 1 1 1"), /all its triangles lie in one point/);
  refuses("an empty file", { name: "t.obj", bytes: new Uint8Array(0) }, /it has no triangles/);
  refuses("a line without end", text("t.obj", "v 0 0 0", `f${" 1".repeat(600000)}`), /line 2 has more than 1,000,000 characters/);
  refuses("lines joined without end", { name: "t.obj", bytes: Buffer.alloc(4e6, "\\\n") }, /more than 1,000,000 characters/);
  refuses("faces beyond the limit", obj(...new Array(11).fill(`f${" 1".repeat(100000)}`)), /it has more than 1,000,000 triangles/, 5000);
  const many = Array.from({ length: 10001 }, (_, i) => `${i}`);
  refuses("more materials than may be", [obj(...many.flatMap((i) => [`usemtl ${i}`, "f 1 2 3"])),
    text("a.mtl", ...many.flatMap((i) => [`newmtl ${i}`, "Kd 1 0 0"]))], /it has more than 10,000 materials/, 5000);
  const began = processorTime(), around = many.map((i) => `v ${Math.cos(i / 1000)} ${Math.sin(i / 1000)} 0`);
  const fan = many.slice(2).map((i) => `f 1 ${i} ${+i + 1}\n`.repeat(15));
  files.readModel([text("t.obj", "v 0 0 0", around.join("\n"), fan.join(""))]);
  check(processorTime() - began < 20000, "150,000 triangles around a vertex are read in bounded time",
    `${(processorTime() - began).toFixed(0)} ms`);
  refuses("a colour that is NaN", [obj("f 1 2 3"), text("a.mtl", "newmtl a", "Kd x")], /line 2 of its \.mtl file: Kd x is not a colour/);

  refuses("a binary .stl file that ends early", { ...binaryStl(soup, 4, 20), name: "u.stl" }, /^u\.stl is refused: /);
  refuses("one that announces four billion", { ...binaryStl(soup, 0xffffffff), bytes: binaryStl(soup, 0xffffffff).bytes.fill(0, 0, 80) },
    /it announces 4,294,967,295 triangles, which take 214,748,364,834 bytes, but has 284 bytes/);
  refuses("one that is too short", { name: "t.stl", bytes: new Uint8Array(83) }, /it is too short/);
  const nan = soup.map((t) => t.map((p) => [...p]));
  nan[2][1][0] = NaN;
  refuses("one with a NaN", binaryStl(nan), /triangle 2: a coordinate is not a number/);
  refuses("a text .stl file that ends early", textStl(), /it ends before its endsolid/);
  refuses("a facet of four vertices", text("t.stl", "solid", "outer loop", ...new Array(4).fill("vertex 0 0 0")), /line 6: a facet has three/);
  refuses("a facet of two", text("t.stl", "solid", "outer loop", "vertex 0 0 0", "vertex 0 0 0", "endloop"), /line 5: a facet ends after 2/);

  refuses("a .ply file that is none", text("t.ply", "plyx"), /it does not begin as a \.ply file/);
  refuses("a header without end", text("t.ply", ...plyHeader("ascii", 4, 4).slice(0, -1)), /its header has no end/);
  refuses("a format of its own", text("t.ply", ...plyHeader("binary_mixed", 4, 4)), /it has the format "binary_mixed"/);
  refuses("a type that is a word of JavaScript", text("t.ply", "ply", "format ascii 1.0", "element vertex 1", "property constructor x",
    "end_header"), /it has a property of type constructor/);
  for (const count of [4000000000, 1e18]) {
    refuses(`${count} vertices announced`, textPly(count), /it announces [0-9,]* elements vertex, but has/);
    refuses(`${count} faces announced, in binary`, binaryPly(true, { polygons: count }), /it announces [0-9,]* elements face, but has/);
  }
  const tiny = ["ply", "format binary_little_endian 1.0", "element vertex 3000001", ...["x", "y", "z"].map((a) => `property char ${a}`), "end_header", ""];
  refuses("more vertices than may be", binary("t.ply", Buffer.from(tiny.join("\n")), Buffer.alloc(9000003)),
    /it has more than 3,000,000 vertices/);
  refuses("-1 vertices", textPly(-1), /it announces -1 of vertex/);
  refuses("vertices of NaN", textPly(4, 4, [["nan", 0, 0], ...corners.slice(1)]), /vertex 0: a coordinate is not a number/);
  refuses("a vertex that is not there", textPly(4, 4, corners, [...faces.slice(1), [0, 1, 4]]), /face 3 names vertex 4 of 4/);
  refuses("in binary", binaryPly(false, { last: -1 }), /face 3 names vertex -1 of 4/);
  refuses("a face longer than the file", binaryPly(true, { size: 255 }), /it ends before its data do/);
  refuses("one of text", textPly(4, 4, corners, [...faces.slice(1), [0, 1, 2]].map((f, i) => (i < 3 ? f : { length: 9, join: () => "0 1 2" }))),
    /it ends before its data do/);
  refuses("a face of half a corner", textPly(4, 4, corners, [...faces.slice(1), { length: 2.5, join: () => "0 1 2" }]), /face 3 has 2\.5 corners/);
  refuses("a binary .ply file that ends early", binaryPly(true, { cut: 1 }), /it ends before its data do/);
  refuses("a cloud of points", textPly(4, 0, corners, []), /it has no faces/);

  const broken = (sentence, change, pattern) => refuses(sentence, gltfFile(change), pattern);
  refuses("JSON that ends early", text("t.gltf", JSON.stringify(gltf()).slice(0, -9)), /its JSON cannot be read/);
  refuses("JSON that is deep", text("t.gltf", "[".repeat(1e6)), /its JSON cannot be read/);
  refuses("JSON that is null", text("t.gltf", "null"), /its JSON is no scene/);
  broken("version 1", (it) => { it.asset.version = "1.0"; }, /it is of version 1\.0, not 2/);
  broken("what the page cannot decode", (it) => { it.extensionsRequired = ["KHR_draco_mesh_compression"]; },
    /it requires KHR_draco_mesh_compression, which this page does not read/);
  broken("a circle of nodes", (it) => { it.nodes[1].children = [0]; }, /node 0 is reached twice/);
  broken("a node below itself", (it) => { it.nodes[1].children = [1]; }, /node 1 is reached twice/);
  broken("a node that is not there", (it) => { it.nodes[1].children = [7]; }, /it names node 7, which it does not have/);
  broken("a circle that nothing leads to", (it) => {
    it.nodes[1].children = [0];
    delete it.scenes;
  }, /it has no triangles/);
  broken("doubling nodes, level by level", (it) => {
    it.nodes = Array.from({ length: 64 }, (_, i) => ({ children: i < 63 ? [i + 1, i + 1] : [], mesh: 0 }));
  }, /is reached twice/);
  const deep = 50000;
  reads("50,000 nodes deep is not too deep", gltfFile((it) => {
    it.nodes = Array.from({ length: deep }, (_, i) => (i < deep - 1 ? { children: [i + 1] } : { mesh: 0 }));
  }), "t.gltf: 1 triangle, 1 material");
  broken("nodes without end", (it) => { it.nodes = new Array(1000001).fill(0); }, /it has more than 1,000,000 nodes/);
  broken("parts without end", (it) => {
    it.meshes[0].primitives = new Array(1001).fill({ attributes: { POSITION: 0 }, mode: 0 });
    it.scenes[0].nodes = Array.from({ length: 100 }, (_, i) => i);
    it.nodes = it.scenes[0].nodes.map(() => ({ mesh: 0 }));
  }, /it has more than 100,000 parts/);
  broken("four billion vertices", (it) => { it.accessors[0].count = 4e9; }, /accessor 0 goes beyond its buffer/);
  broken("four billion indices", (it) => { it.accessors[2].count = 4e9; }, /accessor 2 goes beyond its buffer/);
  broken("a view beyond its buffer", (it) => { it.bufferViews[0].byteOffset = 40; }, /accessor 0 goes beyond its buffer/);
  broken("a view before it", (it) => { it.bufferViews[0].byteOffset = -4; }, /accessor 0 goes beyond its buffer/);
  broken("a stride of nothing", (it) => { it.bufferViews[0].byteStride = 0; }, /accessor 0 goes beyond its buffer/);
  broken("a count between two", (it) => { it.accessors[0].count = 2.5; }, /accessor 0 goes beyond its buffer/);
  broken("a vertex that is not there", (it) => { it.bufferViews[1].byteOffset = 56; }, /a primitive names vertex 127 of 3/);
  broken("a vertex before the first", (it) => {
    const bytes = Buffer.from(gltfBytes);
    bytes.writeInt8(-1, 49);
    it.accessors[2].componentType = 5120;
    it.buffers[0].uri = `data:;base64,${bytes.toString("base64")}`;
  }, /a primitive names vertex -1 of 3/);
  broken("fewer normals than vertices", (it) => { it.accessors[1].count = 2; }, /a primitive has 2 normals for 3 vertices/);
  broken("positions of two numbers", (it) => { it.accessors[0].type = "VEC2"; }, /accessor 0 is not of 3 numbers/);
  broken("components of no kind", (it) => { it.accessors[0].componentType = "constructor"; }, /accessor 0 is not of 3 numbers/);
  broken("sparse positions alone", (it) => {
    delete it.accessors[0].bufferView;
    it.accessors[0].sparse = { count: 1 };
  }, /accessor 0 has no data, or sparse ones alone/);
  broken("no positions", (it) => { it.meshes[0].primitives = [{}, null]; }, /a primitive has no positions/);
  broken("coordinates that are NaN", (it) => {
    const bytes = Buffer.from(gltfBytes);
    bytes.writeFloatLE(NaN, 20);
    it.buffers[0].uri = `data:;base64,${bytes.toString("base64")}`;
  }, /vertex 1 of a primitive: a coordinate is not a number/);
  broken("a matrix that is too large", (it) => { it.nodes[1] = { mesh: 0, matrix: new Array(16).fill(1e300) }; },
    /vertex 0 of a primitive: a coordinate is not a number, or too large/);
  broken("a matrix of words", (it) => { it.nodes[1] = { mesh: 0, matrix: new Array(16).fill("a") }; }, /a factor that is no number/);
  broken("a matrix of two", (it) => { it.nodes[1] = { mesh: 0, matrix: [1, 0] }; }, /it has \[1,0\] where 16 numbers should be/);
  broken("data that are not base 64", (it) => { it.buffers[0].uri = "data:;base64,%%"; }, /buffer 0 is not in base 64/);
  broken("data in another code", (it) => { it.buffers[0].uri = "data:application/octet-stream,abc"; }, /embedded, but not in base 64/);
  broken("data from elsewhere", (it) => { it.buffers[0].uri = "https://elsewhere.invalid/a.bin"; }, /it needs a\.bin: drop both/);
  for (const change of [(it) => { it.nodes = null; }, (it) => { it.meshes = 5; }, (it) => { it.accessors = ["a"]; },
    (it) => { it.materials = [null]; }, (it) => { it.scenes = [null]; }, (it) => { it.buffers = {}; }])
    broken("a part of another kind", change, /^t\.gltf is refused: it names \w+ \d, which it does not have$/);
  refuses("a .glb file that ends early", glb({ cut: 5 }), /it announces \d[0-9,]* bytes, but has \d+/);
  refuses("one that ends within a part", glb({ cut: 5, announced: 20 }), /it ends within one of its parts/);
  refuses("one of version 1", glb({ version: 1 }), /it is of version 1, not 2/);
  refuses("one that is none", text("t.glb", "nothing of the kind, and long enough"), /it does not begin as a \.glb file/);
  refuses("one without data", glb({ change: (it) => it.buffers.unshift({ byteLength: 4, uri: "data:;base64,AAAA" }) }),
    /accessor 0 goes beyond its buffer/);

  refuses("a file of another kind", text("a.txt", "a"), /^a\.txt is no model that this page reads: \.obj, \.stl, \.ply, \.glb, \.gltf$/);
  refuses("no file", [], /^This is no model/);
  refuses("two models", [textPly(), gltfFile()], /^t\.ply and t\.gltf are two models: drop one of them$/);
  refuses("too large a file", { name: "t.ply", bytes: { length: 100e6 + 1 } }, /^t\.ply is refused: .* more than 100 MB$/);

  // Whatever is cut off or changed: a model or a sentence, in bounded time.
  const kinds = [text("t.obj", ...objLines), binaryStl(soup), textStl("endsolid"), textPly(), binaryPly(true), binaryPly(false), glb(), gltfFile()];
  let random = 1, strange = "", slowest = 0, read = 0;
  const next = (n) => (random = (Math.imul(random, 1664525) + 1013904223) >>> 0) % n;
  for (let i = 0; i < 8000; i++) {
    const { name, bytes } = kinds[i % kinds.length], changed = Uint8Array.from(bytes).subarray(0, next(3) ? bytes.length : next(bytes.length));
    for (let k = next(6); k > 0 && changed.length; k--) changed[next(changed.length)] = next(4) ? next(256) : 0xff;
    const began = processorTime();
    try {
      const model = files.readModel([{ name, bytes: changed }]);
      read++;
      if (![model.points, model.normals, model.words, model.texcoords ?? []].every((list) => list.every(Number.isFinite))) strange = `file ${i} has a NaN`;
      if (!model.materials.every((m) => m < model.words.length / files.MATERIAL_WORDS)) strange = `file ${i} has another material`;
    } catch (error) {
      if (!/^t\.\w+ is refused: .*[^ ]$/.test(error.message) || /what its name says|memory/.test(error.message)) strange = error.message;
    }
    slowest = Math.max(slowest, processorTime() - began);
  }
  check(!strange && slowest < 1000 && read > 800 && read < 7200, "8,000 files with bytes changed or cut off",
    strange || `${read} could be read, the slowest in ${slowest.toFixed(0)} ms`);
}

// --- the module ---

async function testModule() {
  const module = await require(path.resolve(folder, "pktrt.js"))({ wasmBinary: fs.readFileSync(`${folder}/pktrt.wasm`) });
  const size = 64, error = () => module.UTF8ToString(module._web_error());
  const put = ({ count, points, normals, words, materials, texcoords }, images = []) => {
    let at = module._web_model_room(count, words.length / files.MATERIAL_WORDS, texcoords !== null) >> 2;
    if (!at) return 1;
    for (const values of [points, normals, words, materials, texcoords ?? []]) {
      (values === materials ? module.HEAPU32 : module.HEAPF32).set(values, at);
      at += values.length;
    }
    for (const { width, height, pixels } of images) module.HEAPU32.set(pixels, module._web_image_room(width, height) >> 2);
    return module._web_open_model(1);
  };
  const render = () => {
    const status = module._web_resize(size, size) || module._web_pose(0.5, 0) || module._web_render_band(0, size, 1, 0);
    const from = module._web_pixels() >> 2;
    return status ? null : module.HEAPF32.slice(from, from + 3 * size * size);
  };
  const sum = () => module.UTF8ToString(module._web_checksum());

  module._web_settings(0, 8, 0, 0);
  check(module._web_open_model(1) !== 0, "without a model there is nothing to open", error());
  module._web_open(0, 1);
  render();
  const before = sum();
  check(module._web_open_model(1) !== 0 && module._web_model_room(4000000, 1) === 0, "nor is there room for four million triangles");
  render();
  check(sum() === before, "the scene of before is still there");

  // It shines, so that its pixels are known from all others.
  const lamp = text("a.mtl", "newmtl lamp", "Kd 0 0 0", "Ke 50 0 0");
  for (const [name, lines] of [["flat", ["v 0 0 0", "v 0 0 1e6", "v 3e6 0 0", "f 1 2 3"]], ["high", ["v 0 0 0", "v 1e-6 0 0", "v 0 9e-6 0", "f 1 2 3"]],
    ["far away", ["v 1e6 1e6 1e6", "v 1000010 1e6 1e6", "v 1e6 1000010 1000010", "f 1 2 3"]]]) {
    const opened = put(files.readModel([text("t.obj", "usemtl lamp", ...lines), lamp])), pixels = render();
    let [left, right, top, bottom] = [size, -1, size, -1];
    for (let i = 0; i < size * size; i++)
      if (pixels?.[3 * i] > 40)
        [left, right, top, bottom] = [Math.min(left, i % size), Math.max(right, i % size), Math.min(top, i / size | 0), Math.max(bottom, i / size | 0)];
    check(opened === 0 && left > 0 && top > 0 && right < size - 1 && bottom < size - 1 && Math.max(right - left, bottom - top) > size / 2,
      `a model that is ${name} is seen, all of it, and not small`, `columns ${left} to ${right}, rows ${top} to ${bottom} of ${size}`);
    check(module._web_triangles() === 1, "it has one triangle");
  }
  const [eye, target] = [0, 3].map((at) => module.HEAPF32.slice((module._web_first_camera() >> 2) + at, (module._web_first_camera() >> 2) + at + 3));
  check([...eye, ...target].every(Number.isFinite) && eye[1] > target[1], "the camera looks down on it", `from ${[...eye].map((x) => x.toFixed(2))}`);
  module._web_camera(0, -4, 0.1, 0, 1, 0, 0, 0);
  check(render().some((x, i) => i % 3 === 0 && x > 40), "it can be seen from below, through the floor");
  module._web_open(0, 1);
  render();
  check(sum() === before, "a scene of the page's own looks as before when a model has been open");

  // A square that shows an image of two pixels twice: red and blue, with the colours of sRGB between them.
  const square = files.readModel([text("t.obj", "usemtl a", "v 0 0 0", "v 1 0 0", "v 1 1 0", "v 0 1 0", "vt -3 0", "vt -1 0", "vt -1 1", "vt -3 1",
    "f 1/1 2/2 3/3 4/4"), text("a.mtl", "newmtl a", "map_Kd a.png"), binary("a.png", png(2, 1))]);
  const image = { width: 2, height: 1, pixels: Uint32Array.of(0xff0000ff, 0xffbc0000) };
  put(square, [image]);
  module._web_camera(0, 1, 4, 0, 1, 0, 0, 0);
  const row = render().slice(3 * size * 32, 3 * size * 33), ratio = (x) => row[3 * x + 2] / (row[3 * x] + row[3 * x + 2]);
  const column = (u) => Math.floor(size / 2 + (2 * u - 1) * size / 2 / (4 * Math.tan(Math.PI / 8))); // of a place in the square
  check(ratio(column(0.125)) < 0.1 && ratio(column(0.375)) > 0.9 && ratio(column(0.625)) < 0.1 && ratio(column(0.875)) > 0.9,
    "an image is seen, twice", [0.125, 0.375, 0.625, 0.875].map((u) => ratio(column(u)).toFixed(2)).join(" "));
  const top = 0.5029; // linear, of 188
  check(Math.abs(row[3 * column(0.375) + 2] / row[3 * column(0.125)] - top) < 0.05, "its codes are those of sRGB");
  check(Math.abs(ratio(column(0.25)) - top / (1 + top)) < 0.08, "it is bilinear", ratio(column(0.25)).toFixed(2));
  module._web_pose(0, 0.01);
  check(same(render().slice(3 * size * 32, 3 * size * 33), row, 0), "an open shutter leaves a model as it is");
  square.words[files.MATERIAL_WORDS + 12] = 1;
  put(square, [{ ...image, pixels: Uint32Array.of(0xff0000ff, 0x00bc0000) }]);
  module._web_camera(0, 1, 4, 0, 1, 0, 0, 0);
  const holes = render().slice(3 * size * 32, 3 * size * 33);
  check(same(holes.slice(3 * column(0.125), 3 * column(0.125) + 3), row.slice(3 * column(0.125), 3 * column(0.125) + 3)) &&
    holes[3 * column(0.375)] > 0.2, "it has holes where it is transparent", [...holes.slice(3 * column(0.375), 3 * column(0.375) + 3)].join(" "));
  check(module._web_image_room(1025, 1) === 0 && module._web_image_room(0, 1) === 0, "there is no room for an image that is too large, or empty");
  if (quick) return;
  // As large as a model may be: how much memory that takes, and that it is given back.
  const side = 707, lines = [];
  for (let i = 0; i <= side; i++) for (let k = 0; k <= side; k++) lines.push(`v ${i} ${(i * 7 + k * 13) % 5} ${k}`);
  for (let i = 0; i < side; i++)
    for (let k = 0; k < side; k++) {
      const at = i * (side + 1) + k + 1;
      lines.push(`f ${at} ${at + 1} ${at + side + 2} ${at + side + 1}`);
    }
  const began = performance.now(), large = files.readModel([{ name: "large.obj", bytes: new TextEncoder().encode(lines.join("\n")) }]), seconds = (performance.now() - began) / 1000;
  check(large.count === 2 * side * side, "a million triangles, about, are read", `${files.describe(large)}, in ${seconds.toFixed(1)} s`);
  check(put(large) === 0 && render() !== null, "and shown", `${(module.HEAPU8.length / 1e6).toFixed(0)} MB of the module's memory`);
  for (let i = 0; i < 3; i++) put(large), render(); // while the scene of before is still there
  const some = module.HEAPU8.length;
  for (let i = 0; i < 4; i++) put(large), render();
  check(module.HEAPU8.length === some, "opened again and again, they take no more memory", `${(some / 1e6).toFixed(0)} MB`);
  check(some < 600e6, "that is less than 600 MB");
}

async function main() {
  const source = fs.readFileSync(path.join(__dirname, "../examples/web/files.js"), "utf8");
  files = await import(`data:text/javascript,${encodeURIComponent(source)}`); // node takes a .js for a script
  testFormats();
  testNormals();
  testImages();
  testHostile();
  await testModule();
  console.log(failures ? `${failures} failed` : "all passed");
  process.exit(failures ? 1 : 0);
}

main().catch((error) => {
  console.log(`FAILED  ${error.stack}`);
  process.exit(1);
});
