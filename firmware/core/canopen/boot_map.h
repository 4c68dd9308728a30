/* boot_map.h: boot's dealings with a PDO map that the drive does not let write. */
#ifndef GONIO_BOOT_MAP_H
#define GONIO_BOOT_MAP_H

#include "axis.h"
#include "trouble.h"

/* Take one value just read of 0x1600 or 0x1A00 (sub 0: the count). false: no use, the trouble says why. */
bool gn_fixed_map_take(struct gn_boot *boot, uint16_t index, uint8_t subindex, uint32_t value,
                       struct gn_trouble *trouble);
/* The whole map was read: does it carry what a cycle needs? */
bool gn_fixed_map_check(const struct gn_pdo_map *map, uint16_t index, struct gn_trouble *trouble);
/* The map that boot writes itself. */
void gn_own_maps(struct gn_pdo_map *rpdo, struct gn_pdo_map *tpdo);

#endif
