"""The SaarCOR chip in time, cycle by cycle (SPEC.md, CH-1 to CH-20), speaking saarcor-chip over stdin and stdout."""

import sys
from bus import BusManager, in_turn
from caches import FirstLevel
from work import Work

STANDARD = """pipelines=4 threads=16 tag=4 return=4 version=a line=128 lines=65536 ways=4 hash=add-upper policy=lru
    granule=16 meta-sets=1024 clock=4 beat=16 banks=4 row=4096 cl=3 rcd=3 rp=3 ras=6 rc=9 rrd=2 wr=2 refresh=2083 rfc=9
    pci-setup=38 pci-beat=4 pci-clock=16 triangles=0
    s-rate=1 s-latency=16 s-line=64 s-sets=256 n-rate=4 n-latency=8 n-line=8 n-sets=2048
    l-rate=64 l-latency=2 l-line=4 l-sets=4096 t-rate=1 t-latency=16 t-line=36 t-sets=1024"""
STANDARD += "".join(f" {unit}-ports=1 {unit}-look-up=2 {unit}-mshrs=16" for unit in "snlt")


class Thread:
    """A packet at a time: what is left of its program, and the lines that its operation still waits for."""

    def __init__(self, pipeline):
        self.pipeline, self.state, self.done, self.program, self.lines = pipeline, "free", 0, [], []
        self.way = None  # the line in flight that it waits for

    def asks(self, unit):
        return self.state == "asks" and self.program[0][0] == unit


class Chip:
    def __init__(self, config, before, packets):
        self.config, self.now, self.packets, self.last_pipeline = config, 0, list(packets), -1
        self.threads = [Thread(n // config["threads"]) for n in range(config["pipelines"] * config["threads"])]
        self.units = {}  # (pipeline, unit): the thread served last, and the first cycle in which it is free
        self.work = Work()
        self.bus = BusManager(config)
        self.caches = {unit: FirstLevel(unit, config, self.bus) for unit in "snlt"}
        for unit, address, size, _ in (operation for packet in before for operation in packet):
            cache = self.caches[unit]
            for line in cache.lines_of(address, size):
                if not cache.use(line):
                    for begin, _ in cache.parts_of(line):
                        self.bus.tags.locate(begin)

    def run(self):
        caches = list(self.caches.values())
        while True:
            self.bus.now = self.now
            self.answers()
            for thread in [thread for cache in caches for thread in cache.arrivals(self.now)]:
                self.answer(thread)
            self.bus.line_from_host()
            self.bus.act_upon_tags()
            self.hand_out()
            if not self.packets and all(thread.state == "free" for thread in self.threads):
                return self.report()
            self.start_units()
            for cache in caches:
                cache.serve(self.threads, self.now)
            self.bus.take_part(caches)
            self.work.account(self)
            self.now += 1

    def answers(self):
        for thread in self.threads:
            if thread.done == self.now and thread.state == "works":
                self.end(thread)
            elif thread.done == self.now and thread.state == "looks up":
                self.answer(thread)

    def hand_out(self):
        free = [thread for thread in self.threads if thread.state == "free"]
        if free and self.packets:
            self.last_pipeline = in_turn([thread.pipeline for thread in free], self.last_pipeline)
            thread = next(thread for thread in free if thread.pipeline == self.last_pipeline)
            thread.program = list(self.packets.pop(0))
            self.begin(thread)

    def start_units(self):
        ready = {}
        for number, thread in enumerate(self.threads):
            if thread.state == "ready":
                ready.setdefault((thread.pipeline, thread.program[0][0]), []).append(number)
        for place, numbers in ready.items():
            last, free = self.units.get(place, (-1, 0))
            if free <= self.now:
                number, unit = in_turn(numbers, last), place[1]
                thread = self.threads[number]
                free = self.now + max(1, -(-thread.program[0][3] // self.config[unit + "-rate"]))
                self.units[place] = number, free
                thread.state, thread.done = "works", free + self.config[unit + "-latency"]
                self.work.begins(unit, thread.program[0][3])

    def begin(self, thread):
        thread.state = "free"
        if thread.program:
            unit, address, size, _ = thread.program[0]
            thread.lines = self.caches[unit].lines_of(address, size)
            thread.state = "asks" if thread.lines else "ready"

    def answer(self, thread):
        """The line is there that a thread waits for."""
        thread.lines.pop(0)
        thread.state = "asks" if thread.lines else "ready"
        if not thread.lines and thread.program[0][3] == 0:
            self.end(thread)

    def end(self, thread):
        thread.program.pop(0)
        self.begin(thread)

    def report(self):
        counts = [f"{c.look_ups:x}/{c.merged:x}/{c.misses:x}" for c in [*self.caches.values(), self.bus]]
        pci, *memory = (f"{count:x}" for count in self.bus.moved.values())
        work = f" {self.work} {self.bus.busy:x}" if "--work" in sys.argv else ""
        return f"c {self.now:x} {pci} {','.join(memory)} {','.join(counts[:4])} {counts[4]}{work}"


def packet(words):
    operations = (word.split(",") for word in words)
    return [(unit, *(int(number, 16) for number in numbers)) for unit, *numbers in operations]


def main():
    config, before, packets = {}, [], []
    for request in sys.stdin:
        name, *words = request.split() or ["#"]
        answer = "ok"
        if name in ("b", "p"):
            (before if name == "b" else packets).append(packet(words))
        elif name == "run":
            answer = Chip(config, before, packets).run()
        elif name == "flush":
            before, packets = [], []
        elif name == "config":
            pairs = (word.split("=") for word in STANDARD.split() + words)
            config = {key: int(value) if value.isdecimal() else value for key, value in pairs}
            answer = "ok observes=cycles,pci,mem,l1,l2"
        elif name in ("saarcor-chip", "end"):
            answer = "saarcor-chip 1" if name != "end" else "end"
        else:
            continue
        print(answer)


main()
