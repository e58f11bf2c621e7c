// Compares what the web page shows of a packet's walk with what a program tells: rays, events and the packets of figure 3,
// word by word; and whether the course's links lead to states that say what the links announce.
// node tests/walk.js out/web build/walk_events
"use strict";
const fs = require("fs");
const { execFileSync } = require("child_process");
const path = require("path");
const { linksOf, courseLinks } = require("./web_links.js");

const [folder, native] = process.argv.slice(2);
const hashes = ["#walk", "#walk?scene=rtrt&x=500&y=300&view=3d&event=7&picture=640x480&eye=1,1.5,6&target=0,1,-0.25&time=0.25&light=2", "#walk?packet=shadow&size=16&steps=2007&event=40", "#walk?x=7&view=3d&follow=1",
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
    if (lines.join("") !== execFileSync(native, numbers, { encoding: "utf8" })) fail(`another walk: ${numbers.join(" ")}`);
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
  // The scenes of the first tab, which the page's other functions open: in a picture of another size, at another time.
  const shown = ["poolhall", "conference", "rtrt"];
  for (let i = 0; i < 9; i++) {
    const number = i % 3, [width, height] = [[256, 192], [640, 480], [256, 256]][(i + number) % 3], time = [0, 0.25, 0.5][i % 2 ? number : 0];
    if (module._web_open(number, 1) || module._web_pose(time, 0)) throw new Error(module.UTF8ToString(module._web_error()));
    const own = [...module.HEAPF32.slice(module._web_first_camera() >> 2, (module._web_first_camera() >> 2) + 6)];
    const camera = i < 3 ? own : own.map((x, a) => Math.fround(x + 0.1 * i * (a % 2)));
    module._web_camera(...camera, 0, 0);
    if (module._walk_show(width, height)) throw new Error("no memory");
    const state = { scene: shown[number], packet: packets[(i + (i > 5)) % 3], size: [8, 16, 4][i % 3], x: 20 * i + 40, y: 15 * i + 20, spacing: 1, order: "rows" };
    const world = walk.makeWorld(module, state.scene, [width, height], camera.slice(0, 3));
    const rays = walk.makePacket(module, state), events = walk.trace(module, 63), lines = [];
    const print = (things, kind) => things.forEach((thing) => lines.push(walk.words(thing, kind) + "\n"));
    print(rays, "ray"), print(events, "event");
    const numbers = [2, packets.indexOf(state.packet), state.size, state.x, state.y, 1, 0, 63, number, width, height, time, ...camera].map(String);
    const program = (words) => execFileSync(native, words, { encoding: "utf8" });
    const is = (words) => program(words).startsWith(lines.join("")) && rays.length > 0;
    if (!is(numbers)) fail(`another walk: ${numbers.join(" ")}`);
    if (is(numbers.map((x, k) => (k === 3 ? String(state.x + state.size) : x)))) fail(`not noticed: the packet beside that of ${numbers.join(" ")}`);
    events.forEach((event, k) => {
      const said = walk.sentence(event, world, rays.length, state.packet === "shadow");
      if (/undefined|NaN|null/.test(said)) fail(said);
      if (k % 16 === 0) walk.replay(world, rays, events, k, state.packet === "shadow");
      if (event.kind !== walk.E.HIT) return;
      // The triangle that is drawn for a hit is where the hit is.
      const at = world.cornersOf(event.index).find((one) => one.lane === event.child).at, point = walk.along(rays[event.ray], event.t);
      for (let a = 0; a < 3; a++) {
        const xs = [at[a], at[3 + a], at[6 + a]], slack = 1e-3;
        if (point[a] < Math.min(...xs) - slack || point[a] > Math.max(...xs) + slack) return fail(`a hit beside its triangle: ${numbers.join(" ")}`);
      }
    });
    walks++, told += events.length;
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
