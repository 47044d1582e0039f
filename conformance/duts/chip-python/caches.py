"""The first-level caches of the SaarCOR chip, and who waits for them (L1-1, CH-8 to CH-11)."""

from bus import in_turn


class OnItsWay:
    def __init__(self, line, thread, parts):
        self.line, self.threads, self.parts, self.there = line, [thread], parts, 0


class FirstLevel:
    """4 ways, LRU, sets by the lower bits."""

    def __init__(self, unit, config, bus):
        self.line, self.ports, self.latency, self.registers = (
            config[f"{unit}-{key}"] for key in ("line", "ports", "look-up", "mshrs"))
        self.unit, self.bus, self.base = unit, bus, config["triangles"] if unit == "t" else 0
        self.sets = [[] for _ in range(config[unit + "-sets"])]  # the line used last at the end
        self.on_their_way, self.parked, self.parts = [], [], []
        self.last_pipeline, self.last_thread = -1, [-1] * config["pipelines"]
        self.look_ups = self.merged = self.misses = 0

    def lines_of(self, address, size):
        first = address - self.base
        return list(range(first // self.line, (first + size - 1) // self.line + 1)) if size else []

    def parts_of(self, line):
        return list(self.bus.parts_of(self.base, line, self.line))

    def use(self, line):
        """One step of the set; whether the line was there."""
        held = self.sets[line % len(self.sets)]
        hit = line in held
        if hit:
            held.remove(line)
        elif len(held) == 4:
            held.pop(0)
        held.append(line)
        return hit

    def arrivals(self, now):
        """The threads whose line is there now."""
        arrived = [way for way in self.on_their_way if way.parts == 0 and way.there <= now]
        for way in arrived:
            self.on_their_way.remove(way)
            self.unpark()
        return [thread for way in arrived for thread in way.threads]

    def serve(self, threads, now):
        """The look-ups of a cycle."""
        for _ in range(self.ports):
            asking = [number for number, thread in enumerate(threads) if thread.asks(self.unit)]
            if not asking:
                break
            self.last_pipeline = in_turn([threads[number].pipeline for number in asking], self.last_pipeline)
            own = [number for number in asking if threads[number].pipeline == self.last_pipeline]
            number = in_turn(own, self.last_thread[self.last_pipeline])
            self.last_thread[self.last_pipeline] = number
            self.look_up(threads[number], now)
            if len(self.on_their_way) < self.registers:
                self.unpark()

    def unpark(self):
        if self.parked:
            self.parked.pop(0).state = "asks"

    def look_up(self, thread, now):
        line = thread.lines[0]
        way = next((way for way in self.on_their_way if way.line == line), None)
        there = line in self.sets[line % len(self.sets)]
        if not way and not there and len(self.on_their_way) == self.registers:
            thread.state = "parked"
            self.parked.append(thread)
            return
        self.look_ups += 1
        self.use(line)
        thread.state = "waits"
        if way:
            self.merged += 1
            thread.way = way
            way.threads.append(thread)
        elif there:
            thread.state, thread.done = "looks up", now + self.latency
        else:
            self.misses += 1
            parts = self.parts_of(line)
            way = OnItsWay(line, thread, len(parts))
            thread.way = way
            self.on_their_way.append(way)
            self.parts += [(way, address, size) for address, size in parts]
