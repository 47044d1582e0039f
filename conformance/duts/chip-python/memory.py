"""What the SaarCOR chip reads through, in time: memory chips (SD-1 to SD-5) and tags (VM-1 to VM-13, CH-17)."""

ENTRY = 5  # bytes of metadata a line
THIRD = 0x9249249249  # every third of 40 bits


class MemoryChips:
    """Serves requests in the order in which they come; each learns when it is served. Times in here are clocks."""

    def __init__(self, config):
        self.config = config
        self.banks = [{"row": None, "may_open": 0, "may_close": 0} for _ in range(config["banks"])]
        self.bus_free = self.may_open = self.next_command = 0
        self.due = config["refresh"]
        self.taken = set()  # clocks from now on that have a command

    def request(self, cycle, address, size, write=False):
        """The cycle after the last beat, and the bytes that move: whole beats."""
        clock = -(-cycle // self.config["clock"])
        self.taken = {taken for taken in self.taken if taken >= clock}
        while self.config["refresh"] and self.due <= clock:
            self.refresh()
        beat, in_row = self.config["beat"], self.config["row"] // self.config["beat"]
        first, last = address // beat, (address + size - 1) // beat
        for row in range(first // in_row, last // in_row + 1):
            beats = min(last, row * in_row + in_row - 1) - max(first, row * in_row) + 1
            self.serve(clock, row, beats, write)
        return self.bus_free * self.config["clock"], (last - first + 1) * beat

    def command(self, clock):
        """Takes the first clock from `clock` on that has no command."""
        while clock in self.taken:
            clock += 1
        self.taken.add(clock)
        return clock

    def serve(self, clock, row, beats, write):
        config, bank = self.config, self.banks[row % self.config["banks"]]
        ready = clock
        if bank["row"] != row:
            if bank["row"] is not None:
                ready = self.command(max(clock, bank["may_close"])) + config["rp"]
            opened = self.command(max(ready, bank["may_open"], self.may_open))
            bank.update(row=row, may_open=opened + config["rc"], may_close=opened + config["ras"])
            self.may_open = opened + config["rrd"]
            ready = opened + config["rcd"]
        latency = 0 if write else config["cl"]
        command = self.command(max(ready, self.next_command, self.bus_free - latency))
        self.next_command, self.bus_free = command + 1, command + latency + beats
        done = self.bus_free + config["wr"] if write else command + beats
        bank["may_close"] = max(bank["may_close"], done)

    def refresh(self):
        begin = max(self.due, self.bus_free)
        if any(bank["row"] is not None for bank in self.banks):
            begin = self.command(max([begin] + [bank["may_close"] for bank in self.banks])) + self.config["rp"]
        end = self.command(max([begin] + [bank["may_open"] for bank in self.banks])) + self.config["rfc"]
        for bank in self.banks:
            bank.update(row=None, may_open=end)
        self.due += self.config["refresh"]


class Tags:
    """Which line lies where on the card, and the metadata that version B moves for it."""

    def __init__(self, config):
        self.config, self.ways = config, config["ways"]
        self.set_count = config["lines"] // self.ways
        self.sets = {}  # [line, whether it is there, management bits] of each way
        self.granules = [[] for _ in range(config["meta-sets"])]  # [number, changed], the one used last at the end

    def set_of(self, line):
        total, upper = line, line // self.set_count if self.config["hash"] != "low" and self.set_count > 1 else 0
        while upper:
            total += upper
            upper = upper // self.set_count if self.config["hash"] == "add-upper-all" else 0
        return total % self.set_count

    def locate(self, address):
        """Address on the card, whether the line is missed, and the granules that move: (number, whether written)."""
        if self.config["version"] == "none":
            return address, False, []
        line, offset = divmod(address, self.config["line"])
        index = self.set_of(line)
        plru = self.config["policy"] == "plru"
        entries = self.sets.setdefault(index, [[0, 0, 0 if plru else way] for way in range(self.ways)])
        before = encoded(entries)
        hits = [way for way, entry in enumerate(entries) if entry[:2] == [line, 1]]
        free = [way for way, entry in enumerate(entries) if not entry[1]]
        way = (hits or free or [pointed_at(entries) if plru else entries[-1][2]])[0]
        if plru:
            turn_away(entries, way)
        elif not hits or self.config["policy"] == "lru":
            order = [way] + [entry[2] for entry in entries if entry[2] != way]
            for entry, other in zip(entries, order):
                entry[2] = other
        entries[way][:2] = [line, 1]
        moves = self.moved(index, before, encoded(entries)) if self.config["version"] == "b" else []
        return (index * self.ways + way) * self.config["line"] + offset, not hits, moves

    def moved(self, index, before, after):
        size, begin, moves = self.config["granule"], index * len(before), []
        numbers = range(begin // size, (begin + len(before) - 1) // size + 1)
        changes = {(begin + place) // size for place in range(len(before)) if before[place] != after[place]}
        for number, change in [(n, False) for n in numbers] + [(n, True) for n in sorted(changes)]:
            held = self.granules[number % len(self.granules)]
            found = next((granule for granule in held if granule[0] == number), None)
            if found:
                held.remove(found)
            else:
                moves.append((number, False))
                if len(held) == 4:
                    old, changed = held.pop(0)
                    if changed:
                        moves.append((old, True))
            held.append([number, change or bool(found and found[1])])
        return moves


def pointed_at(entries):
    """The way that the bits of the tree point at: entry i has the bit of node i, the root is 1."""
    node = 1
    while node < len(entries):
        node = 2 * node + entries[node][2]
    return node - len(entries)


def turn_away(entries, way):
    node = len(entries) + way
    while node > 1:
        entries[node // 2][2] = 1 - node % 2
        node //= 2


def encoded(entries):
    data = b""
    for line, resident, order in entries:
        bits = line | resident << 32 | order << 33
        for check in range(37, 40):
            bits |= (bits & THIRD << check % 3).bit_count() % 2 << check
        data += bits.to_bytes(ENTRY, "little")
    return data
