/* pdo.h: PDO mappings and the packing of controlword, target and mode, statusword and position by them. */
#ifndef GONIO_PDO_H
#define GONIO_PDO_H

#include <stdbool.h>
#include <stdint.h>

#include "can.h"

/* Mapping entries: index, subindex, bits (CiA 301, 0x1600). */
#define GN_MAP_CONTROLWORD 0x60400010u
#define GN_MAP_STATUSWORD 0x60410010u
#define GN_MAP_MODE 0x60600008u
#define GN_MAP_POSITION 0x60640020u
#define GN_MAP_TARGET 0x607A0020u

#define GN_PDO_ENTRIES 8u
#define GN_RPDO1 0x200u
#define GN_TPDO1 0x180u

struct gn_pdo_map {
    uint32_t count;
    uint32_t entries[GN_PDO_ENTRIES];
    uint8_t offsets[GN_PDO_ENTRIES]; /* bytes */
    uint8_t length;                  /* bytes of the whole PDO */
};

struct gn_pdo_command {
    uint16_t controlword;
    int32_t target_counts;
    int8_t mode;
};

void gn_pdo_map_clear(struct gn_pdo_map *map);
/* false: no whole bytes, or more than eight of them. */
bool gn_pdo_map_add(struct gn_pdo_map *map, uint32_t entry);
bool gn_pdo_map_has(const struct gn_pdo_map *map, uint32_t entry);

/* RPDO of a node by its map; mapped objects that are not ours are sent as 0. */
void gn_pdo_pack(const struct gn_pdo_map *map, uint32_t node, const struct gn_pdo_command *command,
                 struct gn_can_frame *frame);
/* false: the frame is shorter than the map, or the map lacks statusword or position. */
bool gn_pdo_unpack(const struct gn_pdo_map *map, const struct gn_can_frame *frame, uint16_t *statusword,
                   int32_t *position_counts);

#endif
