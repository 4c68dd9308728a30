/* crc32c.h: CRC-32C (Castagnoli, reflected, RFC 3720): the check of every link frame. */
#ifndef GONIO_CRC32C_H
#define GONIO_CRC32C_H

#include <stddef.h>
#include <stdint.h>

/* Checksum of `bytes`; `crc` is 0, or the checksum of what went before. By the processor's instruction where it has
 * one. */
uint32_t gn_crc32c(uint32_t crc, const void *bytes, size_t length);
/* The same by tables, on any processor. */
uint32_t gn_crc32c_portable(uint32_t crc, const void *bytes, size_t length);

#endif
