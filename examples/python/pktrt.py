"""pktrt.h in Python: one file over cffi, with numpy arrays in and out. Needs a C compiler, cffi and numpy.

    scene = pktrt.Scene()
    mesh = scene.add_mesh(positions, triangles)          # arrays of (n, 3) and (m, 3)
    scene.commit()
    hits = scene.intersect(pktrt.rays(origins, directions))
    hits["t"][hits["mesh"] != pktrt.NONE]

Names are those of the header without pktrt_: any call on a scene is a method, scene.refit() and scene.set_enabled(3,
False) as well as those below, and constants are pktrt.MODE_WRT, pktrt.NONE and so on. pktrt.lib and pktrt.ffi have
everything as C has it, scene.handle is the pktrt_scene. What fails raises pktrt.Error with the library's sentence.
What the library wonders about goes to the logger "pktrt".

Memory. Counts, strides and key counts are taken from arrays, and refused as arguments; so are pointers, where a method
here takes arrays. Calls that have no method here take pointers as C does: what pktrt.ffi.new makes, never a list, whose
length nobody would look at. Callbacks that a scene or a material has been given live as long as the scene.

Nothing is declared here: the declarations are the header's own, as the compiler's preprocessor leaves them. The
implementation is compiled into a cache folder when it is first needed, which takes half a minute, and again when
header, compiler or flags are others. The environment says where and how: PKTRT_HEADER, PKTRT_CACHE (else
~/.cache/pktrt), CC, CFLAGS (else -O2; with -DPKTRT_AVX512 it has AVX-512, too).

Copies. Rays, hits and surfaces are arrays of the C structures (pktrt.RAY, HIT, SURFACE), of any shape: the library
reads and writes their memory. It reads that of positions (float32), triangles (uint32), normals and others, too, in
the call alone, as it keeps copies of its own. Only arrays of other types, with gaps or in another order of axes are
copied before. `out` takes arrays to write to, so that no new ones are made.

Threads. Python's other threads run during each call. Queries of a committed scene may come from many at once; while a
call changes the scene there must be no other. The library's own threads build and render: Scene(threads=1) has none.
"""
import hashlib
import logging
import os
import pathlib
import platform
import re
import shlex
import subprocess
import tempfile

import cffi
import numpy as np

# --- the library ---

# Distributes work among threads of C, which neither wait for Python's lock nor stop at its interrupts.
_SOURCE = r"""
#define PKTRT_IMPLEMENTATION
#include PKTRT_HEADER_FILENAME
#include <pthread.h>
typedef struct job {
  void (*body)(void *arg, size_t i);
  void *arg;
  size_t n, next;
  pthread_mutex_t lock;
} job;
static void *work(void *of) {
  job *j = (job *)of;
  for (;;) {
    pthread_mutex_lock(&j->lock);
    const size_t i = j->next++;
    pthread_mutex_unlock(&j->lock);
    if (i >= j->n) return NULL;
    j->body(j->arg, i);
  }
}
extern void pktrt_parallel_for(void *user, size_t n, void (*body)(void *arg, size_t i), void *arg) {
  enum { MOST = 255 };
  pthread_t thread[MOST];
  size_t count = 0;
  job j = {body, arg, n, 0, PTHREAD_MUTEX_INITIALIZER};
  const size_t most = (uintptr_t)user < n ? (uintptr_t)user : n;
  while (count + 1 < most && count < MOST && !pthread_create(&thread[count], NULL, work, &j)) count++;
  work(&j);
  while (count) pthread_join(thread[--count], NULL);
}
"""
_OWN = "void pktrt_parallel_for(void *user, size_t n, void (*body)(void *arg, size_t i), void *arg);"


def _run(*command):
    try:
        done = subprocess.run(command, capture_output=True, text=True, check=False)
    except OSError as error:
        raise RuntimeError(f"{command[0]} cannot be run: {error.strerror}") from None
    if done.returncode:
        raise RuntimeError(f"{' '.join(command)}:\n{done.stderr.strip()}")
    return done.stdout


def _declarations(compile_with, header):
    """Hides what the header includes behind empty files, for cffi knows these types. Of macros keeps whole numbers."""
    with tempfile.TemporaryDirectory() as empty:
        for name in ("stdbool.h", "stddef.h", "stdint.h"):
            pathlib.Path(empty, name).touch()
        text = _run(*compile_with, "-E", "-dD", "-P", "-D__attribute__(x)=", "-I" + empty, "-x", "c", header)
    number = re.compile(r"#define PKTRT_[A-Z]\w* (0[xX])?[0-9A-Fa-f]+[uU]?\s*$")
    return "\n".join(line for line in text.splitlines() if not line.startswith("#") or number.match(line)) + _OWN


def _library(compile_with, header, folder):
    """Compiles the header, unless that is done. The file gets its name when it is whole: others may do the same."""
    key = hashlib.sha256(pathlib.Path(header).read_bytes())
    version = _run(*compile_with[:1], "--version")
    key.update("\0".join([_SOURCE, *compile_with, version, platform.machine()]).encode())
    path = pathlib.Path(folder, f"pktrt-{key.hexdigest()[:16]}.so")
    if not path.exists():
        path.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=path.parent) as room:
            source, made = pathlib.Path(room, "pktrt.c"), pathlib.Path(room, "pktrt.so")
            source.write_text(_SOURCE)
            named = f'-DPKTRT_HEADER_FILENAME="{header}"'
            _run(*compile_with, "-shared", "-fPIC", named, str(source), "-o", str(made), "-lm", "-lpthread")
            os.replace(made, path)
    return str(path)


def _load():
    here = pathlib.Path(__file__).resolve()
    beside = here.with_name("pktrt.h")
    header = os.environ.get("PKTRT_HEADER") or str(beside if beside.exists() else here.parents[2] / "pktrt.h")
    header = str(pathlib.Path(header).resolve())
    caches = os.environ.get("XDG_CACHE_HOME") or pathlib.Path.home() / ".cache"
    folder = os.environ.get("PKTRT_CACHE") or pathlib.Path(caches, "pktrt")
    compile_with = shlex.split(os.environ.get("CC") or "cc") + shlex.split(os.environ.get("CFLAGS") or "-O2")
    interface = cffi.FFI()
    interface.cdef(_declarations(compile_with, header))
    path = _library(compile_with, header, folder)
    return interface, interface.dlopen(path), path


ffi, lib, library_path = _load()


def __getattr__(name):
    """Offers the header's constants: pktrt.MODE_WRT is PKTRT_MODE_WRT."""
    if name.isupper() and hasattr(lib, "PKTRT_" + name):
        return getattr(lib, "PKTRT_" + name)
    raise AttributeError(f"pktrt.h has no PKTRT_{name}")


@ffi.callback("void(void *, int, const char *)")
def _log(_user, level, sentence):
    logging.getLogger("pktrt").log(logging.INFO if level else logging.WARNING, "%s", ffi.string(sentence).decode())


class Error(Exception):
    """What the library has refused: its sentence, and as `status` one of pktrt.INVALID_ARGUMENT, LIMIT, ..."""

    def __init__(self, status, sentence):
        super().__init__(sentence)
        self.status = status


# --- arrays ---


def _dtype(kind):
    """The numpy twin of a C type: the offsets are those that cffi has."""
    if kind.kind == "array":
        return np.dtype((_dtype(kind.item), (kind.length,)))
    if kind.kind == "struct":
        of = dict(names=[], formats=[], offsets=[], itemsize=ffi.sizeof(kind))
        for name, field in kind.fields:
            of["names"].append(name)
            of["formats"].append(_dtype(field.type))
            of["offsets"].append(field.offset)
        return np.dtype(of, align=True)
    if kind.cname == "_Bool":
        return np.dtype(bool)
    name = {"float": "f", "double": "f"}.get(kind.cname) or ("u" if int(ffi.cast(kind, -1)) > 0 else "i")
    return np.dtype(f"{name}{ffi.sizeof(kind)}")


RAY, HIT, SURFACE = (_dtype(ffi.typeof(kind)) for kind in ("pktrt_ray", "pktrt_hit", "pktrt_surface_info"))


def _values(values, dtype, shape, name):
    """An array that C can read, of any size where `shape` has None. Copies only where type or order are others."""
    array = np.asarray(values)
    if array.dtype != dtype and (dtype.names or array.dtype.names):
        raise TypeError(f"{name}: an array of {array.dtype} is none of {dtype}")
    if array.dtype != dtype and dtype.kind == "u" and array.size:  # where numpy would wrap around
        if array.dtype.kind not in "iu" or array.min() < 0 or array.max() > np.iinfo(dtype).max:
            raise ValueError(f"{name}: not all of them are whole numbers of 32 bits")
    if len(array.shape) != len(shape) or any(want not in (None, have) for want, have in zip(shape, array.shape)):
        raise ValueError(f"{name}: the shape is {array.shape}, not {str(shape).replace('None', 'any')}")
    return np.require(array, dtype, "CA")


def _structs(values, dtype, name):
    return _values(values, dtype, np.shape(values), name)


def _output(out, dtype, shape):
    if out is None:
        return np.empty(shape, dtype)
    if out.dtype != dtype or out.shape != shape or not (out.flags.c_contiguous and out.flags.aligned):
        raise ValueError(f"out: not a contiguous array of shape {shape} and type {dtype}")
    return out


def _new(kind, fields, call, taken=None):
    """A new C structure of these fields. Refuses names it has not got, and those that `taken` has reasons for."""
    _check_fields(ffi.typeof(kind), fields, call, taken or {})
    return ffi.new(kind + " *", _plain(fields))


def _check_fields(kind, fields, where, taken):
    known = dict(kind.fields)
    for name, value in fields.items():
        if name in taken:
            raise TypeError(f"{where}: {name} is no argument: {taken[name]}")
        if name not in known:
            names = ", ".join(sorted(set(known) - set(taken)))
            raise TypeError(f"{where}: there is no field {name} in {kind.cname}, but these: {names}")
        if isinstance(value, dict):
            if known[name].type.kind != "struct":
                raise TypeError(f"{where}: {name} is {known[name].type.cname}, which no dict can be")
            _check_fields(known[name].type, value, f"{where}: {name}", {})


def _read(array, kind):
    return ffi.NULL if array is None else ffi.from_buffer(kind + "[]", array)


def _write(array, kind):
    return ffi.from_buffer(kind + "[]", array, require_writable=True)


def _plain(value):
    if isinstance(value, dict):
        return {key: _plain(part) for key, part in value.items()}
    return value.tolist() if isinstance(value, (np.ndarray, np.generic)) else value


def rays(origins, directions, tmin=0, tmax=np.inf, time=0):
    """An array of rays; what is given is repeated where others have more, as numpy does it."""
    origins, directions = np.asarray(origins), np.asarray(directions)
    shape = np.broadcast_shapes(origins.shape[:-1], directions.shape[:-1], *map(np.shape, (tmin, tmax, time)))
    made = np.empty(shape, RAY)
    made["origin"], made["direction"], made["tmin"], made["tmax"], made["time"] = origins, directions, tmin, tmax, time
    return made


# --- scenes ---

# What is known of arrays, and no argument.
_OF_ARRAYS = {name: "it is taken from the arrays" for name in (
    "vertex_count", "triangle_count", "key_count", "position_stride", "row_stride")}
_OF_ARRAYS["indices"] = "give triangles"

# What a render can write: values of a pixel, and how many pixels wide and high that is.
_BUFFERS = {"depth": (1, 1), "normal": (3, 1), "albedo": (3, 1), "sample_count": (1, 1), "cost": (1, 1),
            "pixel_error": (1, 1), "block_error": (1, lib.PKTRT_ERROR_BLOCK)}


class Scene:
    """A pktrt_scene. threads: how many build and render, by default one per processor; fields: of pktrt_scene_desc."""

    def __init__(self, threads=None, **fields):
        threads = threads or os.cpu_count() or 1
        hooks = dict(log=_log, user=ffi.cast("void *", threads))
        if threads > 1:
            hooks["parallel_for"] = ffi.addressof(lib, "pktrt_parallel_for")
        own_threads = threads > 1 and "parallel_for" not in fields
        taken = {"user": "the threads made here use it; give threads=1, or a parallel_for that knows it"}
        _check_fields(ffi.typeof("pktrt_scene_desc"), fields, "Scene", taken if own_threads else {})
        handle = lib.pktrt_scene_create(_new("pktrt_scene_desc", {**hooks, **fields}, "Scene"))
        if handle == ffi.NULL:
            raise Error(None, ffi.string(lib.pktrt_last_error(ffi.NULL)).decode())
        kept = [fields]

        def destroy(scene):  # holds the callbacks, which are called to the end
            lib.pktrt_scene_destroy(scene)
            kept.clear()

        self.handle = ffi.gc(handle, destroy)
        self._meshes, self._kept = {}, kept

    def _must(self, status):
        if status != lib.PKTRT_OK:
            raise Error(status, ffi.string(lib.pktrt_last_error(self.handle)).decode())

    def __getattr__(self, name):
        """Offers the header's other calls on a scene: pktrt_NAME(scene, ...) is scene.NAME(...)."""
        call = getattr(lib, "pktrt_" + name, None)
        kind = call is not None and ffi.typeof(call)
        if not kind or kind.kind != "function" or name == "scene_destroy" or not kind.args or \
                kind.args[0] not in (ffi.typeof("pktrt_scene *"), ffi.typeof("const pktrt_scene *")):
            raise AttributeError(f"pktrt.h has no pktrt_{name} of a scene")

        def checked(*arguments):
            for position, (want, argument) in enumerate(zip(kind.args[1:], arguments), 1):
                if want.kind == "pointer" and not isinstance(argument, ffi.CData):
                    raise TypeError(f"{name}: argument {position} is {want.cname}, which pktrt.ffi.new makes, and not "
                                    f"{type(argument).__name__}")
            return call(self.handle, *arguments)

        if kind.result == ffi.typeof("pktrt_status"):
            return lambda *arguments: self._must(checked(*arguments))
        return checked

    def _add(self, call, kind, fields, name):
        index, desc = ffi.new("uint32_t *"), _new(kind, fields, name)
        self._must(call(self.handle, desc, index))
        return index[0]

    @staticmethod
    def _mesh(call, positions, triangles=None, normals=None, texcoords=None, triangle_materials=None, **fields):
        """The fields of a pktrt_mesh_desc, whose counts are those of the arrays. They hold what they point to."""
        _check_fields(ffi.typeof("pktrt_mesh_desc"), fields, call, _OF_ARRAYS)
        keys = np.shape(positions)[:-2]
        xyz = _values(positions, np.dtype("f4"), ((None,) if keys else ()) + (None, 3), "positions")
        n = xyz.shape[-2]
        if triangles is not None:
            triangles = _values(triangles, np.dtype("u4"), (None, 3), "triangles")
        if normals is not None:
            normals = _values(normals, np.dtype("f4"), xyz.shape, "normals")
        if texcoords is not None:
            texcoords = _values(texcoords, np.dtype("f4"), (n, 2), "texcoords")
        arrays = dict(positions=xyz, normals=normals, texcoords=texcoords)
        desc = {**fields, **{name: _read(array, "float") for name, array in arrays.items()}}
        desc["indices"] = _read(triangles, "uint32_t")
        desc["vertex_count"] = n
        count = -(-n // 3) if triangles is None else len(triangles)  # C refuses an incomplete one
        if triangle_materials is not None:
            triangle_materials = _values(triangle_materials, np.dtype("u4"), (count,), "triangle_materials")
        desc["triangle_count"] = count
        desc["triangle_materials"] = _read(triangle_materials, "uint32_t")
        desc["key_count"] = keys[0] if keys else 1
        if keys and not keys[0]:
            raise ValueError("positions: there is no key")
        return desc

    def add_mesh(self, positions, triangles=None, normals=None, texcoords=None, triangle_materials=None, **fields):
        """Adds (n, 3) positions, or (keys, n, 3) that move; triangles: (m, 3), None: each three positions are one.
        Normals are like positions, texcoords (n, 2), triangle_materials (m,); fields are those of pktrt_mesh_desc that
        describe no array: material, group, mask. Returns the index that hits report."""
        desc = self._mesh("add_mesh", positions, triangles, normals, texcoords, triangle_materials, **fields)
        mesh = self._add(lib.pktrt_add_mesh, "pktrt_mesh_desc", desc, "add_mesh")
        self._meshes[mesh] = desc["vertex_count"]
        return mesh

    def add_model(self, *meshes):
        """Adds a model of meshes, each a dict of what add_mesh takes. Returns its index, for add_instance."""
        descs = [self._mesh("add_model", **mesh) for mesh in meshes]
        array, index = ffi.new("pktrt_mesh_desc[]", [_plain(desc) for desc in descs]), ffi.new("uint32_t *")
        self._must(lib.pktrt_add_model(self.handle, array, len(descs), index))
        return index[0]

    def add_instance(self, model, transforms, **fields):
        """Places a model by a (3, 4) matrix, or by (keys, 3, 4) that it moves between; fields: mask, interpolation.
        Returns its index."""
        _check_fields(ffi.typeof("pktrt_instance_desc"), fields, "add_instance", _OF_ARRAYS)
        keys = np.shape(transforms)[:-2]
        matrices = _values(transforms, np.dtype("f4"), ((None,) if keys else ()) + (3, 4), "transforms")
        if keys and not keys[0]:
            raise ValueError("transforms: there is no key")
        desc = {"model": model, "key_count": keys[0] if keys else 1, "transforms": _read(matrices, "float"), **fields}
        return self._add(lib.pktrt_add_instance, "pktrt_instance_desc", desc, "add_instance")

    def set_transform(self, instance, transform, key=0):
        """Replaces the (3, 4) matrix of one key, for the next refit or commit."""
        matrix = _values(transform, np.dtype("f4"), (3, 4), "transform")
        self._must(lib.pktrt_set_transform(self.handle, instance, key, _read(matrix, "float")))

    def _replace(self, call, mesh, key, values, name):
        if mesh not in self._meshes:
            raise ValueError(f"mesh {mesh} has not been added by add_mesh")
        values = _values(values, np.dtype("f4"), (self._meshes[mesh], 3), name)
        self._must(call(self.handle, mesh, key, _read(values, "float")))

    def set_positions(self, mesh, positions, key=0):
        """Replaces the positions of one key, for the next refit or commit."""
        self._replace(lib.pktrt_set_positions, mesh, key, positions, "positions")

    def set_normals(self, mesh, normals, key=0):
        self._replace(lib.pktrt_set_normals, mesh, key, normals, "normals")

    def add_light(self, **fields):
        return self._add(lib.pktrt_add_light, "pktrt_light", fields, "add_light")

    def add_material(self, **fields):
        """Adds a material, and keeps its hooks, if any. Returns its index."""
        self._kept.append(fields)
        return self._add(lib.pktrt_add_material, "pktrt_material", fields, "add_material")

    def info(self):
        """What the committed scene is made of: a pktrt_scene_info."""
        info = ffi.new("pktrt_scene_info *")
        lib.pktrt_get_scene_info(self.handle, info)
        return info

    # Queries: arrays of rays of any shape, and such answers. That of one ray, as rays[0], has the shape ().

    def intersect(self, rays, out=None):
        """The nearest hits; their mesh is pktrt.NONE where a ray hits nothing."""
        rays = _structs(rays, RAY, "rays")
        out = _output(out, HIT, rays.shape)
        if rays.ndim == 0:
            lib.pktrt_intersect(self.handle, _read(rays, "pktrt_ray"), _write(out, "pktrt_hit"))
        else:
            lib.pktrt_intersect_n(self.handle, _read(rays, "pktrt_ray"), _write(out, "pktrt_hit"), rays.size)
        return out

    def occluded(self, rays, out=None):
        """Whether anything is in the way."""
        rays = _structs(rays, RAY, "rays")
        out = _output(out, np.dtype(bool), rays.shape)
        if rays.ndim == 0:
            out[...] = lib.pktrt_occluded(self.handle, _read(rays, "pktrt_ray"))
        else:
            lib.pktrt_occluded_n(self.handle, _read(rays, "pktrt_ray"), _write(out, "bool"), rays.size)
        return out

    def intersect_after(self, rays, previous, out=None):
        """The hits that follow previous ones; previous and out may be the same array."""
        rays = _structs(rays, RAY, "rays")
        previous = _values(previous, HIT, rays.shape, "previous")
        out = _output(out, HIT, rays.shape)
        lib.pktrt_intersect_after_n(self.handle, _read(rays, "pktrt_ray"), _read(previous, "pktrt_hit"),
                                    _write(out, "pktrt_hit"), rays.size)
        return out

    def spawn(self, rays, hits, directions, out=None):
        """Rays that leave the hits, (..., 3) directions, without meeting what they leave."""
        rays = _structs(rays, RAY, "rays")
        hits = _values(hits, HIT, rays.shape, "hits")
        directions = _values(directions, np.dtype("f4"), rays.shape + (3,), "directions")
        out = _output(out, RAY, rays.shape)
        lib.pktrt_spawn_n(self.handle, _read(rays, "pktrt_ray"), _read(hits, "pktrt_hit"), _read(directions, "float"),
                          _write(out, "pktrt_ray"), rays.size)
        return out

    def surface(self, rays, hits, out=None):
        """What one shades with: position, normal, shading_normal, texcoord, material, ..."""
        rays = _structs(rays, RAY, "rays")
        hits = _values(hits, HIT, rays.shape, "hits")
        out = _output(out, SURFACE, rays.shape)
        lib.pktrt_surface_n(self.handle, _read(rays, "pktrt_ray"), _read(hits, "pktrt_hit"),
                            _write(out, "pktrt_surface_info"), rays.size)
        return out

    def winding(self, mesh, points, time=0):
        """How often a closed mesh winds around points (..., 3): 0 is outside."""
        shape = np.shape(points)[:-1]
        points = _values(points, np.dtype("f4"), shape + (3,), "points")
        times = np.ascontiguousarray(np.broadcast_to(np.asarray(time, "f4"), shape))
        out = np.empty(shape, "i4")
        lib.pktrt_winding_n(self.handle, mesh, _read(points, "float"), _read(times, "float"), _write(out, "int"),
                            out.size)
        return out

    def render(self, width, height, buffers=(), **fields):
        """A picture, (height, width, 3) float32 of linear light; fields are those of pktrt_render_desc that describe
        no array, as camera=dict(eye=...). With names of buffers, as ("depth", "normal"), returns them behind it;
        block_error is (rows, columns) of blocks."""
        taken = dict.fromkeys(_BUFFERS, "name it among buffers=, and get it back")
        taken["pixels"] = "the picture is returned"
        taken["row_stride"] = _OF_ARRAYS["row_stride"]
        _check_fields(ffi.typeof("pktrt_render_desc"), fields, "render", taken)
        unknown = [name for name in buffers if name not in _BUFFERS]
        if unknown:
            raise ValueError(f"render: there is no buffer {unknown[0]}, but these: {', '.join(sorted(_BUFFERS))}")
        made = {}
        for name in ("pixels", *buffers):
            channels, pixels_wide = _BUFFERS.get(name, (3, 1))
            shape = (-(-height // pixels_wide), -(-width // pixels_wide))
            made[name] = np.zeros(shape if channels == 1 else shape + (channels,),
                                  "u4" if name == "sample_count" else "f4")
        pointers = {name: _write(array, "uint32_t" if name == "sample_count" else "float")
                    for name, array in made.items()}
        desc = _new("pktrt_render_desc", {**fields, **pointers, "width": width, "height": height}, "render")
        self._must(lib.pktrt_render(self.handle, desc))
        return (made["pixels"], *(made[name] for name in buffers)) if buffers else made["pixels"]
