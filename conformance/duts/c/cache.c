/* The virtual memory of the SaarCOR chip: a shared library, and with pipe.c a program (PROTOCOL.md). */
#include "saarcor.h"

#include <stdlib.h>
#include <string.h>

enum { LRU = SAARCOR_LRU, FIFO = SAARCOR_FIFO, PLRU = SAARCOR_PLRU };
enum { ADD_UPPER = SAARCOR_ADD_UPPER, ADD_UPPER_ALL = SAARCOR_ADD_UPPER_ALL };

static uint32_t line_size, line_bits, ways, sets, set_bits, hash, policy;

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

uint32_t saarcor_vm_version(void) { return SAARCOR_VM_VERSION; }

uint32_t saarcor_vm_observes(void) { return SAARCOR_DATA | SAARCOR_HIT | SAARCOR_CARD | SAARCOR_EVICT; }

uint32_t saarcor_vm_configure(const saarcor_config *config) {
    line_size = config->line;
    ways = config->ways;
    hash = config->hash;
    policy = config->policy;
    uint32_t lines = config->lines;
    sets = lines / ways;
    while (1u << line_bits < line_size) line_bits++;
    while (1u << set_bits < sets) set_bits++;
    tags = calloc(lines, sizeof *tags);
    resident = calloc(lines, 1);
    order = calloc(lines, 1);
    card = malloc((size_t)lines * line_size);
    saarcor_vm_flush();
    return 0;
}

void saarcor_vm_flush(void) {
    memset(resident, 0, sets * ways);
    for (uint32_t entry = 0; entry < sets * ways; entry++) order[entry] = policy == PLRU ? 0 : entry % ways;
}

void saarcor_vm_read(uint32_t host, uint8_t *bytes, uint32_t count, saarcor_access *access) {
    uint32_t line = (uint32_t)((uint64_t)host >> line_bits), set = set_of(line);
    uint32_t offset = host & (line_size - 1), way = find(set, line);
    int hit = way < ways;
    if (!hit) way = victim(set);
    uint32_t slot = set * ways + way;
    uint8_t *line_bytes = card + (size_t)slot * line_size;
    uint32_t address = slot * line_size + offset;
    *access = (saarcor_access){ address, SAARCOR_NOTHING_EVICTED, (uint32_t)hit };
    if (!hit) {
        if (resident[slot]) access->evicted = tags[slot] << line_bits;
        load_line(line, line_bytes);
        tags[slot] = line;
        resident[slot] = 1;
    }
    if (!hit || policy != FIFO) use(set, way);
    memcpy(bytes, line_bytes + offset, count);
}

void saarcor_vm_invalidate(uint32_t host, uint64_t count) {
    uint64_t first = host >> line_bits, last = (host + count - 1) >> line_bits;
    for (uint32_t slot = 0; slot < sets * ways && last - first >= sets * ways; slot++)
        if (tags[slot] >= first && tags[slot] <= last) resident[slot] = 0;
    for (uint64_t line = first; line <= last && last - first < sets * ways; line++) {
        uint32_t set = set_of((uint32_t)line), way = find(set, (uint32_t)line);
        if (way < ways) resident[set * ways + way] = 0;
    }
}

void saarcor_vm_write(uint32_t host, const uint8_t *bytes, uint64_t count) {
    for (; count > 0; count--, bytes++, host++) {
        uint8_t **page = &pages[host / 4096];
        if (!*page) *page = calloc(1, 4096);
        (*page)[host % 4096] = *bytes;
    }
}
