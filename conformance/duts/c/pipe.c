/* The protocol saarcor-vm over stdin and stdout, around the calls of saarcor.h. */
#include "saarcor.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static uint8_t bytes[1 << 19];

static int digit(char c) {
    return c >= '0' && c <= '9' ? c - '0' : (c | 32) >= 'a' && (c | 32) <= 'f' ? (c | 32) - 'a' + 10 : -1;
}

static void write_host(uint32_t host, const char *digits) {
    uint64_t count = 0;
    for (; digit(digits[0]) >= 0; digits += 2) bytes[count++] = (uint8_t)(digit(digits[0]) << 4 | digit(digits[1]));
    saarcor_vm_write(host, bytes, count);
}

static void read_host(uint32_t host, uint32_t count) {
    saarcor_access access;
    saarcor_vm_read(host, bytes, count, &access);
    unsigned address = (unsigned)access.card;
    if (access.hit) printf("h %x ", address);
    else if (access.evicted == SAARCOR_NOTHING_EVICTED) printf("m %x - ", address);
    else printf("m %x %x ", address, (unsigned)access.evicted);
    for (const uint8_t *byte = bytes; byte < bytes + count; byte++) {
        putchar_unlocked("0123456789abcdef"[*byte >> 4]);
        putchar_unlocked("0123456789abcdef"[*byte & 15]);
    }
    putchar_unlocked('\n');
}

static void configure(const char *line) {
    static const char *const keys[] = { "line", "lines", "ways", "hash", "policy" };
    char hash[32] = "", policy[32] = "";
    saarcor_config config;
    if (sscanf(line, "config line=%u lines=%u ways=%u hash=%31s policy=%31s", &config.line, &config.lines, &config.ways,
               hash, policy) != 5) exit((puts("unsupported config"), 0));
    config.hash = !strcmp(hash, "low") ? SAARCOR_LOW : !strcmp(hash, "add-upper") ? SAARCOR_ADD_UPPER : SAARCOR_ADD_UPPER_ALL;
    config.policy = !strcmp(policy, "lru") ? SAARCOR_LRU : !strcmp(policy, "fifo") ? SAARCOR_FIFO : SAARCOR_PLRU;
    uint32_t unsupported = saarcor_vm_configure(&config);
    if (unsupported) exit((printf("unsupported %s\n", keys[unsupported - 1]), 0));
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
        case 'i': saarcor_vm_invalidate(host, strtoull(word, NULL, 16)); puts("ok"); break;
        case 'f': saarcor_vm_flush(); puts("ok"); break;
        case 'c': configure(line); break;
        case 's': puts("saarcor-vm 1"); break;
        case 'e': return puts("end"), 0;
        }
    }
    return 1;
}
