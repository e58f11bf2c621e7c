// Renders bands of pictures: one of several workers, each with a module and a scene of its own. Requests are those of
// look.js, one at a time: {code} the compiled module, {open} a scene or a model, {band} some rows of a picture, or of two halves
// of one, {filter} rows of both halves of a preview. What it cannot do it says in {failed}, and in {refused} if the filter is to blame.
"use strict";
importScripts("pktrt.js", "open.js");

let module = null;
let shutterOpen = false; // as the scene was built

// Instantiates what the page has compiled once for all workers.
function start(code) {
  return pktrt({
    instantiateWasm(imports, done) {
      WebAssembly.instantiate(code, imports).then(done, (error) => postMessage({ failed: String(error) }));
      return {};
    },
  });
}

function must(status) {
  mustOpen(module, status);
}

// The views of the memory are looked up anew each time, for growth replaces them.
function floats(pointer, count) {
  return module.HEAPF32.slice(pointer >> 2, (pointer >> 2) + count);
}

function doubles(pointer, count) {
  return [...module.HEAPF64.slice(pointer >> 3, (pointer >> 3) + count)];
}

function open(request) {
  openScene(module, request);
  shutterOpen = false;
  return { opened: true, camera: [...floats(module._web_first_camera(), 9)], triangles: module._web_triangles() };
}

// Makes room for the filter: where it begins.
function filterRoom(pixels) {
  const room = module._web_filter_room(pixels);
  if (!room) throw new Error("there is not enough memory for the filter");
  return room;
}

// Of a pixel both halves have 20 floats: two colours, and twice seven features.
function renderHalves(band) {
  const pixels = band.width * band.rows, room = filterRoom(pixels);
  must(module._web_render_halves(band.y, band.rows));
  return floats(room, 20 * pixels);
}

// Filters rows of a preview. What came along has `above` rows before them.
function filter({ width, y, rows, above, parts }) {
  const count = parts[0].length / 3, begin = performance.now();
  let at = filterRoom(count) >> 2;
  for (const part of parts) module.HEAPF32.set(part, at), at += part.length;
  const out = 4 * (at + count + 3 * width * above); // after the variance
  must(module._web_filter_rows(width, count / width, above, rows));
  return { band: { y, rows }, pixels: floats(out, 3 * width * rows), filtering: performance.now() - begin };
}

function render(band) {
  const begin = performance.now(), built = shutterOpen !== band.shutter > 0;
  shutterOpen = band.shutter > 0;
  must(module._web_pose(band.time, band.shutter));
  must(module._web_resize(band.width, band.height));
  const posed = performance.now();
  module._web_camera(...band.eye, ...band.target, band.aperture, band.focus);
  module._web_settings(band.mode, band.packet, band.cost, band.attenuation);
  module._web_path(band.path, band.steps, band.counted);
  const halves = band.halves ? renderHalves(band) : null;
  if (!halves) must(module._web_render_band(band.y, band.rows, band.samples, band.pass));
  const first = band.y * band.width, count = band.rows * band.width;
  return {
    band: { y: band.y, rows: band.rows },
    pixels: halves ? null : floats(module._web_pixels() + 12 * first, 3 * count),
    halves,
    cost: band.cost ? floats(module._web_cost() + 4 * first, count) : null,
    work: band.counted ? doubles(module._web_work(), 4) : null,
    built,
    posing: posed - begin,
    rendering: performance.now() - posed,
  };
}

onmessage = async ({ data }) => {
  try {
    let answer;
    if (data.code) {
      module = await start(data.code);
      answer = { ready: true, margin: module._web_filter_margin() };
    } else answer = data.open ? open(data.open) : data.filter ? filter(data.filter) : render(data.band);
    const moved = [answer.pixels, answer.halves, answer.cost].filter(Boolean).map((array) => array.buffer);
    postMessage({ ...answer, id: data.id }, moved);
  } catch (error) {
    const sentence = error.message || String(error), filters = Boolean(data.filter || data.band?.halves);
    postMessage({ [filters ? "refused" : "failed"]: sentence, id: data.id, opening: Boolean(data.open) });
  }
};
