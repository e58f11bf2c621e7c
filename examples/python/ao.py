"""Ambient occlusion of balls on a floor, or of a .tri file: how much of the sky each point sees.
python3 ao.py [FILE.tri] >ao.pgm

Asks for no sine and sums up nothing but whole numbers, so that the picture has the same bits on every machine."""
import sys

import numpy as np
import pktrt

WIDTH, HEIGHT, SAMPLES = 480, 320, 64


def unit(v):
    return v / np.sqrt(v[..., :1] * v[..., :1] + v[..., 1:2] * v[..., 1:2] + v[..., 2:] * v[..., 2:])


def ball(middle, radius, n=24):
    """The six sides of a cube, each a grid, pushed out to a sphere."""
    i, j = np.mgrid[:n, :n].reshape(2, -1) * [[1], [n + 1]]
    quads = np.array([i + j, i + j + 1, i + j + n + 2, i + j, i + j + n + 2, i + j + n + 1]).T.reshape(-1, 3)
    y, x = np.mgrid[:n + 1, :n + 1].reshape(2, -1) * 2 / n - 1
    sides = [np.roll(np.array([x, y, 0 * x + end]), turn, axis=0).T for end in (-1, 1) for turn in range(3)]
    quads = np.concatenate([quads + k * len(x) for k in range(6)])
    return np.array(middle) + radius * unit(np.concatenate(sides)), quads


scene = pktrt.Scene()
scene.add_mesh([[-9, -1, -9], [9, -1, -9], [9, -1, 9], [-9, -1, 9]], [[0, 1, 2], [0, 2, 3]])
if len(sys.argv) > 1:
    soup = np.fromfile(sys.argv[1], "<f4", offset=4).reshape(-1, 3)
    scene.add_mesh((soup - (soup.max(0) + soup.min(0)) / 2) * 2 / (soup.max(0) - soup.min(0)).max())
else:
    for x, z, radius in ((-2, 0.5, 0.5), (-1, 1, 0.3), (0, -0.3, 0.8), (1, 0.8, 0.4), (2, 0, 0.6)):
        scene.add_mesh(*ball([x, radius - 1, z], radius))
scene.commit()

y, x = np.mgrid[:HEIGHT, :WIDTH] + 0.5
ray = pktrt.rays([0, 1, 5], np.stack([(x - WIDTH / 2) / HEIGHT, (HEIGHT / 2 - y) / HEIGHT - 0.25, x * 0 - 1], axis=-1))
hit = scene.intersect(ray)
seen = hit["mesh"] != pktrt.NONE
ray, hit = ray[seen], hit[seen]
normal = scene.surface(ray, hit)["normal"]
numbers = np.random.default_rng(1)
x, y, z = cube = numbers.uniform(-1, 1, (3, 8192))
sphere = unit(cube.T[x * x + y * y + z * z < 1])
sky = np.zeros(len(ray), int)
for _ in range(SAMPLES):  # a normal and a point of the unit sphere: the more upright, the more often, by the cosine
    sky += ~scene.occluded(scene.spawn(ray, hit, normal + sphere[numbers.integers(len(sphere), size=len(ray))]))
picture = np.full((HEIGHT, WIDTH), 40, np.uint8)
picture[seen] = 255 * sky // SAMPLES
sys.stdout.buffer.write(b"P5 %d %d 255\n" % (WIDTH, HEIGHT) + picture.tobytes())
