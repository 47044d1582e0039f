"""A ray against triangles in Python's fractions, independently of the exact judge.

Reads lines `t_min t_max o o o d d d` and nine corners a triangle, f32 as hexadecimal bits. Writes for each line
the triangles that are hit first (numbers joined by commas, or a dash) and the f64 nearest to their distance.

The method is another than the judge's: the point where the ray meets the plane, and then on which side of
each edge it lies, by the normal.
"""

import struct
import sys
from fractions import Fraction


# Every f32 is a multiple of 2^-149. Scaled by its inverse, all coordinates are whole numbers, and distances stay.
SCALE = 1 << 149


def number(bits):
    return struct.unpack(">f", bytes.fromhex(bits))[0]


def dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def sub(a, b):
    return [a[0] - b[0], a[1] - b[1], a[2] - b[2]]


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def distance(origin, direction, corners, t_min, t_max):
    a, b, c = corners
    normal = cross(sub(b, a), sub(c, a))
    across = dot(normal, direction)
    if across == 0:
        return None
    height = dot(normal, sub(a, origin))
    for p, q in ((a, b), (b, c), (c, a)):
        # From p to the point that is met, times `across`.
        to_point = [across * (o - x) + height * d for o, x, d in zip(origin, p, direction)]
        if dot(normal, cross(sub(q, p), to_point)) * across < 0:
            return None
    t = Fraction(height, across)
    return None if t < t_min or (t_max is not None and t >= t_max) else t


for line in sys.stdin:
    t_min, t_max, *rest = [number(bits) for bits in line.split()]
    whole = [int(Fraction(x) * SCALE) for x in rest]
    vectors = [whole[i:i + 3] for i in range(0, len(whole), 3)]
    origin, direction, corners = vectors[0], vectors[1], vectors[2:]
    end = None if t_max == float("inf") else Fraction(t_max)
    hits = []
    for place in range(len(corners) // 3):
        t = distance(origin, direction, corners[3 * place:3 * place + 3], Fraction(t_min), end)
        if t is not None:
            hits.append((t, place))
    least = min(hits)[0] if hits else None
    first = ",".join(str(place) for t, place in hits if t == least) or "-"
    print(first, "-" if least is None else float(least).hex())
