/* configure.h: Configure, AxisConfig and Zone: checked, then kept. */
#ifndef GONIO_CONFIGURE_H
#define GONIO_CONFIGURE_H

#include "motion_state.h"

void gn_configure_request(struct gn_motion *motion, uint32_t request_id, const gonio_Configure *configure);
void gn_configure_axis_request(struct gn_motion *motion, uint32_t request_id, const gonio_AxisConfig *config);
void gn_configure_zone_request(struct gn_motion *motion, uint32_t request_id, const gonio_Zone *zone);

#endif
