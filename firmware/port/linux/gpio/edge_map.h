/* edge_map.h: a chip's numbered events to the core's edges, and what is said of the lines of a chip that is lost. */
#ifndef GONIO_EDGE_MAP_H
#define GONIO_EDGE_MAP_H

#include <stdbool.h>
#include <stdint.h>

#include "edge.h"

/* The input lines of one chip. */
struct gn_edge_map {
    bool has[GN_LINE_COUNT];
    uint32_t offsets[GN_LINE_COUNT];
    uint32_t numbers[GN_LINE_COUNT]; /* of the last edge that came */
    bool low[GN_LINE_COUNT];         /* after it */
};

struct gn_line_event {
    uint32_t offset;
    uint32_t number; /* per line, by the kernel, from 1 */
    bool rising;
    uint64_t stamp_ns; /* CLOCK_MONOTONIC */
};

/* false: no line of ours. */
bool gn_edge_map_take(struct gn_edge_map *map, const struct gn_line_event *event, struct gn_edge *edge);
/* The chip is gone: every interlock line of it falls, for nobody knows its level any more. false: all have. */
bool gn_edge_map_lose(struct gn_edge_map *map, int64_t now_ns, struct gn_edge *edge);

#endif
