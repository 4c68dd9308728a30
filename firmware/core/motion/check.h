/* check.h: what is checked about a knot on receipt, each refusal with its sentence. */
#ifndef GONIO_CHECK_H
#define GONIO_CHECK_H

#include "path.h"
#include "quintic.h"

/* Usable values, and rest where the path begins and ends. */
bool gn_check_knot(const struct gn_knot *knot, uint32_t number, uint32_t knot_count, char *why, uint32_t why_size);
/* The first knot: at time 0, where the axes stand. */
bool gn_check_start(const struct gn_knot *knot, const double *standing_counts, char *why, uint32_t why_size);
/* The segment that ends at knot `number`: time, position, velocity, acceleration, zones. */
bool gn_check_segment(const struct gn_path *path, const struct gn_knot *from, const struct gn_knot *to, uint32_t number,
                      char *why, uint32_t why_size);
/* The segment between two knots, one quintic per axis. */
void gn_segment(struct gn_quintic *axes, const struct gn_knot *from, const struct gn_knot *to);

#endif
