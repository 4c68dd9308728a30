/* unguarded.c: the speed at which delay and braking distance together are as long as is allowed. */
#include "unguarded.h"

#include <math.h>

double gn_unguarded_speed_deg_per_s(const gonio_AxisConfig *axis, const gonio_Configure *cycle) {
    double const deceleration = axis->quick_stop_deceleration_counts_per_s2 / fabs(axis->counts_per_deg);
    double const delay_s = cycle->heartbeat_timeout_ms * 1e-3;
    return deceleration * (sqrt(delay_s * delay_s + 2.0 * GN_UNGUARDED_WAY_DEG / deceleration) - delay_s);
}
