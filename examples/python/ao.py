"""Ambient occlusion of a town, or of a .tri file: how much of the sky each point sees. ao.py [FILE.tri] >ao.pgm"""
import sys

import numpy as np
import pktrt

WIDTH, HEIGHT, SAMPLES, EDGE = 480, 320, 64, 192
random = np.random.default_rng(7)
if len(sys.argv) > 1:
    points, triangles = np.fromfile(sys.argv[1], "<f4", offset=4).reshape(-1, 3), None
else:  # a sheet of squares, lifted by blocks; each square is two triangles
    z, x = np.mgrid[:EDGE, :EDGE]
    points = np.stack([x, np.kron(random.integers(0, 20, (24, 24)), np.ones((8, 8), int)), z], axis=-1).reshape(-1, 3)
    a, e = (z * EDGE + x)[:-1, :-1].reshape(-1, 1), EDGE
    triangles = (a + [[0, e, 1, 1, e, e + 1]]).reshape(-1, 3)
scene = pktrt.Scene()
scene.add_mesh((points - (points.max(0) + points.min(0)) / 2) * 2 / (points.max(0) - points.min(0)).max(), triangles)
scene.commit()
y, x = np.mgrid[:HEIGHT, :WIDTH] + 0.5
ray = pktrt.rays([0, 1.2, 2.2], np.stack([(x - WIDTH / 2) / HEIGHT, (HEIGHT / 2 - y) / HEIGHT - 0.6, x * 0 - 1], axis=-1))
hit = scene.intersect(ray)
seen = hit["mesh"] != pktrt.NONE
ray, hit, sky = ray[seen], hit[seen], np.zeros(seen.sum(), int)
normal = scene.surface(ray, hit)["normal"]
for _ in range(SAMPLES):  # normal and point of the unit sphere: the more upright, the more often, by the cosine
    point = random.normal(size=(len(ray), 3))
    sky += ~scene.occluded(scene.spawn(ray, hit, normal + point / np.sqrt((point * point).sum(1, keepdims=True))))
picture = np.full((HEIGHT, WIDTH), 40, np.uint8)
picture[seen] = 255 * sky // SAMPLES
sys.stdout.buffer.write(b"P5 %d %d 255\n" % (WIDTH, HEIGHT) + picture.tobytes())
