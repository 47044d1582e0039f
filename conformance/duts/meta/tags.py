"""The tags of version B of the SaarCOR chip, speaking saarcor-meta over stdin and stdout (PROTOCOL.md)."""

import sys

ENTRY = 5  # bytes of metadata a line
THIRD = 0x9249249249  # every third of 40 bits


def encode(line, resident, order):
    bits = line | resident << 32 | order << 33
    for check in range(37, 40):
        bits |= (bits & THIRD << check % 3).bit_count() % 2 << check
    return bits.to_bytes(ENTRY, "little")


def decode(data):
    bits = int.from_bytes(data, "little")
    corrupt = any((bits & THIRD << third).bit_count() % 2 for third in range(3))
    return None if corrupt else [bits & 0xFFFFFFFF, bits >> 32 & 1, bits >> 33 & 15]


class Metadata:
    """The bytes of all metadata on the card, and the granules that the chip holds."""

    def __init__(self, data, granule, sets, ways):
        self.granule, self.ways, self.card = granule, ways, data
        self.cached = [[] for _ in range(sets)]  # [number, bytes, changed], the one used last at the end
        self.moved = []

    def bring(self, number):
        held = self.cached[number % len(self.cached)]
        found = next((entry for entry in held if entry[0] == number), None)
        self.moved.append(f"{'h' if found else 'm'}{number:x}")
        if found:
            held.remove(found)
        else:
            found = [number, self.card[number * self.granule:][:self.granule], False]
        if len(held) == self.ways:
            old, data, changed = held.pop(0)
            if changed:
                self.card[old * self.granule:(old + 1) * self.granule] = data
                self.moved.append(f"w{old:x}={data.hex()}")
        held.append(found)
        return found

    def parts(self, begin, size):
        """The granules of some bytes, with the place in the granule and the place in the bytes."""
        for number in range(begin // self.granule, (begin + size - 1) // self.granule + 1):
            first = number * self.granule
            low, high = max(begin, first), min(begin + size, first + self.granule)
            yield number, slice(low - first, high - first), slice(low - begin, high - begin)

    def now(self, begin, size):
        data = self.card[begin:begin + size]
        for number, there, here in self.parts(begin, size):
            for entry in self.cached[number % len(self.cached)]:
                if entry[0] == number:
                    data[here] = entry[1][there]
        return data

    def store(self, begin, data, corrupt):
        old = self.now(begin, len(data))
        for number, there, here in self.parts(begin, len(data)):
            if corrupt or old[here] != data[here]:
                entry = self.bring(number)
                entry[1][there], entry[2] = data[here], True


class Tags:
    """Which line lies where."""

    def __init__(self, config):
        self.hash, self.policy = config["hash"], config["policy"]
        sizes = [int(config[key]) for key in ("granule", "meta-sets", "meta-ways")]
        self.line, self.ways, lines = (int(config[key]) for key in ("line", "ways", "lines"))
        self.sets, self.size = lines // self.ways, self.ways * ENTRY
        self.empty = [[0, 0, way] for way in range(self.ways)]
        data = b"".join(encode(*entry) for entry in self.empty) * (self.sets + sizes[0])
        self.metadata = Metadata(bytearray(data), *sizes)

    def set_of(self, line):
        total, upper = line, line // self.sets if self.sets > 1 and self.hash != "low" else 0
        while upper:
            total += upper
            upper = upper // self.sets if self.hash == "add-upper-all" else 0
        return total % self.sets

    def load(self, line):
        index = self.set_of(line)
        for number, _, _ in self.metadata.parts(index * self.size, self.size):
            self.metadata.bring(number)
        data = self.metadata.now(index * self.size, self.size)
        entries = [decode(data[place:place + ENTRY]) for place in range(0, self.size, ENTRY)]
        corrupt = None in entries
        return index, [list(entry) for entry in self.empty] if corrupt else entries, corrupt

    def store(self, index, entries, corrupt):
        self.metadata.store(index * self.size, b"".join(encode(*entry) for entry in entries), corrupt)

    def read(self, host):
        line, offset = divmod(host, self.line)
        index, entries, corrupt = self.load(line)
        hits = [way for way, entry in enumerate(entries) if entry[:2] == [line, 1]]
        free = [way for way, entry in enumerate(entries) if not entry[1]]
        way = (hits or free or [entries[-1][2]])[0]
        answer = f"{'h' if hits else 'm'} {(index * self.ways + way) * self.line + offset:x}"
        if not hits:
            answer += f" {entries[way][0] * self.line:x}" if entries[way][1] else " -"
        if not hits or self.policy != "fifo":
            order = [way] + [entry[2] for entry in entries if entry[2] != way]
            for entry, other in zip(entries, order):
                entry[2] = other
        entries[way][:2] = [line, 1]
        self.store(index, entries, corrupt)
        return answer

    def invalidate(self, host, count):
        for line in range(host // self.line, (host + count - 1) // self.line + 1):
            index, entries, corrupt = self.load(line)
            for entry in entries:
                if entry[:2] == [line, 1]:
                    entry[1] = 0
                    self.store(index, entries, corrupt)
        return "ok"


def main():
    tags = config = None
    for request in sys.stdin:
        name, *words = request.split() or ["#"]
        if name in ("r", "i"):
            tags.metadata.moved = []
            answer = (tags.read if name == "r" else tags.invalidate)(*(int(word, 16) for word in words))
            answer += " " + ",".join(tags.metadata.moved)
        elif name == "x":
            tags.metadata.card[int(words[0], 16)] ^= int(words[1], 16)
            answer = "ok"
        elif name in ("config", "flush"):
            config = dict(word.split("=") for word in words) or config
            tags, answer = Tags(config), "ok observes=hit,card,evict,meta,bytes" if words else "ok"
            answer = "unsupported policy" if tags.policy == "plru" else answer
        elif name.startswith("saarcor-") or name == "end":
            answer = "saarcor-meta 1" if name != "end" else "end"
        else:
            continue
        print(answer)


main()
