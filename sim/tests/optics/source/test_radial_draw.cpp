// test_radial_draw.cpp: the inverse of cumulative distributions that are known in closed form.
#include <cmath>

#include <gtest/gtest.h>

#include "radial_draw.hpp"

namespace gonio::sim {
namespace {

TEST(Radial_draw, linear_densities_are_inverted_exactly) {
    // x / 2 on [0, 2]; then 3 falling to 1 on [0, 1]: 3 t - t^2 = 2 u.
    Radial_draw const rising({0.0, 2.0}, {0.0, 1.0});
    Radial_draw const falling({0.0, 1.0}, {3.0, 1.0});
    for (double const u : {0x1p-33, 0.001, 0.3, 0.5, 0.9, 1.0 - 0x1p-33}) {
        EXPECT_NEAR(rising.draw(u), 2.0 * std::sqrt(u), 1e-14);
        EXPECT_NEAR(falling.draw(u), 1.5 - std::sqrt(2.25 - 2.0 * u), 1e-14);
    }
}

TEST(Radial_draw, pieces_join_and_dark_gaps_are_skipped) {
    // Half of the power uniform on [0, 1], nothing up to 5, half on [5, 6].
    Radial_draw const draw({0.0, 1.0, 1.0, 5.0, 5.0, 6.0}, {1.0, 1.0, 0.0, 0.0, 1.0, 1.0});
    double last = 0.0;
    for (int i = 0; i < 100000; ++i) {
        double const u = (i + 0.5) / 100000;
        double const x = draw.draw(u);
        ASSERT_NEAR(x, u < 0.5 ? 2.0 * u : 4.0 + 2.0 * u, 1e-12);
        ASSERT_GE(x, last);
        last = x;
    }
}

TEST(Radial_draw, single_place) {
    EXPECT_EQ(Radial_draw({3.0, 3.0}, {1.0, 1.0}).draw(0.7), 3.0);
}

// The mean of the squared radius, against the midpoint rule on the profile.
TEST(Radial_draw, soft_disc_has_the_mean_of_its_profile) {
    constexpr double pi = 3.14159265358979323846;
    Radial_draw const draw = squared_radius({10.0, 4.0});
    double power = 0.0;
    double moment = 0.0;
    for (int i = 0; i < 700000; ++i) {
        double const r = (i + 0.5) * 1e-5;
        double const x = (r - 5.0) / 4.0;
        double const profile = x < -0.5 ? 1.0 : 0.5 * (1.0 - std::sin(pi * x));
        power += profile * r;
        moment += profile * r * r * r;
    }
    double mean = 0.0;
    for (int i = 0; i < 100000; ++i) {
        mean += draw.draw((i + 0.5) / 100000) / 100000;
    }
    EXPECT_NEAR(mean, moment / power, 1e-4 * mean);
}

} // namespace
} // namespace gonio::sim
