// Looks after the module of the web page, in node: whether its pictures have the bits that the command line makes, in bands
// as well as whole, whether 500 frames of the animation leave its memory as it is, and how long a frame takes.
// node tests/web.js out/web build/render [--quick]
"use strict";
const fs = require("fs");
const { execFileSync } = require("child_process");
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
