// Compares what the web page shows of a packet's walk with what a program tells: rays, events and the packets of figure 3,
// word by word. node tests/walk.js out/web build/walk_events
"use strict";
const fs = require("fs");
const { execFileSync } = require("child_process");
const path = require("path");

const [folder, program] = process.argv.slice(2);
const hashes = ["#walk", "#walk?packet=shadow&size=16&steps=2007&event=40", "#walk?x=7&view=3d&follow=1",
  "#walk?steps=group+trim&met=dd....gg........"];
const scenes = ["course", "boxes"], packets = ["camera", "shadow", "mirror"], orders = ["rows", "morton"];

async function main() {
  const source = fs.readFileSync(path.join(__dirname, "../examples/web/walk_data.js"), "utf8");
  const walk = await import(`data:text/javascript,${encodeURIComponent(source)}`); // node takes a .js for a script
  const module = await require(path.resolve(folder, "pktrt.js"))({ wasmBinary: fs.readFileSync(`${folder}/pktrt.wasm`) });
  let failures = 0, walks = 0, told = 0;
  const fail = (sentence) => (failures++, console.log(`FAILED  ${sentence}`));

  function compare(scene, packet, size, x, y, spacing, order, steps) {
    const state = { scene: scenes[scene], packet: packets[packet], size, x, y, spacing, order: orders[order] };
    const world = walk.makeWorld(module, state.scene);
    const rays = walk.makePacket(module, state), events = walk.trace(module, steps), lines = [];
    const print = (things, kind) => things.forEach((thing) => lines.push(walk.words(thing, kind) + "\n"));
    print(rays, "ray"), print(events, "event");
    for (const assembly of ["types", "runs", "groups", "octants", "blind", "none"])
      print(walk.figure(module, assembly, walk.WALK_DEFAULTS.met), "member");
    const numbers = [scene, packet, size, x, y, spacing, order, steps].map(String);
    if (lines.join("") !== execFileSync(program, numbers, { encoding: "utf8" })) fail(`another walk: ${numbers.join(" ")}`);
    events.forEach((event, i) => { // each can be said, and replayed
      const said = walk.sentence(event, world, rays.length, packet === 1);
      if (/undefined|NaN|null/.test(said)) fail(said);
      walk.replay(world, rays, events, i, packet === 1);
    });
    walks++, told += events.length;
  }

  for (let i = 0; i < 96; i++) {
    const spacing = [1, 4][i % 2], size = [2, 8, 16, 4][i % 4];
    compare((i >> 2) % 2, i % 3, size, 23 * i % 190, 31 * i % 120, spacing, (i >> 3) % 2, [0, 35, 64, 9, 55][i % 5]);
  }
  for (const hash of hashes) {
    const back = walk.hashOf(walk.stateOf(hash));
    if (back !== hash) fail(`${hash} comes back as ${back}`);
  }
  if (!failures) console.log(`passed  ${walks} walks of ${told} events are those of the program`);
  process.exitCode = failures ? 1 : 0;
}

main();
