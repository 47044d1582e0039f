"""Intersects rays with triangles by Embree, once with each of its two scene flags.

In a folder, all numbers little-endian:

    triangles  9 f32 a triangle: its corners
    rays       7 f32 a ray: origin, direction, greatest distance; the least distance is 0
    robust     written: 4 numbers a ray, with the flag for robust intersection
    fast       written: the same with Embree's default flags

The numbers of an answer are the triangle's number as u32 (4294967295: none is hit), then as f32 the
distance and the barycentric weights of the second and the third corner.
"""

import sys
from pathlib import Path

import numpy
from embreex.mesh_construction import TriangleMesh
from embreex.rtcore_scene import EmbreeScene

ANSWER = numpy.dtype([("triangle", "<u4"), ("t", "<f4"), ("u", "<f4"), ("v", "<f4")])


def intersect(triangles, rays, robust):
    scene = EmbreeScene(robust=robust)
    TriangleMesh(scene, triangles)
    origins, directions = (numpy.ascontiguousarray(rays[:, part]) for part in (slice(0, 3), slice(3, 6)))
    # Embree overwrites the distances.
    hits = scene.run(origins, directions, dists=rays[:, 6].copy(), output=True)
    answers = numpy.empty(len(rays), dtype=ANSWER)
    answers["triangle"] = hits["primID"].view("<u4")
    for ours, theirs in (("t", "tfar"), ("u", "u"), ("v", "v")):
        answers[ours] = hits[theirs]
    return answers


def main():
    folder = Path(sys.argv[1])
    triangles = numpy.fromfile(folder / "triangles", dtype="<f4").reshape(-1, 3, 3)
    rays = numpy.fromfile(folder / "rays", dtype="<f4").reshape(-1, 7)
    for robust, name in ((True, "robust"), (False, "fast")):
        intersect(triangles, rays, robust).tofile(folder / name)


main()
