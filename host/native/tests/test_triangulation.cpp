// test_triangulation.cpp: hulls of random, cocircular, repeated and nearly flat points against their definition.
#include <algorithm>
#include <numbers>
#include <random>
#include <set>
#include <vector>

#include <gtest/gtest.h>

#include "triangulation.hpp"

namespace gonio::sphere {
namespace {

std::vector<Vec> random_points(std::size_t n, unsigned seed, double size = 10.0) {
    std::mt19937_64 random(seed);
    std::normal_distribution<double> normal;
    std::vector<Vec> points(n);
    for (Vec &one : points) {
        const Vec step = {normal(random), normal(random), normal(random)};
        one = on_grid(normalised(Vec{0.6, 0.0, 0.8} + size * step));
    }
    return points;
}

// Euler's formula, both senses of every edge, orientation, and that no point is in front of a triangle.
void expect_delaunay(const Triangulation &hull) {
    const auto &points = hull.points();
    const auto &triangles = hull.triangles();
    std::set<Index> used;
    for (std::size_t t = 0; t < triangles.size(); ++t) {
        for (int e = 0; e < 3; ++e) {
            used.insert(triangles[t][e]);
            const Index next = hull.across()[t][e];
            const auto &back = hull.across()[next];
            const int there =
                static_cast<int>(std::find(back.begin(), back.end(), static_cast<Index>(t)) - back.begin());
            ASSERT_LT(there, 3);
            EXPECT_EQ(triangles[next][(there + 1) % 3], triangles[t][(e + 2) % 3]);
            EXPECT_EQ(triangles[next][(there + 2) % 3], triangles[t][(e + 1) % 3]);
        }
        for (std::size_t i = 0; i < points.size(); ++i) {
            if (hull.stands_for()[i] == static_cast<Index>(i)) {
                EXPECT_LE(side_of(points[triangles[t][0]], points[triangles[t][1]], points[triangles[t][2]], points[i]),
                          0);
            }
        }
    }
    std::set<Index> standing(hull.stands_for().begin(), hull.stands_for().end());
    EXPECT_EQ(used, standing);
    EXPECT_EQ(triangles.size(), 2 * standing.size() - 4);
    for (std::size_t i = 0; i < points.size(); ++i) {
        EXPECT_LE(length(points[i] - points[hull.stands_for()[i]]), MERGE_RAD);
    }
}

TEST(Triangulation, OfRandomPointsIsDelaunays) {
    for (const std::size_t n : {4U, 5U, 9U, 60U, 700U}) {
        const auto hull = Triangulation::of(random_points(n, static_cast<unsigned>(n)));
        ASSERT_TRUE(hull);
        expect_delaunay(*hull);
    }
}

TEST(Triangulation, OfPatchesDownToWhereAllPointsAreOne) {
    for (const double size : {1e-1, 1e-3, 1e-4, 3e-5, 1e-5, 3e-6, 1e-7}) {
        const auto hull = Triangulation::of(random_points(150, 7, size));
        if (size > 2e-5) {
            ASSERT_TRUE(hull);
        }
        if (hull) {
            expect_delaunay(*hull);
        }
    }
}

TEST(Triangulation, OfAGridWithPolesMeetsCocircularAndRepeatedPoints) {
    std::vector<Vec> points;
    for (int theta = 0; theta <= 180; theta += 15) {
        for (int phi = 0; phi < 360; phi += 15) {
            const double t = theta * std::numbers::pi / 180.0;
            const double p = phi * std::numbers::pi / 180.0;
            points.push_back(on_grid({std::sin(t) * std::cos(p), std::sin(t) * std::sin(p), std::cos(t)}));
        }
    }
    const auto hull = Triangulation::of(points);
    ASSERT_TRUE(hull);
    expect_delaunay(*hull);
    EXPECT_EQ(hull->triangles().size(), 2U * (24 * 11 + 2) - 4);
}

TEST(Triangulation, ExactTiesOnIntegers) {
    // The corners of a cube: six faces of four points exactly in a plane, in any order.
    std::vector<Vec> points;
    points.reserve(8);
    for (int k = 0; k < 8; ++k) {
        points.push_back({(k & 1) != 0 ? 0.5 : -0.5, (k & 2) != 0 ? 0.5 : -0.5, (k & 4) != 0 ? 0.5 : -0.5});
    }
    std::mt19937 random(1);
    for (int trial = 0; trial < 50; ++trial) {
        std::shuffle(points.begin(), points.end(), random);
        const auto hull = Triangulation::of(points);
        ASSERT_TRUE(hull);
        expect_delaunay(*hull);
    }
}

TEST(Triangulation, OfACircleIsNone) {
    for (const double height : {0.0, 0.5}) {
        std::vector<Vec> points;
        for (int k = 0; k < 100; ++k) {
            const double angle = 0.06 * k;
            const double across = std::sqrt(1.0 - height * height);
            points.push_back(on_grid({across * std::cos(angle), height, across * std::sin(angle)}));
        }
        EXPECT_FALSE(Triangulation::of(points));
    }
    EXPECT_FALSE(Triangulation::of({}));
    EXPECT_FALSE(Triangulation::of(random_points(3, 1)));
    EXPECT_FALSE(Triangulation::of(std::vector<Vec>(10, on_grid({0.6, 0.0, 0.8}))));
}

TEST(Triangulation, PointsAddedLaterAreAsGood) {
    const std::vector<Vec> points = random_points(300, 3);
    auto hull = Triangulation::of({points.begin(), points.begin() + 100});
    ASSERT_TRUE(hull);
    for (std::size_t i = 100; i < points.size(); ++i) {
        EXPECT_EQ(hull->add(points[i]), static_cast<Index>(i));
    }
    EXPECT_EQ(hull->add(points[50]), 50); // a repeated one
    expect_delaunay(*hull);
}

TEST(Predicates, AreExactWhereDoublesAreNot) {
    // Four points of a plane, and one of them a grid step off it.
    const double step = 1.0 / GRID;
    const Vec a = {0.25, 0.5, 0.125};
    const Vec b = {0.25 + 3 * step, 0.5 + step, 0.125 - 7 * step};
    const Vec c = {-0.5 + step, 0.75 - step, 0.375 + 5 * step};
    const Vec d = a + (b - a) + (c - a);
    EXPECT_EQ(side_of(a, b, c, d), 0);
    const int up = side_of(a, b, c, d + Vec{step, 0.0, 0.0});
    EXPECT_NE(up, 0);
    EXPECT_EQ(side_of(a, b, c, d - Vec{step, 0.0, 0.0}), -up);
    EXPECT_EQ(side_of(b, a, c, d + Vec{step, 0.0, 0.0}), -up);
    // The extreme coordinates do not overflow.
    EXPECT_EQ(side_of({-1, -1, -1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}), 1);
}

} // namespace
} // namespace gonio::sphere
