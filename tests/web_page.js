// Drives the web page in Chromium by keys, mouse and fingers, and looks at what it shows: pictures are those of build/render, the
// packet's walk is that of build/walk_events, controls have names, nothing is wider than the screen, and it is quick enough.
// With TIMES=report, as in CI, figures of time are told and fail nothing, and fewer frames are counted. Screenshots
// go to out/web-*.png. Chromium is PUPPETEER's, see web.sh.
// node tests/web_page.js http://localhost:8000 out/web build
"use strict";
const fs = require("fs");
const os = require("os");
const path = require("path");
const zlib = require("zlib");
const { execFileSync } = require("child_process");
const puppeteer = require(path.resolve(process.env.PUPPETEER));
const { courseLinks } = require("./web_links.js");

const [url, folder, bin] = process.argv.slice(2);
const SECONDS_TO_FIRST = 3, FRAMES_PER_SECOND = 15, MOST_BYTES = 1e6, MOST_GROWTH = 8e6;
let failures = 0;

function check(sentence, good, told = "") {
  console.log(`  ${good ? "ok    " : "FAILED"}  ${sentence}${told === "" ? "" : `: ${told}`}`);
  if (!good) failures++;
  return good;
}
// What other work of the machine may spoil is tried three times; where it is only reported, once.
const reported = process.env.TIMES === "report";
async function checkTime(sentence, measure, good, told) {
  let value;
  for (let i = 0; i < (reported ? 1 : 3); i++) if (good(value = await measure())) break;
  if (reported)
    return console.log(`  ${good(value) ? "ok    " : "missed"}  ${sentence}: ${told(value)} (reported, fails nothing)`);
  return check(sentence, good(value), told(value));
}

// --- what programs say ---

function native(scene, mode, size, options = []) { // checksum of a picture
  const told = execFileSync(`${bin}/render`, ["--scene", scene, "--mode", mode, "--size", size, "--no-count", "--no-progress",
    ...options], { encoding: "utf8", stdio: ["ignore", "pipe", "ignore"] });
  return /checksum ([0-9a-f]{16})/.exec(told)[1];
}
const EVENT = ["kind", "index", "child", "ray", "active", "tested", "tree", "packet", "depth", "nodes", "boxes", "boxVectors",
  "triangles", "triangleVectors", "triangle", "t"]; // the words of walk_event
const RAY_WORDS = 11;
function nativeWalk(...numbers) { // of scene kind side x y spacing morton steps: how many rays, and all events
  const lines = execFileSync(`${bin}/walk_events`, numbers.map(String), { encoding: "utf8" }).trim().split("\n")
    .map((line) => line.split(" ").map(Number));
  const of = (words) => lines.filter((line) => line.length === words);
  const events = of(EVENT.length).map((line) => Object.fromEntries(EVENT.map((name, i) => [name, line[i]])));
  for (const e of events) e.t = new Float32Array(Uint32Array.of(e.t).buffer)[0];
  return { rays: of(RAY_WORDS).length, events };
}

// --- pages ---

// In the page, before its scripts: notes what is asked of workers and what they answer. `frames` counts whole previews; `picture`
// is the latest first pass, `preview` the latest preview, `sums` what the canvas must show. With `hold` what workers say of scenes
// that they have opened waits in `held`: [who, what it says], the first worker being 0.
function record() {
  const noted = window.noted = { last: 0, frames: 0, pixels: 0, picture: null, preview: null, sums: null, keep: null, costs: null,
    opened: 0, hold: false, held: [] };
  const asked = new Map(), halved = new Map(); // halves of previews that are to be filtered, by their number
  let job = { id: 0 };
  function answered({ id, band, pixels, halves, cost }) {
    const settings = asked.get(`${id} ${band.y}`), { width, height } = settings;
    asked.delete(`${id} ${band.y}`);
    if (halves) {
      const parts = halved.get(id) ?? { settings, parts: [3, 3, 7, 7].map((n) => new Float32Array(n * width * height)) };
      halved.set(id, parts);
      let from = 0;
      for (const part of parts.parts) {
        const each = part.length / height;
        part.set(halves.subarray(from, from += each * band.rows), each * band.y);
      }
      return;
    }
    if (id < job.id) return;
    if (id > job.id) job = { id, settings, rows: 0, floats: new Float32Array(3 * width * height) };
    job.floats.set(pixels, 3 * band.y * width);
    job.rows += band.rows;
    const pass = settings.samples > 1;
    if (pass && settings.pass === 0 && job.rows === band.rows)
      noted.sums = { width, height, colour: new Float64Array(3 * width * height), count: new Uint8Array(height),
        cost: new Float64Array(width * height) };
    if (pass && noted.sums) {
      cost?.forEach((x, i) => noted.sums.cost[band.y * width + i] += x);
      pixels.forEach((x, i) => noted.sums.colour[3 * band.y * width + i] += x);
      for (let y = band.y; y < band.y + band.rows; y++) noted.sums.count[y]++;
    }
    if (noted.keep) noted.keep.push(Array.from(pixels.subarray(0, 20000)));
    if (job.rows < height) return;
    if (pass && cost) { // of whole passes
      const mean = Array.from(noted.sums.cost, (x) => x / (settings.pass + 1));
      noted.costs = { samples: 2 * (settings.pass + 1), mean, first: settings.pass ? noted.costs?.first : mean };
    }
    job.halves = halved.get(id)?.parts;
    halved.delete(id);
    if (!pass) noted.frames++, noted.pixels += width * height, noted.preview = job;
    else if (settings.pass === 0) noted.picture = job;
  }
  const threads = [];
  noted.letGo = () => {
    const [who, data] = noted.held.shift();
    threads[who].dispatchEvent(new MessageEvent("message", { data }));
  };
  window.Worker = class extends Worker {
    constructor(...of) {
      super(...of);
      const who = threads.push(this) - 1;
      this.addEventListener("message", (event) => {
        const { data } = event;
        if (data.band) answered(data);
        if (!data.opened || !event.isTrusted) return;
        noted.opened++;
        if (!noted.hold) return;
        event.stopImmediatePropagation();
        noted.held.push([who, data]);
      });
    }
    postMessage(message, ...more) {
      if (message.band) asked.set(`${message.id} ${message.band.y}`, message.band), noted.last = message.id;
      if (message.filter) asked.set(`${message.id} ${message.filter.y}`, halved.get(message.id).settings);
      super.postMessage(message, ...more);
    }
  };
  window.checksumOf = (floats) => { // FNV-1a over the bits
    let sum = 14695981039346656037n;
    for (const byte of new Uint8Array(floats.buffer)) sum = BigInt.asUintN(64, (sum ^ BigInt(byte)) * 1099511628211n);
    return sum.toString(16).padStart(16, "0");
  };
}

const complaints = []; // of all pages
const hosts = new Set();
let browser = null;

async function open(hash, { width = 1280, height = 900, touch = false, dark = false, tour = false } = {}) {
  const page = await browser.newPage();
  await page.setViewport({ width, height, hasTouch: touch });
  await page.emulateMediaFeatures([{ name: "prefers-color-scheme", value: dark ? "dark" : "light" },
    { name: "prefers-reduced-motion", value: tour ? "no-preference" : "reduce" }]);
  page.on("console", (message) => message.type() === "error" && complaints.push(message.text()));
  page.on("pageerror", (error) => complaints.push(error.message));
  page.on("requestfailed", (request) => complaints.push(`${request.url()}: ${request.failure().errorText}`));
  page.on("request", (request) => /^https?:/.test(request.url()) && hosts.add(new URL(request.url()).host));
  await page.evaluateOnNewDocument(record);
  await page.goto(`${url}/${hash}`);
  return page;
}
const text = (page, selector) => page.$eval(selector, (it) => it.textContent);
const label = (page, selector) => page.$eval(selector, (it) => it.getAttribute("aria-label"));

const eventShown = (page, number) => // of the walk; a pattern
  page.waitForFunction((of) => new RegExp(`^Event ${of} of`).test(document.querySelector(".walk-sentence").textContent),
    { timeout: 60000 }, number);

// The first pass, or preview, that is asked for after something has been done: {settings, checksum}.
async function pictureAfter(page, action, kind = "picture") {
  const before = await page.evaluate(() => noted.last);
  await action();
  await page.waitForFunction((id, which) => noted[which]?.id > id, { timeout: 240000, polling: 50 }, before, kind);
  return page.evaluate((which) => ({ settings: noted[which].settings, checksum: checksumOf(noted[which].floats) }), kind);
}
const firstPicture = async (page) => {
  await page.waitForFunction(() => noted.picture, { timeout: 240000, polling: 50 });
  return page.evaluate(() => ({ settings: noted.picture.settings, checksum: checksumOf(noted.picture.floats) }));
};

// How far the canvas is from what workers have answered, in codes: {differs: of the worst channel}. `scale` for a control.
const canvasDiffers = (page, scale = 1) => page.evaluate((factor) => {
  const { width, height, colour, count } = noted.sums, canvas = document.getElementById("picture");
  if (canvas.width !== width || canvas.height !== height || count.includes(0)) return 255;
  const shown = canvas.getContext("2d").getImageData(0, 0, width, height).data;
  let most = 0;
  for (let i = 0; i < width * height; i++)
    for (let c = 0; c < 3; c++) {
      const x = Math.min(1, factor * colour[3 * i + c] / count[Math.floor(i / width)]);
      const code = 255 * (x <= 0.0031308 ? 12.92 * x : 1.055 * x ** (1 / 2.4) - 0.055);
      most = Math.max(most, Math.abs(shown[4 * i + c] - code));
    }
  return most;
}, scale);

// Controls that a screen reader has no name for.
async function nameless(page) {
  const session = await page.createCDPSession();
  const { nodes } = await session.send("Accessibility.getFullAXTree");
  await session.detach();
  const roles = ["button", "checkbox", "combobox", "radio", "slider", "spinbutton", "tab", "textbox", "img", "application"];
  const controls = nodes.filter((node) => !node.ignored && roles.includes(node.role?.value));
  return { count: controls.length, without: controls.filter((node) => !node.name?.value.trim()).map((node) => node.role.value) };
}
const tooWide = (page) => page.evaluate(() => document.documentElement.scrollWidth > innerWidth);

async function checkLook(page, where) {
  const { count, without } = await nameless(page);
  check(`${where}: all controls have names`, count > 5 && without.length === 0, without.join(", ") || `${count} of them`);
  check(`${where}: nothing is wider than the screen`, !await tooWide(page));
}

// --- what is checked ---

async function pictures() {
  console.log("pictures");
  const page = await open("#scene=poolhall&mode=wrt&size=256x256");
  const wrt = await firstPicture(page), there = native("poolhall", "wrt", "256x256", ["--spp", "2"]);
  check("the pool hall has the floats of build/render", wrt.checksum === there, wrt.checksum);
  await page.waitForFunction(() => !document.getElementById("message").textContent);
  check("the canvas shows them", await canvasDiffers(page) < 1.01, `${(await canvasDiffers(page)).toFixed(2)} codes aside at most`);
  check("control: not a picture a tenth brighter", await canvasDiffers(page, 1.1) > 2);
  const said = await label(page, "#picture");

  await page.focus("#picture");
  const drt = await pictureAfter(page, () => page.keyboard.press("m"));
  check("M goes on to distribution ray tracing", await page.$eval("#mode", (it) => it.value) === "drt");
  const { aperture, focus, shutter, time } = drt.settings;
  check("it has the floats of build/render", time === 0 && drt.checksum === native("poolhall", "drt", "256x256",
    ["--spp", "2", "--aperture", aperture, "--focus", focus, "--shutter", shutter].map(String)), drt.checksum);
  const rcs = await pictureAfter(page, () => page.keyboard.press("m"));
  check("M goes on to ray casting, with the floats of build/render",
    rcs.checksum === native("poolhall", "rcs", "256x256", ["--spp", "2"]), rcs.checksum);
  check("control: another mode has other floats", new Set([wrt.checksum, drt.checksum, rcs.checksum]).size === 3);
  await page.waitForFunction((was) => document.getElementById("picture").ariaLabel !== was, { timeout: 60000 }, said);
  check("the picture's label has changed", true, await label(page, "#picture"));

  console.log("keys");
  let last = rcs.checksum;
  for (const [key, sentence, same] of [["ArrowLeft", "the left arrow orbits"], ["ArrowUp", "so does the one upwards"],
    ["i", "I goes nearer"], ["p", "P changes the packets, not the floats", true]]) {
    const one = await pictureAfter(page, () => page.keyboard.press(key));
    check(sentence, same ? one.checksum === last && one.settings.packet === 16 : one.checksum !== last);
    last = one.checksum;
  }
  const again = await pictureAfter(page, () => page.keyboard.press("r"));
  check("R brings back the first picture", again.checksum === wrt.checksum);
  await page.keyboard.press("c");
  await page.waitForFunction(() => !document.getElementById("overlay").hidden, { timeout: 60000 });
  check("C lays the error over it", true, await text(page, "#legend-what"));
  const frames = () => page.evaluate(() => noted.frames);
  await page.keyboard.press("r");
  await page.keyboard.press(" ");
  const began = await frames();
  await page.waitForFunction((n) => noted.frames > n + 3, { timeout: 60000 }, began);
  check("space starts the animation", Number(await page.$eval("#time", (it) => it.value)) > 0);
  await pictureAfter(page, () => page.keyboard.press(" "));
  check("space ends it", !await page.$eval("#animate", (it) => it.checked));
  await page.close();
}

// The latest preview, filtered as a whole by a module of its own, and in bands: how many floats differ from what workers
// made of it in bands. `margin`: rows around these bands, as many as the filter asks for if not named.
const filteredDiffers = (page, bands, margin) => page.evaluate(async (count, rowsAround) => {
  const { halves, floats, settings: { width, height } } = noted.preview, { moduleCode } = await import(`${location.origin}/page.js`);
  const code = await moduleCode();
  const module = await pktrt({ instantiateWasm: (imports, done) => (WebAssembly.instantiate(code, imports).then(done), {}) });
  const around = rowsAround ?? module._web_filter_margin(), out = new Float32Array(3 * width * height);
  for (let i = 0; i < count; i++) {
    const y = Math.round((height * i) / count), end = Math.round((height * (i + 1)) / count);
    const from = Math.max(0, y - around), to = Math.min(height, end + around), pixels = width * (to - from);
    let at = module._web_filter_room(pixels) >> 2;
    for (const half of halves) {
      const each = half.length / height;
      module.HEAPF32.set(half.subarray(each * from, each * to), at), at += each * (to - from);
    }
    module._web_filter_rows(width, to - from, y - from, end - y);
    at += pixels + 3 * width * (y - from);
    out.set(module.HEAPF32.subarray(at, at + 3 * width * (end - y)), 3 * width * y);
  }
  return out.filter((x, i) => x !== floats[i]).length;
}, bands, margin);

async function filter() {
  console.log("the filter while it moves");
  const page = await open("#scene=rtrt&mode=drt&size=256x256&full=1&filter=1");
  await page.evaluate(() => new Promise((done) => document.head.append(Object.assign(document.createElement("script"), { src: "pktrt.js", onload: done }))));
  await firstPicture(page);
  await page.evaluate(() => { // what stands on the canvas after a preview
    const { prototype } = CanvasRenderingContext2D, { drawImage } = prototype;
    prototype.drawImage = function draw(...of) {
      drawImage.apply(this, of);
      if (this.canvas.id === "picture") window.drawn = this.getImageData(0, 0, 256, 256).data;
    };
  });
  const press = (key) => () => page.focus("#picture").then(() => page.keyboard.press(key));
  const one = await pictureAfter(page, press("ArrowLeft"), "preview");
  check("a preview is two halves of one sample", one.settings.halves === true && one.settings.samples === 1);
  check("bands of workers have the floats of a filter of the whole", await filteredDiffers(page, 1) === 0);
  check("so have bands that are cut elsewhere", await filteredDiffers(page, 5) === 0);
  const seams = await filteredDiffers(page, 5, 0);
  check("control: bands without rows of their neighbours have seams", seams > 1000, `${seams} floats differ`);
  const differs = (of) => page.evaluate((filtered) => {
    const { halves: [a, b], floats } = noted.preview;
    let most = 0;
    for (let i = 0; i < a.length; i++) {
      const x = Math.min(1, filtered ? floats[i] : (a[i] + b[i]) / 2);
      const code = 255 * (x <= 0.0031308 ? 12.92 * x : 1.055 * x ** (1 / 2.4) - 0.055);
      most = Math.max(most, Math.abs(drawn[4 * Math.floor(i / 3) + i % 3] - code));
    }
    return most;
  }, of);
  await page.waitForFunction(() => window.drawn, { timeout: 60000 });
  check("the canvas shows the filtered preview", await differs(true) < 1.01, `${(await differs(true)).toFixed(2)} codes aside at most`);
  check("control: not the mean of its halves", await differs(false) > 5);

  await page.waitForFunction(() => noted.picture?.id > noted.preview.id, { timeout: 240000, polling: 50 });
  await page.waitForFunction(() => !noted.sums.count.includes(0) && Number(document.getElementById("samples").textContent) >= 4, { timeout: 240000 });
  check("at rest it shows the mean of passes, unfiltered", await canvasDiffers(page) < 1.01);
  check("control: the passes are not a picture a tenth brighter", await canvasDiffers(page, 1.1) > 2);

  await press("n")();
  const plain = await pictureAfter(page, press("ArrowLeft"), "preview");
  check("N ends it: a preview is one sample", !plain.settings.halves && !await page.$eval("#filter", (it) => it.checked));
  const hashHas = (pattern) => page.waitForFunction((it) => new RegExp(it).test(location.hash), { timeout: 20000 }, pattern)
    .then(() => true, () => false);
  check("the address says so", await hashHas("^(?!.*filter)"), await page.evaluate(() => location.hash));
  await press("n")();
  check("and when it is on", await hashHas("filter=1"));
  const wrt = await pictureAfter(page, () => page.select("#mode", "wrt"), "preview");
  check("Whitted's mode has no filter", !wrt.settings.halves);
  await page.select("#mode", "drt");

  await Promise.all(page.workers().map((worker) => worker.evaluate("module._web_filter_room = () => 0")));
  const lacking = await pictureAfter(page, press("ArrowLeft"), "preview");
  const sentence = await text(page, "#filter-said");
  check("a filter for which memory is lacking is off, and the page says so", !lacking.settings.halves &&
    /^The filter is off: there is not enough memory for the filter\.$/.test(sentence) && !await page.$eval("#filter", (it) => it.checked), sentence);
  await page.close();
  const off = await open("#scene=rtrt&mode=drt&size=256x256");
  await firstPicture(off);
  const first = await pictureAfter(off, () => off.focus("#picture").then(() => off.keyboard.press("ArrowLeft")), "preview");
  check("control: it is off at first, and says nothing", !first.settings.halves && await text(off, "#filter-said") === "");
  await off.close();
}

// Frames a second of the pool hall with the filter and without, which are told.
async function filterSpeed() {
  console.log("frames per second: the pool hall, distribution ray tracing");
  for (const on of [0, 1]) {
    const page = await open(`#scene=poolhall&mode=drt&size=640x480&filter=${on}`);
    await firstPicture(page);
    await orbiting(page, 3);
    const { frames, pixels, ms } = await orbiting(page, 3);
    console.log(`          ${on ? "filtered" : "not filtered"}: ${frames.toFixed(1)} of ${pixels} pixels, ${ms.toFixed(0)} ms of processors each`);
    await page.close();
  }
}

// Clicks a control of the first tab, whose panel may have to be opened before.
async function clickIn(page, control) {
  await page.$eval(control, (it) =>
    document.querySelector(`.panels [aria-controls="${it.closest("#controls > *").id}"][aria-expanded="false"]`)?.click());
  await page.click(control);
}

// On a phone the controls of both tabs are in panels, and those of the first tab beside the picture, too.
async function panels() {
  const phone = { width: 390, height: 844, touch: true }, desk = { width: 1280, height: 800, touch: true };
  const look = ["#mode=rcs&size=256x256", "look", 6], walk = ["#walk?view=3d&event=40", "walk", 4];
  for (const [size, [hash, section, count]] of [[phone, look], [phone, walk], [desk, look]]) {
    console.log(`panels, ${size.width} x ${size.height}`);
    const page = await open(hash, size);
    await (section === "walk" ? eventShown(page, "40") : firstPicture(page));
    const seen = () => page.$$eval(`#${section} :is(.panels, #controls, .walk-stage, .walk-side) :is(button, input, select, summary)`, (all) =>
      all.filter((it) => it.checkVisibility()).map((it) => [it.id || it.name || it.textContent || it.value, it.getBoundingClientRect()])
        .map(([name, { top, bottom }]) => [name, top >= 0 && bottom <= innerHeight]));
    const below = async () => (await seen()).filter(([, inside]) => !inside).map(([name]) => name);
    const buttons = await page.$$(`#${section} .panels button`);
    if (size === desk) {
      check(`${section}: beside the picture its first panel is open`, await buttons[0].evaluate((it) => it.ariaExpanded) === "true");
      await buttons[0].tap();
    }
    const closed = (await seen()).length;
    check(`${section}: it has a row of buttons`, buttons.length === count && (await below()).length === 0, (await below()).join(", "));
    for (const button of buttons) {
      await button.tap();
      const name = await button.evaluate((it) => it.textContent), out = await below();
      const shown = await page.$$eval(`#${section} .opened`, (all) => all.map((it) => it.id));
      check(`${section}: ${name} opens its panel, and no control is below the fold`, shown.join() === await button.evaluate((it) =>
        it.getAttribute("aria-controls")) && out.length === 0 && await button.evaluate((it) => it.ariaExpanded) === "true", out.join(", "));
      await page.screenshot({ path: `out/web-panel-${section}-${size.width}-${name.toLowerCase()}.png` });
      check(`${section}: nothing is wider than the screen`, !await tooWide(page));
    }
    await buttons[0].tap();
    check(`${section}: the first panel has controls of its own`, (await seen()).length > closed + 2);
    await page.evaluate((it) => document.getElementById(it).prepend(Object.assign(document.createElement("div"), { style: "height: 500px" })), section);
    check("control: where there is less room, some are below the fold", (await below()).length > 2);
    await page.keyboard.press("Escape");
    check(`${section}: Escape closes it`, (await page.$$(`#${section} .opened`)).length === 0 && (await seen()).length === closed);
    await page.close();
  }
}

// Drops files on the page, as a file manager does.
async function drop(page, paths) {
  const session = await page.createCDPSession(), [x, y] = await middle(page, "#picture");
  const data = { items: [], files: paths, dragOperationsMask: 1 };
  for (const type of ["dragEnter", "dragOver", "drop"]) await session.send("Input.dispatchDragEvent", { type, x, y, data });
  await session.detach();
}
const said = (page, pattern) => page.waitForFunction((of) => new RegExp(of).test(document.getElementById("model-said").textContent),
  { timeout: 60000 }, pattern.source).then(() => text(page, "#model-said"), () => text(page, "#model-said"));

async function files() {
  console.log("models that are dropped");
  const there = fs.mkdtempSync(path.join(os.tmpdir(), "web-files-")), at = (name) => path.join(there, name);
  const write = (name, ...lines) => fs.writeFileSync(at(name), lines.join("\n"));
  // A ball of rings that get closer: what is seen of it differs from every scene's picture.
  const ball = [], rings = 24, spokes = 48;
  for (let i = 0; i <= rings; i++)
    for (let k = 0; k < spokes; k++) {
      const [rise, turn] = [Math.PI * i / rings, 2 * Math.PI * k / spokes];
      ball.push(`v ${Math.sin(rise) * Math.cos(turn)} ${Math.cos(rise)} ${Math.sin(rise) * Math.sin(turn)}`);
    }
  ball.push("mtllib ball.mtl", "usemtl red");
  for (let i = 0; i < rings; i++)
    for (let k = 0; k < spokes; k++) {
      const [a, b] = [i * spokes + k + 1, i * spokes + (k + 1) % spokes + 1];
      ball.push(`f ${a} ${b} ${b + spokes} ${a + spokes}`);
    }
  write("ball.obj", ...ball);
  write("ball.mtl", "newmtl red", "Kd 0.8 0.1 0.05");
  write("wedge.stl", "solid", "facet", "outer loop", "vertex 0 0 0", "vertex 1 0 0", "vertex 0 0 1", "endloop", "endsolid");
  write("cut.stl", "solid", "facet", "outer loop", "vertex 0 0 0", "vertex 1 0 0");
  write("lines.obj", "v 0 0 0", "f 1 2 3");

  const page = await open("#scene=rtrt&mode=rcs&size=256x256"), asked = [];
  const scene = await firstPicture(page);
  page.on("request", (request) => asked.push(`${request.method()} ${new URL(request.url()).pathname}`));
  const refused = async (sentence, paths, pattern) => {
    const before = await page.evaluate(() => noted.last), name = await page.$eval("#scene", (it) => it.value);
    await drop(page, paths);
    const told = await said(page, pattern);
    await new Promise((done) => setTimeout(done, 200));
    check(sentence, pattern.test(told) && await page.$eval("#scene", (it) => it.value) === name, told);
    return [before, await page.evaluate(() => noted.last)];
  };
  await page.waitForFunction(() => document.getElementById("samples").textContent === "256", { timeout: 240000 });
  let [before, after] = await refused("a file that ends early is refused", [at("cut.stl")], /^cut\.stl is refused: it ends before/);
  check("nothing is drawn anew for it", before === after);
  await refused("so are two models", [at("ball.obj"), at("wedge.stl")], /two models/);
  await refused("and a folder", [there], /is no model that this page reads/);

  const grey = await pictureAfter(page, () => drop(page, [at("ball.obj")]));
  check("a dropped model is seen", grey.checksum !== scene.checksum, await said(page, /triangles/));
  check("the page says what it is", /^ball\.obj: 2,304 triangles; grey, for want of its materials: drop ball\.mtl/
    .test(await text(page, "#model-said")));
  check("it is a scene of its name", await page.$eval("#scene", (it) => it.selectedOptions[0].text) === "ball.obj");
  const distance = ({ eye, target }) => Math.hypot(...eye.map((x, a) => x - target[a]));
  check("the camera looks at its middle, from where all of it is seen", Math.abs(grey.settings.target[1] - 1) < 0.01 &&
    distance(grey.settings) > 1 / Math.sin(Math.PI / 8) && distance(grey.settings) < 3.2, `${distance(grey.settings).toFixed(2)} m away`);
  await page.waitForFunction(() => !document.getElementById("message").textContent);
  check("the canvas shows the floats", await canvasDiffers(page) < 1.01);
  const middleOf = () => page.$eval("#picture", (it) => [...it.getContext("2d").getImageData(128, 140, 1, 1).data]);
  const [r, g, b] = await middleOf();
  check("it is grey", Math.max(r, g, b) - Math.min(r, g, b) < 12 && r > 40, `${r} ${g} ${b}`);
  const red = await pictureAfter(page, () => drop(page, [at("ball.mtl"), at("ball.obj")]));
  check("with its materials it looks otherwise", red.checksum !== grey.checksum, await said(page, /1 material/));
  await page.waitForFunction(() => !document.getElementById("message").textContent);
  const [r2, g2] = await middleOf();
  check("it is red", r2 > 2 * g2, `${r2} ${g2}`);
  await page.waitForFunction(() => parseInt(document.getElementById("samples").textContent, 10) >= 16, { timeout: 60000 });
  await page.screenshot({ path: "out/web-files.png" });
  await refused("a model that is refused leaves this one", [at("lines.obj")], /line 2: a face names vertex 1 of 1|vertex 2 of 1/);
  // An image: of one colour, then cut in two.
  const image = await page.evaluate(() => {
    const canvas = Object.assign(document.createElement("canvas"), { width: 2000, height: 500 }), pen = canvas.getContext("2d");
    pen.fillStyle = "#00c000";
    pen.fillRect(0, 0, 2000, 500);
    return canvas.toDataURL().replace(/^.*,/, "");
  });
  write("flat.obj", "mtllib flat.mtl", "v -1 0 0", "v 1 0 0", "v 1 2 0", "v -1 2 0", "vt 0 0", "vt 1 0", "vt 1 1", "vt 0 1",
    "usemtl flat", "f 1/1 2/2 3/3 4/4");
  write("flat.mtl", "newmtl flat", "Kd 1 1 1", "map_Kd green.png");
  const flat = ["flat.mtl", "flat.obj", "green.png"].map(at);
  for (const [sentence, bytes, told, good] of [
    ["an image is seen", Buffer.from(image, "base64"), /^flat\.obj: 2 triangles, 1 material$/, ([x, y]) => y > 100 && y > 3 * x],
    ["one that ends early is not", Buffer.from(image, "base64").subarray(0, 200), /; not used: textures$/, ([x, y]) => Math.abs(x - y) < 12]]) {
    fs.writeFileSync(at("green.png"), bytes);
    await pictureAfter(page, () => drop(page, flat));
    await page.waitForFunction(() => !document.getElementById("message").textContent);
    const colour = await middleOf();
    check(sentence, told.test(await text(page, "#model-said")) && good(colour), `${await text(page, "#model-said")}: ${colour.slice(0, 3)}`);
  }
  const again1 = await pictureAfter(page, () => drop(page, [at("ball.mtl"), at("ball.obj")]));
  check("the first model, dropped again, is the picture of before", again1.checksum === red.checksum);
  const room = (code) => Promise.all(page.workers().map((one) => one.evaluate(code)));
  await room("room = module._web_model_room, module._web_model_room = () => 0");
  const stays = await pictureAfter(page, () => drop(page, [at("wedge.stl")]));
  check("one for which memory is lacking, too", stays.checksum === red.checksum &&
    await page.$eval("#scene", (it) => it.selectedOptions[0].text) === "ball.obj", await said(page, /^wedge\.stl is refused: there is not/));
  await room("module._web_model_room = room");
  const wider = await pictureAfter(page, () => page.$eval("#light", (it) => {
    it.value = 4;
    it.dispatchEvent(new Event("change", { bubbles: true }));
  }));
  check("a wider light is another picture", wider.checksum !== red.checksum);

  // By keys alone: to the button, whose dialog the browser fills.
  await page.focus("#scene");
  await page.keyboard.press("Tab");
  check("Tab comes to the button that chooses files", await page.evaluate(() => document.activeElement.id) === "files");
  const chosen = await pictureAfter(page, async () => {
    let chooser = null; // a busy machine may lose it
    for (let i = 0; i < 3 && !chooser; i++)
      [chooser] = await Promise.all([page.waitForFileChooser({ timeout: 9000 }).catch(() => null), page.keyboard.press("Enter")]);
    await chooser.accept([at("wedge.stl")]);
  });
  check("a file that is chosen is seen", chosen.checksum !== wider.checksum, await said(page, /^wedge\.stl: 1 triangle$/));
  const turned = await pictureAfter(page, () => page.click("#up"));
  check("with its y axis up it is another picture", turned.checksum !== chosen.checksum);
  await page.focus("#picture");
  await page.keyboard.press("w");
  await eventShown(page, "1");
  check("a packet walks in a model, too", await page.$eval("[name=walk-scene]", (it) => it.selectedOptions[0].text) === "wedge.stl" &&
    /^64 rays/.test(await text(page, ".walk-count")), await text(page, ".walk-count"));
  await page.click("#tab-look");
  const again = await pictureAfter(page, () => page.select("#scene", "rtrt"));
  check("a scene of the page comes back, and the sentence goes", again.settings.time === 0 && await text(page, "#model-said") === "");
  const shown = () => page.$eval("#scene", (it) => it.selectedOptions[0].text);
  await pictureAfter(page, () => page.goBack());
  check("back leads to the model", await shown() === "wedge.stl", await shown());
  await pictureAfter(page, () => page.goForward());
  check("forward to the scene after it", await shown() === "Figures (rtrt)", await shown());
  await checkLook(page, "the page with a model");
  check("nothing but the page's own scripts is asked for", asked.every((it) => /^GET \/(reader|files|worker|open|pktrt)\.js$/.test(it)),
    [...new Set(asked)].join(", "));
  await page.close();
  const narrow = await open("#mode=rcs", { width: 390, height: 844, touch: true });
  await firstPicture(narrow);
  await pictureAfter(narrow, () => drop(narrow, [at("ball.mtl"), at("ball.obj")]));
  await checkLook(narrow, "390 wide");
  await narrow.screenshot({ path: "out/web-files-390.png", fullPage: true });
  await narrow.close();
  fs.rmSync(there, { recursive: true });
}

async function drag(page, from, by, fingers = 1) { // by touch; a second finger stays where it is
  const session = await page.createCDPSession();
  const at = (i) => [{ x: from[0] + i * by[0], y: from[1] + i * by[1], id: 1 },
    ...(fingers > 1 ? [{ x: from[0] - 60, y: from[1], id: 2 }] : [])];
  await session.send("Input.dispatchTouchEvent", { type: "touchStart", touchPoints: at(0) });
  for (let i = 1; i <= 6; i++) await session.send("Input.dispatchTouchEvent", { type: "touchMove", touchPoints: at(i / 6) });
  await session.send("Input.dispatchTouchEvent", { type: "touchEnd", touchPoints: [] });
  await session.detach();
}
async function middle(page, selector) {
  const box = await (await page.$(selector)).boundingBox();
  return [box.x + box.width / 2, box.y + box.height / 2];
}

async function touch() {
  console.log("touch, 360 wide");
  const page = await open("#scene=rtrt", { width: 360, height: 760, touch: true });
  const first = await firstPicture(page), at = await middle(page, "#picture");
  const turned = await pictureAfter(page, () => drag(page, at, [60, 20]));
  const distance = ({ eye, target }) => Math.hypot(...eye.map((x, a) => x - target[a]));
  check("a finger orbits", turned.checksum !== first.checksum && `${turned.settings.target}` === `${first.settings.target}` &&
    Math.abs(distance(turned.settings) / distance(first.settings) - 1) < 1e-3);
  const near = await pictureAfter(page, () => drag(page, at, [60, 0], 2));
  check("two go nearer", distance(near.settings) < 0.7 * distance(turned.settings),
    `${distance(turned.settings).toFixed(2)} m, then ${distance(near.settings).toFixed(2)} m`);
  check("the canvas shows that", await canvasDiffers(page) < 1.01);
  await drag(page, at, [0, 0], 2);
  check("two that stay still click nothing", await page.$eval("#walk", (it) => it.hidden));
  check("the page has not been moved by it", await page.evaluate(() => scrollY) === 0);
  await checkLook(page, "the picture");
  await page.screenshot({ path: "out/web-360.png", fullPage: true });
  await page.tap("#tab-walk");
  await eventShown(page, "1");
  await page.tap("[data-do=step]");
  check("a tap steps on in the walk", /^Event 2 of/.test(await text(page, ".walk-sentence")));
  const looks = () => page.$eval(".walk-view", (it) => it.toDataURL());
  const before = await looks();
  await page.evaluate(() => scrollTo(0, 0));
  await drag(page, await middle(page, ".walk-view"), [50, 0]);
  check("a finger moves the boxes", await looks() !== before);
  await checkLook(page, "the walk");
  await page.screenshot({ path: "out/web-walk-360.png", fullPage: true });
  await page.evaluate(() => document.body.append(document.createElement("button"), Object.assign(document.createElement("div"),
    { style: "width: 400px; height: 1px" })));
  check("control: a button without a name is noticed", (await nameless(page)).without.join() === "button");
  check("control: what is too wide is noticed", await tooWide(page));
  await page.close();
}

async function wide() {
  console.log("1920 wide");
  const page = await open("#scene=conference&mode=rcs", { width: 1920, height: 1080 });
  await firstPicture(page);
  await page.waitForFunction(() => document.getElementById("rmse").textContent !== "-", { timeout: 60000 });
  await checkLook(page, "the picture");
  await page.screenshot({ path: "out/web-1920.png" });
  await page.click("#tab-walk");
  await eventShown(page, "1");
  await checkLook(page, "the walk");
  await page.screenshot({ path: "out/web-walk-1920.png", fullPage: true });
  await page.close();
}

// What the page must say of a program's events, in its own words.
const sentences = (page, scene, { rays, events }, shadow) => page.evaluate(async (of, list, n, dark) => {
  const walk = await import(`${location.origin}/walk_data.js`), { moduleCode } = await import(`${location.origin}/page.js`);
  const code = await moduleCode();
  const module = await pktrt({ instantiateWasm: (imports, done) => (WebAssembly.instantiate(code, imports).then(done), {}) });
  const world = walk.makeWorld(module, of);
  return list.map((e, i) => `Event ${i + 1} of ${list.length}. ${walk.sentence(e, world, n, dark)}`);
}, scene, events, rays, shadow);

async function walk() {
  console.log("the packet's walk");
  const page = await open("#walk"), said = () => text(page, ".walk-sentence");
  await eventShown(page, "1");
  const there = nativeWalk(0, 0, 8, 96, 32, 1, 0, 63), must = await sentences(page, "course", there, false);
  const steps = [await said()], labels = new Set([await label(page, ".walk-view")]);
  for (let i = 1; i < must.length; i++) {
    await page.keyboard.press("ArrowRight");
    steps.push(await said());
    labels.add(await label(page, ".walk-view"));
  }
  check("step by step it says the events of build/walk_events", must.length > 20 && steps.join("\n") === must.join("\n"),
    `${must.length} events, ${there.rays} rays`);
  check("control: those of a packet beside it are others",
    (await sentences(page, "course", nativeWalk(0, 0, 8, 104, 32, 1, 0, 63), false)).join("\n") !== steps.join("\n"));
  check("the canvas has a label for each", labels.size === must.length);
  const work = await page.$$eval(".walk-counters tbody td:first-of-type", (cells) => cells.map((it) => it.textContent));
  const end = there.events[there.events.length - 1];
  check("the table counts what the program counts", work.slice(0, 5).join() ===
    [end.nodes, end.boxes, end.boxVectors, end.triangles, end.triangleVectors].join(), work.slice(0, 5).join(", "));
  await page.keyboard.press("ArrowLeft");
  check("the left arrow goes back", await said() === must[must.length - 2]);
  await page.keyboard.press("Home");
  check("Home goes to the first", await said() === must[0]);
  await page.keyboard.press(" ");
  await eventShown(page, "([3-9]|[1-9][0-9]+)");
  await page.keyboard.press(" ");
  check("space plays and pauses it", await page.$eval("[data-do=play]", (it) => it.ariaPressed) === "false");

  // The address says what is shown, and shows what it says.
  await page.evaluate(() => { location.hash = "#walk?scene=boxes&packet=shadow&size=16&x=80&y=60&spacing=4&steps=2007&event=40"; });
  const shadow = await sentences(page, "boxes", nativeWalk(1, 1, 16, 80, 60, 4, 0, 35), true);
  await page.waitForFunction((it) => document.querySelector(".walk-sentence").textContent === it, { timeout: 60000 }, shadow[39])
    .catch(() => {});
  check("an address leads to an event of shadow rays among boxes", await said() === shadow[39], await said());
  await page.keyboard.press("End");
  check("End goes to the last", await said() === shadow[shadow.length - 1], await said());
  await page.evaluate(() => { location.hash = "#walk?view=3d&size=16&spacing=4&event=61"; });
  await eventShown(page, "61");
  await page.screenshot({ path: "out/web-walk.png", fullPage: true });
  await page.close();
  const dark = await open("#walk", { dark: true });
  await eventShown(dark, "1");
  await dark.screenshot({ path: "out/web-walk-dark.png" });
  await dark.close();
}

// The tour of the second tab, and whether its controls are in sight at once.
async function tour() {
  console.log("the tour");
  const inSight = (page, selector) => page.$$eval(selector, (all) => all.filter((it) => it.offsetParent &&
    it.getBoundingClientRect().bottom > innerHeight).map((it) => it.dataset.do || it.name || it.value || it.className));
  const captions = (page) => page.evaluate(() => new Promise((done) => {
    const told = [], caption = document.querySelector(".walk-caption");
    const look = setInterval(() => {
      if (!caption.hidden && caption.textContent && told[told.length - 1] !== caption.textContent) told.push(caption.textContent);
      if (caption.hidden) clearInterval(look), done(told);
    }, 50);
  }));
  for (const [width, height, controls] of [[1280, 800, "#walk :is(.walk-stage, .walk-side) :is(button, input, select, summary)"],
    [390, 844, ".walk-stage :is(button, input, select, summary)"]]) {
    const page = await open("#mode=rcs&size=256x256", { width, height, touch: width < 500, tour: true });
    await firstPicture(page);
    await page.click("#tab-walk");
    await page.waitForFunction(() => !document.querySelector(".walk-caption").hidden, { timeout: 60000 });
    check(`${width} x ${height}: the tab begins in 3D, with a tour`, await page.$eval("[name=walk-view]:checked", (it) => it.value) === "3d",
      await text(page, ".walk-caption"));
    await page.screenshot({ path: `out/web-tour-${width}.png` });
    const below = await inSight(page, controls);
    check(`${width} x ${height}: no control is below the fold`, below.length === 0, below.join(", "));
    if (width === 1280) {
      await page.evaluate(() => document.querySelector(".walk-stage").prepend(Object.assign(document.createElement("div"), { style: "height: 400px" })));
      check("control: where there is less room, some are", (await inSight(page, controls)).length > 5);
    }
    const looks = () => page.$eval(".walk-view", (it) => it.toDataURL()), before = await looks();
    await new Promise((done) => setTimeout(done, 1000));
    check("it moves by itself", await looks() !== before);
    if (width === 390) await page.touchscreen.tap(...await middle(page, ".walk-view"));
    else await page.mouse.click(...await middle(page, ".walk-view"));
    check("the first touch ends it", await page.$eval(".walk-caption", (it) => it.hidden));
    const after = await looks();
    await new Promise((done) => setTimeout(done, 700));
    check("then it is still", await looks() === after);
    if (width === 1280) {
      await page.click("[data-do=tour]");
      const told = await captions(page), said = await text(page, ".walk-sentence");
      check("it can be played again, to its end", told.length === 4 && /^Event (\d+) of \1\. The walk is over/.test(said), told.join(" | "));
      const count = (words) => Number(words.replace(/,/g, "")), [, took, all] = /took ([\d,]+) tests .* taken ([\d,]+)\./.exec(told[3]).map(count);
      const events = nativeWalk(0, 0, 8, 96, 32, 1, 0, 63).events, end = events[events.length - 1];
      check("what it says at the end is so", took === end.triangles && all > 10 * took && all % 64 === 0, `${took} of ${all}`);
      await page.click("[data-do=tour]");
      await page.keyboard.press("Escape");
      check("a key ends it", await page.$eval(".walk-caption", (it) => it.hidden));
    }
    await page.close();
  }
  const calm = await open("#walk");
  await eventShown(calm, "1");
  check("control: whoever asks for less motion has no tour", await calm.$eval(".walk-caption", (it) => it.hidden) &&
    await calm.$eval("[name=walk-view]:checked", (it) => it.value) === "3d");
  await calm.close();
  const page = await open("#walk?steps=none&event=142", { tour: true });
  await eventShown(page, "142");
  check("control: nor has an address that names a state", await page.$eval(".walk-caption", (it) => it.hidden));
  await page.close();
}

// Walks that are not the usual one, or cannot be.
async function strange() {
  console.log("strange walks");
  const walk = async (hash) => {
    const page = await open(hash);
    await eventShown(page, "\\d+");
    return page;
  };
  for (const [hash, sentence] of [["#walk?packet=mirror", /^These 64 rays start where a mirror is seen\. /], ["#walk?size=1", /^This ray starts at an eye/],
    ["#walk?spacing=3", /through pixels that are 3 apart\. /]]) {
    const page = await walk(hash);
    await page.click("[data-do=tour]");
    await page.waitForFunction(() => !document.querySelector(".walk-caption").hidden, { timeout: 20000 });
    const said = await text(page, ".walk-caption");
    check(`the tour says of ${hash} what is true of it`, sentence.test(said), said);
    await page.close();
  }
  const page = await walk("#walk?event=20");
  await page.select("[name=walk-scene]", "boxes");
  await eventShown(page, "1");
  check("another scene is walked from its first event on", true);
  await page.close();
  for (const [hash, good] of [["#walk?scene=poolhall&size=16&spacing=12&picture=100x100", /[?&]spacing=6\b/],
    ["#walk?scene=poolhall&eye=1,2,3&target=1,2,3&event=2", /^(?!.*eye=)/], ["#walk?steps=toString&event=2", /steps=none/]]) {
    const odd = await walk(hash);
    await odd.click("[data-do=step]");
    await odd.waitForFunction((of) => location.hash !== of, { timeout: 20000 }, hash);
    const now = await odd.evaluate(() => location.hash);
    check(`${hash} becomes one that can be`, good.test(now) && !/[xy]=-/.test(now), now);
    await odd.close();
  }
  const gone = await open("#walk?scene=model&x=300&y=200");
  await gone.waitForFunction(() => /Event 1 of/.test(document.querySelector(".walk-sentence").textContent), { timeout: 60000 });
  const said = await text(gone, ".walk-sentence");
  check("a model that is gone is said to be", /^The model has gone/.test(said), said);
  await gone.close();
}

const heldIs = (page, who) => page.waitForFunction((of) => `${noted.held.map((it) => it[0])}` === of, { timeout: 60000, polling: 50 }, who);
const letGo = (page) => page.evaluate(() => noted.letGo());

// What is done while another scene is on its way, or at once before something else.
async function hurry() {
  console.log("what is done in a hurry");
  const page = await open("#mode=rcs&size=256x256&workers=-3"), message = () => text(page, "#message"), hash = () => page.evaluate(() => location.hash);
  check("a number of workers that there cannot be does not stop the page", await firstPicture(page).then(() => true, () => false), await message());
  await page.waitForFunction(() => noted.opened > 0 && document.getElementById("message").textContent === "", { timeout: 60000 });
  await page.evaluate(() => { noted.hold = true; });
  await page.select("#scene", "conference");
  await heldIs(page, "0");
  check("while a scene is built, its name is said", await message() === "Building: Conference room", await message());
  await page.mouse.click(...await middle(page, "#picture"));
  check("a click on the picture of before leads to no walk", !/^#walk/.test(await hash()), await hash());
  const before = await page.evaluate(() => noted.last);
  await page.select("#scene", "poolhall");
  check("of the scene that is there nothing is said any more", await message() === "", await message());
  await letGo(page);
  await heldIs(page, "0");
  await letGo(page);
  await page.waitForFunction((id) => noted.picture?.id > id, { timeout: 240000, polling: 50 }, before);
  check("nor when its picture has come again", await message() === "", await message());
  await page.evaluate(() => { noted.hold = false; });
  await page.mouse.click(...await middle(page, "#picture"));
  check("control: then a click leads to a walk", /^#walk/.test(await hash()), await hash());
  await page.evaluate(() => history.back());
  await page.waitForFunction(() => !document.getElementById("look").hidden, { timeout: 60000 });
  const orbited = (then) => page.evaluate((id) => {
    document.getElementById("picture").dispatchEvent(new KeyboardEvent("keydown", { key: "ArrowLeft" }));
    document.getElementById(id).click();
  }, then);
  await orbited("tab-walk");
  await page.evaluate(() => history.back());
  await page.waitForFunction(() => !document.getElementById("look").hidden, { timeout: 60000 });
  check("a view that is left at once stays in the address", /eye=/.test(await hash()), await hash());
  await page.close();
}

// A second worker opens a scene while the first has its picture, and is done when another scene is looked at.
async function late() {
  console.log("a worker that is late");
  const page = await open("#mode=rcs&size=256x256&workers=2");
  await firstPicture(page);
  if (await page.$eval("#workers", (it) => it.value) !== "2") {
    console.log("          this machine has one worker, which is never late");
    return page.close();
  }
  await page.waitForFunction(() => noted.opened === 2, { timeout: 60000, polling: 50 });
  await page.evaluate(() => { noted.hold = true; });
  await pictureAfter(page, async () => {
    await page.select("#scene", "rtrt");
    await heldIs(page, "0");
    await letGo(page);
  });
  await heldIs(page, "1");
  await page.select("#scene", "conference");
  await heldIs(page, "1,0");
  check("control: they tell of two scenes", await page.evaluate(() => `${noted.held[0][1].camera}` !== `${noted.held[1][1].camera}`));
  const seen = await pictureAfter(page, async () => {
    await letGo(page);
    await letGo(page);
  });
  const alone = await open("#scene=conference&mode=rcs&size=256x256");
  check("the scene that is wanted is seen as it is at first", seen.checksum === (await firstPicture(alone)).checksum);
  await alone.close();
  await page.close();
}

// What is seen is in the address, and the browser's button goes back.
async function addresses() {
  console.log("addresses");
  const page = await open("#mode=rcs&size=256x256"), hash = (of = page) => of.evaluate(() => location.hash);
  const hashHas = (pattern, of = page) => of.waitForFunction((it) => new RegExp(it).test(location.hash), { timeout: 60000 }, pattern.source)
    .then(() => true, () => false);
  const first = await firstPicture(page);
  check("an address that one comes with stays as it is", await hash() === "#mode=rcs&size=256x256");
  await page.focus("#picture");
  for (const key of ["ArrowLeft", "i"]) await pictureAfter(page, () => page.keyboard.press(key));
  const seen = await pictureAfter(page, () => page.select("#path", "paper"));
  check("it follows the camera and the controls", await hashHas(/^#mode=rcs&size=256x256&path=paper.*eye=.*&target=/), await hash());
  const moved = await hash(), again = await open(moved);
  check("opened anew it shows the same picture, bit for bit", (await firstPicture(again)).checksum === seen.checksum);
  check("control: another one than at first", seen.checksum !== first.checksum);
  await again.close();

  const other = await pictureAfter(page, () => page.select("#scene", "rtrt"));
  check("another scene has an address of its own", await hashHas(/^#scene=rtrt&mode=rcs/) && other.checksum !== seen.checksum, await hash());
  const back = await pictureAfter(page, () => page.goBack());
  check("back leads to the scene of before, as it was seen", await hash() === moved && back.checksum === seen.checksum);
  check("control: the controls are those of before, too", await page.$eval("#scene", (it) => it.value) === "poolhall" &&
    await page.$eval("#path", (it) => it.value) === "paper");
  const forward = await pictureAfter(page, () => page.goForward());
  check("forward leads to the other one", forward.checksum === other.checksum && await hashHas(/^#scene=rtrt/));
  await pictureAfter(page, () => page.goBack());

  await page.click("#tab-walk");
  await eventShown(page, "1");
  await page.click("[data-do=last]");
  check("the other tab has an address, too", await hashHas(/^#walk\?.*event=/), await hash());
  const tab = () => page.$eval("[role=tab][aria-selected=true]", (it) => it.id), last = await text(page, ".walk-sentence");
  const shows = (name) => page.waitForFunction((it) => !document.getElementById(it).hidden, { timeout: 60000 }, name).then(() => true, () => false);
  await page.evaluate(() => history.back());
  check("back leads to the first tab", await shows("look") && await tab() === "tab-look" && await hash() === moved);
  await page.evaluate(() => history.forward());
  check("forward to the walk, where it was", await shows("walk") && await text(page, ".walk-sentence") === last);
  await page.click("#tab-look");
  check("a tab that is chosen brings its address", await hash() === moved);
  await page.evaluate(() => { location.hash = "#scene=rtrt&mode=drt"; });
  check("an address that is typed is followed", await page.waitForFunction(() => document.getElementById("mode").value === "drt" &&
    document.getElementById("scene").value === "rtrt", { timeout: 60000 }).then(() => true, () => false));
  await page.close();
}

async function fullscreen() {
  console.log("fullscreen");
  const page = await open("#scene=rtrt&mode=rcs&size=320x240&over=boxes");
  await firstPicture(page);
  const sizes = (selector) => page.$eval(selector, (it) => [it.getBoundingClientRect(), innerWidth, innerHeight]
    .flatMap((x) => (typeof x === "number" ? x : [x.x, x.y, x.width, x.height])));
  const fills = ([x, y, width, height, across, down], ratio) => (Math.abs(width - across) < 2 || Math.abs(height - down) < 2) && width < across + 2 &&
    height < down + 2 && (!ratio || Math.abs(width / height - ratio) < 0.02) && Math.abs(2 * x + width - across) < 3 && Math.abs(2 * y + height - down) < 3;
  const within = (full) => page.waitForFunction((it) => Boolean(document.fullscreenElement) === it, { timeout: 20000 }, full).then(() => true, () => false);
  check("control: at first the picture does not fill the screen", !fills(await sizes("#picture"), 4 / 3));
  await clickIn(page, "#fullscreen");
  check("the button fills the screen with the picture", await within(true) && await page.waitForFunction(() => document.fullscreenElement &&
    document.getElementById("picture").getBoundingClientRect().height > 0.9 * innerHeight, { timeout: 20000 }).then(() => true, () => false) &&
    fills(await sizes("#picture"), 4 / 3), `${await sizes("#picture")}`);
  check("what is laid over it lies over it", `${await sizes("#overlay")}` === `${await sizes("#picture")}`);
  await page.screenshot({ path: "out/web-fullscreen.png" });
  await page.focus("#picture");
  await page.keyboard.press("f");
  check("F ends it", await within(false) && !fills(await sizes("#picture"), 4 / 3));
  await page.click("#tab-walk");
  await eventShown(page, "1");
  await page.click("[data-do=full]");
  check("the walk can fill it, too", await within(true) && await page.waitForFunction(() => {
    const { width, height } = document.querySelector(".walk-view").getBoundingClientRect();
    return width === innerWidth && height > innerHeight - 2;
  }, { timeout: 20000 }).then(() => true, () => false));
  await page.evaluate(() => document.exitFullscreen());
  await page.close();
}

// A click on the picture: the packet of that pixel, in that scene as it is seen, goes down the tree of the other tab.
async function pick() {
  console.log("from a pixel to its walk");
  const page = await open("#scene=rtrt&mode=rcs&size=640x480&time=0.25&packet=4");
  await firstPicture(page);
  await page.focus("#picture");
  const { settings } = await pictureAfter(page, () => page.keyboard.press("ArrowLeft"));
  const box = await (await page.$("#picture")).boundingBox(), [x, y] = [335, 270]; // a pixel, in the middle of which one clicks
  await page.mouse.click(box.x + (x + 0.5) * box.width / 640, box.y + (y + 0.5) * box.height / 480);
  await eventShown(page, "1");
  const hash = await page.evaluate(() => location.hash), named = new URLSearchParams(hash.slice(6));
  const numbers = (name) => named.get(name).split(",").map(Number);
  check("a click opens the walk of the packet that has the pixel", named.get("x") === "332" && named.get("y") === "268" && named.get("size") === "4" &&
    named.get("picture") === "640x480", hash);
  const near = (a, b) => a.every((v, i) => Math.abs(v - b[i]) < 1e-4);
  check("it is seen from where the picture is", near(numbers("eye"), settings.eye) && near(numbers("target"), settings.target));
  const events = (at) => nativeWalk(2, 0, 4, at, 268, 1, 0, 63, 2, 640, 480, settings.time, ...numbers("eye"), ...numbers("target")).events;
  const kinds = await page.evaluate((of) => {
    const said = [];
    for (let i = 0; i < of; i++) {
      said.push(document.querySelector(".walk-sentence").textContent);
      document.body.dispatchEvent(new KeyboardEvent("keydown", { key: "ArrowRight", bubbles: true }));
    }
    return said;
  }, events(332).length);
  // What build/walk_events says of it, by what each sentence must have: what it is about, and how many rays are tested.
  const must = (e) => [/is opened/, /the first active one/, /interval/, /four planes/, /first to hit/, /misses it/, /is met by/, /hits triangle/,
    /all its rays/, /range ends/, /meets? the triangles/, /is over/][e.kind];
  const same = (list) => list.length === kinds.length && list.every((e, i) => must(e).test(kinds[i]) && (e.kind !== 7 || kinds[i].includes(`triangle ${e.triangle} `)));
  check("it is the walk of build/walk_events in that scene", events(332).length > 20 && same(events(332)), `${kinds.length} events`);
  check("control: not that of a packet further on", !same(events(372)));
  await page.waitForFunction((n) => location.hash.includes(`event=${n}&`), { timeout: 60000 }, kinds.length);
  const opens = await page.evaluate(() => location.hash);
  const drawn = () => page.$eval(".walk-view", (it) => it.toDataURL());
  await page.click(".walk-more summary");
  const before = await drawn();
  await page.click("[name=walk-mesh]");
  check("what the camera sees is drawn around it", before !== await drawn());
  await page.click("[name=walk-mesh]");
  check("control: with it the view is as before", before === await drawn());
  await page.click(".walk-more summary");
  await checkLook(page, "the walk in a scene of the first tab");
  await page.screenshot({ path: "out/web-pick.png", fullPage: true });
  await page.select("[name=walk-packet]", "mirror");
  await eventShown(page, "[0-9]+");
  check("its reflections walk, too", /[1-9][0-9]* rays?,/.test(await text(page, ".walk-count")), await text(page, ".walk-count"));
  await page.close();
  const again = await open(opens);
  await eventShown(again, "[0-9]+");
  check("the address leads there again", (await text(again, ".walk-sentence")) === kinds[kinds.length - 1], opens);
  await again.close();
  const dragged = await open("#scene=rtrt&mode=rcs&size=256x256");
  await firstPicture(dragged);
  const [cx, cy] = await middle(dragged, "#picture");
  await dragged.mouse.move(cx, cy);
  await dragged.mouse.down();
  await dragged.mouse.move(cx + 40, cy + 5, { steps: 4 });
  await dragged.mouse.up();
  check("control: who drags stays in the picture", await dragged.$eval("#walk", (it) => it.hidden));
  await pictureAfter(dragged, () => dragged.click("#animate"), "preview");
  await dragged.focus("#picture");
  await dragged.keyboard.press("w");
  await eventShown(dragged, "1");
  check("W leads to the packet in the middle", /x=128&y=128/.test(await dragged.evaluate(() => location.hash)));
  await dragged.close();
}

// Opens a link of the course: whether the page says its title in sight, with controls and address as the link has them.
async function leads({ hash, title }, timeout = 20000) {
  const page = await open(hash);
  const good = await page.waitForFunction((words, where) => {
    const walks = where.startsWith("#walk"), named = [...new URLSearchParams(where.replace(/^#(walk\??)?/, ""))];
    const chosen = ":is(select, [type=number], :checked)";
    const control = (name) => document.querySelector(walks ? `[name=walk-${name}]${chosen}` : `#${name}`);
    const inSight = (it) => it.textContent.includes(words) && it.offsetParent &&
      it.getBoundingClientRect().top < innerHeight;
    return [...document.querySelectorAll("#walk p, #legend")].some(inSight) && // which says step and event, too
      named.every(([name, value]) => (walks && /^(steps|event)$/.test(name)) || control(name)?.value === value);
  }, { timeout, polling: 100 }, title, hash).then(() => true, () => false);
  await new Promise((done) => setTimeout(done, 400)); // the walk writes its address anew
  const same = await page.evaluate(() => location.hash) === hash;
  await page.close();
  return good && same;
}
async function links() {
  console.log("the course's links");
  const all = courseLinks();
  for (const link of all) check(`${link.file}: it says "${link.title}"`, await leads(link), link.hash);
  check("there are links of most chapters", new Set(all.map((link) => link.file)).size > 6, `${all.length}`);
  for (const [hash, title] of [["#walk?event=9999", "Event 151 of 151"], ["#walk?event=2", "is entered"],
    ["#scene=rtrt&mode=drt&size=256x256&over=errors", "of the light around"]])
    check(`control: not ${hash}`, !await leads({ hash, title }, 3000));
}

// The table of ways of tracing: {way: [milliseconds, rays, nodes, boxes, triangles]}, the way as "paper: all 8 x 8".
const waysTried = (page) => page.$$eval("#tried tbody tr", (rows) => Object.fromEntries(rows.map((row) => {
  const [path, packets, ...figures] = [...row.cells].map((it) => it.textContent);
  return [`${path} ${packets}`, figures.map((it) => Number(it.replace(/,/g, "")))];
})));

async function paths() {
  console.log("ways of tracing");
  const page = await open("#scene=poolhall&mode=wrt&size=256x256");
  const fast = await firstPicture(page);
  const timed = (way) => page.waitForFunction((of) => [...document.querySelectorAll("#tried tbody tr")].some((row) =>
    `${row.cells[0].textContent} ${row.cells[1].textContent}` === of && Number(row.cells[2].textContent) > 0),
    { timeout: 120000 }, way);
  await timed("fast 8 x 8");
  for (const [path, packet, steps, way] of [["paper", "8", "all", "paper: all 8 x 8"], ["paper", "2", "all", "paper: all 2 x 2"],
    ["paper", "8", "none", "paper: none 8 x 8"], ["single", "8", "none", "single -"]]) {
    const one = await pictureAfter(page, async () => {
      for (const [id, value] of [["path", path], ["packet", packet], ["steps", steps]])
        if (await page.$eval(`#${id}`, (it) => it.value) !== value && (id !== "steps" || path === "paper")) await page.select(`#${id}`, value);
    });
    await timed(way);
    check(`${way}: the same floats`, one.checksum === fast.checksum);
  }
  const ways = await waysTried(page), told = (way) => `${ways[way].join(", ")}`;
  const said = execFileSync(`${bin}/render`, ["--scene", "poolhall", "--mode", "wrt", "--size", "256x256", "--spp", "2", "--path",
    "paper", "--no-progress"], { encoding: "utf8", stdio: ["ignore", "pipe", "ignore"] });
  const [, rays, boxes, triangles] = /^ *all +(\d+) +\S+ +\S+ +(\S+) +(\S+)/m.exec(said).map(Number);
  const near = (x, y) => Math.abs(x / y - 1) < 0.02;
  const counts = (way) => ways[way][1] === rays && near(ways[way][3], boxes) && near(ways[way][4], triangles);
  check("the paper's path does the work that build/render counts", counts("paper: all 8 x 8"), told("paper: all 8 x 8"));
  check("control: without its steps it does other work", !counts("paper: none 8 x 8"), told("paper: none 8 x 8"));
  check("smaller packets open more nodes", ways["paper: all 2 x 2"][2] > 3 * ways["paper: all 8 x 8"][2], told("paper: all 2 x 2"));
  check("the fast path counts rays alone", ways["fast 8 x 8"][1] === rays && !(ways["fast 8 x 8"][3] > 0), told("fast 8 x 8"));
  const current = () => page.$$eval("#tried [aria-current]", (rows) => rows.length);
  check("control: one way is marked as that of the picture", await current() === 1);
  await pictureAfter(page, () => page.select("#over", "boxes"));
  check("none is while costs are laid over it, which are not timed", await current() === 0);
  await pictureAfter(page, () => page.select("#over", "none"));
  await page.setViewport({ width: 1280, height: 800 });
  const bottom = await page.$eval("#tried tbody tr:nth-child(2)", (row) => row.getBoundingClientRect().bottom + scrollY);
  check("where ways are compared, two of them are in sight of the picture", bottom < 800, bottom);
  const apart = await page.evaluate(() => {
    document.getElementById("look").classList.remove("comparing");
    return document.querySelector("#tried tbody tr:nth-child(2)").getBoundingClientRect().bottom + scrollY;
  });
  check("control: beside a larger picture they are not", apart > 800, apart);
  await page.focus("#picture");
  await pictureAfter(page, () => page.keyboard.press("ArrowLeft"));
  check("of another view the table begins anew", Object.keys(await waysTried(page)).length <= 1);
  await checkLook(page, "the page with the table");
  await page.screenshot({ path: "out/web-paths.png", fullPage: true });
  await page.close();
}

// What lies over the picture, against the heat of build/render: colours by the logarithm of the counts, from black to white.
async function costs() {
  console.log("costs laid over the picture");
  const page = await open("#scene=rtrt&mode=wrt&size=256x256&path=paper&over=boxes"), file = path.join(os.tmpdir(), `web-heat-${process.pid}.pfm`);
  await page.waitForFunction(() => noted.costs?.samples >= 8, { timeout: 120000 });
  execFileSync(`${bin}/render`, ["--scene", "rtrt", "--mode", "wrt", "--size", "256x256", "--spp", "2", "--path", "paper", "--heat", "boxes",
    "--no-progress", "-o", file], { stdio: "ignore" });
  const bytes = fs.readFileSync(file), head = /^P[Ff]\n(\d+) (\d+)\n(\S+)\n/.exec(bytes.subarray(0, 40).toString("latin1"));
  fs.rmSync(file);
  const channels = bytes.subarray(0, 2).toString() === "PF" ? 3 : 1, counts = []; // rows from the lowest up
  for (let y = 255; y >= 0; y--) for (let x = 0; x < 256; x++) counts.push(bytes.readFloatLE(head[0].length + 4 * channels * (256 * y + x)));
  const now = await page.waitForFunction(() => Number(document.getElementById("samples").textContent) === noted.costs.samples && {
    ...noted.costs, shown: [...document.getElementById("overlay").getContext("2d").getImageData(0, 0, 256, 256).data],
    least: document.getElementById("legend-least").textContent, most: document.getElementById("legend-most").textContent,
    ticks: [...document.querySelectorAll("#legend-scale span")].map((it) => [it.textContent, parseFloat(it.style.left)]),
  }, { timeout: 60000 }).then((it) => it.jsonValue());
  const equal = counts.filter((x, i) => Math.abs(x - now.first[i]) <= 0.02 * x + 1).length / counts.length;
  check("boxes are counted as by build/render", equal > 0.98, `${(100 * equal).toFixed(1)}% of pixels`);
  const besides = counts.filter((x, i) => i && Math.abs(x - now.first[i - 1]) <= 0.02 * x + 1).length / counts.length;
  check("control: not those of the pixel beside it", besides < 0.9, `${(100 * besides).toFixed(1)}%`);
  const number = (told) => Number(told.replace(/,/g, "")), { ticks, shown } = now, least = number(now.least), most = number(now.most);
  const place = (x) => Math.log(x / least) / Math.log(most / least);
  check("its legend goes from a power of ten up", Number.isInteger(Math.log10(least)) && most >= 10 * least, `${least} to ${most}`);
  check("powers of ten are marked at the place of their logarithm", ticks.length > 0 && ticks.every(([told, at]) =>
    Math.abs(at - 100 * place(number(told))) < 0.1), ticks.join(" "));
  const heat = [[0, 0, 0], [35, 15, 95], [110, 25, 120], [205, 50, 70], [245, 125, 25], [250, 205, 70], [255, 255, 255]];
  const colour = (part) => {
    const at = 6 * Math.max(0, Math.min(1, part)), below = Math.min(5, Math.floor(at));
    return heat[below].map((x, c) => x + (at - below) * (heat[below + 1][c] - x));
  };
  const good = (to) => now.mean.filter((x, i) => colour(to(x)).every((c, k) => Math.abs(c - shown[4 * i + k]) < 6)).length / counts.length;
  check("pixels have the colours of these counts", good(place) > 0.9, `${(100 * good(place)).toFixed(1)}%`);
  check("control: not those of a linear scale", good((x) => x / most) < 0.5, `${(100 * good((x) => x / most)).toFixed(1)}%`);
  await page.screenshot({ path: "out/web-costs.png" });
  const scale = async (of) => [number(await text(of, "#legend-least")), number(await text(of, "#legend-most"))].join(" to ");
  const first = await scale(page);
  await pictureAfter(page, () => page.select("#path", "single"));
  check("of one picture all ways have one scale", await scale(page) === first, await scale(page));
  const alone = await open("#scene=rtrt&mode=wrt&size=256x256&path=single&over=boxes");
  await alone.waitForFunction(() => noted.costs?.samples >= 2 && !document.getElementById("legend").hidden, { timeout: 120000 });
  check("control: this way alone has another", await scale(alone) !== first, await scale(alone));
  await alone.close();
  await page.close();
}

// What a visitor reads first, and where the links at the foot lead.
async function texts() {
  console.log("texts and links");
  const page = await open("#mode=rcs&size=256x256");
  const first = (await text(page, "#about")).trim().replace(/\s+/g, " ").split(". ")[0], plain = (words) => !/pktrt|WebAssembly|packet|header|bits/.test(words);
  check("the first sentence says in plain words what the page does", /^This page draws/.test(first) && plain(first), first);
  check("control: not one for those who know", !plain("A packet ray tracer in one C header"));
  const links = await page.$$eval("footer a", (all) => all.map((it) => it.href));
  const reads = async (link, pattern) => {
    const answer = await fetch(link);
    return answer.ok && pattern.test(await answer.text());
  };
  for (const [name, pattern] of [["project.txt", /^# pktrt\.h\n[^]*## Licence/], ["course.txt", /The course[^]*Interval/i],
    ["pktrt.h", /PKTRT_IMPLEMENTATION/], ["licence.txt", /^\s*This software is available under two licences[^]*MIT[^]*domain/]])
    check(`the foot leads to ${name}`, links.includes(`${url}/${name}`) && await reads(`${url}/${name}`, pattern));
  check("the licence is text alone", !await reads(`${url}/licence.txt`, /\*\/|>>/));
  check("and to the paper", links.some((link) => link === "https://graphicsinterface.org/proceedings/gi2007/gi2007-24/"));
  check("control: not to a text that is missing", !await reads(`${url}/licences.txt`, /./));
  await page.close();
}

async function quick() {
  console.log("time and memory");
  const packed = (name) => zlib.gzipSync(fs.readFileSync(path.join(folder, name))).length;
  const loaded = fs.readdirSync(folder).filter((name) => /\.(html|css|js|wasm)$/.test(name));
  const bytes = loaded.reduce((sum, name) => sum + packed(name), 0);
  check(`less than ${MOST_BYTES / 1e6} MB to load, compressed`, bytes < MOST_BYTES, `${(bytes / 1e6).toFixed(2)} MB`);
  await checkTime(`the first picture comes within ${SECONDS_TO_FIRST} s`, async () => {
    const page = await open("");
    await page.waitForFunction(() => document.getElementById("first").textContent !== "-", { timeout: 240000, polling: 50 });
    const seconds = parseFloat(await text(page, "#first"));
    await page.close();
    return seconds;
  }, (x) => x < SECONDS_TO_FIRST, (x) => `${x} s`);

  // Memory: of the modules, and of the page when what is garbage has been collected.
  const page = await open("#scene=poolhall&mode=rcs&size=256x256&full=1&animate=1"), session = await page.createCDPSession();
  const memory = async () => {
    await session.send("HeapProfiler.collectGarbage");
    const modules = await Promise.all(page.workers().map((one) => one.evaluate("module.HEAPU8.length")));
    return { modules: modules.reduce((sum, x) => sum + x, 0), page: await page.evaluate(() => performance.memory.usedJSHeapSize) };
  };
  const after = async (more) => {
    const from = await page.evaluate(() => noted.frames);
    await page.waitForFunction((n) => noted.frames >= n, { timeout: 400000, polling: 100 }, from + more);
    return memory();
  };
  const mb = (x) => (x / 1e6).toFixed(1), frames = reported ? 100 : 500;
  const early = await after(50), late = await after(frames);
  check(`${frames} frames leave the modules' memory as it is`, late.modules === early.modules,
    `${mb(early.modules)} MB of all workers`);
  check("and the page's", late.page - early.page < MOST_GROWTH, `${mb(early.page)} MB, then ${mb(late.page)} MB`);
  await page.evaluate(() => { noted.keep = []; });
  const kept = await after(30);
  check("control: frames that are kept are noticed", kept.page - late.page > MOST_GROWTH, `${mb(kept.page)} MB`);
  await page.close();
}

// Frames a second while one orbits, and of each: pixels, and milliseconds of processors.
async function orbiting(page, seconds) {
  const session = await browser.target().createCDPSession();
  const processors = async () => (await session.send("SystemInfo.getProcessInfo")).processInfo
    .reduce((sum, one) => sum + (one.type === "renderer" ? 1000 * one.cpuTime : 0), 0);
  const before = await processors();
  const [count, pixels, took] = await page.evaluate((wait) => new Promise((done) => {
    const { frames, pixels: sum } = noted, began = performance.now(), canvas = document.getElementById("picture");
    const keys = setInterval(() => canvas.dispatchEvent(new KeyboardEvent("keydown", { key: "ArrowLeft" })), 10);
    setTimeout(() => (clearInterval(keys), done([noted.frames - frames, noted.pixels - sum, performance.now() - began])),
      1000 * wait);
  }), seconds);
  const ms = (await processors() - before) / count;
  await session.detach();
  return { frames: 1000 * count / took, pixels: Math.round(pixels / count), ms };
}

async function speed() {
  console.log("frames per second: the pool hall, Whitted's mode");
  const page = await open("#scene=poolhall&mode=wrt&size=256x256");
  const alone = ({ ms }) => 1000 * page.workers().length / ms; // if nothing else had these processors
  const told = (one) => `${one.frames.toFixed(1)} of ${one.pixels} pixels, ${one.ms.toFixed(0)} ms of ${page.workers().length} ` +
    `processors each: up to ${alone(one).toFixed(1)} a second`;
  await firstPicture(page);
  await orbiting(page, 2); // until it knows how many pixels fit
  console.log(`          as many pixels as fit: ${told(await orbiting(page, 2))}`);
  await clickIn(page, "#full");
  let all = true;
  await checkTime(`${FRAMES_PER_SECOND} frames a second of 256 x 256`, async () => {
    await orbiting(page, 0.5);
    const one = await orbiting(page, 2);
    all &&= one.pixels === 256 * 256;
    return one;
  }, (one) => one.frames >= FRAMES_PER_SECOND, told);
  check("these had all pixels", all);
  await clickIn(page, "#faint");
  console.log(`          faint rays left out: ${told(await orbiting(page, 2))}`);
  check("the page shows a figure", Number(await text(page, "#rate")) > 1, await text(page, "#rate"));
  await page.close();
}

// The page as examples/README.md shows it, for make web-picture alone.
async function gallery() {
  const page = await open("", { height: 800 });
  await page.waitForFunction(() => Number(document.getElementById("samples").textContent) >= 32, { timeout: 240000 });
  await page.screenshot({ path: "out/web-page.png" });
  await page.close();
}

async function complaining() {
  console.log("complaints");
  check("the console has no errors", complaints.length === 0, complaints.slice(0, 3).join("; "));
  check("nothing is asked of other hosts", [...hosts].join() === new URL(url).host, [...hosts].join(", "));
  const page = await open("");
  await page.evaluate(() => {
    console.error("planted");
    return fetch("http://elsewhere.invalid/").catch(() => {});
  });
  check("control: errors are noticed", complaints.includes("planted"));
  check("control: so are other hosts", hosts.has("elsewhere.invalid"));
  await page.close();
}

async function main() {
  browser = await puppeteer.launch({ executablePath: process.env.CHROMIUM, headless: true, protocolTimeout: 500000,
    args: ["--no-sandbox", "--disable-dev-shm-usage", "--enable-precise-memory-info",
      "--host-resolver-rules=MAP * ~NOTFOUND, EXCLUDE localhost"] });
  try {
    const only = process.env.ONLY?.split(" ").filter(Boolean) || [];
    if (only.includes("gallery")) await gallery();
    for (const part of [pictures, filter, panels, files, touch, wide, walk, tour, strange, late, hurry, addresses,
      fullscreen, pick, links, paths, costs, texts, quick, speed, filterSpeed, complaining])
      if (!only.length || only.includes(part.name)) {
        const began = performance.now();
        await part();
        console.log(`  (${((performance.now() - began) / 1000).toFixed(0)} s)`);
      }
  } finally {
    await browser.close();
  }
  console.log(failures ? `web: ${failures} checks failed` : "web: all checks passed");
  process.exitCode = failures ? 1 : 0;
}

main().catch((error) => {
  console.log(`  FAILED  ${error.stack}`);
  process.exitCode = 1;
});
