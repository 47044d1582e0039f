"""A ray against triangles in Python's fractions, independently of the exact judge.

Reads lines `t_min t_max o o o d d d` and nine corners a triangle, f32 as hexadecimal bits. Writes for each line
the triangles that are hit first (numbers joined by commas, or a dash) and the f64 nearest to their distance.

The method is another than the judge's: the point where the ray meets the plane, and then on which side of
each edge it lies, by the normal.
"""

import struct
import sys
from fractions import Fraction


def number(bits):
    return struct.unpack(">f", bytes.fromhex(bits))[0]


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def sub(a, b):
    return [x - y for x, y in zip(a, b)]


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def distance(origin, direction, corners, t_min, t_max):
    a, b, c = corners
    normal = cross(sub(b, a), sub(c, a))
    across = dot(normal, direction)
    if across == 0:
        return None
    t = dot(normal, sub(a, origin)) / across
    if t < t_min or (t_max is not None and t >= t_max):
        return None
    point = [o + t * d for o, d in zip(origin, direction)]
    for p, q in ((a, b), (b, c), (c, a)):
        if dot(normal, cross(sub(q, p), sub(point, p))) < 0:
            return None
    return t


for line in sys.stdin:
    t_min, t_max, *rest = [number(bits) for bits in line.split()]
    vectors = [[Fraction(x) for x in rest[i:i + 3]] for i in range(0, len(rest), 3)]
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
