/* A virtual memory as a shared library: what saarcor-vm 1 asks for over a pipe, as calls (PROTOCOL.md). */
#ifndef SAARCOR_H
#define SAARCOR_H

#include <stdint.h>

enum { SAARCOR_VM_VERSION = 1 };
enum { SAARCOR_LOW, SAARCOR_ADD_UPPER, SAARCOR_ADD_UPPER_ALL };             /* hash */
enum { SAARCOR_LRU, SAARCOR_FIFO, SAARCOR_PLRU };                           /* policy */
enum { SAARCOR_DATA = 1, SAARCOR_HIT = 2, SAARCOR_CARD = 4, SAARCOR_EVICT = 8 }; /* observes */

typedef struct { uint32_t line, lines, ways, hash, policy; } saarcor_config;

/* What a read did; what is not observed is of no interest. */
typedef struct { uint64_t card, evicted; uint32_t hit; } saarcor_access;
#define SAARCOR_NOTHING_EVICTED UINT64_MAX

uint32_t saarcor_vm_version(void);  /* SAARCOR_VM_VERSION */
uint32_t saarcor_vm_observes(void); /* a sum of SAARCOR_DATA and so on */

/* An empty cache in front of a host's memory of zeros; called once. 0, or else what is not supported: 1 line, 2 lines,
   3 ways, 4 hash, 5 policy. */
uint32_t saarcor_vm_configure(const saarcor_config *config);

void saarcor_vm_write(uint32_t host, const uint8_t *bytes, uint64_t count);
void saarcor_vm_read(uint32_t host, uint8_t *bytes, uint32_t count, saarcor_access *access); /* within one line */
void saarcor_vm_invalidate(uint32_t host, uint64_t count);
void saarcor_vm_flush(void);

#endif
