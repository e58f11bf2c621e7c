// Looks after the module of the web page, in node: whether its pictures have the bits that the command line makes, in bands
// as well as whole, whether the filter has no seams and lowers the error, whether 500 frames of the animation leave its memory as it is, and how long a frame takes.
// node tests/web.js out/web build/render [--quick]
"use strict";
const fs = require("fs");
const { execFileSync } = require("child_process");
const os = require("os");
const path = require("path");

const [folder, render, quick] = process.argv.slice(2);
const scenes = ["poolhall", "conference", "rtrt"], modes = ["rcs", "wrt", "drt"];
let failures = 0;

function check(good, sentence) {
  console.log(`${good ? "passed" : "FAILED"}  ${sentence}`);
  if (!good) failures++;
}

function native(scene, mode, width, height, samples, lightSize) {
  const told = execFileSync(render, ["--scene", scene, "--mode", mode, "--size", `${width}x${height}`, "--spp", samples,
    "--light-size", lightSize, "--no-count", "--no-progress"], { encoding: "utf8", stdio: ["ignore", "pipe", "ignore"] });
  return /checksum ([0-9a-f]{16})/.exec(told)[1];
}

// The filter, of the pool hall: of the whole and in bands, and what it is good for.
function filters(module, must) {
  const width = 120, height = 88, n = width * height, margin = module._web_filter_margin();
  const floats = (pointer, count) => module.HEAPF32.slice(pointer >> 2, (pointer >> 2) + count);
  must(module._web_open(0, 1));
  must(module._web_resize(width, height));
  must(module._web_pose(0, 1 / 240));
  module._web_settings(2, 8, 0, 0);
  must(module._web_render_band(0, height, 64, 7));
  const truth = floats(module._web_pixels(), 3 * n), room = module._web_filter_room(n);
  must(module._web_render_halves(0, height));
  const planes = [3, 3, 7, 7], halves = [];
  let at = room;
  for (const each of planes) halves.push(floats(at, each * n)), at += 4 * each * n;

  const filtered = (bands, around) => {
    const out = new Float32Array(3 * n);
    for (let i = 0; i < bands; i++) {
      const y = Math.round((height * i) / bands), end = Math.round((height * (i + 1)) / bands);
      const from = Math.max(0, y - around), to = Math.min(height, end + around), pixels = width * (to - from);
      let here = module._web_filter_room(pixels) >> 2;
      halves.forEach((half, k) => {
        module.HEAPF32.set(half.subarray(planes[k] * width * from, planes[k] * width * to), here);
        here += planes[k] * pixels;
      });
      must(module._web_filter_rows(width, to - from, y - from, end - y));
      out.set(floats(4 * (here + pixels + 3 * width * (y - from)), 3 * width * (end - y)), 3 * width * y);
    }
    return out;
  };
  const whole = filtered(1, 0), differ = (other) => other.filter((x, i) => x !== whole[i]).length;
  check(differ(filtered(4, margin)) === 0, "the filter in four bands has the bits of one over the whole picture");
  check(differ(filtered(4, 0)) > 1000, `control: without the ${margin} rows around them bands have seams`);
  const error = (of) => Math.sqrt(of.reduce((sum, x, i) => sum + (Math.min(1, x) - Math.min(1, truth[i])) ** 2, 0) / of.length);
  const mean = halves[0].map((x, i) => (x + halves[1][i]) / 2), [before, after] = [error(mean), error(whole)];
  check(after < 0.95 * before, `it lowers the error that is shown: ${before.toFixed(4)}, filtered ${after.toFixed(4)}`);

  const named = ["--scene", "poolhall", "--mode", "drt", "--size", `${width}x${height}`, "--spp", "2", "--no-count", "--no-progress"];
  const native = (...options) => {
    const file = path.join(os.tmpdir(), `web-filter-${process.pid}.pfm`);
    execFileSync(render, [...named, ...options, "-o", file], { stdio: "ignore" });
    const bytes = fs.readFileSync(file), head = /^PF\n\d+ \d+\n\S+\n/.exec(bytes.subarray(0, 40).toString("latin1"))[0].length;
    fs.rmSync(file);
    return Float32Array.from({ length: 3 * n }, (_, i) => {
      const row = height - 1 - Math.floor(i / (3 * width));
      return bytes.readFloatLE(head + 4 * (3 * width * row + (i % (3 * width))));
    });
  };
  const near = (of) => of.filter((x, i) => Math.abs(x - whole[i]) <= 1e-4 * (1 + Math.abs(x))).length / of.length;
  const same = near(native("--filter"));
  check(same > 0.99, `it is that of build/render --filter: ${(100 * same).toFixed(2)}% of floats`);
  check(near(native()) < 0.5, "control: without --filter they are others");
  check(module._web_filter_rows(width, height + 1, 0, 1) !== 0,
    `rows for which there is no room are refused: ${module.UTF8ToString(module._web_error())}`);
}

async function main() {
  const module = await require(path.resolve(folder, "pktrt.js"))({ wasmBinary: fs.readFileSync(`${folder}/pktrt.wasm`) });
  const must = (status) => {
    if (status) throw new Error(module.UTF8ToString(module._web_error()));
  };
  const checksum = () => module.UTF8ToString(module._web_checksum());
  const megabytes = () => module.HEAPU8.length / 1e6;

  const width = 120, height = 88;
  for (const [scene, mode, samples, light] of [["poolhall", "wrt", 1, 1], ["conference", "rcs", 2, 1], ["rtrt", "drt", 2, 2],
    ["poolhall", "drt", 1, 0.5]]) {
    must(module._web_open(scenes.indexOf(scene), light));
    must(module._web_resize(width, height));
    must(module._web_pose(0, mode === "drt" ? 1 / 240 : 0)); // one frame, as there
    module._web_settings(modes.indexOf(mode), 8, 0, 0);
    must(module._web_render_band(0, height, samples, 0));
    const whole = checksum(), there = native(scene, mode, width, height, samples, light);
    check(whole === there, `${scene}, ${mode}, ${samples} per pixel, lights ${light} times as wide: ${whole}, ${there}`);
    must(module._web_render_band(0, height, samples, 1));
    const alone = samples === 1 && mode !== "drt"; // in the middle of the pixel, in every pass
    check((checksum() === whole) === alone, `another pass is ${alone ? "the same" : "another"} picture`);
    module._web_settings(modes.indexOf(mode), 4, 1, 0);
    for (let y = 64; y >= 0; y -= 16) must(module._web_render_band(y, Math.min(16, height - y), samples, 0));
    must(module._web_render_band(80, 8, samples, 0));
    check(checksum() === whole, "the same in bands from the lowest up, in packets of 4 x 4, its cost counted");
  }
  filters(module, must);
  check(module._web_open(99, 1) !== 0, `there is no scene 99: ${module.UTF8ToString(module._web_error())}`);

  if (!quick) {
    must(module._web_open(0, 1));
    must(module._web_resize(64, 64));
    module._web_settings(1, 8, 0, 0);
    must(module._web_render_band(0, 64, 1, 0));
    const rest = checksum();
    let early = 0;
    for (let frame = 1; frame <= 500; frame++) {
      must(module._web_pose(frame / 500, 0));
      must(module._web_render_band(0, 64, 1, 0));
      if (frame === 20) early = megabytes();
    }
    check(checksum() === rest, "after 500 frames of the animation the first picture comes again");
    check(megabytes() === early, `memory after 20 frames ${early.toFixed(1)} MB, after 500 ${megabytes().toFixed(1)} MB`);
    for (let i = 0; i < 6; i++) must(module._web_open(i % 3, 1));
    const some = megabytes();
    for (let i = 0; i < 12; i++) must(module._web_open(i % 3, 1));
    check(megabytes() === some, `memory after 6 scenes ${some.toFixed(1)} MB, after 18 ${megabytes().toFixed(1)} MB`);

    must(module._web_open(0, 1));
    must(module._web_resize(256, 256));
    for (const [number, mode, attenuation] of [[0, "rcs", 0], [1, "wrt", 0], [1, "wrt without faint rays", 1 / 20], [2, "drt", 0]]) {
      module._web_settings(number, 8, 0, attenuation);
      let best = Infinity;
      for (let i = 0; i < 6; i++) {
        const before = process.cpuUsage();
        must(module._web_render_band(0, 256, 1, 0));
        const used = process.cpuUsage(before);
        best = Math.min(best, (used.user + used.system) / 1000);
      }
      console.log(`time    pool hall, ${mode}, 256 x 256, one thread: ${best.toFixed(0)} ms of a processor, best of 6`);
    }
  }
  console.log(failures ? `${failures} failed` : "all passed");
  process.exit(failures ? 1 : 0);
}

main().catch((error) => {
  console.log(`FAILED  ${error.message}`);
  process.exit(1);
});
