/* The virtual memory of the SaarCOR chip, speaking saarcor-vm over stdin and stdout (PROTOCOL.md). */
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef enum { LRU, FIFO, PLRU } policy_t;
typedef enum { LOW, ADD_UPPER, ADD_UPPER_ALL } hash_t;

static uint32_t line_size, line_bits, ways, sets, set_bits;
static hash_t hash;
static policy_t policy;

/* Metadata, an entry a way: the line's full address, whether it is resident, management bits. */
static uint32_t *tags;
static uint8_t *resident;
static uint8_t *order; /* LRU, FIFO: ways of a set from the youngest on; PLRU: bit of each tree node */

static uint8_t *card;              /* on-board memory */
static uint8_t *pages[1 << 20];    /* host memory; a page that is not there is zero */

static void load_line(uint32_t line, uint8_t *bytes) {
    uint32_t host = (uint32_t)((uint64_t)line << line_bits);
    for (uint32_t done = 0, part; done < line_size; done += part) {
        part = line_size - done < 4096 - (host + done) % 4096 ? line_size - done : 4096 - (host + done) % 4096;
        const uint8_t *page = pages[(host + done) / 4096];
        if (page) memcpy(bytes + done, page + (host + done) % 4096, part);
        else memset(bytes + done, 0, part);
    }
}

static uint32_t set_of(uint32_t line) {
    uint64_t sum = line, upper = (uint64_t)line >> set_bits;
    if (hash == ADD_UPPER) sum += upper;
    for (; hash == ADD_UPPER_ALL && set_bits && upper; upper >>= set_bits) sum += upper & (sets - 1);
    return (uint32_t)(sum & (sets - 1));
}

static uint32_t find(uint32_t set, uint32_t line) {
    for (uint32_t way = 0; way < ways; way++)
        if (resident[set * ways + way] && tags[set * ways + way] == line) return way;
    return ways;
}

static void use(uint32_t set, uint32_t way) {
    uint8_t *bits = order + set * ways;
    if (policy == PLRU) {
        for (uint32_t node = ways + way; node > 1; node /= 2) bits[node / 2] = !(node & 1);
        return;
    }
    uint32_t place = 0;
    while (bits[place] != way) place++;
    memmove(bits + 1, bits, place);
    bits[0] = (uint8_t)way;
}

static uint32_t victim(uint32_t set) {
    const uint8_t *bits = order + set * ways;
    for (uint32_t way = 0; way < ways; way++)
        if (!resident[set * ways + way]) return way;
    if (policy != PLRU) return bits[ways - 1];
    uint32_t node = 1;
    while (node < ways) node = 2 * node + bits[node];
    return node - ways;
}

static void flush(void) {
    memset(resident, 0, sets * ways);
    for (uint32_t entry = 0; entry < sets * ways; entry++) order[entry] = policy == PLRU ? 0 : entry % ways;
}

static void read_host(uint32_t host, uint32_t count) {
    uint32_t line = (uint32_t)((uint64_t)host >> line_bits), set = set_of(line);
    uint32_t offset = host & (line_size - 1), way = find(set, line);
    int hit = way < ways;
    if (!hit) way = victim(set);
    uint32_t slot = set * ways + way;
    uint8_t *bytes = card + (size_t)slot * line_size;
    uint32_t address = slot * line_size + offset;
    if (hit) printf("h %x ", address);
    else if (resident[slot]) printf("m %x %x ", address, tags[slot] << line_bits);
    else printf("m %x - ", address);
    if (!hit) {
        load_line(line, bytes);
        tags[slot] = line;
        resident[slot] = 1;
    }
    if (!hit || policy != FIFO) use(set, way);
    for (bytes += offset; count > 0; count--, bytes++) {
        putchar_unlocked("0123456789abcdef"[*bytes >> 4]);
        putchar_unlocked("0123456789abcdef"[*bytes & 15]);
    }
    putchar_unlocked('\n');
}

static void invalidate(uint32_t host, uint64_t count) {
    uint64_t first = host >> line_bits, last = (host + count - 1) >> line_bits;
    for (uint32_t slot = 0; slot < sets * ways && last - first >= sets * ways; slot++)
        if (tags[slot] >= first && tags[slot] <= last) resident[slot] = 0;
    for (uint64_t line = first; line <= last && last - first < sets * ways; line++) {
        uint32_t set = set_of((uint32_t)line), way = find(set, (uint32_t)line);
        if (way < ways) resident[set * ways + way] = 0;
    }
}

static void write_host(uint32_t host, const char *digits) {
    for (unsigned byte; sscanf(digits, "%2x", &byte) == 1; digits += 2, host++) {
        uint8_t **page = &pages[host / 4096];
        if (!*page) *page = calloc(1, 4096);
        (*page)[host % 4096] = (uint8_t)byte;
    }
}

static void configure(const char *line) {
    char hash_name[32] = "", policy_name[32] = "";
    unsigned lines;
    if (sscanf(line, "config line=%u lines=%u ways=%u hash=%31s policy=%31s", &line_size, &lines, &ways, hash_name,
               policy_name) != 5) exit((puts("unsupported config"), 0));
    hash = !strcmp(hash_name, "low") ? LOW : !strcmp(hash_name, "add-upper") ? ADD_UPPER : ADD_UPPER_ALL;
    policy = !strcmp(policy_name, "lru") ? LRU : !strcmp(policy_name, "fifo") ? FIFO : PLRU;
    sets = lines / ways;
    while (1u << line_bits < line_size) line_bits++;
    while (1u << set_bits < sets) set_bits++;
    tags = calloc(lines, sizeof *tags);
    resident = calloc(lines, 1);
    order = calloc(lines, 1);
    card = malloc((size_t)lines * line_size);
    flush();
    puts("ok observes=data,hit,card,evict");
}

int main(void) {
    static char line[1 << 20];
    while (fgets(line, sizeof line, stdin)) {
        char *word = line + 2, name = line[0];
        uint32_t host = name == 'r' || name == 'w' || name == 'i' ? (uint32_t)strtoul(word, &word, 16) : 0;
        switch (name) {
        case 'r': read_host(host, (uint32_t)strtoul(word, NULL, 16)); break;
        case 'w': write_host(host, word + 1); puts("ok"); break;
        case 'i': invalidate(host, strtoull(word, NULL, 16)); puts("ok"); break;
        case 'f': flush(); puts("ok"); break;
        case 'c': configure(line); break;
        case 's': puts("saarcor-vm 1"); break;
        case 'e': return puts("end"), 0;
        }
    }
    return 1;
}
