// test_shading.cpp: overlapping circles against counting points, and the head before the source.
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "shading.hpp"

namespace gonio::sim {

TEST(Shading, OverlapEqualsCountedPoints) {
    double const a = 3.0;
    double const b = 2.0;
    for (double const distance : {0.0, 0.5, 1.0, 1.7, 2.9, 4.6, 5.0, 7.0}) {
        int const n = 2000;
        int inside = 0;
        for (int i = 0; i < n; ++i) {
            for (int j = 0; j < n; ++j) {
                double const x = a * (2.0 * (i + 0.5) / n - 1.0);
                double const y = a * (2.0 * (j + 0.5) / n - 1.0);
                inside += x * x + y * y < a * a && (x - distance) * (x - distance) + y * y < b * b ? 1 : 0;
            }
        }
        EXPECT_NEAR(overlap_area(a, b, distance), inside * (2.0 * a / n) * (2.0 * a / n), 2e-3) << distance;
        EXPECT_DOUBLE_EQ(overlap_area(a, b, distance), overlap_area(b, a, distance));
    }
}

TEST(Shading, HeadCoversASmallBeamAndHalfOfItAtItsEdge) {
    Head const head{50.0, 10.0, 1020.0};
    Vec3 const source = {0.0, 0.0, 1.0};
    auto const at = [](double distance_mm) {
        double const angle = std::asin(distance_mm / 1020.0);
        return Vec3{std::sin(angle), 0.0, std::cos(angle)};
    };
    EXPECT_EQ(head.transmitted(source, source), 0.0);
    EXPECT_NEAR(head.transmitted(source, at(19.99)), 0.0, 1e-5);
    EXPECT_NEAR(head.transmitted(source, at(25.0)), 0.54, 0.02);
    EXPECT_EQ(head.transmitted(source, at(30.01)), 1.0);
    EXPECT_EQ(head.transmitted(source, {0.0, 0.0, -1.0}), 1.0);
    // A beam wider than the head is never covered whole.
    EXPECT_NEAR((Head{50.0, 65.0, 1020.0}).transmitted(source, source), 1.0 - 2500.0 / 4225.0, 1e-12);
}

} // namespace gonio::sim
