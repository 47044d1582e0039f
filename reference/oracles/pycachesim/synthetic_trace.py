#!/usr/bin/env python3
"""Writes traces/synthetic.din: reads as a ray tracer makes them, without a scene.

Each of 2000 "rays" walks a binary tree of 8-byte nodes from the root to a leaf and then reads
three records of 48 bytes. Neighbouring rays end in neighbouring leaves, and now and then one goes
elsewhere. A record that straddles two lines of 128 bytes is two reads, as in a recorded trace.
"""

LINE = 128
DEPTH = 12
NODE_BYTES = 8
RECORD_BYTES = 48
RECORDS_AT = (2 << DEPTH) * NODE_BYTES


def touch(address, size):
    """One row for each line touched."""
    print(f"0 {address:x}")
    if address // LINE != (address + size - 1) // LINE:
        print(f"0 {(address + size - 1) // LINE * LINE:x}")


def main():
    state = 2003
    leaf = 0
    for _ in range(2000):
        # The linear congruential generator of Numerical Recipes.
        state = (1664525 * state + 1013904223) % 2**32
        if state >> 29 == 0:
            leaf = (state >> 8) % 2**DEPTH
        else:
            leaf = (leaf + (state >> 24) % 3) % 2**DEPTH
        for level in range(DEPTH):
            node = 2**level + (leaf >> (DEPTH - level))
            touch(node * NODE_BYTES, NODE_BYTES)
        for record in range(3):
            touch(RECORDS_AT + (2 * leaf + record) * RECORD_BYTES, RECORD_BYTES)


if __name__ == "__main__":
    main()
