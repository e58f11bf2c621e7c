"""pktrt.h in Python: one file over cffi, with numpy arrays in and out. Needs a C compiler, cffi and numpy.

    scene = pktrt.Scene()
    mesh = scene.add_mesh(positions, triangles)          # arrays of (n, 3) and (m, 3)
    scene.commit()
    hits = scene.intersect(pktrt.rays(origins, directions))
    hits["t"][hits["mesh"] != pktrt.NONE]

Names are those of the header without pktrt_: any call on a scene is a method, scene.refit() and scene.set_enabled(3,
False) as well as those below, and constants are pktrt.MODE_WRT, pktrt.NONE and so on. pktrt.lib and pktrt.ffi have
everything as C has it, scene.handle is the pktrt_scene. What fails raises pktrt.Error with the library's sentence.
What the library wonders about goes to the logger "pktrt". Arguments that do not fit raise TypeError or ValueError,
which name the argument.

Memory. Counts, strides and key counts are taken from arrays, and refused as arguments; so are pointers, where a method
here takes arrays. Calls that have no method here take pointers as C does: what pktrt.ffi.new makes, never a list, whose
length nobody would look at. Callbacks that a scene or a material has been given live as long as the scene.

Nothing is declared here: the declarations are the header's own, as the compiler's preprocessor leaves them. The
implementation is compiled into a cache folder when it is first needed, which takes half a minute, and again when
header, compiler or flags are others. The environment says where and how: PKTRT_HEADER, PKTRT_CACHE (else
~/.cache/pktrt), CC, CFLAGS (else -O2; with -DPKTRT_AVX512 it has AVX-512, too). `pip install .` in this folder compiles
once, as it installs; no compiler is needed after that.

Images. Arrays of (height, width, 3) or (height, width), image[0] at the upper edge, are textures and environments: C
looks things up in them, from any thread, without Python's lock. uint8 is sRGB and decoded; float32 is linear and used
where it lies, so change it between pictures alone. Lookups are bilinear.

    scene.add_material(texture=image)                             # its albedo
    scene.add_material(texture=dict(albedo=pktrt.Image(image, wrap="clamp"), opacity=leaf), albedo=[1, 0.9, 0.8])
    scene.render(640, 480, environment=sky, ambient=[0, 0, 0])    # sky: latitudes by longitudes, see Image

Copies. Rays, hits and surfaces are arrays of the C structures (pktrt.RAY, HIT, SURFACE, ...), of any shape: the library
reads and writes their memory. It reads that of positions (float32), triangles (uint32), normals and others, too, in
the call alone, as it keeps copies of its own. Only arrays of other types, with gaps or in another order of axes are
copied before. `out` takes arrays to write to, so that no new ones are made.

Threads. Python's other threads run during each call. Queries of a committed scene may come from many at once; while a
call changes the scene there must be no other. The library's own threads build and render: Scene(threads=1) has none.
"""
import hashlib
import importlib.machinery
import logging
import operator
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
#include <math.h>
#include <pthread.h>
PKTRT_PYTHON_TYPES
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

/* The two texels around a place along an axis, and their weights. The middle of texel i is at (i + 0.5) / size. */
static void along(double place, uint32_t size, bool clamp, size_t at[2], float weight[2]) {
  place = clamp ? (place < 1 ? place : 1) : place - floor(place);
  if (!(place >= 0 && place <= 1)) place = 0;
  const double middle = place * size - 0.5, lower = floor(middle);
  weight[1] = (float)(middle - lower);
  weight[0] = 1 - weight[1];
  for (int k = 0; k < 2; k++) {
    const double i = lower + k;
    if (i < 0) at[k] = clamp ? 0 : size - 1;
    else if (i >= size) at[k] = clamp ? size - 1 : 0;
    else at[k] = (size_t)i;
  }
}
/* An image at (u, v): (0, 0) is the lower left corner, (1, 1) the upper right one. One channel counts for all three. */
static void look_up(const pktrt_image *image, double u, double v, bool clamp_u, bool clamp_v, float value[3]) {
  size_t x[2], y[2];
  float across[2], down[2];
  along(u, image->width, clamp_u, x, across);
  along(1 - v, image->height, clamp_v, y, down);
  for (uint32_t c = 0; c < 3; c++) {
    float row[2];
    for (int k = 0; k < 2; k++) {
      const float *from = image->values + y[k] * image->width * image->channels + c % image->channels;
      row[k] = across[0] * from[x[0] * image->channels] + across[1] * from[x[1] * image->channels];
    }
    value[c] = down[0] * row[0] + down[1] * row[1];
  }
}
/* The texture of a material with images. */
extern void pktrt_image_texture(void *user, const pktrt_points *p) {
  const pktrt_images *images = (const pktrt_images *)user;
  const pktrt_image *factor[3] = {images->albedo, images->reflectance, images->emission};
  float *const *changed[3] = {p->albedo, p->reflectance, p->emission};
  float value[3];
  for (uint32_t i = 0; i < p->n; i++) {
    const double u = p->texcoord[0][i], v = p->texcoord[1][i];
    for (int k = 0; k < 3; k++) {
      if (!factor[k]) continue;
      look_up(factor[k], u, v, factor[k]->clamp, factor[k]->clamp, value);
      for (int c = 0; c < 3; c++) changed[k][c][i] *= value[c];
    }
    if (images->opacity) {
      look_up(images->opacity, u, v, images->opacity->clamp, images->opacity->clamp, value);
      p->opacity[i] = value[0];
    }
    if (images->exponent) {
      look_up(images->exponent, u, v, images->exponent->clamp, images->exponent->clamp, value);
      p->exponent[i] = value[0];
    }
    if (images->normal) { /* on the side that the ray came from */
      look_up(images->normal, u, v, images->normal->clamp, images->normal->clamp, value);
      float along_normal = 0;
      for (int c = 0; c < 3; c++) along_normal += value[c] * p->normal[c][i];
      for (int c = 0; c < 3; c++) p->normal_out[c][i] = along_normal < 0 ? -value[c] : value[c];
    }
  }
}
extern void pktrt_image_environment(void *user, uint32_t n, const float *const direction[3],
                                    float *const radiance[3]) {
  const pktrt_image *image = (const pktrt_image *)user;
  const double pi = 3.14159265358979323846;
  for (uint32_t i = 0; i < n; i++) {
    const double x = direction[0][i], y = direction[1][i], z = direction[2][i];
    float value[3];
    look_up(image, 0.5 + atan2(x, -z) / (2 * pi), 0.5 + atan2(y, sqrt(x * x + z * z)) / pi, false, true, value);
    for (int c = 0; c < 3; c++) radiance[c][i] = value[c];
  }
}

extern bool pktrt_camera_ray_n(const pktrt_camera *camera, uint32_t width, uint32_t height, const double *x,
                               const double *y, const float *lens, const float *time, pktrt_ray *out, size_t n) {
  bool all = true;
  for (size_t i = 0; i < n; i++)
    if (!pktrt_camera_ray(camera, width, height, x[i], y[i], lens ? lens + 2 * i : NULL, time[i], &out[i])) all = false;
  return all;
}
extern void pktrt_sample_all(const pktrt_sampling *set, uint32_t x, uint32_t y, uint32_t dimensions, float *out) {
  for (uint32_t i = 0; i < set->samples; i++) pktrt_sample(set, x, y, i, 0, dimensions, out + (size_t)i * dimensions);
}
extern void pktrt_map_disk_n(const float *u, float *out, size_t n) {
  for (size_t i = 0; i < n; i++) pktrt_map_disk(u + 2 * i, out + 2 * i);
}
extern void pktrt_map_sphere_n(const float *u, float *out, size_t n) {
  for (size_t i = 0; i < n; i++) pktrt_map_sphere(u + 2 * i, out + 3 * i);
}
extern void pktrt_map_cosine_n(const float *u, const float *normal, float *out, size_t n) {
  for (size_t i = 0; i < n; i++) pktrt_map_cosine(u + 2 * i, normal + 3 * i, out + 3 * i);
}
extern void pktrt_map_phong_n(const float *u, const float *axis, const float *exponent, float *out, size_t n) {
  for (size_t i = 0; i < n; i++) pktrt_map_phong(u + 2 * i, axis + 3 * i, exponent[i], out + 3 * i);
}
extern void pktrt_fresnel_n(const float *cosine, const float *eta, const float *k, float *out, size_t n) {
  for (size_t i = 0; i < n; i++)
    out[i] = k ? pktrt_fresnel_conductor(cosine[i], eta[i], k[i]) : pktrt_fresnel_dielectric(cosine[i], eta[i]);
}
"""
# What of it Python calls or fills.
_TYPES = """
typedef struct pktrt_image {
  const float *values; /* height rows of width texels of 1 or 3 channels; row 0 is the upper one */
  uint32_t width, height, channels;
  bool clamp;
} pktrt_image;
typedef struct pktrt_images {
  const pktrt_image *albedo, *reflectance, *emission, *opacity, *exponent, *normal;
} pktrt_images;
"""
_CALLS = """
void pktrt_parallel_for(void *user, size_t n, void (*body)(void *arg, size_t i), void *arg);
void pktrt_image_texture(void *user, const pktrt_points *);
void pktrt_image_environment(void *user, uint32_t n, const float *const direction[3], float *const radiance[3]);
bool pktrt_camera_ray_n(const pktrt_camera *, uint32_t width, uint32_t height, const double *x, const double *y,
                        const float *lens, const float *time, pktrt_ray *, size_t n);
void pktrt_sample_all(const pktrt_sampling *, uint32_t x, uint32_t y, uint32_t dimensions, float *out);
void pktrt_map_disk_n(const float *u, float *out, size_t n);
void pktrt_map_sphere_n(const float *u, float *out, size_t n);
void pktrt_map_cosine_n(const float *u, const float *normal, float *out, size_t n);
void pktrt_map_phong_n(const float *u, const float *axis, const float *exponent, float *out, size_t n);
void pktrt_fresnel_n(const float *cosine, const float *eta, const float *k, float *out, size_t n);
"""


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
    kept = [line for line in text.splitlines() if not line.startswith("#") or number.match(line)]
    return "\n".join(kept) + _TYPES + _CALLS


def _library(compile_with, header, folder, declarations):
    """Compiles the header, unless that is done. The file gets its name when it is whole: others may do the same. It has
    the declarations in it, for those who have no compiler."""
    key = hashlib.sha256(pathlib.Path(header).read_bytes())
    version = _run(*compile_with[:1], "--version")
    key.update("\0".join([_SOURCE, declarations, *compile_with, version, platform.machine()]).encode())
    path = pathlib.Path(folder, f"pktrt-{key.hexdigest()[:16]}.so")
    if not path.exists():
        path.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=path.parent) as room:
            source, made = pathlib.Path(room, "pktrt.c"), pathlib.Path(room, "pktrt.so")
            text = ",".join(map(str, declarations.encode() + b"\0"))
            source.write_text(_SOURCE.replace("PKTRT_PYTHON_TYPES", _TYPES) +
                              "extern const char pktrt_declarations[];\n"
                              f"const char pktrt_declarations[] = {{{text}}};\n")
            named = f'-DPKTRT_HEADER_FILENAME="{header}"'
            flags = ["-shared", "-fPIC", "-ffp-contract=off", named]  # no fused products where images are looked up
            _run(*compile_with, *flags, str(source), "-o", str(made), "-lm", "-lpthread")
            os.replace(made, path)
    return str(path)


def _installed(here):
    """The library that pip has put beside this file, and its declarations; None if there is none."""
    for suffix in importlib.machinery.EXTENSION_SUFFIXES:
        path = here.with_name("_pktrt" + suffix)
        if path.exists():
            reader = cffi.FFI()
            reader.cdef("extern const char pktrt_declarations[];")
            return str(path), reader.string(reader.cast("char *", reader.dlopen(str(path)).pktrt_declarations)).decode()
    return None


def _load():
    here = pathlib.Path(__file__).resolve()
    interface = cffi.FFI()
    installed = None if os.environ.get("PKTRT_HEADER") else _installed(here)
    if installed:
        interface.cdef(installed[1])
        return interface, interface.dlopen(installed[0]), installed[0], installed[1]
    beside = here.with_name("pktrt.h")
    header = os.environ.get("PKTRT_HEADER") or str(beside if beside.exists() else here.parents[2] / "pktrt.h")
    header = str(pathlib.Path(header).resolve())
    caches = os.environ.get("XDG_CACHE_HOME") or pathlib.Path.home() / ".cache"
    folder = os.environ.get("PKTRT_CACHE") or pathlib.Path(caches, "pktrt")
    compile_with = shlex.split(os.environ.get("CC") or "cc") + shlex.split(os.environ.get("CFLAGS") or "-O2")
    declarations = _declarations(compile_with, header)
    interface.cdef(declarations)
    path = _library(compile_with, header, folder, declarations)
    return interface, interface.dlopen(path), path, declarations


ffi, lib, library_path, _DECLARED = _load()


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
CLOSEST, MESH_INFO = _dtype(ffi.typeof("pktrt_closest")), _dtype(ffi.typeof("pktrt_mesh_info"))
REPORT, STATS = _dtype(ffi.typeof("pktrt_report")), _dtype(ffi.typeof("pktrt_stats"))
SCENE_REPORT = _dtype(ffi.typeof("pktrt_scene_report"))
TREE, NODE = _dtype(ffi.typeof("pktrt_tree")), _dtype(ffi.typeof("pktrt_node"))
_QUERY = _dtype(ffi.typeof("pktrt_point_query"))


def _array(values, name):
    try:
        array = np.asarray(values)
    except (TypeError, ValueError) as error:
        raise ValueError(f"{name}: {error}") from None
    if array.dtype.kind not in "biufV":
        raise TypeError(f"{name}: these are no numbers, but {array.dtype}")
    return array


def _values(values, dtype, shape, name):
    """An array that C can read, of any size where `shape` has None. Copies only where type or order are others."""
    array = _array(values, name)
    if array.dtype != dtype and (dtype.names or array.dtype.names):
        raise TypeError(f"{name}: an array of {array.dtype} is none of {dtype}")
    if array.dtype != dtype and dtype.kind == "u" and array.size:  # where numpy would wrap around
        if array.dtype.kind not in "iu" or array.min() < 0 or array.max() > np.iinfo(dtype).max:
            raise ValueError(f"{name}: not all of them are whole numbers of 32 bits")
    if len(array.shape) != len(shape) or any(want not in (None, have) for want, have in zip(shape, array.shape)):
        raise ValueError(f"{name}: the shape is {array.shape}, not {str(shape).replace('None', 'any')}")
    with np.errstate(over="ignore"):  # the library refuses infinity in words of its own
        return np.require(array, dtype, "CA")


def _structs(values, dtype, name):
    return _values(values, dtype, _array(values, name).shape, name)


def _spread(values, dtype, shape, name):
    """As _values, but repeated to the shape as numpy does it."""
    array = _array(values, name)
    try:
        array = np.broadcast_to(array, shape)
    except ValueError:
        raise ValueError(f"{name}: the shape is {array.shape}, which cannot be repeated to {shape}") from None
    return _values(array, np.dtype(dtype), shape, name)


def _leading(values, last, name):
    """The shape of an array of vectors of `last` components, but for these."""
    shape = _array(values, name).shape
    if not shape or shape[-1] != last:
        raise ValueError(f"{name}: the shape is {shape}, not (..., {last})")
    return shape[:-1]


def _whole(value, name):
    try:
        value = operator.index(value)
    except TypeError:
        raise TypeError(f"{name}: {value!r} is no whole number") from None
    if not 0 <= value < 2 ** 32:
        raise ValueError(f"{name}: {value} is no whole number of 32 bits")
    return value


def _output(out, dtype, shape):
    if out is None:
        return np.empty(shape, dtype)
    if not isinstance(out, np.ndarray):
        raise TypeError(f"out: {type(out).__name__} is no array")
    if out.dtype != dtype or out.shape != shape or not (out.flags.c_contiguous and out.flags.aligned):
        raise ValueError(f"out: not a contiguous array of shape {shape} and type {dtype}")
    return out


def _new(kind, fields, call, taken=None):
    """A new C structure of these fields. Refuses names it has not got, and those that `taken` has reasons for."""
    _check_fields(ffi.typeof(kind), fields, call, taken or {})
    made = ffi.new(kind + " *")
    _fill(made[0], fields, call)
    return made


def _fill(struct, fields, where):
    """Sets fields of a structure. What does not fit is said with its name."""
    kinds = {name: field.type for name, field in ffi.typeof(struct).fields}
    for name, value in fields.items():
        if isinstance(value, dict):
            _fill(getattr(struct, name), value, f"{where}: {name}")
            continue
        if isinstance(value, np.ndarray) and value.dtype.names and kinds[name].kind == "pointer":  # as stats
            value = _write(value, kinds[name].item.cname)
        elif kinds[name].kind == "array" and not isinstance(value, ffi.CData):
            want, have = _dtype(kinds[name]).shape, _array(value, f"{where}: {name}").shape
            if want != have:
                raise ValueError(f"{where}: {name}: the shape is {have}, not {want}")
        try:
            setattr(struct, name, _plain(value))
        except (TypeError, ValueError, OverflowError) as error:
            raise type(error)(f"{where}: {name}: {error}") from None


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
    if isinstance(value, (list, tuple)):
        return [_plain(part) for part in value]
    return value.tolist() if isinstance(value, (np.ndarray, np.generic)) else value


def rays(origins, directions, tmin=0, tmax=np.inf, time=0):
    """An array of rays; what is given is repeated where others have more, as numpy does it."""
    shapes = [_leading(origins, 3, "origins"), _leading(directions, 3, "directions")]
    ends = [_array(value, name) for value, name in ((tmin, "tmin"), (tmax, "tmax"), (time, "time"))]
    try:
        shape = np.broadcast_shapes(*shapes, *(end.shape for end in ends))
    except ValueError:
        shapes = ", ".join(map(str, [*shapes, *(end.shape for end in ends)]))
        raise ValueError(f"origins, directions, tmin, tmax, time: their shapes do not match: {shapes}") from None
    made = np.empty(shape, RAY)
    made["origin"], made["direction"], made["tmin"], made["tmax"], made["time"] = origins, directions, *ends
    return made


def camera_ray(width, height, camera=None, x=None, y=None, lens=None, time=0):
    """The renderer's rays through places (x, y) of a picture, in pixels from its upper left corner; without them those
    through the middles of all pixels, (height, width) of them. lens: points of the unit square, (..., 2)."""
    width, height = _whole(width, "width"), _whole(height, "height")
    made = _new("pktrt_camera", camera or {}, "camera")
    if x is None and y is None:
        y, x = np.mgrid[:height, :width] + 0.5
    if x is None or y is None:
        raise ValueError(f"{'x' if x is None else 'y'}: give both x and y, or neither")
    shapes = [_array(value, name).shape for value, name in ((x, "x"), (y, "y"), (time, "time"))]
    if lens is not None:
        shapes.append(_leading(lens, 2, "lens"))
    try:
        shape = np.broadcast_shapes(*shapes)
    except ValueError:
        shapes = ", ".join(map(str, shapes))
        raise ValueError(f"x, y, time, lens: their shapes do not match: {shapes}") from None
    x, y, time = _spread(x, "f8", shape, "x"), _spread(y, "f8", shape, "y"), _spread(time, "f4", shape, "time")
    lens = None if lens is None else _spread(lens, "f4", shape + (2,), "lens")
    out = np.empty(shape, RAY)
    if not lib.pktrt_camera_ray_n(made, width, height, _read(x, "double"), _read(y, "double"), _read(lens, "float"),
                                  _read(time, "float"), _write(out, "pktrt_ray"), out.size):
        if 0 < width * height < 2 ** 24:  # the library's sentence: it refuses the picture before it begins
            Scene(threads=1).render(width, height, camera=made[0])
        raise ValueError("camera: no picture can be made of this camera, width and height")
    return out


def samples(count, dimensions, sampler=None, seed=0, pixel=(0, 0)):
    """The set of samples that a pixel gets: (count, dimensions) float32 in [0,1), Sobol' points if nothing is said.
    Sets of other seeds are independent of each other, each a replicate."""
    fields = dict(sampler=lib.PKTRT_SAMPLER_SOBOL if sampler is None else sampler, samples=count, seed=seed)
    count, dimensions = _whole(count, "count"), _whole(dimensions, "dimensions")
    if not 1 <= count <= 65536:
        raise ValueError(f"count: {count} is not in 1 to 65536")
    x, y = (_whole(value, "pixel") for value in pixel)
    out = np.empty((count, dimensions), "f4")
    lib.pktrt_sample_all(_new("pktrt_sampling", fields, "samples"), x, y, dimensions, _write(out, "float"))
    return out


def map_disk(u):
    """Points of the unit square, (..., 2), to points of the unit disk."""
    u = _values(u, np.dtype("f4"), _leading(u, 2, "u") + (2,), "u")
    out = np.empty_like(u)
    lib.pktrt_map_disk_n(_read(u, "float"), _write(out, "float"), u.size // 2)
    return out


def map_sphere(u):
    """Points of the unit square, (..., 2), to directions, (..., 3)."""
    u = _values(u, np.dtype("f4"), _leading(u, 2, "u") + (2,), "u")
    out = np.empty(u.shape[:-1] + (3,), "f4")
    lib.pktrt_map_sphere_n(_read(u, "float"), _write(out, "float"), u.size // 2)
    return out


def map_cosine(u, normals):
    """Points of the unit square, (..., 2), to directions around unit normals, with density cos / pi."""
    u = _values(u, np.dtype("f4"), _leading(u, 2, "u") + (2,), "u")
    normals = _spread(normals, "f4", u.shape[:-1] + (3,), "normals")
    out = np.empty_like(normals)
    lib.pktrt_map_cosine_n(_read(u, "float"), _read(normals, "float"), _write(out, "float"), u.size // 2)
    return out


def map_phong(u, axes, exponent):
    """Points of the unit square, (..., 2), to directions of Phong lobes around unit axes."""
    u = _values(u, np.dtype("f4"), _leading(u, 2, "u") + (2,), "u")
    axes = _spread(axes, "f4", u.shape[:-1] + (3,), "axes")
    exponent = _spread(exponent, "f4", u.shape[:-1], "exponent")
    out = np.empty_like(axes)
    lib.pktrt_map_phong_n(_read(u, "float"), _read(axes, "float"), _read(exponent, "float"), _write(out, "float"),
                          exponent.size)
    return out


def fresnel(cosine, eta, extinction=None):
    """The part of unpolarised light that is reflected: by a dielectric, whose index behind the surface is eta times
    that before it, or with an extinction by a conductor."""
    named = [(cosine, "cosine"), (eta, "eta")] + ([] if extinction is None else [(extinction, "extinction")])
    shapes = [_array(values, name).shape for values, name in named]
    try:
        shape = np.broadcast_shapes(*shapes)
    except ValueError:
        raise ValueError(f"cosine, eta, extinction: their shapes do not match: {', '.join(map(str, shapes))}") from None
    cosine, eta, *rest = (_spread(values, "f4", shape, name) for values, name in named)
    out = np.empty(shape, "f4")
    lib.pktrt_fresnel_n(_read(cosine, "float"), _read(eta, "float"), _read(rest[0] if rest else None, "float"),
                        _write(out, "float"), out.size)
    return out


def transform_from_4x4(matrices):
    """The (..., 3, 4) matrices of instances for (..., 16) elements by columns, as OpenGL and glTF have them."""
    shape = _leading(matrices, 16, "matrices")
    matrices = _values(matrices, np.dtype("f4"), shape + (16,), "matrices")
    return matrices.reshape(*shape, 4, 4).swapaxes(-1, -2)[..., :3, :]


def to_srgb8(pixels, exposure=1, tone=None, out=None):
    """Linear RGB, (..., 3), as uint8 for screens and files. tone: pktrt.TONE_CLAMP or pktrt.TONE_CURVE."""
    pixels = _values(pixels, np.dtype("f4"), _leading(pixels, 3, "pixels") + (3,), "pixels")
    out = _output(out, np.dtype("u1"), pixels.shape)
    tone = lib.PKTRT_TONE_CLAMP if tone is None else _whole(tone, "tone")
    try:
        exposure = float(exposure)
    except (TypeError, ValueError):
        raise TypeError(f"exposure: {exposure!r} is no number") from None
    lib.pktrt_to_srgb8(_read(pixels, "float"), pixels.size // 3, exposure, tone, _write(out, "unsigned char"))
    return out


def stats():
    """Zeroed counts of work, to be given to queries as stats=; each query adds to them."""
    return np.zeros((), STATS)


# --- images ---

_DECODED = {
    "srgb": [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in (i / 255 for i in range(256))],
    "linear": [i / 255 for i in range(256)],
    "signed": [i / 127.5 - 1 for i in range(256)]}
_DECODED = {name: np.array(table, "f4") for name, table in _DECODED.items()}


class Image:
    """An array that C looks things up in: a texture or an environment, see the top. wrap: "repeat" or "clamp", which
    environments take no notice of. coding, of uint8: "srgb", "linear" (0 to 1) or "signed" (-1 to 1, for normals).

    As an environment its middle is -z, +x is to the right, its upper edge is +y: u = 1/2 + atan2(x, -z) / (2 pi)."""

    def __init__(self, values, wrap="repeat", coding="srgb", name="image"):
        if wrap not in ("repeat", "clamp"):
            raise ValueError(f"wrap: {wrap!r} is neither 'repeat' nor 'clamp'")
        if coding not in _DECODED:
            raise ValueError(f"coding: {coding!r} is none of {', '.join(_DECODED)}")
        values = _array(values, name)
        if values.ndim == 3 and values.shape[2] == 4:
            raise ValueError(f"{name}: the shape is {values.shape}; give [..., :3], and [..., 3] as opacity")
        if values.ndim not in (2, 3) or values.shape[2:] not in ((), (1,), (3,)) or not values.size:
            raise ValueError(f"{name}: the shape is {values.shape}, not (height, width, 3) or (height, width)")
        if max(values.shape) >= 2 ** 31:
            raise ValueError(f"{name}: the shape is {values.shape}, which is too large")
        if values.dtype.kind != "f" and values.dtype != np.uint8:
            raise TypeError(f"{name}: values are {values.dtype}, neither floats nor uint8")
        self.values = _DECODED[coding][values] if values.dtype == np.uint8 else \
            _values(values, np.dtype("f4"), values.shape, name)
        if not np.isfinite(self.values).all():
            raise ValueError(f"{name}: a value is NaN or infinite")
        fields = dict(values=_read(self.values, "float"), height=values.shape[0], width=values.shape[1],
                      channels=3 if values.shape[2:] == (3,) else 1, clamp=wrap == "clamp")
        self._own = fields
        self.pointer = _new("pktrt_image", fields, name)


# What images of a material say, and how uint8 is read there.
_SLOTS = dict(albedo="srgb", reflectance="srgb", emission="srgb", opacity="linear", exponent="linear", normal="signed")


def _image(values, coding, name):
    return values if isinstance(values, Image) else Image(values, coding=coding, name=name)


def _with_images(fields, call):
    """The fields of a material, whose images, if it has any, are ready for C. They hold what they point to."""
    texture = fields.get("texture")
    if texture is None or isinstance(texture, ffi.CData):
        return fields
    if "user" in fields:
        raise TypeError(f"{call}: user is no argument: the images of texture use it")
    given = texture if isinstance(texture, dict) else dict(albedo=texture)
    images = {}
    for slot, values in given.items():
        if slot not in _SLOTS:
            raise TypeError(f"{call}: texture: there is no {slot}, but these: {', '.join(_SLOTS)}")
        name = f"{call}: texture" + (f": {slot}" if isinstance(texture, dict) else "")
        images[slot] = _image(values, _SLOTS[slot], name)
        shape = images[slot].values.shape
        if slot in ("opacity", "exponent") and shape[2:] == (3,):
            raise ValueError(f"{name}: the shape is {shape}, not (height, width)")
        if slot == "normal" and shape[2:] != (3,):
            raise ValueError(f"{name}: the shape is {shape}, not (height, width, 3)")
    pointers = _new("pktrt_images", {slot: image.pointer for slot, image in images.items()}, call)
    fields = {**{slot: [1, 1, 1] for slot in ("albedo", "reflectance", "emission") if slot in images}, **fields}
    if "opacity" in images:
        fields.setdefault("cutout", True)
    return _Held(images, pointers, texture=ffi.addressof(_C, "pktrt_image_texture"), user=pointers, **{
        name: value for name, value in fields.items() if name != "texture"})


class _Held(dict):
    """Fields with what they point to."""

    def __init__(self, images, pointers, **fields):
        super().__init__(fields)
        self.images, self.pointers = images, pointers


_C = lib


# --- scenes ---

# What is known of arrays, and no argument.
_OF_ARRAYS = {name: "it is taken from the arrays" for name in (
    "vertex_count", "triangle_count", "key_count", "position_stride", "row_stride")}
_OF_ARRAYS["indices"] = "give triangles"

# What a render can write: values of a pixel, and how many pixels wide and high that is.
_BUFFERS = {"depth": (1, 1), "normal": (3, 1), "albedo": (3, 1), "sample_count": (1, 1), "cost": (1, 1),
            "pixel_error": (1, 1), "block_error": (1, lib.PKTRT_ERROR_BLOCK)}
_RECORDS = {"report": REPORT, "stats": STATS}


def _parameters(name):
    """The parameters of a call of the header but the scene, as far as they have names."""
    found = re.search(rf"\bpktrt_{name}\(([^;]*)\);", _DECLARED)
    names = [re.search(r"(\w+)(\[\w*\])?\s*$", part) for part in found.group(1).split(",")] if found else []
    return [part.group(1) if part else "" for part in names][1:]


class Scene:
    """A pktrt_scene. threads: how many build and render, by default one per processor; fields: of pktrt_scene_desc."""

    def __init__(self, threads=None, **fields):
        threads = _whole(threads or os.cpu_count() or 1, "threads")
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
        # Vertices of meshes, keys of instances, hooks and images of materials, and the environment that is prepared.
        self._meshes, self._keys, self._looks, self._prepared = {}, {}, {}, None
        kept.append(self._looks)

    def _must(self, status):
        if status != lib.PKTRT_OK:
            raise Error(status, ffi.string(lib.pktrt_last_error(self.handle)).decode())

    @staticmethod
    def _checked(status, name):
        """As _must, of calls that leave the scene alone, and so no detail."""
        if status != lib.PKTRT_OK:
            raise Error(status, f"{name}: {ffi.string(lib.pktrt_status_string(status)).decode()}")

    def __getattr__(self, name):
        """Offers the header's other calls on a scene: pktrt_NAME(scene, ...) is scene.NAME(...)."""
        call = getattr(lib, "pktrt_" + name, None)
        kind = call is not None and ffi.typeof(call)
        if not kind or kind.kind != "function" or name == "scene_destroy" or not kind.args or \
                kind.args[0] != ffi.typeof("pktrt_scene *"):
            raise AttributeError(f"pktrt.h has no pktrt_{name} of a scene")

        parameters = _parameters(name)

        def checked(*arguments):
            if len(arguments) != len(kind.args) - 1:
                wanted = ", ".join(known or want.cname for known, want in zip(parameters, kind.args[1:]))
                raise TypeError(f"{name}: there are {len(arguments)} arguments, and not {len(kind.args) - 1}: {wanted}")
            fitting = []
            for position, (want, argument) in enumerate(zip(kind.args[1:], arguments), 1):
                known = parameters[position - 1] if position <= len(parameters) else ""
                called = f"{name}: argument {position}" + (f" ({known})" if known and known not in want.cname else "")
                if want.kind == "pointer" and not isinstance(argument, ffi.CData):
                    raise TypeError(f"{called} is {want.cname}, which pktrt.ffi.new makes, and not "
                                    f"{type(argument).__name__}")
                if want.kind == "primitive":
                    try:
                        argument = ffi.new(want.cname + " *", _plain(argument))[0]
                    except (TypeError, ValueError, OverflowError) as error:
                        raise type(error)(f"{called}: {error}") from None
                fitting.append(argument)
            return call(self.handle, *fitting)

        if kind.result == ffi.typeof("pktrt_status"):
            if re.search(rf"\bpktrt_{name}\(\s*const ", _DECLARED):  # cffi forgets const
                return lambda *arguments: self._checked(checked(*arguments), name)
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
        keys = _array(positions, "positions").shape[:-2]
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
        descs = []
        for position, mesh in enumerate(meshes):
            if not isinstance(mesh, dict) or "positions" not in mesh:
                raise TypeError(f"meshes: number {position} is no dict that has positions")
            descs.append(self._mesh("add_model", **mesh))
        array, index = ffi.new("pktrt_mesh_desc[]", len(descs)), ffi.new("uint32_t *")
        for position, desc in enumerate(descs):
            _fill(array[position], desc, "add_model")
        self._must(lib.pktrt_add_model(self.handle, array, len(descs), index))
        return index[0]

    def add_instance(self, model, transforms=((1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0)), **fields):
        """Places a model by a (3, 4) matrix, or by (keys, 3, 4) that it moves between; fields: mask, interpolation, as
        pktrt.INTERPOLATION_RIGID. Returns its index."""
        _check_fields(ffi.typeof("pktrt_instance_desc"), fields, "add_instance", _OF_ARRAYS)
        keys = _array(transforms, "transforms").shape[:-2]
        matrices = _values(transforms, np.dtype("f4"), ((None,) if keys else ()) + (3, 4), "transforms")
        if keys and not keys[0]:
            raise ValueError("transforms: there is no key")
        desc = {"model": model, "key_count": keys[0] if keys else 1, "transforms": _read(matrices, "float"), **fields}
        instance = self._add(lib.pktrt_add_instance, "pktrt_instance_desc", desc, "add_instance")
        self._keys[instance] = keys
        return instance

    def set_transform(self, instance, transform, key=0):
        """Replaces the (3, 4) matrix of one key, for the next refit or commit."""
        matrix = _values(transform, np.dtype("f4"), (3, 4), "transform")
        self._must(lib.pktrt_set_transform(self.handle, _whole(instance, "instance"), _whole(key, "key"),
                                           _read(matrix, "float")))

    def set_transforms(self, instance, transforms):
        """Replaces all matrices of an instance, of the shape that add_instance was given."""
        if _whole(instance, "instance") not in self._keys:
            raise ValueError(f"instance: {instance} has not been added by add_instance")
        matrices = _values(transforms, np.dtype("f4"), self._keys[instance] + (3, 4), "transforms")
        self._must(lib.pktrt_set_transforms(self.handle, instance, _read(matrices, "float")))

    def _replace(self, call, mesh, key, values, name):
        if _whole(mesh, "mesh") not in self._meshes:
            raise ValueError(f"mesh: {mesh} has not been added by add_mesh")
        values = _values(values, np.dtype("f4"), (self._meshes[mesh], 3), name)
        self._must(call(self.handle, mesh, _whole(key, "key"), _read(values, "float")))

    def set_positions(self, mesh, positions, key=0):
        """Replaces the positions of one key, for the next refit or commit."""
        self._replace(lib.pktrt_set_positions, mesh, key, positions, "positions")

    def set_normals(self, mesh, normals, key=0):
        self._replace(lib.pktrt_set_normals, mesh, key, normals, "normals")

    def add_light(self, **fields):
        return self._add(lib.pktrt_add_light, "pktrt_light", fields, "add_light")

    def set_light(self, light, **fields):
        """Replaces a light by another, of any kind: fields that are not given are zero."""
        desc = _new("pktrt_light", fields, "set_light")
        self._must(lib.pktrt_set_light(self.handle, _whole(light, "light"), desc))

    def add_material(self, **fields):
        """Adds a material, and keeps its hooks and images, if any. texture: a hook; or an image, as array or Image,
        that the albedo is multiplied by; or a dict of images: albedo, reflectance, emission (factors; 1 where the
        material has none), opacity (of a cutout), exponent, normal (in the axes of the scene). Returns its index."""
        fields = _with_images(fields, "add_material")
        material = self._add(lib.pktrt_add_material, "pktrt_material", fields, "add_material")
        self._looks[material] = fields
        return material

    def set_material(self, material, **fields):
        """Replaces a material: fields that are not given are zero. texture: see add_material."""
        fields = _with_images(fields, "set_material")
        desc = _new("pktrt_material", fields, "set_material")
        self._must(lib.pktrt_set_material(self.handle, _whole(material, "material"), desc))
        self._looks[material] = fields

    def info(self):
        """What the committed scene is made of: a pktrt_scene_info."""
        info = ffi.new("pktrt_scene_info *")
        lib.pktrt_get_scene_info(self.handle, info)
        return info

    def mesh_info(self, mesh):
        """What a committed mesh is, as a pktrt.MESH_INFO: whether it is closed, how many edges are open, ..."""
        out = np.zeros((), MESH_INFO)
        self._checked(lib.pktrt_get_mesh_info(self.handle, _whole(mesh, "mesh"), _write(out, "pktrt_mesh_info")),
                   f"mesh {mesh}")
        return out

    def mesh_source(self, mesh):
        """The instance that a mesh belongs to, and the mesh of its model; None if it was added by add_mesh."""
        found = ffi.new("uint32_t[2]")
        there = lib.pktrt_get_mesh_source(self.handle, _whole(mesh, "mesh"), found, found + 1)
        return tuple(found) if there else None

    def trees(self):
        """The trees of the committed scene, an array of pktrt.TREE."""
        out = []
        while True:
            tree = np.zeros((), TREE)
            if not lib.pktrt_get_tree(self.handle, len(out), _write(tree, "pktrt_tree")):
                return np.array(out, TREE)
            out.append(tree)

    def node(self, tree, index, time=0):
        """A node of a tree, as a pktrt.NODE: boxes of its children at a time, triangles of its leaves. 0: the root."""
        out = np.zeros((), NODE)
        try:
            time = float(time)
        except (TypeError, ValueError):
            raise TypeError(f"time: {time!r} is no number") from None
        if not lib.pktrt_get_node(self.handle, _whole(tree, "tree"), _whole(index, "index"), time,
                                  _write(out, "pktrt_node")):
            raise ValueError(f"index: there is no node {index} in a tree {tree}")
        return out

    def report(self, **fields):
        """What the scene has and what a render with these fields runs, as a pktrt.SCENE_REPORT."""
        out = np.zeros((), SCENE_REPORT)
        fields, held = self._surrounded(fields, "report")
        desc = _new("pktrt_render_desc", fields, "report") if fields else ffi.NULL
        lib.pktrt_get_scene_report(self.handle, desc, _write(out, "pktrt_scene_report"))
        return out

    def report_text(self, **fields):
        """The same in lines of text."""
        report = _read(self.report(**fields), "pktrt_scene_report")
        room = lib.pktrt_scene_report_text(report, ffi.NULL, 0) + 1
        text = ffi.new("char[]", room)
        lib.pktrt_scene_report_text(report, text, room)
        return ffi.string(text).decode()

    # Queries: arrays of rays of any shape, and such answers. That of one ray, as rays[0], has the shape ().

    def intersect(self, rays, out=None, **query):
        """The nearest hits; their mesh is pktrt.NONE where a ray hits nothing. query: fields of pktrt_query_desc, as
        mask, path, stats."""
        rays = _structs(rays, RAY, "rays")
        out = _output(out, HIT, rays.shape)
        if query:
            desc = _new("pktrt_query_desc", query, "intersect")
            lib.pktrt_intersect_ex(self.handle, desc, _read(rays, "pktrt_ray"), _write(out, "pktrt_hit"), rays.size)
        elif rays.ndim == 0:
            lib.pktrt_intersect(self.handle, _read(rays, "pktrt_ray"), _write(out, "pktrt_hit"))
        else:
            lib.pktrt_intersect_n(self.handle, _read(rays, "pktrt_ray"), _write(out, "pktrt_hit"), rays.size)
        return out

    def occluded(self, rays, out=None, **query):
        """Whether anything is in the way. query: as of intersect."""
        rays = _structs(rays, RAY, "rays")
        out = _output(out, np.dtype(bool), rays.shape)
        if query:
            desc = _new("pktrt_query_desc", query, "occluded")
            lib.pktrt_occluded_ex(self.handle, desc, _read(rays, "pktrt_ray"), _write(out, "bool"), rays.size)
        elif rays.ndim == 0:
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

    def intersect_all(self, rays, capacity, out=None):
        """The nearest `capacity` crossings of each ray, (..., capacity), and how many there are, which may be more.
        Where there are less, the rest are misses."""
        rays = _structs(rays, RAY, "rays")
        capacity = _whole(capacity, "capacity")
        out = _output(out, HIT, rays.shape + (capacity,))
        counts = np.empty(rays.shape, np.uintp)
        out[...] = np.zeros((), HIT)
        out["mesh"] = out["triangle"] = lib.PKTRT_NONE
        out["t"] = rays["tmax"][..., None]
        lib.pktrt_intersect_all_n(self.handle, _read(rays, "pktrt_ray"), _write(out, "pktrt_hit"), capacity,
                                  _write(counts, "size_t"), rays.size)
        return out, counts

    def closest_point(self, points, max_distance=np.inf, time=0, mask=0, out=None):
        """The nearest points of all triangles to points (..., 3), as pktrt.CLOSEST: distance, point, normal, mesh, ...
        Their mesh is pktrt.NONE where there is none."""
        shape = _leading(points, 3, "points")
        queries = np.zeros(shape, _QUERY)
        queries["point"] = _values(points, np.dtype("f4"), shape + (3,), "points")
        queries["max_distance"] = _spread(max_distance, "f4", shape, "max_distance")
        queries["time"] = _spread(time, "f4", shape, "time")
        queries["mask"] = _spread(mask, "u4", shape, "mask")
        out = _output(out, CLOSEST, shape)
        lib.pktrt_closest_point_n(self.handle, _read(queries, "pktrt_point_query"), _write(out, "pktrt_closest"),
                                  out.size)
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

    def spawn_at(self, mesh, triangle, u, v, directions, time=0, out=None):
        """Rays that leave points of triangles in (..., 3) directions, without meeting these; all else is repeated to
        that shape."""
        shape = _leading(directions, 3, "directions")
        hits = np.zeros(shape, HIT)
        for name, values in (("mesh", mesh), ("triangle", triangle), ("u", u), ("v", v)):
            hits[name] = _spread(values, HIT[name], shape, name)
        times = _spread(time, "f4", shape, "time")
        directions = _values(directions, np.dtype("f4"), shape + (3,), "directions")
        out = _output(out, RAY, shape)
        lib.pktrt_spawn_at_n(self.handle, _read(hits, "pktrt_hit"), _read(times, "float"), _read(directions, "float"),
                             _write(out, "pktrt_ray"), out.size)
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
        shape = _leading(points, 3, "points")
        points = _values(points, np.dtype("f4"), shape + (3,), "points")
        times = _spread(time, "f4", shape, "time")
        out = np.empty(shape, "i4")
        lib.pktrt_winding_n(self.handle, _whole(mesh, "mesh"), _read(points, "float"), _read(times, "float"),
                            _write(out, "int"), out.size)
        return out

    def _surrounded(self, fields, call):
        """The fields of a render whose environment, if it is an image, is ready for C; and what must live meanwhile."""
        environment = fields.get("environment")
        if environment is None or isinstance(environment, ffi.CData):
            return {name: value for name, value in fields.items() if value is not None or name != "environment"}, None
        if "user" in fields:
            raise TypeError(f"{call}: user is no argument: the image of environment uses it")
        image = _image(environment, "srgb", "environment")
        return {**fields, "environment": ffi.addressof(_C, "pktrt_image_environment"), "user": image.pointer}, image

    def prepare_environment(self, environment=None, **fields):
        """Looks where an environment is bright, for all pictures with the same Image; None forgets it."""
        fields, held = self._surrounded({**fields, "environment": environment}, "prepare_environment")
        desc = _new("pktrt_render_desc", fields, "prepare_environment")
        self._must(lib.pktrt_prepare_environment(self.handle, desc))
        self._prepared = held, fields

    def render(self, width, height, buffers=(), out=None, **fields):
        """A picture, (height, width, 3) float32 of linear light; fields are those of pktrt_render_desc that describe
        no array, as camera=dict(eye=...), but that environment may be an image. With names of buffers, as ("depth",
        "normal", "pixel_error"), returns them behind it; block_error is (rows, columns) of blocks. "report" and "stats"
        are names, too, of a pktrt.REPORT and pktrt.STATS."""
        width, height = _whole(width, "width"), _whole(height, "height")
        taken = dict.fromkeys(_BUFFERS, "name it among buffers=, and get it back")
        taken["pixels"] = "the picture is returned"
        taken["row_stride"] = _OF_ARRAYS["row_stride"]
        _check_fields(ffi.typeof("pktrt_render_desc"), fields, "render", taken)
        buffers = (buffers,) if isinstance(buffers, str) else tuple(buffers)
        known = sorted([*_BUFFERS, *_RECORDS])
        unknown = [name for name in buffers if name not in known]
        if unknown:
            raise ValueError(f"render: buffers: there is no buffer {unknown[0]}, but these: {', '.join(known)}")
        made, pointers = {"pixels": _output(out, np.dtype("f4"), (height, width, 3))}, {}
        if out is None:
            made["pixels"][...] = 0
        for name in buffers:
            if name in _RECORDS:
                if name in fields:
                    raise TypeError(f"render: {name} is both an argument and among buffers")
                made[name] = np.zeros((), _RECORDS[name])
                pointers[name] = _write(made[name], "pktrt_" + name)
                continue
            channels, pixels_wide = _BUFFERS[name]
            shape = (-(-height // pixels_wide), -(-width // pixels_wide))
            made[name] = np.zeros(shape if channels == 1 else shape + (channels,),
                                  "u4" if name == "sample_count" else "f4")
            pointers[name] = _write(made[name], "uint32_t" if name == "sample_count" else "float")
        pointers["pixels"] = _write(made["pixels"], "float")
        fields, held = self._surrounded(fields, "render")
        desc = _new("pktrt_render_desc", {**fields, **pointers, "width": width, "height": height}, "render")
        self._must(lib.pktrt_render(self.handle, desc))
        return (made["pixels"], *(made[name] for name in buffers)) if buffers else made["pixels"]
