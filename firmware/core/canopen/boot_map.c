/* boot_map.c: reads a fixed PDO map and decides whether the cycle can work with it. */
#include "boot_map.h"

#include <stdio.h>

static bool refuse(struct gn_trouble *trouble, uint16_t index, const char *what) {
    *trouble = (struct gn_trouble){
        .code = gonio_FaultCode_FAULT_READ_BACK,
        .index = index,
        .remedy = "change the map with the maker's tool, or change the drive",
    };
    (void)snprintf(trouble->cause, sizeof trouble->cause, "its fixed PDO map 0x%04X %s", index, what);
    return false;
}

bool gn_fixed_map_take(struct gn_boot *boot, uint16_t index, uint8_t subindex, uint32_t value,
                       struct gn_trouble *trouble) {
    if (subindex == 0u) {
        gn_pdo_map_clear(&boot->fixed);
        boot->map_count = value;
        return (value >= 1u && value <= GN_PDO_ENTRIES) || refuse(trouble, index, "does not have 1 to 8 entries");
    }
    return gn_pdo_map_add(&boot->fixed, value) || refuse(trouble, index, "is not of whole bytes, 8 at most");
}

bool gn_fixed_map_check(const struct gn_pdo_map *map, uint16_t index, struct gn_trouble *trouble) {
    bool const receive = index == 0x1600u;
    if (!gn_pdo_map_has(map, receive ? GN_MAP_CONTROLWORD : GN_MAP_STATUSWORD)) {
        return refuse(trouble, index, receive ? "lacks 0x6040 (controlword)" : "lacks 0x6041 (statusword)");
    }
    if (!gn_pdo_map_has(map, receive ? GN_MAP_TARGET : GN_MAP_POSITION)) {
        return refuse(trouble, index, receive ? "lacks 0x607A (target position)" : "lacks 0x6064 (position)");
    }
    return true;
}

void gn_own_maps(struct gn_pdo_map *rpdo, struct gn_pdo_map *tpdo) {
    gn_pdo_map_clear(rpdo);
    gn_pdo_map_clear(tpdo);
    (void)gn_pdo_map_add(rpdo, GN_MAP_CONTROLWORD);
    (void)gn_pdo_map_add(rpdo, GN_MAP_TARGET);
    (void)gn_pdo_map_add(tpdo, GN_MAP_STATUSWORD);
    (void)gn_pdo_map_add(tpdo, GN_MAP_POSITION);
}
