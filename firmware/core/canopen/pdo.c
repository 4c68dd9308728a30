/* pdo.c: packs and unpacks the cyclic PDOs by the mapping that the drive has. */
#include "pdo.h"

void gn_pdo_map_clear(struct gn_pdo_map *map) {
    *map = (struct gn_pdo_map){0};
}

bool gn_pdo_map_add(struct gn_pdo_map *map, uint32_t entry) {
    uint32_t const bits = entry & 0xFFu;
    if (map->count == GN_PDO_ENTRIES || bits == 0u || bits % 8u != 0u || map->length + bits / 8u > 8u) {
        return false;
    }
    map->entries[map->count] = entry;
    map->offsets[map->count] = map->length;
    map->length = (uint8_t)(map->length + bits / 8u);
    map->count++;
    return true;
}

/* Byte offset of an entry, or -1. */
static int offset_of(const struct gn_pdo_map *map, uint32_t entry) {
    for (uint32_t i = 0; i < map->count; i++) {
        if (map->entries[i] == entry) {
            return map->offsets[i];
        }
    }
    return -1;
}

bool gn_pdo_map_has(const struct gn_pdo_map *map, uint32_t entry) {
    return offset_of(map, entry) >= 0;
}

static void put(const struct gn_pdo_map *map, uint32_t entry, uint32_t value, uint8_t *data) {
    int const offset = offset_of(map, entry);
    if (offset < 0) {
        return;
    }
    for (uint32_t i = 0; i < (entry & 0xFFu) / 8u; i++) {
        data[(uint32_t)offset + i] = (uint8_t)(value >> (8u * i));
    }
}

static uint32_t get(const struct gn_pdo_map *map, uint32_t entry, const uint8_t *data) {
    uint32_t const offset = (uint32_t)offset_of(map, entry);
    uint32_t value = 0;
    for (uint32_t i = 0; i < (entry & 0xFFu) / 8u; i++) {
        value |= (uint32_t)data[offset + i] << (8u * i);
    }
    return value;
}

void gn_pdo_pack(const struct gn_pdo_map *map, uint32_t node, const struct gn_pdo_command *command,
                 struct gn_can_frame *frame) {
    *frame = (struct gn_can_frame){.id = GN_RPDO1 + node, .length = map->length};
    put(map, GN_MAP_CONTROLWORD, command->controlword, frame->data);
    put(map, GN_MAP_TARGET, (uint32_t)command->target_counts, frame->data);
    put(map, GN_MAP_MODE, (uint8_t)command->mode, frame->data);
}

bool gn_pdo_unpack(const struct gn_pdo_map *map, const struct gn_can_frame *frame, uint16_t *statusword,
                   int32_t *position_counts) {
    if (frame->length < map->length || !gn_pdo_map_has(map, GN_MAP_STATUSWORD) ||
        !gn_pdo_map_has(map, GN_MAP_POSITION)) {
        return false;
    }
    *statusword = (uint16_t)get(map, GN_MAP_STATUSWORD, frame->data);
    *position_counts = (int32_t)get(map, GN_MAP_POSITION, frame->data);
    return true;
}
