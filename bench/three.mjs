// Races pktrt, compiled to WebAssembly with its vectors, with three-mesh-bvh: the same mesh, the same rays to their closest hits, in
// one process. Each round has all of them in turn, and the best of its rounds counts. bench/three.sh puts this beside both
// libraries and runs it: node three.mjs SCENE ROUNDS FILE; rows go to FILE.csv, the table to FILE.md and the terminal.
import fs from "fs";
import { BufferAttribute, BufferGeometry, DoubleSide, Ray, REVISION } from "three";
import { CENTER, MeshBVH, SAH } from "three-mesh-bvh";
import open from "./pktrt.js";

const [scene, rounds, file] = process.argv.slice(2);
const version = JSON.parse(fs.readFileSync(new URL("node_modules/three-mesh-bvh/package.json", import.meta.url))).version;
const RAY = 9, HIT = 8; // floats of a pktrt_ray, of a pktrt_hit; t comes first
const pktrt = await open();

if (!pktrt.ccall("three_open", "number", ["string"], [scene])) throw new Error(`${scene} cannot be made`);

// Takes processor time, which a busy machine changes less; that of threads which collect garbage is in it.
function seconds(work) {
  const start = process.cpuUsage();
  const made = work(), { user, system } = process.cpuUsage(start);
  return [(user + system) / 1e6, made];
}

// What JavaScript has to do for it is timed as well: rays go in, distances come out.
const floats = (at) => at >> 2;
function many(rays, t) {
  pktrt.HEAPF32.set(rays, floats(pktrt._three_rays()));
  pktrt._three_many();
  const hits = floats(pktrt._three_hits()), heap = pktrt.HEAPF32;
  for (let i = 0; i < t.length; i++) t[i] = heap[hits + HIT * i];
}
function single(rays, t) {
  const at = floats(pktrt._three_rays()), hits = floats(pktrt._three_hits()), heap = pktrt.HEAPF32;
  for (let i = 0; i < t.length; i++) {
    for (let k = 0; k < RAY; k++) heap[at + k] = rays[RAY * i + k];
    pktrt._three_one();
    t[i] = heap[hits];
  }
}
const ray = new Ray();
const first = (bvh) => (rays, t) => {
  for (let i = 0; i < t.length; i++) {
    ray.origin.fromArray(rays, RAY * i);
    ray.direction.fromArray(rays, RAY * i + 4);
    const hit = bvh.raycastFirst(ray, DoubleSide, rays[RAY * i + 3], rays[RAY * i + 7]);
    t[i] = hit ? hit.distance : Infinity;
  }
};

// --- trees ---

const triangles = pktrt._three_triangles();
function build(strategy) {
  const geometry = new BufferGeometry(), vertices = pktrt._three_vertices();
  const positions = floats(pktrt._three_positions()), indices = pktrt._three_indices() >> 2;
  geometry.setAttribute("position", new BufferAttribute(pktrt.HEAPF32.slice(positions, positions + 3 * vertices), 3));
  geometry.setIndex(new BufferAttribute(pktrt.HEAPU32.slice(indices, indices + 3 * triangles), 1));
  return new MeshBVH(geometry, { strategy });
}
const best = (n, work) => { // the least time, and what the last round made
  let least = Infinity, made;
  for (let i = 0; i < n; i++) {
    const [time, now] = seconds(work);
    least = Math.min(least, time), made = now;
  }
  return [least, made];
};
const [pktrtBuild] = best(3, () => pktrt._three_build(0));
const [sahBuild, sah] = best(3, () => build(SAH));
const [centerBuild, center] = best(3, () => build(CENTER));
const contenders = [
  { name: "pktrt, one call for all", build: pktrtBuild, trace: many },
  { name: "pktrt, a call for each", build: pktrtBuild, trace: single },
  { name: "three-mesh-bvh, SAH", build: sahBuild, trace: first(sah) },
  { name: "three-mesh-bvh, default", build: centerBuild, trace: first(center) },
];

// --- the race ---

// Counts distances that differ by more than a ten-thousandth, and rays that hit in one only; shift: from those of other rays.
function differing(t, want, shift) {
  let n = 0;
  for (let i = 0; i < t.length; i++) {
    const a = t[i], b = want[(i + shift) % t.length];
    n += a !== b && !(Math.abs(a - b) <= 1e-4 * b);
  }
  return n;
}

const rows = ["scene,triangles,rays,library,count,nanoseconds,hits,differ,build_ms"];
const table = [`${scene} as one mesh of ${triangles} triangles; node ${process.version}, three-mesh-bvh ${version}, three r${REVISION}.`, "",
  "| rays | traced by | ns of a ray | times as long | hits | distances that differ | building, ms |", "|---|---|--:|--:|--:|--:|--:|"];
for (const [diffuse, kind] of ["primary", "diffuse"].entries()) {
  const count = pktrt._three_make(diffuse), at = floats(pktrt._three_rays());
  const rays = pktrt.HEAPF32.slice(at, at + RAY * count);
  for (const c of contenders) c.t = new Float64Array(count), c.best = Infinity;
  for (let round = 0; round < rounds; round++)
    for (const c of contenders) c.best = Math.min(c.best, seconds(() => c.trace(rays, c.t))[0]);
  const want = contenders[0];
  for (const c of contenders) {
    const hits = c.t.reduce((n, t) => n + (t < Infinity), 0), differ = differing(c.t, want.t, 0), ns = 1e9 * c.best / count;
    if (!(differing(c.t, want.t, 1) > count / 10)) throw new Error("the control: another ray's distances do not differ");
    rows.push([scene, triangles, kind, `"${c.name}"`, count, ns.toFixed(1), hits, differ, (1000 * c.build).toFixed(1)].join(","));
    table.push(`| ${kind} | ${c.name} | ${ns.toFixed(0)} | ${(c.best / want.best).toFixed(2)} | ${hits} of ${count} | ${differ} | ` +
      `${(1000 * c.build).toFixed(0)} |`);
  }
}
fs.writeFileSync(`${file}.csv`, rows.join("\n") + "\n");
fs.writeFileSync(`${file}.md`, table.join("\n") + "\n");
console.log(table.join("\n"));
