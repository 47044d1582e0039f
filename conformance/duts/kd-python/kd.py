"""The traversal and intersection units of the SaarCOR chip, speaking saarcor-kd over stdin and stdout (PROTOCOL.md)."""

import math
import struct
import sys

MEMORY = 1 << 24
INFINITY, NAN = float("inf"), float("nan")
FLOAT, WORD = struct.Struct("<f"), struct.Struct("<I")


def f32(value):
    """Rounded to single precision: each sum, product and quotient of two such numbers, rounded once."""
    try:
        return FLOAT.unpack(FLOAT.pack(value))[0]
    except OverflowError:
        return INFINITY if value > 0 else -INFINITY


def number(word):
    return FLOAT.unpack(WORD.pack(word))[0]


def bits(value):
    return f"{WORD.unpack(FLOAT.pack(value))[0]:x}"


def divide(a, b):
    if b == 0:
        return NAN if a == 0 or a != a else math.copysign(INFINITY, a) * math.copysign(1, b)
    return f32(a / b)


def dot(a, b):
    x, y, z = (f32(p * q) for p, q in zip(a, b))
    return f32(f32(x + y) + z)


def cross(a, b):
    return [f32(f32(a[p] * b[q]) - f32(a[q] * b[p])) for p, q in ((1, 2), (2, 0), (0, 1))]


def widen(t):
    """Least and greatest distance at which a plane may be met: wider by 2 gamma(3) and twice the least float."""
    width = f32(6 * 2.0**-24 / f32(1 - 3 * 2.0**-24))
    a, b = f32(t * f32(1 - width)), f32(t * f32(1 + width))
    return f32((a if a < b else b) - 2.0**-148), f32((a if a > b else b) + 2.0**-148)


def reciprocal(direction, reach):
    """1 / direction; NaN, for both children, where distances have no bound."""
    r = divide(1.0, direction)
    return r if direction == 0 or abs(r) >= 2.0**-126 and f32(reach * abs(r)) < INFINITY else NAN


class Units:
    def __init__(self):
        self.memory = bytearray(MEMORY)
        self.box = None

    def read(self, layout, address):
        self.touched.append(address)
        return struct.unpack_from(layout, self.memory, address)

    def intersect(self, address, triangle):
        """Moller and Trumbore: distance and weights, or nothing."""
        a, b, c = triangle[0:3], triangle[3:6], triangle[6:9]
        to_b, to_c, from_a = ([f32(x - y) for x, y in zip(end, a)] for end in (b, c, self.origin))
        p, q = cross(self.direction, to_c), cross(from_a, to_b)
        r = divide(1.0, dot(to_b, p))
        t, u, v = f32(dot(to_c, q) * r), f32(dot(from_a, p) * r), f32(dot(self.direction, q) * r)
        inside = u >= 0 and v >= 0 and f32(u + v) <= 1
        nearer = t < self.t or t == self.t and address < self.triangle
        if inside and self.t_min <= t < self.t_max and nearer:
            self.triangle, self.t, self.u, self.v = address, t, u, v

    def step(self, cell, first, second, stack):
        """The child that is next; the other is put off if the ray meets it. Beside NaN, min and max keep the first."""
        _, enter, leave = cell
        r, split = self.reciprocals[second & 3], number(first)
        low, high = widen(f32(f32(split - self.origin[second & 3]) * r))
        below, down = second & ~3, r < 0
        near = (below + 8 * down, enter, min(leave, high))
        far = (below + 8 * (not down), max(enter, low), leave)
        if near[1] <= near[2] and far[1] <= far[2]:
            stack.append(far)
        return near if near[1] <= near[2] else far

    def trace(self, numbers):
        self.origin, self.direction, (self.t_min, self.t_max) = numbers[0:3], numbers[3:6], numbers[6:8]
        self.triangle, self.t, self.touched = MEMORY, self.t_max, []
        self.reciprocals, enter, leave = [], self.t_min, self.t_max
        for low, high, origin, direction in zip(self.box[0:3], self.box[3:6], self.origin, self.direction):
            low, high = f32(low - origin), f32(high - origin)
            r = reciprocal(direction, max(abs(low), abs(high)))
            near, far = (high, low) if r < 0 else (low, high)
            enter, leave = max(enter, widen(f32(near * r))[0]), min(leave, widen(f32(far * r))[1])
            self.reciprocals.append(r)
        stack = [(0, enter, leave)]
        while stack:
            node, enter, leave = stack.pop()
            cell = (node, enter, min(leave, self.t))
            while cell[1] <= cell[2]:
                first, second = self.read("<II", cell[0])
                if second & 3 != 3:
                    cell = self.step(cell, first, second, stack)
                    continue
                for entry in range(second & ~3, (second & ~3) + 4 * first, 4):
                    triangle = self.read("<I", entry)[0] & ~3
                    self.intersect(triangle, self.read("<9f", triangle))
                break
        return self.triangle != MEMORY


def main():
    units = Units()
    for request in sys.stdin:
        name, *words = request.split() or ["#"]
        answer = "ok"
        numbers = [number(int(word, 16)) for word in words] if name in "abc" else []
        if name == "w":
            address, data = int(words[0], 16), bytes.fromhex(words[1])
            units.memory[address:address + len(data)] = data
        elif name == "b":
            units.box = numbers
        elif name == "a":
            answer = "h" if units.trace(numbers) else "m"
        elif name == "c":
            hit = units.trace(numbers)
            answer = f"h {units.triangle:x} {bits(units.t)} {bits(units.u)} {bits(units.v)}" if hit else "m"
            answer += " " + (",".join(f"{address:x}" for address in units.touched) or "none")
        elif name == "flush":
            units = Units()
        elif name == "config":
            known = words == ["kernel=moller-trumbore"]
            answer = "ok observes=triangle,t,uv,touched" if known else "unsupported kernel"
        elif name.startswith("saarcor-"):
            answer = "saarcor-kd 1"
        elif name == "end":
            answer = "end"
        else:
            continue
        print(answer)
        if name == "end":
            return


if __name__ == "__main__":
    main()
