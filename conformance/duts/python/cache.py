"""The virtual memory of the SaarCOR chip, speaking saarcor-vm over stdin and stdout (PROTOCOL.md)."""

import sys

PAGE = 4096


class Host:
    """The host's memory: zero but for the pages that were written to."""

    def __init__(self):
        self.pages = {}

    def write(self, host, data):
        for address, byte in enumerate(data, host):
            self.pages.setdefault(address // PAGE, bytearray(PAGE))[address % PAGE] = byte

    def line(self, host, size):
        whole = max(size, PAGE)
        pages = range(host // PAGE, (host // whole * whole + whole - 1) // PAGE + 1)
        data = b"".join(self.pages.get(page, bytes(PAGE)) for page in pages)
        return data[host % PAGE:][:size]


class Cache:
    """Lines on the card, in sets of ways."""

    def __init__(self, line, lines, ways, hash, policy):
        self.line, self.ways, self.sets = line, ways, lines // ways
        self.hash, self.policy = hash, policy
        self.host = Host()
        self.flush()

    def flush(self):
        self.tags = {}  # set -> the line in each way, or None
        self.data = {}  # line -> its bytes on the card
        self.order = {}  # set -> LRU, FIFO: ways from the oldest to the youngest; PLRU: bits of the tree

    def set_of(self, line):
        if self.hash == "low":
            return line % self.sets
        if self.hash == "add-upper":
            return (line + line // self.sets) % self.sets
        total = line
        while self.sets > 1 and line >= self.sets:
            line //= self.sets
            total += line % self.sets
        return total % self.sets

    def victim(self, tags, order):
        if None in tags:
            return tags.index(None)
        if self.policy != "plru":
            return order[0]
        node = 1
        while node < self.ways:
            node = 2 * node + order[node]
        return node - self.ways

    def use(self, order, way):
        if self.policy == "plru":
            node = self.ways + way
            while node > 1:
                order[node // 2] = 1 - node % 2
                node //= 2
        else:
            order.remove(way)
            order.append(way)

    def read(self, host, count):
        line, offset = divmod(host, self.line)
        index = self.set_of(line)
        tags = self.tags.setdefault(index, [None] * self.ways)
        first = [0] * self.ways if self.policy == "plru" else list(range(self.ways))
        order = self.order.setdefault(index, first)
        hit = line in tags
        way = tags.index(line) if hit else self.victim(tags, order)
        answer = f"{'h' if hit else 'm'} {(index * self.ways + way) * self.line + offset:x}"
        if not hit:
            evicted = tags[way]
            answer += " -" if evicted is None else f" {evicted * self.line:x}"
            self.data.pop(evicted, None)
            self.data[line] = self.host.line(line * self.line, self.line)
            tags[way] = line
        if not hit or self.policy != "fifo":
            self.use(order, way)
        return f"{answer} {self.data[line][offset:offset + count].hex()}"

    def invalidate(self, host, count):
        first, last = host // self.line, (host + count - 1) // self.line
        lines = range(first, last + 1) if last - first < len(self.data) else list(self.data)
        for line in lines:
            if line in self.data and first <= line <= last:
                del self.data[line]
                tags = self.tags[self.set_of(line)]
                tags[tags.index(line)] = None


def main():
    cache = None
    for request in sys.stdin:
        name, *words = request.split() or ["#"]
        if name == "r":
            answer = cache.read(int(words[0], 16), int(words[1], 16))
        elif name == "w":
            cache.host.write(int(words[0], 16), bytes.fromhex(words[1]))
            answer = "ok"
        elif name == "i":
            cache.invalidate(int(words[0], 16), int(words[1], 16))
            answer = "ok"
        elif name == "flush":
            cache.flush()
            answer = "ok"
        elif name == "config":
            config = dict(word.split("=") for word in words)
            sizes = [int(config[key]) for key in ("line", "lines", "ways")]
            cache = Cache(*sizes, config["hash"], config["policy"])
            answer = "ok observes=data,hit,card,evict"
        elif name.startswith("saarcor-"):
            answer = "saarcor-vm 1"
        elif name == "end":
            answer = "end"
        else:
            continue
        print(answer)
        if name == "end":
            break


if __name__ == "__main__":
    main()
