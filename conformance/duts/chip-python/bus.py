"""The bus manager of the SaarCOR chip: parts of missed lines, lines from the host, and what moves (CH-12 to CH-16)."""

from memory import MemoryChips, Tags


def in_turn(wanting, last):
    """Of those that want it the next above the one served last, else the lowest (CH-6)."""
    return min((number for number in wanting if number > last), default=min(wanting))


class Load:
    """A line from the host: where on the card it will lie, and the parts that wait for it."""

    def __init__(self, line, card):
        self.line, self.card, self.there, self.arrived, self.waiting = line, card, None, False, []


class BusManager:
    def __init__(self, config):
        self.config, self.now = config, 0
        self.memory, self.tags, self.last_cache = MemoryChips(config), Tags(config), -1
        self.asked, self.known = [], 0  # (cycle in which the tag is known, part, card, whether missed, its load)
        self.loads, self.bus_free, self.busy = [], 0, 0  # the loads in flight, in order
        self.moved = {"pci": 0, "fill": 0, "load": 0, "read": 0, "back": 0}
        self.look_ups = self.merged = self.misses = 0

    def parts_of(self, base, line, size):
        """The parts of a first-level line: (address, bytes)."""
        address, cut = base + line * size, self.config["line"]
        end = min(address + size, 1 << 32)
        while address < end:
            border = end if self.config["version"] == "none" else (address // cut + 1) * cut
            yield address, min(border, end) - address
            address = border

    def line_from_host(self):
        while self.loads and self.loads[0].there == self.now:
            load = self.loads.pop(0)
            load.arrived = True
            self.move("load", load.card, self.config["line"], True)
            for part, card in load.waiting:
                self.read(part, card)

    def act_upon_tags(self):
        while self.asked and self.asked[0][0] <= self.now:
            _, part, card, missed, load = self.asked.pop(0)
            if missed:
                beats = -(-self.config["line"] // self.config["pci-beat"])
                begin = max(self.now, self.bus_free)
                taken = self.config["pci-setup"] + beats * self.config["pci-clock"]
                self.bus_free, self.busy = begin + taken, self.busy + taken
                load.there = self.bus_free
                self.moved["pci"] += self.config["line"]
            if load and not load.arrived:
                load.waiting.append((part, card))
            else:
                self.read(part, card)

    def take_part(self, caches):
        """Takes a part (its line in flight, its address, its bytes), and looks up its tag."""
        asking = [place for place, cache in enumerate(caches) if cache.parts]
        if not asking:
            return
        self.last_cache = in_turn(asking, self.last_cache)
        part = caches[self.last_cache].parts.pop(0)
        card, missed, moves = self.tags.locate(part[1])
        granule, behind = self.config["granule"], self.config["lines"] * self.config["line"]
        ready = self.now
        for number, written in moves:
            end = self.move("back" if written else "read", behind + number * granule, granule, written)
            ready = ready if written else max(ready, end)
        if self.config["version"] != "none":
            ready += self.config["tag"]
        self.known = max(self.known, ready, self.now + 1)
        line, offset = divmod(part[1], self.config["line"])
        if missed:
            load = Load(line, card - offset)
            self.loads.append(load)
        else:  # The latest load of the line brings it to where it is resident.
            load = next((load for load in reversed(self.loads) if load.line == line), None)
        merged = load is not None and not missed
        self.look_ups, self.merged, self.misses = self.look_ups + 1, self.merged + merged, self.misses + missed
        self.asked.append((self.known, part, card, missed, load))

    def move(self, purpose, card, size, write=False):
        end, moved = self.memory.request(self.now, card, size, write)
        self.moved[purpose] += moved
        return end

    def read(self, part, card):
        way = part[0]
        end = self.move("fill", card, part[2])
        way.parts -= 1
        way.there = max(way.there, end + self.config["return"], self.now + 1)
