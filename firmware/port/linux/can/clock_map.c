/* clock_map.c: narrows the difference of the clocks pair by pair, sees it jump, and places stamps on either side. */
#include "clock_map.h"

static struct gn_clock_offset offset_of(const struct gn_clock_pair *pair) {
    return (struct gn_clock_offset){pair->real_ns - pair->after_ns, pair->real_ns - pair->before_ns};
}

static int64_t middle(const struct gn_clock_offset *offset) {
    return offset->low_ns + (offset->high_ns - offset->low_ns) / 2;
}

void gn_clock_map_init(struct gn_clock_map *map, const struct gn_clock_pair *pair) {
    *map = (struct gn_clock_map){.present = offset_of(pair), .empty_ns = pair->after_ns};
}

void gn_clock_map_update(struct gn_clock_map *map, const struct gn_clock_pair *pair) {
    struct gn_clock_offset const seen = offset_of(pair);
    int64_t const low_ns = seen.low_ns > map->present.low_ns ? seen.low_ns : map->present.low_ns;
    int64_t const high_ns = seen.high_ns < map->present.high_ns ? seen.high_ns : map->present.high_ns;
    if (low_ns <= high_ns) {
        map->present = (struct gn_clock_offset){low_ns, high_ns};
        return;
    }
    if (low_ns - high_ns > GN_CLOCK_STEP_NS) {
        map->previous = map->present;
        map->stepped = true;
        map->steps++;
    }
    map->present = seen;
}

void gn_clock_map_drained(struct gn_clock_map *map, int64_t now_ns) {
    map->empty_ns = now_ns;
    map->stepped = false;
}

/* Whether a stamp falls between the last empty look and now. The reading's own width is allowed for. */
static bool lands(const struct gn_clock_map *map, const struct gn_clock_offset *offset, int64_t real_ns,
                  int64_t now_ns) {
    return real_ns - offset->low_ns >= map->empty_ns - GN_CLOCK_TRANSIT_NS && real_ns - offset->high_ns <= now_ns;
}

int64_t gn_clock_map_stamp(const struct gn_clock_map *map, int64_t real_ns, int64_t now_ns, bool *by_arrival) {
    bool const after = lands(map, &map->present, real_ns, now_ns);
    bool const before = map->stepped && lands(map, &map->previous, real_ns, now_ns);
    *by_arrival = after == before; /* neither, or both: a step so small that either could be */
    if (*by_arrival) {
        return now_ns;
    }
    int64_t const stamp_ns = real_ns - middle(after ? &map->present : &map->previous);
    return stamp_ns < now_ns ? stamp_ns : now_ns;
}
