/* unguarded.h: how fast an axis may go whose drive has no RPDO deadline (0x1400:05).
 * If the firmware dies, such a drive hears of it only when its heartbeat consumer (0x1016, heartbeat_timeout_ms) runs
 * out; until then it may run on at its speed, then it brakes by its quick stop. */
#ifndef GONIO_UNGUARDED_H
#define GONIO_UNGUARDED_H

#include "gonio.pb.h"

/* The whole way that it may run on alone: 18 mm at the end of an arm of 1 m. Software limits, end stops and zones are
 * drawn with more than that to spare. */
#define GN_UNGUARDED_WAY_DEG 1.0

double gn_unguarded_speed_deg_per_s(const gonio_AxisConfig *axis, const gonio_Configure *cycle);

#endif
