// test_sphere_cells.cpp: cells, triangles found and fits, with the sanitizers' eyes: any points fill the sphere.
#include <algorithm>
#include <memory>
#include <numeric>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "local_fit.hpp"
#include "locator.hpp"
#include "parts.hpp"
#include "tracks.hpp"

namespace gonio::sphere {
namespace {

std::vector<Vec> any_points(std::mt19937_64 &random) {
    std::normal_distribution<double> normal;
    const auto n = static_cast<std::size_t>(std::uniform_int_distribution<int>(1, 200)(random));
    const int kind = std::uniform_int_distribution<int>(0, 4)(random);
    std::vector<Vec> points(n);
    for (Vec &one : points) {
        const Vec step = {normal(random), normal(random), normal(random)};
        one = kind == 1   ? Vec{step.x, step.y, 0.0}                                                 // the horizon
              : kind == 2 ? Vec{0.0, 0.0, 1.0} + 1e-3 * step                                         // a patch
              : kind == 3 ? Vec{std::round(step.x), std::round(step.y), std::round(step.z) + 1e-300} // repeated
                          : step;
        if (length(one) < 1e-100) {
            one = {0.0, 0.0, 1.0};
        }
        one = normalised(one);
    }
    return points;
}

double sum(const std::vector<double> &values) {
    return std::accumulate(values.begin(), values.end(), 0.0);
}

TEST(Cells, OfAnyPointsFillTheSphere) {
    std::mt19937_64 random(5);
    for (int trial = 0; trial < 400; ++trial) {
        const std::vector<Vec> points = any_points(random);
        const std::vector<double> reach(points.size(), PI);
        const Cells whole = cells_of_points(points, {reach, {}}, false);
        EXPECT_NEAR(sum(whole.solid), 4.0 * PI, 3e-8);
        EXPECT_NEAR(sum(whole.linear), 4.0 * PI, 3e-8);
        const Cells halves = cells_of_points(points, {reach, {}}, true);
        double up = 0.0;
        bool any_up = false;
        bool any_down = false;
        for (std::size_t i = 0; i < points.size(); ++i) {
            up += points[i].z >= 0.0 ? halves.solid[i] : 0.0;
            (points[i].z >= 0.0 ? any_up : any_down) = true;
        }
        EXPECT_NEAR(up, any_up ? 2.0 * PI : 0.0, 1e-8);
        EXPECT_NEAR(sum(halves.solid), (any_up ? 2.0 * PI : 0.0) + (any_down ? 2.0 * PI : 0.0), 2e-8);
    }
}

TEST(Locator, WeightsOfAnyPointsAddUpOrAreNone) {
    std::mt19937_64 random(6);
    for (int trial = 0; trial < 200; ++trial) {
        const std::vector<Vec> points = any_points(random);
        const std::vector<Vec> wanted = any_points(random);
        const std::vector<double> reach(points.size(), trial % 2 == 0 ? PI : 0.3);
        const Locator locator(points, reach, trial % 3 == 0);
        for (const Found &one : locator.at(wanted)) {
            EXPECT_NEAR(one.weight[0] + one.weight[1] + one.weight[2], one.inside ? 1.0 : 0.0, 1e-12);
            for (const std::int64_t index : one.index) {
                EXPECT_LT(index, static_cast<std::int64_t>(points.size()));
            }
        }
    }
}

TEST(LocalFit, OfALinearFunctionIsItsGradient) {
    std::mt19937_64 random(7);
    std::normal_distribution<double> normal;
    std::vector<Vec> points(6000);
    std::vector<Cluster> samples;
    const Vec slope = {1.0, -2.0, 0.5};
    for (Vec &one : points) {
        one = normalised(Vec{normal(random), normal(random), normal(random)});
        samples.push_back(cluster_of(one, dot(slope, one), 1.0));
    }
    const std::vector<Fit> fits = local_fits(points, samples, 0.15);
    for (std::size_t i = 0; i < points.size(); ++i) {
        const Vec tangent = slope - dot(slope, points[i]) * points[i];
        EXPECT_LT(length(fits[i].gradient - tangent), 0.02);
        EXPECT_GT(fits[i].gradient_variance, 0.0);
    }
}

TEST(Tracks, OfParallelCirclesAreApartByTheirElevation) {
    std::vector<Vec> unit;
    std::vector<Vec> ahead;
    std::vector<double> along;
    for (int circle = 0; circle < 8; ++circle) {
        for (int k = 0; k < 300; ++k) {
            const double azimuth = 0.005 * k;
            const double elevation = 0.05 * circle;
            unit.push_back({std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth),
                            std::sin(elevation)});
            ahead.push_back({-std::sin(azimuth), std::cos(azimuth), 0.0});
            along.push_back(2.0 * circle + azimuth);
        }
    }
    const std::vector<std::int64_t> path(unit.size(), 0);
    const std::vector<Beside> found = track_distances({unit, ahead, along, path}, {3.0, 0.8, 0.7, 0.001});
    for (std::size_t i = 0; i < unit.size(); ++i) {
        EXPECT_NEAR(found[i].near, 0.05, 0.003);
        EXPECT_NEAR(found[i].way, 2.0, 0.2);
        if (i >= 300 && i + 300 < unit.size()) {
            EXPECT_NEAR(found[i].far, 0.05, 0.003);
        }
    }
}

// A fine row of points beside a coarse one: where the coarse one reaches, so do they, and only if it shares.
TEST(Reach, OfACoarsePointGoesToTheFineOnesAroundIt) {
    std::vector<Vec> unit = {normalised({0.3, 0.0, 1.0})};
    for (int k = -10; k <= 10; ++k) {
        unit.push_back(normalised({0.002 * (k % 2), 0.01 * k, 1.0}));
    }
    std::vector<double> reach(unit.size(), 0.01);
    reach[0] = 0.4;
    std::unique_ptr<bool[]> shared(new bool[unit.size()]);
    std::fill_n(shared.get(), unit.size(), true);
    const std::vector<double> found = shared_reach(unit, {reach, {shared.get(), unit.size()}});
    EXPECT_EQ(*std::max_element(found.begin() + 1, found.end()), 0.4);
    for (const double widest : found) {
        EXPECT_GT(widest, 0.02);
    }
    shared[0] = false;
    EXPECT_EQ(shared_reach(unit, {reach, {shared.get(), unit.size()}}), reach);
}

} // namespace
} // namespace gonio::sphere
