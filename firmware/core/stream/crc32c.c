/* crc32c.c: CRC-32C eight bytes at a time: by the instruction of SSE4.2 or ARMv8 where the processor has it, else by
 * eight tables. */
#include "crc32c.h"

#include <stdbool.h>
#include <string.h>

#if defined(__x86_64__)
#include <nmmintrin.h>
#define INSTRUCTION __attribute__((target("sse4.2")))
#elif defined(__aarch64__) && defined(__linux__)
#include <arm_acle.h>
#include <sys/auxv.h>
#define INSTRUCTION __attribute__((target("+crc")))
#define HWCAP_BIT_CRC32 (1ul << 7) /* of the kernel's ABI: <asm/hwcap.h> */
#endif

_Static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "eight bytes are loaded as one little-endian word");

/* A table's entry is linear over GF(2) in the bits of its index, so eight constants (the entries of 1, 2, 4 .. 128)
 * give all 256. */
#define ENTRY(i, a, b, c, d, e, f, g, h)                                                                               \
    ((((i) >> 0u & 1u) * (a)) ^ (((i) >> 1u & 1u) * (b)) ^ (((i) >> 2u & 1u) * (c)) ^ (((i) >> 3u & 1u) * (d)) ^       \
     (((i) >> 4u & 1u) * (e)) ^ (((i) >> 5u & 1u) * (f)) ^ (((i) >> 6u & 1u) * (g)) ^ (((i) >> 7u & 1u) * (h)))
#define ENTRIES_4(i, ...)                                                                                              \
    ENTRY(i, __VA_ARGS__), ENTRY((i) + 1u, __VA_ARGS__), ENTRY((i) + 2u, __VA_ARGS__), ENTRY((i) + 3u, __VA_ARGS__)
#define ENTRIES_16(i, ...)                                                                                             \
    ENTRIES_4(i, __VA_ARGS__), ENTRIES_4((i) + 4u, __VA_ARGS__), ENTRIES_4((i) + 8u, __VA_ARGS__),                     \
        ENTRIES_4((i) + 12u, __VA_ARGS__)
#define ENTRIES_64(i, ...)                                                                                             \
    ENTRIES_16(i, __VA_ARGS__), ENTRIES_16((i) + 16u, __VA_ARGS__), ENTRIES_16((i) + 32u, __VA_ARGS__),                \
        ENTRIES_16((i) + 48u, __VA_ARGS__)
#define SLICE(...)                                                                                                     \
    {                                                                                                                  \
        ENTRIES_64(0u, __VA_ARGS__), ENTRIES_64(64u, __VA_ARGS__), ENTRIES_64(128u, __VA_ARGS__),                      \
            ENTRIES_64(192u, __VA_ARGS__)                                                                              \
    }

/* table[k][i]: the checksum of byte i followed by k zero bytes, for the polynomial 0x82F63B78. */
static const uint32_t table[8][256] = {
    SLICE(0xF26B8303u, 0xE13B70F7u, 0xC79A971Fu, 0x8AD958CFu, 0x105EC76Fu, 0x20BD8EDEu, 0x417B1DBCu, 0x82F63B78u),
    SLICE(0x13A29877u, 0x274530EEu, 0x4E8A61DCu, 0x9D14C3B8u, 0x3FC5F181u, 0x7F8BE302u, 0xFF17C604u, 0xFBC3FAF9u),
    SLICE(0xA541927Eu, 0x4F6F520Du, 0x9EDEA41Au, 0x38513EC5u, 0x70A27D8Au, 0xE144FB14u, 0xC76580D9u, 0x8B277743u),
    SLICE(0xDD45AAB8u, 0xBF672381u, 0x7B2231F3u, 0xF64463E6u, 0xE964B13Du, 0xD725148Bu, 0xABA65FE7u, 0x52A0C93Fu),
    SLICE(0x38116FACu, 0x7022DF58u, 0xE045BEB0u, 0xC5670B91u, 0x8F2261D3u, 0x1BA8B557u, 0x37516AAEu, 0x6EA2D55Cu),
    SLICE(0xEF306B19u, 0xDB8CA0C3u, 0xB2F53777u, 0x6006181Fu, 0xC00C303Eu, 0x85F4168Du, 0x0E045BEBu, 0x1C08B7D6u),
    SLICE(0x68032CC8u, 0xD0065990u, 0xA5E0C5D1u, 0x4E2DFD53u, 0x9C5BFAA6u, 0x3D5B83BDu, 0x7AB7077Au, 0xF56E0EF4u),
    SLICE(0x493C7D27u, 0x9278FA4Eu, 0x211D826Du, 0x423B04DAu, 0x847609B4u, 0x0D006599u, 0x1A00CB32u, 0x34019664u),
};

uint32_t gn_crc32c_portable(uint32_t crc, const void *bytes, size_t length) {
    const uint8_t *next = bytes;
    uint32_t state = ~crc;
    for (; length >= 8u; length -= 8u, next += 8) {
        uint64_t word = 0;
        memcpy(&word, next, sizeof word);
        word ^= state;
        state = table[7][word & 255u] ^ table[6][word >> 8u & 255u] ^ table[5][word >> 16u & 255u] ^
                table[4][word >> 24u & 255u] ^ table[3][word >> 32u & 255u] ^ table[2][word >> 40u & 255u] ^
                table[1][word >> 48u & 255u] ^ table[0][word >> 56u];
    }
    for (; length > 0u; --length) {
        state = state >> 8u ^ table[0][(state ^ *next++) & 255u];
    }
    return ~state;
}

#if defined(__x86_64__)
static bool has_instruction(void) {
    return __builtin_cpu_supports("sse4.2");
}

INSTRUCTION static uint32_t eight(uint32_t state, uint64_t word) {
    return (uint32_t)_mm_crc32_u64(state, word);
}

INSTRUCTION static uint32_t one(uint32_t state, uint8_t byte) {
    return _mm_crc32_u8(state, byte);
}
#elif defined(INSTRUCTION)
static bool has_instruction(void) {
    return (getauxval(AT_HWCAP) & HWCAP_BIT_CRC32) != 0u;
}

INSTRUCTION static uint32_t eight(uint32_t state, uint64_t word) {
    return __crc32cd(state, word);
}

INSTRUCTION static uint32_t one(uint32_t state, uint8_t byte) {
    return __crc32cb(state, byte);
}
#endif

#if defined(INSTRUCTION)
INSTRUCTION static uint32_t by_instruction(uint32_t crc, const uint8_t *next, size_t length) {
    uint32_t state = ~crc;
    for (; length >= 8u; length -= 8u, next += 8) {
        uint64_t word = 0;
        memcpy(&word, next, sizeof word);
        state = eight(state, word);
    }
    for (; length > 0u; --length) {
        state = one(state, *next++);
    }
    return ~state;
}
#endif

uint32_t gn_crc32c(uint32_t crc, const void *bytes, size_t length) {
#if defined(INSTRUCTION)
    if (has_instruction()) {
        return by_instruction(crc, bytes, length);
    }
#endif
    return gn_crc32c_portable(crc, bytes, length);
}
