#!/usr/bin/env python3
"""Plays a din trace on pycachesim, a cache simulator independent of this project.

Prints the hits and misses of a cold cache for each memory size, as TOML: the format of
traces/*.toml, so that a new trace's expectations are this program's output.

Usage: check.py TRACE [--line 128] [--ways 4] [--policy LRU] --memory BYTES [--memory BYTES ...]
"""

import argparse
import importlib.metadata
import pathlib
import sys

import cachesim

READ = "0"


def addresses(path):
    """The byte addresses of a din trace: a label and a hexadecimal address a row."""
    with open(path, encoding="ascii") as trace:
        for number, row in enumerate(trace, start=1):
            fields = row.split()
            if len(fields) != 2 or fields[0] != READ:
                sys.exit(f"{path}:{number}: expected '0 HEXADDRESS', a read, found {row.strip()!r}")
            yield int(fields[1], 16)


def play(trace, memory, line, ways, policy):
    """Hits and misses of a cold cache without hash."""
    cache = cachesim.Cache("L2", memory // (line * ways), ways, line, policy)
    host = cachesim.MainMemory()
    host.load_to(cache)
    host.store_from(cache)
    simulator = cachesim.CacheSimulator(cache, host)
    for address in trace:
        simulator.load(address, length=1)
    stats = cache.stats()
    return stats["HIT_count"], stats["MISS_count"]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("trace", type=pathlib.Path)
    parser.add_argument("--line", type=int, default=128, help="bytes a line")
    parser.add_argument("--ways", type=int, default=4, help="lines a set")
    parser.add_argument("--policy", choices=["LRU", "FIFO"], default="LRU")
    parser.add_argument("--memory", type=int, action="append", required=True, help="bytes of the cache")
    arguments = parser.parse_args()

    trace = list(addresses(arguments.trace))
    print(f'trace = "{arguments.trace.name}"')
    print('simulator = "pycachesim"')
    print(f'version = "{importlib.metadata.version("pycachesim")}"')
    print(f'policy = "{arguments.policy}"')
    print(f"line_bytes = {arguments.line}")
    print(f"ways = {arguments.ways}")
    for memory in arguments.memory:
        hits, misses = play(trace, memory, arguments.line, arguments.ways, arguments.policy)
        print(f"\n[[cold]]\nmemory_bytes = {memory}\nhits = {hits}\nmisses = {misses}")


if __name__ == "__main__":
    main()
