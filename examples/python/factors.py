"""View factors of four pairs of surfaces, with error bars, against their closed forms: how much of the light that a
diffuse surface sends out reaches another one. factors.py [--quick] [OUT.png]      writes out/factors.png

Cells begin with # %%, for notebooks and editors that know them. The closed forms are those of textbooks on radiative
transfer, as of Howell, Menguc and Siegel, "Thermal Radiation Heat Transfer"."""
# %% What is needed
import pathlib
import sys

import matplotlib
import numpy as np
import pktrt

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

arguments = [a for a in sys.argv[1:] if a != "--quick"]
OUT = pathlib.Path(arguments[0] if arguments else pathlib.Path(__file__).resolve().parents[2] / "out" / "factors.png")
QUICK = "--quick" in sys.argv
RAYS, REPLICATES = 1024 if QUICK else 4096, 32


# %% Surfaces, as points and triangles whose front sends out light
def sheet(corner, along, across):
    """A parallelogram, whose front is that of cross(along, across)."""
    corner, along, across = (np.array(v, float) for v in (corner, along, across))
    points = np.stack([corner, corner + along, corner + along + across, corner + across])
    return points, np.array([[0, 1, 2], [0, 2, 3]])


def disc(radius, height, upwards, sides=2048):
    """A polygon of the disc's area, perpendicular to y."""
    angle = 2 * np.pi * np.arange(sides) / sides
    radius *= np.sqrt(2 * np.pi / sides / np.sin(2 * np.pi / sides))
    rim = np.stack([radius * np.cos(angle), 0 * angle + height, radius * np.sin(angle)], axis=1)
    k = np.arange(sides)
    turn = np.stack([0 * k + sides, (k + 1) % sides, k] if upwards else [0 * k + sides, k, (k + 1) % sides], axis=1)
    return np.concatenate([rim, [[0, height, 0]]]), turn


def ball(rows=200):
    """A unit sphere, between the polyhedra inside and outside."""
    columns = 2 * rows
    theta, phi = np.mgrid[:rows + 1, :columns] * np.pi / rows
    points = np.stack([np.sin(theta) * np.cos(phi), np.cos(theta), np.sin(theta) * np.sin(phi)], axis=-1).reshape(-1, 3)
    row, column = np.mgrid[:rows, :columns].reshape(2, -1)
    a, b = row * columns + column, row * columns + (column + 1) % columns
    triangles = np.concatenate([np.stack([a, b, a + columns], 1), np.stack([b, b + columns, a + columns], 1)])
    return points * (1 + (np.pi / rows) ** 2 / 12), triangles


# %% A view factor, by rays
def factor(sender, receiver, first):
    """The mean over replicates, of seeds from the first on, and its standard error. Each replicate is a scrambled set
    of Sobol' points in four dimensions: two choose a point of the sender, two the direction, with density cos / pi."""
    scene = pktrt.Scene()
    of, to = scene.add_mesh(*sender), scene.add_mesh(*receiver)
    scene.commit()
    corner = sender[0][sender[1]]
    normal = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    area = np.sqrt((normal ** 2).sum(1))
    normal /= np.where(area > 0, area, 1)[:, None]
    upto = np.cumsum(area) / area.sum()
    estimates = []
    for seed in range(first, first + REPLICATES):
        s = pktrt.samples(RAYS, 4, seed=seed)
        chosen = np.minimum(np.searchsorted(upto, s[:, 0], side="right"), len(area) - 1)
        begin = np.concatenate([[0], upto])[chosen]
        root = np.sqrt((s[:, 0] - begin) / np.maximum(upto[chosen] - begin, 1e-30)).clip(0, 1)
        directions = pktrt.map_cosine(s[:, 2:], normal[chosen])
        rays = scene.spawn_at(of, chosen, root * (1 - s[:, 1]), root * s[:, 1], directions)
        estimates.append((scene.intersect(rays)["mesh"] == to).mean())
    return np.mean(estimates), np.std(estimates, ddof=1) / np.sqrt(REPLICATES)


# %% Four pairs, and their closed forms
def facing(distance):
    """Two parallel squares of side 1."""
    x2 = 1 / distance ** 2
    x, root = np.sqrt(x2), np.sqrt(1 + x2)
    return 2 / (np.pi * x2) * (np.log((1 + x2) / np.sqrt(1 + 2 * x2)) + 2 * x * root * np.arctan(x / root) -
                               2 * x * np.arctan(x))


def corner(height):
    """From a unit square to a rectangle of this height that stands on one of its sides."""
    w, h = 1.0, height
    w2, h2 = w * w, h * h
    s = w2 + h2
    logs = np.log((1 + w2) * (1 + h2) / (1 + s)) + w2 * np.log(w2 * (1 + s) / ((1 + w2) * s)) + \
        h2 * np.log(h2 * (1 + s) / ((1 + h2) * s))
    arcs = w * np.arctan(1 / w) + h * np.arctan(1 / h) - np.sqrt(s) * np.arctan(1 / np.sqrt(s))
    return (arcs + logs / 4) / (np.pi * w)


def discs(distance):
    """From a disc of radius 1 to a coaxial one of radius 1/2."""
    r1, r2 = 1 / distance, 0.5 / distance
    x = 1 + (1 + r2 * r2) / (r1 * r1)
    return (x - np.sqrt(x * x - 4 * (r2 / r1) ** 2)) / 2


def over(distance):
    """From a sphere of radius 1 to a disc of radius 1 at this distance from its middle."""
    return (1 - 1 / np.sqrt(1 + 1 / distance ** 2)) / 2


floor = sheet([0, 0, 0], [0, 0, 1], [1, 0, 0])
pairs = (
    ("two parallel unit squares", "distance", facing, np.linspace(0.1, 2, 11), lambda d: (
        floor, sheet([0, d, 0], [1, 0, 0], [0, 0, 1]))),
    ("unit square to a rectangle on its side", "height of the rectangle", corner, np.linspace(0.1, 2, 11), lambda h: (
        floor, sheet([0, 0, 0], [0, h, 0], [0, 0, 1]))),
    ("disc of radius 1 to a coaxial one of 1/2", "distance", discs, np.linspace(0.1, 2, 11), lambda d: (
        disc(1, 0, True), disc(0.5, d, False))),
    ("unit sphere to a disc of radius 1", "distance from the sphere's centre", over, np.linspace(1.05, 3, 11),
     lambda d: (ball(60 if QUICK else 200), disc(1, -d, True))))

# %% Plots: above the factors, below how far they are off, with bars of two standard errors
figure = plt.figure(figsize=(11, 9))
outer = figure.add_gridspec(2, 2, hspace=0.28, wspace=0.24, left=0.07, right=0.98, top=0.95, bottom=0.06)
for place, (name, axis, closed, values, surfaces) in zip(outer, pairs):
    found = np.array([factor(*surfaces(value), REPLICATES * k) for k, value in enumerate(values)])
    off = found[:, 0] - closed(values)
    errors = np.maximum(found[:, 1], 0.1 / (RAYS * REPLICATES))
    fine = np.linspace(values[0], values[-1], 300)
    inner = place.subgridspec(2, 1, height_ratios=(2.2, 1), hspace=0.12)
    above = figure.add_subplot(inner[0])
    below = figure.add_subplot(inner[1], sharex=above)
    above.plot(fine, closed(fine), color="0.6", label="closed form")
    above.errorbar(values, found[:, 0], 2 * errors, fmt="o", markersize=4, color="C0", label="rays")
    above.set_title(name, fontsize=11)
    above.set_ylabel("view factor")
    above.set_ylim(0)
    above.legend(frameon=False)
    above.tick_params(labelbottom=False)
    below.axhline(0, color="0.6")
    below.errorbar(values, off * 1e4, 2 * errors * 1e4, fmt="o", markersize=4, color="C0", capsize=2)
    below.set_xlabel(axis)
    below.set_ylabel("off by, 1e-4")
    print(f"{name}: {abs(off).max():.1e} and {abs(off / errors).max():.1f} standard errors off at most")
OUT.parent.mkdir(parents=True, exist_ok=True)
figure.savefig(OUT, dpi=90)
