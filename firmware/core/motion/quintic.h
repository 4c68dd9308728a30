/* quintic.h: one axis between two knots: the quintic with their positions, velocities and accelerations. */
#ifndef GONIO_QUINTIC_H
#define GONIO_QUINTIC_H

#include "bernstein.h"

struct gn_state {
    double position;     /* counts */
    double velocity;     /* counts/s */
    double acceleration; /* counts/s2 */
};

struct gn_quintic {
    double position[6]; /* Bernstein coefficients on [0, duration] */
    double duration_s;
};

/* Hermite interpolation at both ends; duration_s > 0. */
struct gn_quintic gn_quintic_join(const struct gn_state *from, const struct gn_state *to, double duration_s);
struct gn_state gn_quintic_state(const struct gn_quintic *segment, double time_s);
/* Bernstein coefficients of the velocity: 5, in counts/s. */
void gn_quintic_velocity(const struct gn_quintic *segment, double *coefficients);
/* Bernstein coefficients of the acceleration: 4, in counts/s2. */
void gn_quintic_acceleration(const struct gn_quintic *segment, double *coefficients);

#endif
