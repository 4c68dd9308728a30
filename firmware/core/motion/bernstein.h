/* bernstein.h: polynomials on [0, 1] by their Bernstein coefficients, whose hull bounds the values between. */
#ifndef GONIO_BERNSTEIN_H
#define GONIO_BERNSTEIN_H

#include <stdint.h>

#define GN_BERNSTEIN_COUNT 6u /* coefficients of the highest degree, 5 */

struct gn_range {
    double low, high;
};

/* Halve [0, 1]: coefficients on [0, 1/2] and [1/2, 1] (de Casteljau). The outputs do not overlap the input. */
void gn_bernstein_split(const double *coefficients, uint32_t degree, double *left, double *right);
/* Value at u in [0, 1]; exact at both ends. */
double gn_bernstein_value(const double *coefficients, uint32_t degree, double u);
/* Smallest and largest coefficient: never narrower than the values. */
struct gn_range gn_bernstein_hull(const double *coefficients, uint32_t degree);
/* Bounds of the values, at most `tolerance` (or 1e-12 of the largest coefficient) wider than the values, by
 * subdivision. The coefficients must be finite. */
struct gn_range gn_bernstein_bounds(const double *coefficients, uint32_t degree, double tolerance);

#endif
