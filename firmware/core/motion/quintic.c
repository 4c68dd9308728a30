/* quintic.c: quintic Hermite segments in Bernstein form. */
#include "quintic.h"

struct gn_quintic gn_quintic_join(const struct gn_state *from, const struct gn_state *to, double duration_s) {
    /* The derivatives of a Bernstein polynomial at its ends are differences of its first and last coefficients. */
    double const from_speed = from->velocity * duration_s / 5.0;
    double const from_bend = from->acceleration * duration_s * duration_s / 20.0;
    double const to_speed = to->velocity * duration_s / 5.0;
    double const to_bend = to->acceleration * duration_s * duration_s / 20.0;
    return (struct gn_quintic){
        .position =
            {
                from->position,
                from->position + from_speed,
                from->position + 2.0 * from_speed + from_bend,
                to->position - 2.0 * to_speed + to_bend,
                to->position - to_speed,
                to->position,
            },
        .duration_s = duration_s,
    };
}

void gn_quintic_velocity(const struct gn_quintic *segment, double *coefficients) {
    for (uint32_t i = 0; i < 5u; i++) {
        coefficients[i] = 5.0 / segment->duration_s * (segment->position[i + 1u] - segment->position[i]);
    }
}

void gn_quintic_acceleration(const struct gn_quintic *segment, double *coefficients) {
    double const scale = 20.0 / (segment->duration_s * segment->duration_s);
    for (uint32_t i = 0; i < 4u; i++) {
        coefficients[i] = scale * ((segment->position[i + 2u] - segment->position[i + 1u]) -
                                   (segment->position[i + 1u] - segment->position[i]));
    }
}

struct gn_state gn_quintic_state(const struct gn_quintic *segment, double time_s) {
    double velocity[5];
    double acceleration[4];
    double const u = time_s / segment->duration_s;
    gn_quintic_velocity(segment, velocity);
    gn_quintic_acceleration(segment, acceleration);
    return (struct gn_state){
        .position = gn_bernstein_value(segment->position, 5u, u),
        .velocity = gn_bernstein_value(velocity, 4u, u),
        .acceleration = gn_bernstein_value(acceleration, 3u, u),
    };
}
