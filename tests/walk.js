// Compares what the web page shows of a packet's walk with what a program tells: rays, events and the packets of figure 3,
// word by word; and whether the course's links lead to states that say what the links announce.
// node tests/walk.js out/web build/walk_events
"use strict";
const fs = require("fs");
const { execFileSync } = require("child_process");
const path = require("path");
const { linksOf, courseLinks } = require("./web_links.js");

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

  // What the page says of a link's state; "": the address is not as the page would write it, or there is no such event.
  function saidOf(hash) {
    const state = walk.stateOf(hash), world = walk.makeWorld(module, state.scene);
    const rays = walk.makePacket(module, state);
    const events = walk.trace(module, state.steps), members = walk.figure(module, state.assembly, state.met);
    if (walk.hashOf(state) !== hash || state.event >= events.length) return "";
    const packets = new Set(members.map((member) => member.packet)).size;
    if (walk.leadsToFigure(hash)) return `${walk.many(members.length, "ray")} in ${walk.many(packets, "packet")}`;
    return walk.sentence(events[state.event], world, rays.length, state.packet === "shadow");
  }
  const holds = ({ hash, title }) => saidOf(hash).includes(title);
  const links = courseLinks().filter(({ hash }) => hash.startsWith("#walk"));
  for (const link of links) if (!holds(link)) fail(`${link.file}: ${link.hash} does not say "${link.title}"`);
  if (links.length < 6) fail(`the course has ${links.length} links to walks`);
  for (const [hash, title] of [["#walk?evnt=3", "is"], ["#walk?event=9999", "is"], ["#walk?event=2", "is entered"],
    ["#walk?assembly=run", "rays in"]])
    if (holds({ hash, title })) fail(`not noticed: ${hash} "${title}"`);
  if (linksOf("[a](http://localhost:8080/#walk \"b\") [c](http://localhost:8000/#walk)").some((link) => link))
    fail("not noticed: links of another form");

  if (!failures) {
    console.log(`passed  ${walks} walks of ${told} events are those of the program`);
    console.log(`passed  ${links.length} links of the course lead where they say`);
  }
  process.exitCode = failures ? 1 : 0;
}

main();
