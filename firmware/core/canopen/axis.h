/* axis.h: one driven axis: its configuration, its node's protocol machines, and where it is. */
#ifndef GONIO_AXIS_H
#define GONIO_AXIS_H

#include "drive402.h"
#include "gonio.pb.h"
#include "nmt.h"
#include "pdo.h"
#include "sdo.h"

/* What every protocol machine needs of its surroundings, for one call. */
struct gn_bus {
    const struct gn_can_port *can;
    const gonio_Configure *cycle;
    int64_t now_ns;
};

struct gn_boot {
    uint32_t step;
    uint32_t phase;
    int64_t deadline_ns;
    bool start_allowed; /* every node is configured and SYNC runs */
    bool operational;
    uint32_t gear[2];        /* 0x6091: motor and shaft revolutions */
    uint32_t feed[2];        /* 0x6092: feed and shaft revolutions; feed 0: not there */
    bool period_read_only;   /* 0x60C2 */
    uint32_t period_units;   /* 0x60C2:01 where it is read only */
    uint32_t map_count;      /* entries of a fixed PDO map */
    struct gn_pdo_map fixed; /* as far as it was read */
};

enum gn_homing_phase {
    GN_HOMING_OFF = 0,
    GN_HOMING_SET_MODE = 1,
    GN_HOMING_CHECK_MODE = 2,
    GN_HOMING_ENABLE = 3,
    GN_HOMING_MOVE = 4,
    GN_HOMING_SET_CSP = 5,
    GN_HOMING_CHECK_CSP = 6,
    GN_HOMING_DONE = 7,
};

struct gn_homing {
    enum gn_homing_phase phase;
    bool began;       /* the drive said "in progress" */
    int64_t began_ns; /* of the phase */
};

struct gn_axis {
    gonio_AxisConfig config;
    bool configured;
    gonio_NodeInfo info;
    struct gn_node node;
    struct gn_sdo sdo;
    struct gn_pdo_map rpdo, tpdo;
    struct gn_drive drive;
    struct gn_boot boot;
    struct gn_homing homing;
    double unguarded_counts_per_s; /* fastest without an RPDO deadline; 0: it has one */
    bool enabled;                  /* operation enabled is expected of the drive */
    bool failed;                   /* since the last ClearFault */
    bool homed;                    /* position known */
    bool measured;                 /* measured_counts holds a position of this boot */
    int32_t measured_counts;
    int32_t target_counts; /* of the last RPDO */
};

#endif
