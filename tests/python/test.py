"""Compares examples/python/pktrt.py with C, bit for bit: queries, pictures, sentences; looks at addresses and at
Python's lock; installs it by pip. Each check has a control that must fail.

usage: test.py BUILD      the folder of render, python/answers and python/scene.so
       test.py BUILD --picture SCENE MODE WIDTH HEIGHT     prints the checksum, which build/render has, too"""
import ctypes
import gc
import importlib.util
import os
import pathlib
import shutil
import subprocess
import sys
import threading
import time
import weakref

sys.dont_write_bytecode = True
ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "examples" / "python"))
import numpy as np  # noqa: E402
import pktrt  # noqa: E402

BUILD = pathlib.Path(sys.argv[1]).resolve()
ffi = pktrt.ffi
checks = failures = 0


def check(good, sentence):
    global checks, failures
    checks += 1
    failures += not good
    print(f"  {'ok     ' if good else 'FAILED '} {sentence}")


def same(a, b):
    """Whether two arrays have the same bits, padding of structures left out."""
    if a.dtype.names:
        return all(same(a[name], b[name]) for name in a.dtype.names)
    return a.shape == b.shape and a.dtype == b.dtype and a.tobytes() == b.tobytes()


# --- pictures of the examples' scenes ---


def checksum(pixels):
    total = 14695981039346656037
    for byte in pixels.astype("<f4").tobytes():
        total = (total ^ byte) * 1099511628211 % 2 ** 64
    return f"{total:016x}"


def picture(scene, mode, width, height, **fields):
    """The scene is made by C, which calls the library that Python has loaded. The picture is made by Python."""
    ffi.dlopen(pktrt.library_path, ffi.RTLD_NOW | ffi.RTLD_GLOBAL)
    ffi.cdef("bool scene_for_python(pktrt_scene *, const char *, pktrt_camera *, float *, float *);", override=True)
    scenes = ffi.dlopen(str(BUILD / "python" / "scene.so"))
    world, camera = pktrt.Scene(), ffi.new("pktrt_camera *")
    background, ambient = ffi.new("float[3]"), ffi.new("float[3]")
    if not scenes.scene_for_python(world.handle, scene.encode(), camera, background, ambient):
        sys.exit(f"test.py: there is no scene {scene}")
    world.commit()
    mode = getattr(pktrt, "MODE_" + mode.upper())
    fields = {"camera": camera[0], "background": list(background), "ambient": list(ambient), **fields}
    return checksum(world.render(width, height, mode=mode, **fields))


if len(sys.argv) > 2:
    print(picture(sys.argv[3], sys.argv[4], int(sys.argv[5]), int(sys.argv[6])))
    sys.exit()

# --- arrays for both ---

numbers = np.random.default_rng(1)
N = 6000
grid = np.arange(33)
x, z = [v.ravel() for v in np.meshgrid(grid, grid)]
positions0 = np.stack([x / 4 - 4, numbers.uniform(-1, 0, x.size), z / 4 - 4], axis=1).astype("f4")
corner = (x + 33 * z)[(x < 32) & (z < 32)]
triangles0 = np.stack([corner, corner + 33, corner + 34, corner, corner + 34, corner + 1], axis=1)
triangles0 = triangles0.reshape(-1, 3).astype("u4")
positions1 = numbers.uniform(-1, 1, (2, 300, 3)).astype("f4")  # moves, with two keys
triangles1 = numbers.integers(300, size=(400, 3)).astype("u4")
rays = pktrt.rays(numbers.uniform(-4, 4, (N, 3)), numbers.uniform(-1, 1, (N, 3)), time=numbers.random(N))
rays["origin"][::3, 1] = 4
rays["direction"][::3] = positions0[numbers.integers(len(positions0), size=N // 3)] - rays["origin"][::3]  # at vertices
rays["direction"][1::7, 0], rays["tmin"][::5], rays["tmax"][::4] = 0, 0.25, 1
rays["origin"][5], rays["direction"][6], rays["tmax"][7] = np.nan, 0, np.nan

folder = BUILD / "python" / "arrays"
folder.mkdir(parents=True, exist_ok=True)
for name in ("positions0", "triangles0", "positions1", "triangles1", "rays"):
    globals()[name].tofile(folder / name)
subprocess.run([BUILD / "python" / "answers"], cwd=folder, check=True)


def from_c(name, dtype):
    return np.fromfile(folder / name, dtype)


def make(**fields):
    scene = pktrt.Scene(**fields)
    scene.add_material(specular=pktrt.SPECULAR_MIRROR, albedo=[0.5, 0, 0], reflectance=np.array([0, 0.75, 0.25]))
    scene.add_light(kind=pktrt.LIGHT_POINT, position=[0, 4, 2], intensity=[40, 30, 20])
    return scene


world, other = make(), make()
world.add_mesh(positions0, triangles0)
world.add_mesh(positions1, triangles1, material=1)
world.commit()
# The control: all that answers tell is different.
other.add_mesh(positions1 + np.float32(2 ** -20), triangles1[::-1], material=1)
other.add_mesh(positions0 + np.float32(2 ** -20), triangles0[::-1])
other.commit()

# --- the same answers ---

hits, others = world.intersect(rays), other.intersect(rays)
for field in pktrt.HIT.names:
    check(same(hits[field], from_c("many", pktrt.HIT)[field]), f"{N} rays at once: {field} has the bits that C gets")
    check(not same(others[field], hits[field]), f"control: other meshes have other bits in {field}")
check(N / 4 < np.count_nonzero(hits["mesh"] != pktrt.NONE) < N * 3 / 4, "some rays hit and some do not")
single = np.array([world.intersect(ray) for ray in rays])
check(same(single, from_c("single", pktrt.HIT)), "rays one by one: the same bits")
single[N // 2]["u"] = np.nextafter(single[N // 2]["u"], np.float32(1))
check(not same(single, from_c("single", pktrt.HIT)), "control: a single bit is noticed")
blocked = world.occluded(rays)
check(same(blocked, from_c("blocked", bool)), "what is in the way of many rays is what C gets")
check(same(np.array([world.occluded(ray) for ray in rays]), from_c("blocked_single", bool)), "and of single rays")
check(not same(other.occluded(rays), blocked), "control: other things are in the way with other meshes")
check(same(world.intersect_after(rays, hits), from_c("after", pktrt.HIT)), "hits behind hits are what C gets")
check(not same(world.intersect_after(rays, others), from_c("after", pktrt.HIT)),
      "control: behind others there are others")
check(same(world.spawn(rays, hits, rays["direction"]), from_c("next", pktrt.RAY)), "rays that leave are what C gets")
check(not same(world.spawn(rays, others, rays["direction"]), from_c("next", pktrt.RAY)),
      "control: others leave elsewhere")
check(same(world.surface(rays, hits), from_c("surface", pktrt.SURFACE)), "surfaces are what C gets")
check(not same(other.surface(rays, others), from_c("surface", pktrt.SURFACE)), "control: other surfaces")
shaped = world.intersect(rays.reshape(20, -1, 3))
check(same(shaped.ravel(), hits) and shaped.shape == (20, N // 60, 3), "arrays keep their shape")
world.set_positions(0, positions0 + np.float32(1))
world.refit()
lifted = world.intersect(rays)
check(not same(lifted, hits), "a mesh that is deformed is hit elsewhere")
world.set_positions(0, positions0)
world.refit()
check(same(world.intersect(rays), hits), "and where it was when it is back")
trees = world.trees()
roots = np.array([world.node(k, 0, 0.5) for k in range(len(trees))])
check(same(trees, from_c("trees", pktrt.TREE)) and same(roots, from_c("roots", pktrt.NODE)) and len(trees) == 2,
      "trees and their roots are those that C sees")
check(not same(np.array([world.node(k, 0, 0) for k in range(len(trees))]), roots), "control: at another time others")

# --- the same pictures ---

view = dict(mode=pktrt.MODE_DRT, samples=2, seed=7, background=(0, 0, 0.5),
            camera=dict(eye=np.array([0, 2, 5]), fov_y=50, shutter=1))
pixels, normal = world.render(48, 32, ("normal",), **view)
check(same(pixels.ravel(), from_c("pixels", "f4")), "a picture has the bits that C's has")
check(same(normal.ravel(), from_c("normal", "f4")), "and so have its normals")
check(not same(world.render(48, 32, **{**view, "seed": 8}).ravel(), from_c("pixels", "f4")), "control: another seed")
alone = make(threads=1)
alone.add_mesh(positions0, triangles0)
alone.add_mesh(positions1, triangles1, material=1)
alone.commit()
check(same(alone.render(48, 32, **view), pixels), "one thread makes the same picture as several")
arguments = "--scene conference --mode wrt --size 40x30 --no-count --no-progress".split()
told = subprocess.run([BUILD / "render", *arguments], check=True, capture_output=True, text=True).stdout
want, got = told.split("checksum ")[1][:16], picture("conference", "wrt", 40, 30)
check(got == want, f"a picture of a built-in scene: {got}, by build/render {want}")
check(picture("conference", "wrt", 40, 30, ambient=[0, 0, 0]) != want,
      "control: with other light it has another checksum")

# --- a notebook's scene: images, instances, lights and materials that change ---


def turned(degrees, x):
    """A (3, 4) matrix that turns about y and moves along x."""
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    return np.array([[c, 0, s, x], [0, 1, 0, 0.5], [-s, 0, c, 0]])


edge = np.linspace(-4, 4, 9)
given = dict(
    floor=np.stack(np.broadcast_arrays(edge, numbers.uniform(-1, 0, (9, 9)), edge[:, None]), axis=-1).reshape(-1, 3),
    floor_texcoords=numbers.uniform(-2, 2, (81, 2)), floor_materials=numbers.integers(5, size=128),
    body=np.array([[0.5, -0.5, -0.5], [-0.5, 0.5, -0.5], [-0.5, -0.5, 0.5], [0.5, 0.5, 0.5]]),
    body_triangles=np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]),
    places=[turned(0, -1), turned(120, -1)], places_later=[turned(0, -2), turned(170, 1)], place=turned(30, 1.5),
    camera_places=numbers.uniform(-10, 70, (500, 2)), camera_lens=numbers.random((500, 2)),
    camera_times=numbers.random(500),
    image_albedo=numbers.integers(256, size=(6, 7, 3)), image_grey=numbers.integers(256, size=(5, 5)),
    image_shine=numbers.integers(256, size=(3, 4, 3)), image_rough=numbers.uniform(1, 99, (4, 2)),
    image_leaf=numbers.integers(256, size=(9, 9)), image_glow=numbers.random((3, 3, 3)),
    image_bumps=numbers.integers(256, size=(6, 6, 3)), image_sky=numbers.random((8, 16, 3)))
square = np.arange(72).reshape(8, 9)[:, :8].reshape(-1, 1)
given["floor_triangles"] = np.concatenate([square + [[0, 9, 1]], square + [[1, 9, 10]]])
bytes_of = {name for name in given if name.startswith("image_")} - {"image_rough", "image_glow", "image_sky"}
for name, array in given.items():
    kind = "f8" if name == "camera_places" else "u1" if name in bytes_of else \
        "u4" if name.endswith(("triangles", "materials")) else "f4"
    given[name] = np.array(array).astype(kind)
    given[name].tofile(folder / name)
subprocess.run([BUILD / "python" / "notebook"], cwd=folder, check=True)


def make_stage(change=0, threads=None):
    """The scene that tests/python/notebook.c makes; change: adds to a texture, for controls."""
    scene = pktrt.Scene(threads)
    scene.add_material(albedo=[1, 0.9, 0.8], texture=given["image_albedo"] + np.uint8(change))
    scene.add_material(specular=pktrt.SPECULAR_MIRROR, lobe=pktrt.LOBE_PHONG, albedo=[0.5] * 3, reflectance=[0.5] * 3,
                       texture=dict(albedo=pktrt.Image(given["image_grey"], wrap="clamp"),
                                    reflectance=pktrt.Image(given["image_shine"], "clamp"),
                                    exponent=given["image_rough"]))
    scene.add_material(albedo=[0.25, 0.5, 0], texture=dict(opacity=given["image_leaf"], emission=given["image_glow"]))
    scene.add_material(albedo=[0.75] * 3, texture=dict(normal=given["image_bumps"]))
    scene.add_mesh(given["floor"], given["floor_triangles"], texcoords=given["floor_texcoords"],
                   triangle_materials=given["floor_materials"], mask=1)
    body = dict(positions=given["body"], triangles=given["body_triangles"])
    spare, model = scene.add_model(body), scene.add_model(body)
    scene.remove_model(spare)
    scene.add_instance(model, given["places"], mask=2, interpolation=pktrt.INTERPOLATION_RIGID)
    scene.set_transform(scene.add_instance(model, mask=4), given["place"])
    scene.commit()
    scene.set_transforms(0, given["places_later"])
    scene.refit()
    lamp = dict(kind=pktrt.LIGHT_POINT, position=[0, 5, 0], intensity=[90, 90, 90])
    first, second = scene.add_light(**lamp), scene.add_light(**lamp)
    scene.remove_light(first)
    scene.set_light(second, kind=pktrt.LIGHT_ENVIRONMENT, intensity=[1, 0.5, 1])
    return scene


stage, sky = make_stage(), pktrt.Image(given["image_sky"])
moved = make_stage(change=1)
moved.set_transforms(0, given["places"])
moved.set_transform(1, np.eye(3, 4))
moved.refit()
there = stage.intersect(rays)
check(same(there, from_c("staged", pktrt.HIT)), "hits of instances that turn are what C gets")
check(not same(moved.intersect(rays), there), "control: they turn elsewhere")
everything, counts = stage.intersect_all(rays, 3)
check(same(everything.ravel(), from_c("all", pktrt.HIT)) and same(counts, from_c("counts", np.uintp)) and
      counts.max() > 3, "all crossings and their numbers are what C gets")
check(not same(moved.intersect_all(rays, 3)[0], everything), "control: other crossings")
nearest = stage.closest_point(rays["origin"], 2, rays["time"], mask=3)
check(same(nearest, from_c("closest", pktrt.CLOSEST)) and len(set(nearest["mesh"])) == 3, "so are the nearest points")
check(not same(stage.closest_point(rays["origin"], 2, rays["time"]), nearest), "control: by another mask others")
winding = stage.winding(1, rays["origin"], rays["time"])
check(same(winding, from_c("winding", "i4")) and set(winding) == {0, 1}, "so is what is inside a body that turns")
check(not same(stage.winding(2, rays["origin"], rays["time"]), winding), "control: inside another body")
work = pktrt.stats()
query = dict(mask=4, path=pktrt.PATH_PAPER, stats=work, type=pktrt.RAY_OTHER)
masked = stage.intersect(rays, **query)
check(same(masked, from_c("masked", pktrt.HIT)) and same(stage.occluded(rays, **query), from_c("masked_blocked", bool)),
      "queries by a mask and a path are what C gets")
check(same(work, from_c("stats", pktrt.STATS).reshape(())) and work["by_type"][pktrt.RAY_OTHER]["rays"] > N,
      "and so is the work they count")
check(not same(masked, there) and not same(pktrt.stats(), work), "control: without a mask others, and no work")
leaving = stage.spawn_at(there["mesh"], there["triangle"], there["u"], there["v"], rays["direction"], rays["time"])
check(same(leaving, from_c("left", pktrt.RAY)), "rays from points of triangles are what C gets")
check(not same(stage.spawn_at(0, there["triangle"], there["u"], there["v"], rays["direction"]), leaving),
      "control: from those of one mesh others")
infos = from_c("mesh_infos", pktrt.MESH_INFO)
check(all(same(stage.mesh_info(k), infos[k]) for k in (0, 1)) and stage.mesh_info(1)["closed"] and
      not stage.mesh_info(0)["closed"], "what meshes are is what C gets")
check(stage.mesh_source(2) == (1, 0) and stage.mesh_source(0) is None, "and where they come from")

camera = dict(eye=[1, 2, 6], eye_end=(2, 2, 6), fov_y=50, aperture=0.5, moving=True)
through = (*given["camera_places"].T, given["camera_lens"], given["camera_times"])
check(same(pktrt.camera_ray(64, 48, camera, *through), from_c("camera_rays", pktrt.RAY)),
      "rays of a camera that moves are what C gets")
check(not same(pktrt.camera_ray(64, 48, {**camera, "aperture": 0.25}, *through), from_c("camera_rays", pktrt.RAY)),
      "control: of a smaller lens others")
middles = pktrt.camera_ray(6, 4, camera)
check(middles.shape == (4, 6) and same(middles[1, 2], pktrt.camera_ray(6, 4, camera, 2.5, 1.5)),
      "without places they go through the middles of pixels")
drawn = pktrt.samples(64, 5, pktrt.SAMPLER_HALTON, seed=9, pixel=(3, 4))
check(same(drawn.ravel(), from_c("set", "f4")), "samples are what C gets")
check(not same(pktrt.samples(64, 5, pktrt.SAMPLER_HALTON, seed=8, pixel=(3, 4)), drawn), "control: another seed")
pairs = drawn[:, :2]
check(same(pktrt.map_disk(pairs).ravel(), from_c("disk", "f4")) and
      same(pktrt.map_sphere(pairs).ravel(), from_c("sphere", "f4")) and
      same(pktrt.map_cosine(pairs, [0.6, 0, 0.8]).ravel(), from_c("cosine", "f4")),
      "and so are disks, spheres and hemispheres made of them")
check(not same(pktrt.map_cosine(pairs, [0, 0, 1]).ravel(), from_c("cosine", "f4")), "control: another hemisphere")
lobes = pktrt.map_phong(pairs, [0.6, 0, 0.8], 20 * drawn[:, 2])
check(same(lobes.ravel(), from_c("phong", "f4")), "and Phong lobes")
check(not same(pktrt.map_phong(pairs, [0.6, 0, 0.8], 20), lobes), "control: of another exponent others")
check(same(pktrt.fresnel(drawn[:, 0], 1.5), from_c("glass", "f4")) and
      same(pktrt.fresnel(drawn[:, 0], drawn[:, 1], 3), from_c("metal", "f4")),
      "what glass and metal reflect is what C gets")
check(not same(pktrt.fresnel(drawn[:, 0], drawn[:, 1]), from_c("metal", "f4")), "control: without extinction less")
by_columns, by_c = np.arange(16, dtype="f4"), np.empty((3, 4), "f4")
pktrt.lib.pktrt_transform_from_4x4(ffi.from_buffer("float[]", by_columns), ffi.from_buffer("float[]", by_c))
check(same(pktrt.transform_from_4x4([by_columns, by_columns])[1], by_c),
      "matrices by columns become those of instances")

camera = dict(eye=[1, 3, 6], projection=pktrt.PROJECTION_ORTHOGRAPHIC, width=9, shutter=1, shift=[0.1, 0])
parallel = dict(mode=pktrt.MODE_DRT, samples=2, passes=3, camera=camera)
stage.prepare_environment(sky)
maps = ("pixel_error", "block_error", "report")
pixels, error, blocks, told = stage.render(48, 32, maps, environment=sky, **parallel)
check(same(pixels.ravel(), from_c("stage", "f4")), "a picture with images has the bits that C's has")
check(same(error.ravel(), from_c("pixel_error", "f4")) and same(blocks.ravel(), from_c("block_error", "f4")),
      "and so have maps of its error")
by_c = from_c("report", pktrt.REPORT)[0]
check(all(same(told[name], by_c[name]) for name in pktrt.REPORT.names if name != "seconds") and told["rmse"] > 0,
      "and so has its report")
check(not same(moved.render(48, 32, environment=sky, **parallel), pixels), "control: another image")
for name in ("image_grey", "image_shine", "image_rough", "image_leaf", "image_glow", "image_bumps"):
    was, given[name] = given[name], given[name][::-1].copy()
    check(not same(make_stage().render(48, 32, environment=sky, **parallel), pixels), f"control: {name} upside down")
    given[name] = was
check(not same(stage.render(48, 32, environment=given["image_sky"][::-1], **parallel), pixels),
      "control: the sky upside down")
by_itself = make_stage(threads=1)
check(same(by_itself.intersect(rays), there), "one thread gets the same hits")
check(same(pktrt.to_srgb8(pixels, 1.5, pktrt.TONE_CURVE).ravel(), from_c("codes", "u1")), "bytes are what C gets")
check(not same(pktrt.to_srgb8(pixels).ravel(), from_c("codes", "u1")), "control: without exposure others")
described = stage.report_text(width=48, height=32, environment=sky, **parallel)
# But for its first line, the kernels: the builds of both may have other instruction sets.
first, rest = described.split("\n", 1)
check(first.startswith("kernels") and rest == (folder / "text").read_text().split("\n", 1)[1] and "instances" in rest,
      "the text of a report is what C gets")
check(stage.report_text() != described, "control: that of queries is another")
stage.set_material(1, albedo=[0.5, 0, 0])
check(same(stage.render(48, 32, environment=sky, **parallel).ravel(), from_c("repainted", "f4")),
      "a material that is replaced looks as it does in C")
canvas = np.empty((32, 48, 3), "f4")
check(stage.render(48, 32, out=canvas, environment=sky, **parallel) is canvas and
      same(canvas.ravel(), from_c("repainted", "f4")), "a picture is written where one says")

live = np.full((2, 2, 3), 0.25, "f4")
window = pktrt.Scene(1)
wall = dict(positions=[[-9, -9, -1], [9, -9, -1], [0, 9, -1]], texcoords=[[0, 0], [1, 0], [0, 1]])
window.add_mesh(**wall, material=window.add_material(texture=dict(emission=live)))
window.commit()
lit = window.render(2, 2, camera=dict(target=[0, 0, -1]))
live[...] = 0.5
check((lit == 0.25).all() and (window.render(2, 2, camera=dict(target=[0, 0, -1])) == 0.5).all(),
      "float32 images are used where they lie")
edges = np.eye(3, dtype="f4")[None, [0, 1, 2, 2]] + np.zeros((3, 1, 1), "f4")
window = pktrt.Scene(1)
for way, column in (([0, 0, -1], 2), ([1, 0, 0], 3), ([-1, 0, 0], 1)):
    seen = window.render(1, 1, environment=edges, camera=dict(target=way, fov_y=0.1), samples=1)[0, 0]
    want = (edges[0, column - 1] + edges[0, column]) / 2
    check(np.allclose(seen, want, atol=1e-2), f"an environment has at {way} its columns {column - 1} and {column}")
top = np.arange(1, 4, dtype="f4")[:, None] * np.ones((1, 4), "f4")
seen = [window.render(1, 1, environment=top, camera=dict(target=way, up=[1, 0, 0], fov_y=0.1), samples=1)[0, 0, 0]
        for way in ([0, 1, 0], [0, 0, 1], [0, -1, 0])]
check(np.allclose(seen, [1, 2, 3], atol=1e-2), "and its upper row above")
released = pktrt.Image(given["image_albedo"])
holder = pktrt.Scene(1)
painted = holder.add_material(texture=released)
mark = weakref.ref(released)
del released
gc.collect()
check(mark() is not None, "a material keeps its image")
holder.set_material(painted, albedo=[1, 1, 1])
gc.collect()
check(mark() is None, "until it has another one")
shown = pktrt.Image(given["image_sky"])
holder.prepare_environment(shown)
mark = weakref.ref(shown)
del shown
gc.collect()
check(mark() is not None, "a scene keeps the environment that it has prepared")
holder.prepare_environment(None)
check(mark() is None, "until it forgets it")

# --- the same structures ---

layout = (folder / "layout").read_text().split("\n")[:-1]


def offset(line, twins):
    kind, *field = line.split()[:-1]
    if kind in twins:
        return twins[kind].fields[field[0]][1] if field else twins[kind].itemsize
    return ffi.offsetof(kind, field[0]) if field else ffi.sizeof(kind)


twins = dict(pktrt_ray=pktrt.RAY, pktrt_hit=pktrt.HIT, pktrt_surface_info=pktrt.SURFACE)
wrong = [line for line in layout if offset(line, twins) != int(line.split()[-1])]
check(not wrong and len(layout) == 33, f"{len(layout)} sizes and offsets are those of C {wrong}")
formats = [pktrt.RAY.fields[name][0] for name in pktrt.RAY.names]
twins["pktrt_ray"] = np.dtype(dict(names=pktrt.RAY.names, formats=formats, offsets=[0, 12, 16, 32, 28], itemsize=36))
check(sum(offset(line, twins) != int(line.split()[-1]) for line in layout) == 2,
      "control: two that are exchanged are noticed")

# --- the same sentences ---

sentences = (folder / "sentences").read_text().split("\n")[:-1]


def sentence_of(call):
    try:
        call()
    except pktrt.Error as error:
        return str(error), error.status
    return None, pktrt.OK


bad = [[0, 1, 5]]
check(sentence_of(lambda: world.add_mesh(np.zeros((3, 3)), bad)) == (sentences[0], pktrt.INVALID_ARGUMENT),
      f"raised: {sentences[0]}")
check(sentence_of(lambda: world.set_enabled(7, False))[0] == sentences[1], f"raised: {sentences[1]}")
check(sentence_of(lambda: world.add_mesh(np.zeros((3, 3)), [[0, 1, 4]]))[0] != sentences[0],
      "control: another mistake, another sentence")
check(sentence_of(lambda: world.set_enabled(1, True))[0] is None, "control: what is right raises nothing")
check(sentence_of(lambda: pktrt.Scene(isa=pktrt.ISA_NEON + 99))[0], "a scene that cannot be made says why")


def refused(error, call):
    try:
        call()
    except error:
        return True
    return False


check(refused(ValueError, lambda: world.add_mesh(np.zeros((3, 2)))), "positions that are pairs are refused")
check(refused(ValueError, lambda: world.add_mesh(np.zeros((3, 3)), [[0, 1, -1]])), "indices below 0 are refused")
check(refused(ValueError, lambda: world.add_mesh(np.zeros((3, 3)), [[0, 1, 2 ** 32]])),
      "indices of more than 32 bits are refused")
check(refused(ValueError, lambda: world.set_positions(0, positions0[1:])), "less positions than before are refused")
check(refused(TypeError, lambda: world.intersect(np.zeros((3, 9), "f4"))), "an array that is none of rays is refused")
check(refused(ValueError, lambda: world.intersect(rays, out=hits[1:])), "an array of another length is not written to")
frozen = hits.copy()
frozen.flags.writeable = False
check(refused((ValueError, BufferError), lambda: world.intersect(rays, out=frozen)) and same(frozen, hits),
      "nor is one that is read-only")

# --- what describes arrays is taken from them ---


def outcome(call):
    """What a call raises, as its name and sentence; ("none", result) where it raises nothing."""
    try:
        return "none", call()
    except Exception as error:  # whatever it is
        return type(error).__name__, str(error)


three, matrix = np.eye(3, dtype="f4"), np.eye(3, 4)
room = pktrt.Scene(threads=1)
model = room.add_model(dict(positions=three), dict(positions=three, triangles=[[0, 1, 2]], material=0))
placed = room.add_instance(model, [matrix, matrix])
room.commit()
described = dict(
    add_mesh=(lambda **more: room.add_mesh(three, **more),
              dict(vertex_count=2, triangle_count=0, key_count=1, position_stride=8, indices=ffi.NULL)),
    add_model=(lambda **more: room.add_model(dict(positions=three, **more)),
               dict(vertex_count=2, triangle_count=0, key_count=1, position_stride=8, indices=ffi.NULL)),
    add_instance=(lambda **more: room.add_instance(model, matrix, **more), dict(key_count=1)),
    render=(lambda **more: room.render(4, 4, **more),
            dict(row_stride=13, pixels=ffi.NULL, depth=ffi.NULL, normal=ffi.NULL, albedo=ffi.NULL, cost=ffi.NULL,
                 sample_count=ffi.NULL, pixel_error=ffi.NULL, block_error=ffi.NULL)))
taken = [(call, name, outcome(lambda: described[call][0](**{name: value})))
         for call in described for name, value in described[call][1].items()]
missed = [(call, name) for call, name, (kind, said) in taken
          if kind != "TypeError" or f"{name} is no argument" not in said]
check(not missed and len(taken) == 20, f"{len(taken)} arguments that arrays tell are refused {missed}")
known = {call: sorted(dict(ffi.typeof("pktrt_" + desc).fields)) for call, desc in
         dict(add_mesh="mesh_desc", add_instance="instance_desc", render="render_desc").items()}
free = dict(add_mesh={"material", "group", "mask"}, add_instance={"model", "mask", "interpolation"})
arrays = {"positions", "normals", "texcoords", "transforms", "triangle_materials"}  # arguments by themselves
check(all(set(known[call]) - set(described[call][1]) - arrays == free[call] for call in free),
      "no field of meshes and instances is left that could describe an array")
pointers = {name for name, field in ffi.typeof("pktrt_render_desc").fields
            if field.type.kind == "pointer" and field.type.item.kind == "primitive"}
check(pointers == set(described["render"][1]) - {"row_stride"}, "nor is one of pictures that points to one")
check(outcome(lambda: room.add_mesh(three, material=0, group=1, mask=3))[0] == "none" and
      outcome(lambda: room.add_instance(model, matrix, mask=3))[0] == "none", "control: other fields are taken")
check(outcome(lambda: room.set_transform(placed, [1, 2, 3]))[0] == "ValueError" and
      outcome(lambda: room.set_transform(placed, matrix, key=1))[0] == "none", "a matrix that is too short is refused")
answer = ffi.new("int *")
listed = outcome(lambda: room.winding_n(0, [0.5], [0.0], answer, 1))
check(listed[0] == "TypeError" and "argument 2" in listed[1], "lists are refused where C wants pointers")
check(outcome(lambda: room.winding_n(0, ffi.new("float[3]"), ffi.new("float[1]"), answer, 1))[0] == "none",
      "control: pointers are taken")
rows, columns = room.render(40, 20, ("block_error",), passes=2, camera=dict(eye=[0, 0, 5]))[1].shape
check((rows, columns) == (2, 3), "errors of blocks have an array of blocks")

four = np.zeros((4, 3), "f4")
loose = outcome(lambda: room.add_mesh(four))
check(loose[0] == "Error" and "a soup of 2 triangles needs 6 vertices, vertex_count is 4" in loose[1],
      f"loose vertices that are no multiple of three: {loose[1]}")
check(outcome(lambda: room.add_mesh(four, [[0, 1, 3]]))[0] == "none", "control: with triangles they may be four")

for call, sentence, names in (
        (lambda: room.add_mesh(three, materail=1), "no field materail", ("group", "mask", "material")),
        (lambda: room.add_light(knd=0), "no field knd", ("kind", "position")),
        (lambda: room.add_material(colour=[1, 1, 1]), "no field colour", ("albedo", "emission")),
        (lambda: room.render(4, 4, sample=1), "no field sample", ("samples", "camera")),
        (lambda: room.render(4, 4, camera=dict(fov=50)), "no field fov", ("fov_y", "eye")),
        (lambda: room.render(4, 4, ("dept",)), "no buffer dept", ("depth", "normal")),
        (lambda: pktrt.Scene(isaa=1), "no field isaa", ("isa", "quality"))):
    kind, said = outcome(call)
    check(kind in ("TypeError", "ValueError") and sentence in said and all(name in said for name in names),
          f"{sentence}, and which there are")

# --- what does not fit is refused by name ---

spot = np.zeros((2, 3))
ray = pktrt.rays(spot, [0, 0, 1])
grass = np.zeros((4, 4, 3), "u1")
sheet = room.add_mesh(three)
room.commit()
wrong = (
    ("positions", lambda: room.add_mesh("none")), ("positions", lambda: room.add_mesh([[1, 2, 3], [4, 5]])),
    ("positions", lambda: room.add_mesh(np.zeros((2, 3), complex))), ("positions", lambda: room.add_mesh(None)),
    ("triangles", lambda: room.add_mesh(three, [[0.5, 1, 2]])), ("triangles", lambda: room.add_mesh(three, [0, 1, 2])),
    ("normals", lambda: room.add_mesh(three, normals=[0, 1, 0])),
    ("texcoords", lambda: room.add_mesh(three, texcoords=three)),
    ("triangle_materials", lambda: room.add_mesh(three, triangle_materials=[0, 0])),
    ("material", lambda: room.add_mesh(three, material="red")), ("group", lambda: room.add_mesh(three, group=-1)),
    ("meshes", lambda: room.add_model(three)),
    ("material", lambda: room.add_model(dict(positions=three, material=0.5))),
    ("model", lambda: room.add_instance("first")), ("transforms", lambda: room.add_instance(model, np.eye(4))),
    ("interpolation", lambda: room.add_instance(model, interpolation="rigid")),
    ("transform", lambda: room.set_transform(placed, np.eye(4))),
    ("key", lambda: room.set_transform(placed, matrix, 0.5)),
    ("instance", lambda: room.set_transform(1.5, matrix)),
    ("instance", lambda: room.set_transforms(7, [matrix, matrix])),
    ("transforms", lambda: room.set_transforms(placed, matrix)), ("mesh", lambda: room.set_positions(99, three)),
    ("positions", lambda: room.set_positions(sheet, three[1:])),
    ("normals", lambda: room.set_normals(sheet, "up")),
    ("position", lambda: room.add_light(position=[1, 2])), ("edge", lambda: room.add_light(edge=[1, 0, 0])),
    ("intensity", lambda: room.add_light(intensity="bright")), ("radius", lambda: room.add_light(radius=[1])),
    ("light", lambda: room.set_light("sun", kind=0)), ("kind", lambda: room.set_light(0, kind="point")),
    ("material", lambda: room.set_material(-1)), ("albedo", lambda: room.set_material(1, albedo=0.5)),
    ("ior", lambda: room.add_material(ior=[1.5])), ("exponent", lambda: room.add_material(exponent=[1, 2])),
    ("texture", lambda: room.add_material(texture="grass.png")),
    ("texture", lambda: room.add_material(texture=grass[..., :2])),
    ("texture", lambda: room.add_material(texture=np.zeros((4, 4, 4), "u1"))),
    ("texture", lambda: room.add_material(texture=grass.astype(int))),
    ("texture", lambda: room.add_material(texture=np.full((2, 2), np.nan))),
    ("texture: there is no colour", lambda: room.add_material(texture=dict(colour=grass))),
    ("texture: opacity", lambda: room.add_material(texture=dict(opacity=grass))),
    ("texture: normal", lambda: room.add_material(texture=dict(normal=grass[..., 0]))),
    ("user", lambda: room.add_material(texture=grass, user=ffi.NULL)),
    ("wrap", lambda: pktrt.Image(grass, wrap="mirror")), ("coding", lambda: pktrt.Image(grass, coding="gamma")),
    ("environment", lambda: room.render(2, 2, environment=grass[0, 0])),
    ("environment", lambda: room.prepare_environment("sky")),
    ("user", lambda: room.render(2, 2, environment=grass, user=1)),
    ("width", lambda: room.render(2.5, 2)), ("height", lambda: room.render(2, "2")),
    ("out", lambda: room.render(2, 2, out=[0])), ("out", lambda: room.render(2, 2, out=np.zeros((2, 2, 3)))),
    ("report", lambda: room.render(2, 2, ("report",), report=ffi.NULL)),
    ("samples", lambda: room.render(2, 2, samples=1.5)),
    ("camera: eye", lambda: room.render(2, 2, camera=dict(eye=[0, 0]))),
    ("camera: fov_y", lambda: room.render(2, 2, camera=dict(fov_y="wide"))),
    ("background", lambda: room.render(2, 2, background=1)), ("origins", lambda: pktrt.rays([0, 0], [0, 0, 1])),
    ("directions", lambda: pktrt.rays([0, 0, 0], 1)),
    ("directions", lambda: pktrt.rays(np.zeros((2, 3)), np.ones((3, 3)))),
    ("tmax", lambda: pktrt.rays([0, 0, 0], [0, 0, 1], tmax="far")), ("rays", lambda: room.intersect(spot)),
    ("mask", lambda: room.intersect(ray, mask=-1)), ("stats", lambda: room.occluded(ray, stats=3)),
    ("no field masks", lambda: room.intersect(ray, masks=1)), ("capacity", lambda: room.intersect_all(ray, 1.5)),
    ("rays", lambda: room.intersect_all(spot, 1)), ("points", lambda: room.closest_point([1, 2])),
    ("max_distance", lambda: room.closest_point(spot, [1, 2, 3])), ("mask", lambda: room.closest_point(spot, mask=-1)),
    ("previous", lambda: room.intersect_after(ray, ray)), ("hits", lambda: room.surface(ray, ray)),
    ("directions", lambda: room.spawn(ray, room.intersect(ray), [0, 0, 1])),
    ("directions", lambda: room.spawn_at(0, 0, 0, 0, [1, 2])), ("triangle", lambda: room.spawn_at(0, 0.5, 0, 0, spot)),
    ("u", lambda: room.spawn_at(0, 0, [0, 0, 0], 0, spot)), ("mesh", lambda: room.mesh_info("floor")),
    ("mesh", lambda: room.winding(None, spot)), ("points", lambda: room.winding(0, 1)),
    ("camera: up", lambda: pktrt.camera_ray(4, 4, dict(up=0))), ("lens", lambda: pktrt.camera_ray(4, 4, lens=[0.5])),
    ("y", lambda: pktrt.camera_ray(4, 4, x=1)), ("width", lambda: pktrt.camera_ray("4", 4)),
    ("count", lambda: pktrt.samples(0, 2)), ("seed", lambda: pktrt.samples(4, 2, seed="x")),
    ("u", lambda: pktrt.map_disk([1, 2, 3])), ("normals", lambda: pktrt.map_cosine(np.zeros((2, 2)), [0, 1])),
    ("exponent", lambda: pktrt.map_phong(spot[:, :2], [0, 0, 1], [1, 2, 3])),
    ("axes", lambda: pktrt.map_phong(spot[:, :2], 1 + 1j, 1)),
    ("eta", lambda: pktrt.fresnel([0, 1], "glass")), ("cosine", lambda: pktrt.fresnel([0, 1], [1, 2, 3])),
    ("matrices", lambda: pktrt.transform_from_4x4(matrix)), ("index", lambda: room.node(0, 99)),
    ("tree", lambda: room.node("root", 0)), ("time", lambda: room.node(0, 0, "noon")),
    ("pixels", lambda: pktrt.to_srgb8([1, 2])), ("exposure", lambda: pktrt.to_srgb8(spot, exposure="dark")),
    ("threads", lambda: pktrt.Scene(threads="many")), ("quality", lambda: pktrt.Scene(quality="high")),
    ("mesh", lambda: room.remove_mesh("first")), ("enabled", lambda: room.set_enabled(0, "yes")),
    ("mesh, enabled", lambda: room.set_enabled(0)))
unnamed = [(name, kind, said) for name, (kind, said) in ((name, outcome(call)) for name, call in wrong)
           if kind not in ("TypeError", "ValueError", "OverflowError") or name not in said]
check(not unnamed, f"{len(wrong)} arguments that do not fit are refused by name {unnamed}")
for words, call in (("fov_y", lambda: pktrt.camera_ray(4, 4, dict(fov_y=200))),
                    ("radius", lambda: room.add_light(kind=pktrt.LIGHT_SPHERE, radius=-1)),
                    ("light", lambda: room.set_light(77, kind=pktrt.LIGHT_POINT)),
                    ("material", lambda: room.set_material(0, albedo=[1, 1, 1])),
                    ("mesh 1234", lambda: room.mesh_info(1234)),
                    ("render_tile", lambda: room.render_tile(ffi.new("pktrt_render_desc *"), 0, 0, 1, 1)),
                    ("model", lambda: room.remove_model(model))):
    kind, said = outcome(call)
    check(kind == "Error" and words in said, f"raised: {said}")
check(outcome(lambda: room.intersect(ray))[0] == "none" and
      outcome(lambda: room.render(2, 2, camera=dict(eye=[0, 0, 5])))[0] == "none",
      "control: what fits is taken, and nothing is lost")

# --- callbacks ---


def heard():
    """A scene with a callback that nothing else holds, what it hears, and whether the callback lives."""
    told = []

    def log(_user, _level, sentence):
        told.append(ffi.string(sentence).decode())

    scene = pktrt.Scene(threads=1, rebuild=pktrt.REBUILD_ADVISE,
                        log=ffi.callback("void(void *, int, const char *)", log))
    return scene, told, weakref.ref(log)


talking, told, callback = heard()
gc.collect()
check(callback() is not None, "a scene keeps its callback")
if callback() is not None:
    sheet = talking.add_mesh(positions0, triangles0)
    talking.commit()
    talking.set_positions(sheet, numbers.uniform(-1, 1, positions0.shape))
    talking.refit()
    check(any("rebuild is advised" in sentence for sentence in told), f"which is called: {told}")
del talking
gc.collect()
check(callback() is None, "control: without the scene the callback goes, too")
check("user is no argument" in outcome(lambda: pktrt.Scene(threads=2, user=ffi.NULL))[1] and
      outcome(lambda: pktrt.Scene(threads=1, user=ffi.NULL))[0] == "none", "user is not taken from the threads")

# --- no copies ---

passed = {}


class Spy:
    """The library, whose calls leave word of what addresses they get."""

    def __init__(self, of):
        self.of = of

    def __getattr__(self, name):
        call = getattr(self.of, name)
        return (lambda *a: (passed.__setitem__(name, self.addresses(a)), call(*a))[1]) if callable(call) else call

    @staticmethod
    def addresses(arguments):
        pointers = [a for a in arguments[1:] if isinstance(a, ffi.CData)]
        if pointers and ffi.typeof(pointers[0]).cname == "pktrt_mesh_desc *":
            pointers = [pointers[0].positions, pointers[0].indices, pointers[0].normals]
        return [int(ffi.cast("uintptr_t", pointer)) for pointer in pointers]


def at(*arrays):
    return [array.ctypes.data for array in arrays]


kept, pktrt.lib = pktrt.lib, Spy(pktrt.lib)
out, seen = np.empty(N, pktrt.HIT), np.empty(N, bool)
check(world.intersect(rays, out=out) is out and passed["pktrt_intersect_n"] == at(rays, out),
      "rays and hits are where C works on them")
made = world.intersect(rays)
check(passed["pktrt_intersect_n"] == at(rays, made), "so are hits that are made anew")
world.intersect(rays[::2])
check(passed["pktrt_intersect_n"][0] != at(rays)[0], "control: rays with gaps are copied")
check(same(world.intersect(rays[::2]), hits[::2]), "and have the same hits")
world.occluded(rays, out=seen)
check(passed["pktrt_occluded_n"] == at(rays, seen), "so are flags of what is in the way")
up = np.ones((len(positions0), 3), "f4")
world.add_mesh(positions0, triangles0, normals=up)
check(passed["pktrt_add_mesh"] == at(positions0, triangles0, up),
      "positions, triangles and normals are where C reads them")
world.add_mesh(positions0.astype("f8"), triangles0.astype("i8"))
check(not set(passed["pktrt_add_mesh"]) & set(at(positions0, triangles0)), "control: other types are copied")
later = positions0.copy()
world.set_positions(0, later)
check(passed["pktrt_set_positions"] == at(later), "so are positions that replace others")
world.set_positions(0, np.asfortranarray(later))
check(passed["pktrt_set_positions"] != at(later), "control: those in another order of axes are copied")
pktrt.lib = kept

# --- threads ---

many = np.tile(rays, 100)
want = np.tile(hits, 100)
answers = [None] * 4


def ask(k):
    answers[k] = alone.intersect(many)


threads = [threading.Thread(target=ask, args=(k,)) for k in range(4)]
for thread in threads:
    thread.start()
for thread in threads:
    thread.join()
check(all(same(answer, want) for answer in answers), "four threads ask at a time, and get the same bits")


def steps_during(call):
    """How often this thread gets on while another one is in a call of half a second or so."""
    state = []
    thread = threading.Thread(target=lambda: (state.append("begun"), call(), state.append("done")))
    steps = 0
    thread.start()
    while len(state) < 2:
        time.sleep(0.001)
        steps += len(state) == 1
    thread.join()
    return steps


held = ctypes.PyDLL(pktrt.library_path).pktrt_intersect_n  # keeps Python's lock
held.argtypes, held.restype = [ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_size_t], None
out = np.empty(len(many), pktrt.HIT)
handle = int(ffi.cast("uintptr_t", alone.handle))
free = steps_during(lambda: alone.intersect(many, out=out))
stuck = steps_during(lambda: held(handle, *at(many, out), len(many)))
check(free > 4, f"other threads get on during a call: {free} steps")
check(stuck < 4, f"control: by a call that keeps Python's lock they do not: {stuck} steps")

# --- the example ---

ao = [sys.executable, "-B", ROOT / "examples" / "python" / "ao.py"]
first = subprocess.run(ao, check=True, capture_output=True).stdout
second = subprocess.run(ao, check=True, capture_output=True).stdout
check(first == second and len(first) == 15 + 480 * 320 and len(set(first)) > 50,
      "ao.py makes a picture, and the same again")
soup = np.array([len(triangles0)], "<u4").tobytes() + positions0[triangles0].astype("<f4").tobytes()
(folder / "hill.tri").write_bytes(soup)
hill = subprocess.run([*ao, folder / "hill.tri"], check=True, capture_output=True).stdout
check(hill != first and len(set(hill)) > 50, "and another one of a .tri file")

# --- the example of view factors ---

if importlib.util.find_spec("matplotlib"):
    plots = folder / "factors.png"
    factors = [sys.executable, "-B", ROOT / "examples" / "python" / "factors.py", "--quick", plots]
    said = subprocess.run(factors, check=True, capture_output=True, text=True).stdout
    furthest = [float(line.split()[-6]) for line in said.splitlines() if line.endswith("standard errors off at most")]
    check(len(furthest) == 4 and 1 < max(furthest) < 4 and plots.read_bytes()[:4] == b"\x89PNG",
          f"factors.py: view factors are the closed forms', within {furthest} standard errors")
else:
    print("  test-python: there is no matplotlib (make deps-extra), factors.py is not run")

# --- pip ---

if all(importlib.util.find_spec(name) for name in ("pip", "setuptools", "wheel")):
    room = BUILD / "python" / "pip"
    shutil.rmtree(room, ignore_errors=True)
    shutil.copytree(ROOT / "examples" / "python", room / "examples" / "python",
                    ignore=shutil.ignore_patterns("build", "*.egg-info", "__pycache__"))
    shutil.copy(ROOT / "pktrt.h", room)
    bare = {name: value for name, value in os.environ.items() if not name.startswith("PKTRT_")}
    pip = [sys.executable, "-m", "pip", "install", "--no-build-isolation", "--no-index", "--no-deps", "--quiet",
           "--disable-pip-version-check", "--target", room / "to", "."]
    quick = {"PIP_ROOT_USER_ACTION": "ignore", "CFLAGS": "-O1 -DPKTRT_NO_AVX2"}
    done = subprocess.run(pip, cwd=room / "examples" / "python", env={**bare, **quick}, capture_output=True, text=True)
    check(done.returncode == 0, f"pip installs it offline {done.stderr}")
    program = ("import pktrt, sys; s = pktrt.Scene(); s.add_mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]]); s.commit(); "
               "print(pktrt.library_path, s.intersect(pktrt.rays([.25, .25, 1], [0, 0, -1]))['t'])")
    use = [sys.executable, "-c", program]
    # Elsewhere, without header, and with a compiler that fails.
    shutil.rmtree(room / "examples")
    (room / "pktrt.h").unlink()
    away = {**bare, "PYTHONPATH": str(room / "to"), "CC": "false", "HOME": str(room)}
    done = subprocess.run(use, cwd="/", env=away, capture_output=True, text=True)
    check(done.returncode == 0 and str(room / "to") in done.stdout and done.stdout.endswith(" 1.0\n"),
          f"and what it has installed needs neither compiler nor header {done.stderr}")
    for made in (room / "to").glob("_pktrt*"):
        made.unlink()
    done = subprocess.run(use, cwd="/", env=away, capture_output=True, text=True)
    check(done.returncode != 0, "control: without the library it does")
else:
    print("  test-python: there is no pip, setuptools or wheel (make deps-extra), nothing is installed")

print(f"test-python: {checks - failures} of {checks} checks passed")
sys.exit(failures != 0)
