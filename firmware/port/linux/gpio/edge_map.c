/* edge_map.c: offset to line; the numbers stay the kernel's, so a jump is an edge that its buffer lost. */
#include "edge_map.h"

bool gn_edge_map_take(struct gn_edge_map *map, const struct gn_line_event *event, struct gn_edge *edge) {
    for (uint32_t line = 0; line < GN_LINE_COUNT; line++) {
        if (map->has[line] && map->offsets[line] == event->offset) {
            map->numbers[line] = event->number;
            map->low[line] = !event->rising;
            *edge = (struct gn_edge){
                .line = line, .number = event->number, .rising = event->rising, .stamp_ns = (int64_t)event->stamp_ns};
            return true;
        }
    }
    return false;
}

bool gn_edge_map_lose(struct gn_edge_map *map, int64_t now_ns, struct gn_edge *edge) {
    for (uint32_t line = GN_LINE_STROBE + 1u; line < GN_LINE_COUNT; line++) {
        if (map->has[line] && !map->low[line]) {
            map->low[line] = true;
            *edge = (struct gn_edge){.line = line, .number = ++map->numbers[line], .stamp_ns = now_ns};
            return true;
        }
    }
    return false;
}
