// Looks around in a scene, as examples/view.c does in a window. While anything moves, a picture is one sample for each of as
// many pixels as fit into a fifteenth of a second; with the filter, which distribution ray tracing has, two samples and what filter.h
// makes of them. When all is still, passes at full size refine it, unfiltered, and their scatter tells what error is left.
//
// Pictures are made by workers, band by band (worker.js). This page sums up passes, and shows them. A band's floats depend on
// what was asked for alone, not on who made it or when. The filter looks across bands: they are put together here, and sent
// out again with some rows of their neighbours.
import { addresses, byId, given, isWalk, moduleCode, setControl } from "./page.js";
import { modelOf } from "./files.js";
import { hashOf, stepsOf, stepsText, tidy, WALK_DEFAULTS } from "./walk_data.js";

const SAMPLES = 2; // of a pixel and pass: a single one would lie in the middle each time, but in DRT
const MOST_PASSES = 128;
const LOOP_SECONDS = 10; // of the animation
const PREVIEW_MS = 1000 / 15;
const BAND_MS = 80; // how long the user may have to wait for a worker; each band costs some milliseconds by itself
const LEAST_PIXELS = 256, LEAST_FILTERED = 80 * 60; // of a preview: in fewer the filter finds little to compare
const FILTERED_ROWS = 32; // at least, of a band: its filter looks at some rows around it as well
const FAINT = 1 / 20; // what a ray can add at most that may be left out while things move
const READ_SECONDS = 60; // after which a file is given up
const MOST_COPIED = 4e6; // triangles of a model, of all workers
const BLOCK = 16;   // pixels along the edge of what errors are relative to: PKTRT_ERROR_BLOCK

const control = Object.fromEntries(
  ["scene", "mode", "animate", "time", "aperture", "focus", "shutter", "light", "filter", "size", "full", "faint", "packet", "workers",
    "over", "strength", "files", "up", "path", "steps"].map((id) => [id, byId(id)]));
const number = (id) => Number(control[id].value);
const section = byId("look"), picture = byId("picture"), overlay = byId("overlay");
const show = (id, text) => { byId(id).textContent = text; };
let building = false;   // the message says so
function say(text) {
  show("message", text);
  building = false;
}
function sayBuilding() { // as long as there is no picture of what is wanted
  if (seen === wanted()) {
    if (building) say("");
    return;
  }
  say(`Building: ${control.scene.selectedOptions[0].text}`);
  building = true;
}

// --- camera ---

let camera = null;      // eye, target, fov in degrees
let firstCamera = null; // the scene's own, as the worker tells it, with aperture and focus
let cameraScene = "";   // whose that is

const sub = (a, b) => a.map((x, i) => x - b[i]);
const add = (a, b, s) => a.map((x, i) => x + s * b[i]);
const unit = (a) => a.map((x) => x / Math.hypot(...a));
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];

function setNumber(id, value) {
  control[id].value = value;
  showNumbers();
}

// Around the target: angles in radians, to the right and up, not quite to the poles.
function orbit(right, up) {
  const [x, y, z] = sub(camera.eye, camera.target), distance = Math.hypot(x, y, z);
  const turn = Math.atan2(x, z) + right, rise = Math.max(-1.5, Math.min(1.5, Math.asin(y / distance) + up));
  camera.eye = add(camera.target,
    [Math.cos(rise) * Math.sin(turn), Math.sin(rise), Math.cos(rise) * Math.cos(turn)], distance);
}

// Nearer to the target or farther; what is sharp stays as far before or behind it, in proportion.
function zoom(factor) {
  const back = sub(camera.eye, camera.target), distance = factor * Math.hypot(...back);
  if (distance < 0.02 || distance > 200) return;
  camera.eye = add(camera.target, back, factor);
  setNumber("focus", factor * number("focus"));
}

// Eye and target sideways and up, by parts of the picture's height as it is at the target.
function pan(right, up) {
  const back = sub(camera.eye, camera.target), height = 2 * Math.hypot(...back) * Math.tan((camera.fov * Math.PI) / 360);
  const x = unit(cross([0, 1, 0], back)), y = cross(unit(back), x);
  for (const point of ["eye", "target"]) camera[point] = add(add(camera[point], x, height * right), y, height * up);
}

// --- workers ---

const workers = [];  // the first one makes the first picture of a scene, the others come to help then
let seen = "";       // the scene of which there has been a picture
let jobs = [];       // pictures that are being made, the oldest first: two where things move, so that no worker waits
let jobsBegun = 0;

const isModel = () => control.scene.value === "model";
const wantedScene = () => (isModel() ? `model ${model.number}` : control.scene.value);
const wanted = () => `${wantedScene()} ${control.light.value}`;
const paused = () => document.hidden || section.hidden;

function setWorkers(count) {
  while (workers.length > count) workers.pop().thread.terminate();
  while (workers.length < count) {
    const one = { thread: new Worker("worker.js"), scene: "", before: "", cannot: "", busy: true };
    workers.push(one);
    one.thread.onmessage = ({ data }) => take(one, data);
    one.thread.onerror = (event) => say(`A worker failed: ${event.message}`);
    moduleCode().then((code) => one.thread.postMessage({ code }),
      (error) => say(`This browser cannot run it; WebAssembly with SIMD is needed. ${error.message}`));
  }
}

function send(one, request) {
  one.busy = true;
  one.thread.postMessage(request);
}

// The picture that needs a worker. One is begun before that before it is whole only if both are previews.
function nextJob() {
  const waits = () => jobs.find((one) => one.bands.length);
  if (!waits() && (!jobs.length || (jobs.length === 1 && jobs[0].pass < 0 && moves()))) begin();
  return waits();
}

// Gives work to all who have none. Of a large model few have copies, for each takes about 460 bytes a triangle.
function feed() {
  if (paused()) return;
  const scene = wanted(), helpers = isModel() ? Math.max(1, Math.floor(MOST_COPIED / model.count)) : workers.length;
  for (const one of workers.slice(0, helpers)) {
    if (one.busy || one.cannot === scene) continue;
    if (one.scene !== scene) {
      if (one !== workers[0] && seen !== scene) continue;
      one.before = one.scene;
      one.scene = scene;
      send(one, { open: { scene: control.scene.selectedIndex, light: number("light"), model: isModel() ? model : null } });
    } else {
      const job = nextJob();
      if (!job) continue;
      job.began ??= performance.now();
      const band = job.bands.shift();
      send(one, job.filtering ? { id: job.id, filter: filterOf(job, band) } : { id: job.id, band });
    }
  }
}

function take(one, answer) {
  if (!workers.includes(one)) return;
  if (answer.failed && !(answer.opening && one.scene.startsWith("model")))
    return say(answer.failed); // it stays busy, and is asked for nothing any more
  one.busy = false;
  margin = answer.margin ?? margin;
  if (answer.refused) refuseFilter(answer.refused);
  if (answer.failed) { // a model, for which memory is lacking: the worker has the scene of before
    one.cannot = one.scene;
    one.scene = one.before;
    if (one === workers[0]) giveBack(one.cannot, answer.failed);
  }
  if (answer.opened && one.scene === wanted()) takeScene(answer); // it may have taken long, and another is wanted by now
  const job = answer.band && jobs.find((one) => one.id === answer.id);
  if (job) takeBand(job, answer);
  feed();
}

function takeScene({ camera: told, triangles }) {
  if (cameraScene === wantedScene()) return; // another worker has told of it
  const keep = address; // what it says counts once
  address = new Map();
  kept = null;
  tried = [];
  byId("tried").hidden = true;
  firstCamera = { eye: told.slice(0, 3), target: told.slice(3, 6), fov: told[6], aperture: told[7], focus: told[8] };
  cameraScene = wantedScene();
  lookFrom(keep);
  show("triangles", triangles.toLocaleString("en"));
}

// --- the address ---

// What is in it, beside eye and target. The lens is the scene's own if it is not named.
const ADDRESSED = ["scene", "mode", "size", "path", "steps", "packet", "aperture", "focus", "shutter", "light", "time", "over", "strength",
  "full", "faint", "filter"];
let address = given;                               // what the next scene is to be seen like
let written = isWalk() ? "" : location.hash;       // what stands there
let addressed = {};                                // values of controls that need not be named
let writing = 0;                                   // a timer
let waiting = null;                                // what it is about to write; null: the scene is not there yet
const valueOf = (id) => (control[id].type === "checkbox" ? String(Number(control[id].checked))
  : id === "steps" ? stepsText(steps()) : control[id].value);
const pointText = (point) => point.map((x) => +Math.fround(x).toPrecision(9)).join();
const pointIn = (text) => {
  const point = (text ?? "").split(",").map(Number);
  return point.length === 3 && point.every((x) => Number.isFinite(x) && Math.abs(x) < 1e6) ? point : null;
};

// Looks at a scene as an address says, and where it says nothing as the scene does.
function lookFrom(named) {
  camera = { ...firstCamera };
  const eye = pointIn(named.get("eye")), target = pointIn(named.get("target"));
  if (eye && target && Math.hypot(...sub(eye, target)) > 0) Object.assign(camera, { eye, target });
  const { aperture, focus } = firstCamera;
  if (!named.has("aperture")) setNumber("aperture", aperture);
  if (!named.has("focus")) setNumber("focus", focus || Math.hypot(...sub(camera.eye, camera.target)));
  Object.assign(addressed, { ownAperture: control.aperture.value, ownFocus: control.focus.value });
}

// Of a scene that is not there yet: seen as it is at first. A model is gone when the page is: with another page the address
// is that of the first scene.
function addressNow() {
  if (isModel()) return "#scene=model";
  const there = camera && cameraScene === wantedScene(), own = { ...addressed, aperture: addressed.ownAperture, focus: addressed.ownFocus };
  const named = ADDRESSED.filter((id) => valueOf(id) !== own[id] && (there || !["aperture", "focus"].includes(id)))
    .map((id) => `${id}=${valueOf(id)}`);
  if (!there) return named.length ? `#${named.join("&")}` : "";
  const same = (a, b) => pointText(a) === pointText(b);
  if (!same(camera.eye, firstCamera.eye) || !same(camera.target, firstCamera.target))
    named.push(`eye=${pointText(camera.eye)}`, `target=${pointText(camera.target)}`);
  return named.length ? `#${named.join("&")}` : "";
}

// Writes the address when nothing has changed for a while: browsers count such calls.
function writeAddress() {
  clearTimeout(writing);
  waiting = cameraScene === wantedScene() ? addressNow() : null;
  writing = setTimeout(() => writeNow("replaceState"), 300);
}
function writeWaiting() { // before another entry of the history begins
  if (!writing || waiting === null || section.hidden || control.animate.checked) return;
  clearTimeout(writing);
  writing = 0;
  written = waiting;
  history.replaceState(null, "", written || location.pathname + location.search);
}
section.addEventListener("leaving", writeWaiting);
function writeNow(how) {
  clearTimeout(writing), writing = 0;
  if (section.hidden || control.animate.checked) return;
  if (cameraScene !== wantedScene() && how === "replaceState") return writeAddress();
  written = addressNow();
  history[how](null, "", written || location.pathname + location.search);
}
addresses.look = () => written;

addEventListener("hashchange", () => {
  if (isWalk() || location.hash === written) return;
  const named = new URLSearchParams(location.hash.slice(1)), before = control.size.value;
  written = location.hash;
  if (named.get("scene") === "model" && !model) named.delete("scene"); // it was another page's
  for (const id of ADDRESSED) setControl(id, named.get(id) ?? (id === "scene" ? "poolhall" : (addressed[id] || control[id].value)));
  setSteps(stepsOf(named.get("steps") ?? "all"));
  control.animate.checked = false;
  if (control.size.value !== before) fit();
  sayModel();
  address = named;
  if (cameraScene === wantedScene()) lookFrom(named), address = new Map();
  showNumbers();
  change();
  clearTimeout(writing), writing = 0;
});

// --- pictures ---

let changed = true; // by the user, since the last preview began
let passes = 0;     // whole ones, of the picture as it stands
let previewPixels = 20000, msPerSample = 0.003, refitMs = 0;
let frameMs = 0, shownAt = 0, ticked = 0;
let sums = null; // of passes: colours, squares of colours, costs
let report = null;

const size = () => control.size.value.split("x").map(Number);

const moves = () => changed || control.animate.checked;

// What the user has done counts at once. A preview that is under way is let go on, unless what it shows is another scene.
function change() {
  jobs = jobs.filter((one) => one.pass < 0 && one.scene === wanted());
  changed = true;
  passes = 0;
  report = null;
  sayBuilding();
  feed();
  writeAddress();
}

function begin() {
  if (cameraScene !== wantedScene()) return;
  const [width, height] = size();
  if (!moves()) {
    if (passes < MOST_PASSES) beginPass(width, height);
    return;
  }
  if (control.animate.checked) {
    const now = performance.now();
    setNumber("time", (number("time") + (now - ticked) / 1000 / LOOP_SECONDS) % 1);
    ticked = now;
  }
  const scale = control.full.checked ? 1 : Math.sqrt(Math.min(1, previewPixels / (width * height)));
  passes = 0;
  changed = false;
  beginJob(Math.ceil(scale * width), Math.ceil(scale * height), -1);
}

function beginPass(width, height) {
  const n = width * height;
  if (passes === 0) {
    if (!sums || sums.cost.length !== n)
      sums = { colour: new Float64Array(3 * n), square: new Float64Array(n), cost: new Float64Array(n) };
    for (const sum of Object.values(sums)) sum.fill(0);
    frameMs = 0;
  }
  beginJob(width, height, passes);
}

// How much work rows are, by parts of the height: what bands took when they were made last.
const work = new Float32Array(64).fill(1);

// Cuts a height into bands that should be about as much work each.
function cut(height, count) {
  const all = work.reduce((sum, x) => sum + x), bands = [];
  for (let y = 0, from = 0, sum = 0; y < height; y += 8) {
    const end = Math.min(height, y + 8);
    sum += (work[Math.floor((64 * y) / height)] * 64 * 8) / height;
    if (end < height && sum < (all * (bands.length + 1)) / count) continue;
    bands.push({ y: from, rows: end - from });
    from = end;
  }
  return bands;
}

function beginJob(width, height, pass) {
  const filters = pass < 0 && control.filter.checked && control.mode.value === "drt";
  const samples = pass >= 0 ? SAMPLES : 1, perPixel = filters ? 2 : samples;
  const common = {
    width, height, samples, halves: filters, pass: Math.max(0, pass), eye: camera.eye, target: camera.target, aperture: number("aperture"),
    focus: number("focus"), time: number("time"), shutter: control.mode.value === "drt" ? number("shutter") : 0,
    mode: control.mode.selectedIndex, packet: number("packet"), cost: { boxes: 1, triangles: 2 }[control.over.value] || 0,
    attenuation: pass < 0 && control.faint.checked ? FAINT : 0,
    path: control.path.selectedIndex, steps: steps(), counted: Number(pass === 0), // which takes time: not in the others
  };
  const job = { id: ++jobsBegun, scene: wanted(), width, height, pass, began: null, built: false, spent: 0, samples: perPixel,
    halves: filters ? HALVES.map((floats) => new Float32Array(floats * width * height)) : null, filtering: false,
    work: pass === 0 ? [0, 0, 0, 0] : null, way: wayOf(common),
    seen: JSON.stringify([wanted(), control.over.value, common.mode, common.eye, common.target, common.aperture, common.focus,
      common.time, common.shutter]) };
  const expected = width * height * perPixel * msPerSample;
  job.bands = cut(height, Math.max(expected / BAND_MS, pass < 0 ? workers.length : 2 * workers.length))
    .map((band) => ({ ...common, ...band }));
  job.left = job.bands.length;
  job.image = pass < 0 || !passImage || passImage.width !== width || passImage.height !== height
    ? new ImageData(width, height) : passImage;
  if (pass >= 0) passImage = job.image;
  job.cost = common.cost ? new Float32Array(width * height) : null;
  jobs.push(job);
}

let passImage = null;
const pen = picture.getContext("2d", { alpha: false });
const scratch = document.createElement("canvas");

// Codes of linear values, by 1/16383.
const codes = Uint8Array.from({ length: 16384 }, (_, i) => {
  const x = i / 16383;
  return Math.round(255 * (x <= 0.0031308 ? 12.92 * x : 1.055 * x ** (1 / 2.4) - 0.055));
});

// Puts values, times a factor, into an image's rows from `y` on.
function encode(image, y, values, from, count, factor) {
  const out = image.data, scale = 16383 * factor;
  for (let i = 0, to = 4 * y * image.width, at = from; i < count; i++, to += 4, at += 3) {
    out[to] = codes[Math.min(16383, values[at] * scale) | 0];
    out[to + 1] = codes[Math.min(16383, values[at + 1] * scale) | 0];
    out[to + 2] = codes[Math.min(16383, values[at + 2] * scale) | 0];
    out[to + 3] = 255;
  }
}

// --- the filter ---

const HALVES = [3, 3, 7, 7]; // floats of a pixel: colours of both halves, and features, as web_filter.c has them
let margin = 0;              // rows around a band that its filter needs

// Puts a band of both halves into its place. When all are there, bands that are to be filtered take their turn.
function takeHalves(job, { y, rows }, halves) {
  let from = 0;
  HALVES.forEach((floats, i) => {
    const count = floats * job.width * rows;
    job.halves[i].set(halves.subarray(from, from + count), floats * job.width * y);
    from += count;
  });
  if (--job.left > 0) return;
  const count = Math.max(1, Math.min(workers.length, Math.floor(job.height / FILTERED_ROWS)));
  const edge = (i) => Math.round((job.height * i) / count);
  job.filtering = true;
  job.bands = Array.from({ length: count }, (_, i) => ({ y: edge(i), rows: edge(i + 1) - edge(i) }));
  job.left = count;
}

function filterOf({ width, height, halves }, { y, rows }) {
  const from = Math.max(0, y - margin), to = Math.min(height, y + rows + margin);
  return { width, y, rows, above: y - from, parts: halves.map((all, i) => all.slice(HALVES[i] * width * from, HALVES[i] * width * to)) };
}

// Previews go on without it.
function refuseFilter(sentence) {
  control.filter.checked = false;
  show("filter-said", `The filter is off: ${sentence}.`);
  jobs = jobs.filter((one) => !one.halves);
  change();
}

function takeBand(job, answer) {
  const { band, pixels, halves, filtering } = answer;
  if (filtering === undefined) noteBand(job, answer);
  if (halves) takeHalves(job, band, halves);
  else showBand(job, band, pixels, answer.cost);
  while (jobs.length && jobs[0].left === 0) finish(jobs.shift());
}

// What a band took, and what it counted.
function noteBand(job, { band, cost, work: done, built, posing, rendering }) {
  const { width, height, samples } = job, n = band.rows * width;
  msPerSample += 0.2 * (rendering / n / samples - msPerSample);
  for (let i = Math.ceil((64 * band.y) / height); i < (64 * (band.y + band.rows)) / height; i++)
    work[i] += 0.5 * (rendering / n / samples / msPerSample - work[i]);
  if (built) job.built = true; // which is no measure of what fits into a frame
  else if (posing > 0.2 && control.animate.checked) refitMs += (refitMs ? 0.1 : 1) * (posing - refitMs);
  if (cost) job.cost.set(cost, band.y * width);
  job.spent += rendering;
  if (done) job.work = job.work.map((x, i) => x + done[i]);
}

function showBand(job, band, pixels, cost) {
  const { width, pass, image } = job, first = band.y * width, n = band.rows * width;
  if (pass < 0) encode(image, band.y, pixels, 0, n, 1);
  else {
    for (let i = 0, at = 3 * first, from = 0; i < n; i++, at += 3, from += 3) {
      const r = pixels[from], g = pixels[from + 1], b = pixels[from + 2];
      sums.colour[at] += r, sums.colour[at + 1] += g, sums.colour[at + 2] += b;
      sums.square[first + i] += r * r + g * g + b * b;
      if (cost) sums.cost[first + i] += cost[i];
    }
    encode(image, band.y, sums.colour, 3 * first, n, 1 / (pass + 1));
    pen.putImageData(image, 0, 0, 0, band.y, width, band.rows);
  }
  job.left--;
}

// A picture is whole: shows it, if that has not been done band by band.
function finish(done) {
  const now = performance.now(), alone = Math.max(done.began, shownAt); // since when it has had the workers for itself
  if (done.pass < 0) stretch(pen, done.image, true);
  if (!seen) show("first", `${(now / 1000).toFixed(2)} s`);
  seen = done.scene;
  sayBuilding();
  const took = now - (frameMs ? shownAt : done.began);
  frameMs += (frameMs ? 0.2 : 1) * (took - frameMs);
  shownAt = now;
  if (done.pass >= 0) {
    passes++;
    report = passes > 1 ? estimate(done.width, done.height) : null;
  } else if (!done.built) adapt(PREVIEW_MS / (now - alone), done.halves ? LEAST_FILTERED : LEAST_PIXELS);
  layOver(done);
  showFigures(done);
  if (done.pass >= 0) noteWay(done);
}

// As many pixels as fit; a size that is about right stays, else it would never be at rest.
function adapt(factor, least) {
  const [width, height] = size();
  if (factor < 0.8 || factor > 1.2)
    previewPixels = Math.max(least, Math.min(width * height, previewPixels * Math.max(0.25, Math.min(2, factor))));
}

// Draws an image as large as the canvas.
function stretch(to, image, smooth) {
  scratch.width = image.width, scratch.height = image.height;
  scratch.getContext("2d").putImageData(image, 0, 0);
  to.imageSmoothingEnabled = smooth;
  to.drawImage(scratch, 0, 0, to.canvas.width, to.canvas.height);
}

// --- errors and costs ---

// Estimates how wrong the mean of passes is, as pktrt_error_measure has it: V of a pixel is the scatter of its passes over
// their number; RMSE is that of a channel, the relative MSE divides V by what is around the pixel. Also tells its square
// root for each pixel, and how many pixels carry the sum of V: where they are few, it may be far off.
function estimate(width, height) {
  const n = passes, v = new Float32Array(width * height), below = new Float32Array(width * height);
  const columns = Math.ceil(width / BLOCK), blocks = new Float64Array(4 * columns * Math.ceil(height / BLOCK));
  const whole = [0, 0, 0];
  let all = 0, squared = 0;
  for (let y = 0, i = 0; y < height; y++)
    for (let x = 0; x < width; x++, i++) {
      const block = 4 * (Math.floor(y / BLOCK) * columns + Math.floor(x / BLOCK));
      let squares = 0;
      for (let c = 0; c < 3; c++) {
        const mean = sums.colour[3 * i + c] / n;
        squares += mean * mean, blocks[block + c] += mean, whole[c] += mean;
      }
      blocks[block + 3]++;
      v[i] = Math.max(0, sums.square[i] - n * squares) / (n * (n - 1));
      all += v[i], squared += v[i] * v[i];
    }
  const pixels = width * height, least = whole.reduce((sum, x) => sum + (x / pixels) ** 2, 0) / 100;
  let relative = 0;
  for (let y = 0, i = 0; y < height; y++)
    for (let x = 0; x < width; x++, i++) {
      const b = 4 * (Math.floor(y / BLOCK) * columns + Math.floor(x / BLOCK)), k = blocks[b + 3];
      const part = v[i] / ((blocks[b] ** 2 + blocks[b + 1] ** 2 + blocks[b + 2] ** 2) / (k * k) + least || 1);
      relative += part;
      below[i] = Math.sqrt(part);
    }
  const carried = squared > 0 ? (all * all) / squared : 0;
  return { rmse: Math.sqrt(all / 3 / pixels), relative: Math.sqrt(relative / pixels), below, carried };
}

// Colours from black over red to white: those of examples/heat.h.
const heat = [[0, 0, 0], [35, 15, 95], [110, 25, 120], [205, 50, 70], [245, 125, 25], [250, 205, 70], [255, 255, 255]];
const heatCodes = Uint8ClampedArray.from({ length: 768 }, (_, i) => {
  const at = (Math.floor(i / 3) / 255) * 6, below = Math.min(5, Math.floor(at));
  return heat[below][i % 3] + (at - below) * (heat[below + 1][i % 3] - heat[below][i % 3]);
});

// What is black and what is white of counts, which one pixel of 200 is below and exceeds: a power of ten from 1 on, and 1, 2
// or 5 times one.
function heatScale(values) {
  const some = values.filter((x, i) => i % Math.ceil(values.length / 20000) === 0).sort();
  const few = Math.floor(some.length / 200), low = Math.max(1, some[few]), high = Math.max(2, some[some.length - 1 - few]);
  const least = 10 ** Math.floor(Math.log10(low)), ten = 10 ** Math.floor(Math.log10(high));
  return [least, Math.max(10 * least, [1, 2, 5, 10].find((step) => step * ten >= high) * ten)];
}

// The same for all ways to trace one picture, so that their colours can be compared: wide enough for all of them.
let scaled = { picture: "", least: 0, most: 0 };
function scaleOf(picture, cost) {
  const [least, most] = heatScale(cost);
  if (scaled.picture !== picture) scaled = { picture, least, most };
  scaled.least = Math.min(least, scaled.least);
  scaled.most = Math.max(most, scaled.most);
  return [scaled.least, scaled.most];
}

function paintHeat(values, width, height, place) {
  const image = new ImageData(width, height), out = image.data;
  for (let i = 0; i < values.length; i++) {
    const code = 3 * Math.round(255 * Math.max(0, Math.min(1, place(values[i]))));
    out.set(heatCodes.subarray(code, code + 3), 4 * i);
    out[4 * i + 3] = 255;
  }
  stretch(overlay.getContext("2d"), image, false);
}

// Shows what the user wants over the picture, of which it is the latest that is known.
function layOver(done) {
  const cost = done.cost && done.pass >= 0 ? sums.cost.map((x) => x / passes) : done.cost; // of passes their mean
  const what = control.over.value, there = what === "error" ? report !== null : cost !== null;
  overlay.hidden = byId("legend").hidden = !there;
  if (!there) return;
  const [least, most] = what === "error" ? [0.001, 1] : scaleOf(done.seen, cost);
  const place = (x) => (x > 0 ? Math.log(x / least) / Math.log(most / least) : 0);
  const written = (x) => (what === "error" ? `${+(100 * x).toPrecision(2)}%` : Math.round(x).toLocaleString("en"));
  paintHeat(what === "error" ? report.below : cost, done.width, done.height, place);
  show("legend-least", written(least)), show("legend-most", written(most));
  show("legend-what", what === "error" ? "of the light around, logarithmic"
    : `${what} tested for a sample, logarithmic${control.path.value === "fast" ? "; each ray alone, for the fast path does not count" : ""}`);
  const between = []; // the powers of ten between both ends
  for (let x = 10 * least; x < 0.6 * most; x *= 10) between.push(x);
  byId("legend-scale").replaceChildren(...between.map((x) => {
    const tick = Object.assign(document.createElement("span"), { textContent: written(x) });
    tick.style.left = `${100 * place(x)}%`;
    return tick;
  }));
}

// --- ways of tracing, and what each has cost ---

const stepBoxes = [...document.querySelectorAll("[name=step]")];
const steps = () => stepBoxes.reduce((bits, box) => bits | (box.checked ? Number(box.value) : 0), 0) || stepsOf("none");
const PATH_NOTES = {
  fast: "It chooses packets by itself: their size here only says in which order pixels are taken.",
  paper: "A packet goes down the tree as one. What it decides about a box, it decides for all its rays.",
  single: "Each ray goes down the tree by itself, whatever the size of packets.",
};

function setSteps(bits) {
  for (const box of stepBoxes) box.checked = (bits & Number(box.value)) !== 0;
  const text = stepsText(bits);
  control.steps.value = [...control.steps.options].some((one) => one.value === text) ? text : "some";
}

function showPath() {
  byId("paper-only").hidden = control.path.value !== "paper";
  show("path-note", PATH_NOTES[control.path.value]);
}

// Names a way of tracing, and what the picture is beside that: {name, packets, picture}. null where things are counted that
// take time, or move.
function wayOf({ pass, counted, packet, path, steps: bits, ...rest }) {
  if (rest.cost || control.animate.checked) return null;
  const name = control.path.value + (control.path.value === "paper" ? `: ${stepsText(bits)}` : "");
  return { name, packets: control.path.value === "single" ? "-" : `${packet} x ${packet}`, picture: JSON.stringify([wanted(), rest]) };
}

let tried = [], triedPicture = ""; // ways, the latest last; of which picture

// A pass is whole: the first tells how much work it was, the others how long it takes.
function noteWay({ way, pass, work: counts, spent }) {
  if (!way) return byId("tried").querySelector("[aria-current]")?.removeAttribute("aria-current");
  if (way.picture !== triedPicture) tried = [];
  triedPicture = way.picture;
  let one = tried.find((other) => other.name === way.name && other.packets === way.packets);
  if (!one) tried.push(one = { ...way, ms: Infinity, counts: null });
  if (pass === 0) one.counts = counts;
  else one.ms = Math.min(one.ms, spent);
  const cell = (kind, text, scope = {}) => Object.assign(document.createElement(kind), { textContent: text, ...scope });
  byId("tried").hidden = false;
  section.classList.toggle("comparing", tried.length > 1);
  document.querySelector("#tried tbody").replaceChildren(...tried.map((row) => {
    const tr = document.createElement("tr"), [rays, ...rest] = row.counts ?? [0, 0, 0, 0];
    if (row === one) tr.setAttribute("aria-current", "true");
    tr.append(cell("th", row.name, { scope: "row" }), cell("td", row.packets),
      cell("td", row.ms < Infinity ? row.ms.toFixed(row.ms < 100 ? 1 : 0) : "-"), cell("td", rays.toLocaleString("en")),
      ...rest.map((x) => cell("td", x > 0 ? (x / rays).toFixed(2) : "-")));
    return tr;
  }));
}

// --- figures ---

let labelledAt = 0;

function showFigures(done) {
  const refining = done.pass >= 0;
  show("rate-name", refining ? "Passes per second" : "Frames per second");
  show("rate", (1000 / frameMs).toFixed(1));
  show("samples", refining ? passes * SAMPLES : done.samples);
  show("rmse", report ? report.rmse.toPrecision(2) : "-");
  show("relative", report ? `${(100 * report.relative).toPrecision(2)}%` : "-");
  show("carried", report ? `${Math.round(report.carried).toLocaleString("en")} pixels` : "-");
  show("pixels", `${done.width} x ${done.height}`);
  show("refit", refitMs ? `${refitMs.toFixed(1)} ms` : "-");
  const now = performance.now(), last = passes === MOST_PASSES;
  if (now - labelledAt < 2000 && passes !== 2 && !last) return; // a screen reader would never come to an end
  labelledAt = now;
  const chosen = (id) => control[id].selectedOptions[0].text;
  picture.setAttribute("aria-label", `${chosen("scene")}. ${chosen("mode")}. ` +
    (report ? `${passes * SAMPLES} samples per pixel, estimated error ${report.rmse.toPrecision(2)}` +
      ` or ${(100 * report.relative).toPrecision(2)}%.` : "Estimated error not yet known.") +
    (control.over.value === "none" ? "" : ` Laid over it: ${chosen("over")}.`));
}

function showNumbers() {
  for (const output of document.querySelectorAll("#controls output"))
    output.textContent = Number(byId(output.htmlFor[0]).value).toFixed(output.htmlFor[0] === "strength" ? 2 : 3)
      .replace(/\.?0+$/, "");
  showPath();
  byId("drt-only").classList.toggle("off", control.mode.value !== "drt");
  overlay.style.opacity = control.strength.value;
}

// --- a model of the user's own ---

let model = null; // of files.js, with the files that it comes from, and a number
let models = 0;   // that there have been
let kept = null;  // scene and model of before one that no worker has opened yet
let reading = null, readingEnds = 0;

const tell = (sentence) => show("model-said", sentence);

function endReading() {
  reading?.terminate();
  clearTimeout(readingEnds);
  reading = null;
}

// Reads a model from files. One that is refused leaves the scene as it is. `options` are those of readModel.
function read(files, options) {
  let name = "";
  endReading();
  try {
    ({ name } = modelOf(files));
  } catch (error) {
    return tell(error.message);
  }
  const refuse = (sentence) => {
    endReading();
    tell(sentence);
  };
  tell(`Reading ${name}`);
  reading = new Worker("reader.js", { type: "module" });
  reading.onmessage = ({ data }) => {
    if (data.refused) return refuse(data.refused);
    endReading();
    takeModel({ ...data.model, files, number: ++models });
  };
  reading.onerror = () => refuse(`${name} is refused: it cannot be read`);
  readingEnds = setTimeout(() => refuse(`${name} is refused: to read it takes more than ${READ_SECONDS} s`),
    1000 * READ_SECONDS);
  reading.postMessage({ files, options });
}

function takeModel(made) {
  const another = !isModel();
  kept = { scene: control.scene.value, model };
  if (another) writeWaiting();
  model = made;
  if (control.scene.options[control.scene.length - 1].value !== "model") control.scene.add(new Option("", "model"));
  nameModel("model");
  if (another) writeNow("pushState"); // so that one can go back
  change();
}

// Chooses a scene, once it is clear whose name the model's option has.
function nameModel(scene) {
  const option = control.scene.options[control.scene.length - 1];
  if (option.value === "model" && model) option.text = model.name;
  else if (option.value === "model") option.remove();
  control.scene.value = scene;
  sayModel();
}

function sayModel() {
  tell(isModel() ? model.said : "");
  byId("up-shown").hidden = !isModel();
  if (isModel()) control.up.checked = model.zUp;
}

// The first worker cannot open a model: if it is the one at hand, the scene of before comes back.
function giveBack(scene, sentence) {
  if (!kept || scene !== wanted()) return say(sentence);
  const { name } = model;
  model = kept.model;
  nameModel(kept.scene);
  kept = null;
  tell(`${name} is refused: ${sentence}`);
  say("");
  change();
}

const dropped = (on) => (event) => {
  if (!event.dataTransfer?.types.includes("Files")) return;
  event.preventDefault();
  section.classList.toggle("dropping", on);
};
addEventListener("dragover", dropped(true));
addEventListener("dragleave", dropped(false));
addEventListener("drop", (event) => {
  dropped(false)(event);
  if (!event.dataTransfer.files.length) return;
  byId("tab-look").click();
  read([...event.dataTransfer.files], {});
});
control.files.addEventListener("change", () => {
  if (control.files.files.length) read([...control.files.files], {});
  control.files.value = ""; // so that the same one can be chosen again
});
control.up.addEventListener("change", () => read(model.files, { zUp: control.up.checked }));

function fit() {
  const [width, height] = size();
  for (const canvas of [picture, overlay]) canvas.width = width, canvas.height = height;
  const frame = picture.parentElement.style;
  frame.aspectRatio = `${width} / ${height}`;
  frame.setProperty("--ratio", width / height);
  frame.maxWidth = `min(${2.5 * width}px, var(--most-height) * ${width / height})`;
  overlay.hidden = byId("legend").hidden = true;
}

// --- what the user does ---

const resettable = ["mode", "time", "aperture", "focus", "shutter", "light", "packet", "over", "strength", "path", "steps"];
let atStart = null; // their values

function reset() {
  if (!firstCamera) return;
  for (const id of resettable) control[id].value = atStart[id];
  for (const id of ["full", "faint", "filter"]) control[id].checked = atStart[id];
  setSteps(stepsOf(atStart.steps));
  control.aperture.value = firstCamera.aperture;
  control.focus.value = firstCamera.focus || Math.hypot(...sub(firstCamera.eye, firstCamera.target));
  control.animate.checked = false;
  camera = { ...firstCamera };
  showNumbers();
  change();
}

function save() {
  const copy = document.createElement("canvas"), to = copy.getContext("2d");
  copy.width = picture.width, copy.height = picture.height;
  to.drawImage(picture, 0, 0);
  to.globalAlpha = number("strength");
  if (!overlay.hidden) to.drawImage(overlay, 0, 0);
  copy.toBlob((blob) => {
    const link = document.createElement("a");
    link.href = URL.createObjectURL(blob);
    link.download = `${control.scene.value}-${control.mode.value}.png`;
    link.click();
    URL.revokeObjectURL(link.href);
  });
}

// The next of a list, from the last one to the first.
function next(id) {
  control[id].selectedIndex = (control[id].selectedIndex + 1) % control[id].length;
  control[id].dispatchEvent(new Event("change", { bubbles: true }));
}

// Larger or smaller by a quarter; below the least there is nothing.
function step(id, least, up) {
  const value = number(id);
  setNumber(id, up ? (value > 0 ? 1.25 * value : least) : value > 1.1 * least ? value / 1.25 : 0);
  change();
}

function move(how, ...by) {
  if (!camera) return;
  how(...by);
  change();
}

function fillScreen() {
  if (document.fullscreenElement) document.exitFullscreen();
  else picture.parentElement.requestFullscreen();
}
byId("fullscreen").hidden = !document.fullscreenEnabled;
byId("fullscreen").addEventListener("click", fillScreen);

const keys = {
  ArrowLeft: (e) => move(e.shiftKey ? pan : orbit, e.shiftKey ? -0.02 : -0.05, 0),
  ArrowRight: (e) => move(e.shiftKey ? pan : orbit, e.shiftKey ? 0.02 : 0.05, 0),
  ArrowUp: (e) => move(e.shiftKey ? pan : orbit, 0, e.shiftKey ? 0.02 : 0.05),
  ArrowDown: (e) => move(e.shiftKey ? pan : orbit, 0, e.shiftKey ? -0.02 : -0.05),
  i: () => move(zoom, 0.9),
  o: () => move(zoom, 1 / 0.9),
  m: () => next("mode"),
  p: () => next("packet"),
  t: () => next("path"),
  w: () => pick(...size().map((of) => Math.floor(of / 2))),
  c: () => next("over"),
  n: () => control.filter.click(),
  " ": () => control.animate.click(),
  "+": () => step("aperture", 0.01, true),
  "=": () => step("aperture", 0.01, true), // the same key without shift
  "-": () => step("aperture", 0.01, false),
  ".": () => step("shutter", 0.001, true),
  ",": () => step("shutter", 0.001, false),
  r: reset,
  s: save,
  f: fillScreen,
  h: () => { byId("keys-shown").open = !byId("keys-shown").open; },
};

picture.addEventListener("keydown", (event) => {
  const action = keys[event.key.length === 1 ? event.key.toLowerCase() : event.key];
  if (!action || event.ctrlKey || event.metaKey || event.altKey) return;
  event.preventDefault();
  action(event);
});

// Shows the walk of the packet that has a pixel, in the other tab. Numbers are rounded as floats, which they become.
function pick(x, y) {
  if (!camera || cameraScene !== wantedScene()) return; // what is seen is not what is wanted
  const side = number("packet");
  writeWaiting(); // so that one can go back here
  location.hash = hashOf(tidy({ ...WALK_DEFAULTS, scene: control.scene.value, size: side, x: x - (x % side), y: y - (y % side),
    view: "3d", steps: control.path.value === "paper" ? steps() : stepsOf("all"), picture: control.size.value,
    eye: pointText(camera.eye), target: pointText(camera.target), time: +number("time").toFixed(4), light: number("light") }));
}
export const modelShown = () => (isModel() ? model : null);

const pointers = new Map(); // those that are down: where, and with which button

picture.addEventListener("pointerdown", (event) => {
  picture.focus({ preventScroll: true });
  picture.setPointerCapture(event.pointerId);
  for (const one of pointers.values()) one.still = false; // two fingers click nothing
  pointers.set(event.pointerId, { x: event.clientX, y: event.clientY, sideways: event.button > 0 || event.shiftKey,
    still: pointers.size === 0 && event.button === 0 && !event.shiftKey && [event.clientX, event.clientY] });
});
picture.addEventListener("pointercancel", (event) => pointers.delete(event.pointerId));
picture.addEventListener("pointerup", (event) => {
  const { still } = pointers.get(event.pointerId) ?? {}, seat = picture.getBoundingClientRect(), [width, height] = size();
  pointers.delete(event.pointerId);
  const to = (at, of) => Math.max(0, Math.min(of - 1, Math.floor(at * of)));
  if (still && !document.fullscreenElement) pick(to((event.clientX - seat.left) / seat.width, width), to((event.clientY - seat.top) / seat.height, height));
});
picture.addEventListener("pointermove", (event) => {
  const at = pointers.get(event.pointerId), height = picture.clientHeight;
  if (!at || !camera) return;
  if (at.still && pointers.size === 1 && Math.hypot(event.clientX - at.still[0], event.clientY - at.still[1]) < 5) return;
  for (const one of pointers.values()) one.still = false;
  const right = (event.clientX - at.x) / height, up = (event.clientY - at.y) / height;
  const other = [...pointers.values()].find((one) => one !== at);
  const before = other && Math.hypot(at.x - other.x, at.y - other.y);
  at.x = event.clientX, at.y = event.clientY;
  if (other) {
    pan(-right / 2, up / 2);
    zoom(before / Math.max(1, Math.hypot(at.x - other.x, at.y - other.y)));
  } else if (at.sideways) pan(-right, up);
  else orbit(-Math.PI * right, Math.PI * up);
  change();
});
picture.addEventListener("wheel", (event) => {
  event.preventDefault();
  move(zoom, 0.9 ** (-event.deltaY / (event.deltaMode ? 3 : 100)));
}, { passive: false });
picture.addEventListener("contextmenu", (event) => event.preventDefault());

byId("reset").addEventListener("click", reset);
byId("save").addEventListener("click", save);
byId("controls").addEventListener("submit", (event) => event.preventDefault());
byId("controls").addEventListener("input", ({ target }) => {
  showNumbers();
  // A light of another size has everything built anew: not before the user has let go of it.
  if (target.type === "range" && target !== control.light && target !== control.strength) change();
});
byId("controls").addEventListener("change", ({ target }) => {
  showNumbers();
  if (target === control.strength) writeAddress();
  if ([control.strength, control.files, control.up].includes(target)) return;
  labelledAt = 0;
  if (target === control.steps && target.value !== "some") setSteps(stepsOf(target.value));
  if (stepBoxes.includes(target)) setSteps(steps());
  if (target === control.filter) show("filter-said", "");
  if (target === control.animate) ticked = performance.now();
  if (target === control.workers) {
    setWorkers(number("workers"));
    jobs = [];
  }
  if (target === control.size) {
    fit();
    jobs = [];
  }
  if (target === control.scene) {
    writeWaiting();
    writeNow("pushState"); // so that one can go back
    sayModel();
  }
  if (target.type !== "range" || target === control.light) change();
});

function resume() {
  ticked = shownAt = performance.now();
  feed();
}
document.addEventListener("visibilitychange", resume);
section.addEventListener("shown", resume);

// --- the beginning ---

const most = Math.min(navigator.hardwareConcurrency || 1, navigator.deviceMemory < 4 ? 2 : 8);
for (let i = 1; i <= most; i++) control.workers.add(new Option(i, i));
control.workers.value = Math.max(1, Math.min(most, Math.floor(Number(given.get("workers"))) || most));
if (!given.has("size"))
  control.size.value = picture.parentElement.clientWidth * devicePixelRatio < 600 ? "320x240" : "640x480";
setSteps(stepsOf(given.get("steps") ?? "all"));
atStart = Object.fromEntries(resettable.map((id) => [id, control[id].value]));
atStart.steps = stepsText(steps());
for (const id of ["full", "faint", "filter"]) atStart[id] = control[id].checked;
// The values of the page's text, but for what is chosen for this screen.
addressed = Object.fromEntries(ADDRESSED.map((id) => {
  const one = control[id], options = [...one.options ?? []];
  if (one.type === "checkbox") return [id, String(Number(one.defaultChecked))];
  return [id, one.options ? (options.find((option) => option.defaultSelected) ?? options[0]).value : one.defaultValue];
}));
addressed.size = given.has("size") ? "" : control.size.value;
ticked = performance.now();
fit();
showNumbers();
sayBuilding();
setWorkers(number("workers"));
