// test_zones.cpp: the verdict on segments near zones against dense sampling.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>

extern "C" {
#include "zones.h"
}

namespace {

// Axes 3 and 4 (index 2 and 3) both at least `low`, both at most `high`.
gonio_Zone box(double low, double high) {
    gonio_Zone zone = gonio_Zone_init_zero;
    zone.half_spaces_count = 4;
    for (std::size_t i = 0; i < 4; i++) {
        zone.half_spaces[i].a_count = 4;
        std::size_t const axis = 2 + i / 2;
        double const sign = i % 2 == 0 ? -1.0 : 1.0;
        zone.half_spaces[i].a[axis] = sign;
        zone.half_spaces[i].b = i % 2 == 0 ? -low : high;
    }
    return zone;
}

gn_zone zone_from(const gonio_Zone &configured, std::array<double, 4> start) {
    gn_zone zone{};
    gn_zone_for_path(&zone, &configured, start.data());
    return zone;
}

std::array<gn_quintic, 4> straight(std::array<double, 4> from, std::array<double, 4> to) {
    std::array<gn_quintic, 4> axes{};
    for (std::size_t axis = 0; axis < 4; axis++) {
        gn_state const start{from[axis], 0.0, 0.0};
        gn_state const end{to[axis], 0.0, 0.0};
        axes[axis] = gn_quintic_join(&start, &end, 1.0);
    }
    return axes;
}

// Smallest over the curve of the largest a.q - b (all half-spaces of the boxes have unit vectors): negative inside.
double clearance(const gn_zone &zone, const std::array<gn_quintic, 4> &axes) {
    double least = HUGE_VAL;
    for (int i = 0; i <= 4000; i++) {
        double most = -HUGE_VAL;
        for (std::uint32_t j = 0; j < zone.half_spaces; j++) {
            double sum = -zone.b[j];
            for (std::size_t axis = 0; axis < 4; axis++) {
                sum += zone.a[j][axis] * gn_bernstein_value(axes[axis].position, 5, i / 4000.0);
            }
            most = std::max(most, sum);
        }
        least = std::min(least, most);
    }
    return least;
}

TEST(Zones, StraightThroughIsSeenBetweenItsEnds) {
    gn_zone const zone = zone_from(box(40.0, 60.0), {});
    auto const through = straight({0, 0, 0, 50}, {0, 0, 100, 50});
    auto const beside = straight({0, 0, 0, 61}, {0, 0, 100, 61});
    EXPECT_FALSE(gn_zone_is_clear(&zone, through.data()));
    EXPECT_TRUE(gn_zone_is_clear(&zone, beside.data()));
}

TEST(Zones, PassingACornerIsAllowed) {
    // The chord passes the corner (40, 60) at a distance of half a count; the axis-parallel hull would hit the box.
    gn_zone const zone = zone_from(box(40.0, 60.0), {});
    auto const past = straight({0, 0, 0, 20.5}, {0, 0, 79.5, 100});
    auto const cut = straight({0, 0, 0, 19.5}, {0, 0, 80.5, 100});
    EXPECT_TRUE(gn_zone_is_clear(&zone, past.data()));
    EXPECT_FALSE(gn_zone_is_clear(&zone, cut.data()));
}

TEST(Zones, TouchingIsRefused) {
    gn_zone const zone = zone_from(box(40.0, 60.0), {});
    auto const along = straight({0, 0, 0, 60}, {0, 0, 100, 60});
    EXPECT_FALSE(gn_zone_is_clear(&zone, along.data()));
}

TEST(Zones, AgreesWithDenseSamplingOnRandomSegments) {
    std::mt19937_64 random(21);
    std::uniform_real_distribution<double> place(0.0, 100.0);
    std::uniform_real_distribution<double> speed(-300.0, 300.0);
    int entered = 0;
    int clear = 0;
    for (int trial = 0; trial < 2000; trial++) {
        gn_zone const zone = zone_from(box(40.0, 55.0), {});
        std::array<gn_quintic, 4> axes{};
        for (auto &axis : axes) {
            gn_state const from{place(random), speed(random), speed(random)};
            gn_state const to{place(random), speed(random), speed(random)};
            axis = gn_quintic_join(&from, &to, 0.5);
        }
        double const least = clearance(zone, axes);
        bool const verdict = gn_zone_is_clear(&zone, axes.data());
        // Never cleared when inside; never refused when clear by more than the finest piece.
        if (least <= 0.0) {
            EXPECT_FALSE(verdict) << trial;
            entered++;
        } else if (least > 0.05) {
            EXPECT_TRUE(verdict) << trial;
            clear++;
        }
    }
    EXPECT_GT(entered, 200);
    EXPECT_GT(clear, 200);
}

TEST(Zones, APathThatStartsInsideMayOnlyLeave) {
    // After homing the arm stands below the holder: rising is allowed, turning deeper into the column is not.
    gonio_Zone column = gonio_Zone_init_zero;
    column.half_spaces_count = 2;
    column.half_spaces[0].a_count = 4;
    column.half_spaces[0].a[2] = 1.0; // azimuth <= -150
    column.half_spaces[0].b = -150.0;
    column.half_spaces[1].a_count = 4;
    column.half_spaces[1].a[3] = 1.0; // elevation <= -78
    column.half_spaces[1].b = -78.0;
    std::array<double, 4> const home = {0, 0, -170, -84};
    gn_zone const zone = zone_from(column, home);
    auto const up = straight(home, {0, 0, -170, 0});
    auto const deeper = straight(home, {0, 0, -180, -88});
    auto const back_in = straight({0, 0, -160, -60}, {0, 0, -175, -89});
    EXPECT_TRUE(gn_zone_is_clear(&zone, up.data()));
    EXPECT_FALSE(gn_zone_is_clear(&zone, deeper.data()));
    EXPECT_FALSE(gn_zone_is_clear(&zone, back_in.data()));
    // From outside the same column is closed altogether.
    gn_zone const closed = zone_from(column, {0, 0, 0, 0});
    EXPECT_FALSE(gn_zone_is_clear(&closed, up.data()));
}

} // namespace
