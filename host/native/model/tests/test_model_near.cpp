// test_model_near.cpp: points near lobes, in cells and for grids: any points, under the sanitizers' eyes.
#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <stdexcept>
#include <vector>

#include <gtest/gtest.h>

#include "model/near_lobes.hpp"
#include "model/sorted_cells.hpp"
#include "model/suitable_size.hpp"

namespace gonio::model {
namespace {

TEST(NearLobes, PlacesAreAsFarAsTheAngle) {
    const std::array<Vec, 3> frame{Vec{1.0, 0.0, 0.0}, Vec{0.0, 1.0, 0.0}, Vec{0.0, 0.0, 1.0}};
    const std::array<double, 4> whitening{10.0, 0.0, 0.0, 5.0};
    const std::vector<Vec> unit{{0.0, 0.0, 1.0},
                                {std::sin(0.3), 0.0, std::cos(0.3)},
                                {0.0, std::sin(0.3), std::cos(0.3)},
                                {1.0, 0.0, 0.0},
                                {0.0, 0.0, -1.0}};
    const Near two = near_lobes(unit, frame, whitening, 2.0); // 0.4 rad along the longer axis
    EXPECT_EQ(two.row, (std::vector<std::int64_t>{0, 1, 2}));
    EXPECT_NEAR(two.place[2], 3.0, 1e-12);
    EXPECT_NEAR(two.place[5], 1.5, 1e-12);
    const Near all = near_lobes(unit, frame, whitening, HUGE_VAL);
    ASSERT_EQ(all.row.size(), unit.size());
    EXPECT_NEAR(all.place[6], 5.0 * M_PI, 1e-12);
    EXPECT_NEAR(std::hypot(all.place[8], 2.0 * all.place[9]), 10.0 * M_PI, 1e-6); // the antipode
    EXPECT_THROW(near_lobes(unit, frame, std::span(whitening).first(3), 1.0), std::invalid_argument);
}

TEST(SortedCells, EveryPointOnceAndWithinTheGrid) {
    std::mt19937_64 random(3);
    std::uniform_real_distribution<double> share(-1.0, 1.0);
    for (const std::size_t size : {1U, 2U, 33U}) {
        std::vector<Vec> unit{{1.0, 0.0, 0.0}, {-1.0, 0.0, 0.0}, {0.0, 0.0, 1.0}, {NAN, 0.0, 1.0}};
        for (int i = 0; i < 500; ++i) {
            unit.push_back(sphere::normalised({share(random), share(random), std::fabs(share(random))}));
        }
        const std::vector<double> ones(unit.size(), 1.0);
        const Sorted_cells found = sorted_cells({unit, ones, ones, ones}, size, unit.size());
        std::vector<std::int64_t> once = found.row;
        EXPECT_EQ(once.size(), unit.size());
        std::sort(once.begin(), once.end());
        for (std::size_t i = 0; i < once.size(); ++i) {
            EXPECT_EQ(once[i], static_cast<std::int64_t>(i));
        }
        EXPECT_EQ(found.start.size(), found.home.size() + 1);
        EXPECT_EQ(found.start.back(), static_cast<std::int64_t>(unit.size()));
        EXPECT_LT(found.home.back(), static_cast<std::int64_t>(size * size));
    }
    EXPECT_THROW(sorted_cells({}, 0, 1), std::invalid_argument);
    EXPECT_THROW(sorted_cells({}, 5000, 1), std::invalid_argument);
    const std::vector<Vec> one{{0.0, 0.0, 1.0}};
    EXPECT_THROW(sorted_cells({one, {}, {}, {}}, 3, 1), std::invalid_argument);
}

TEST(SuitableSize, AnyPoints) {
    std::mt19937_64 random(4);
    std::uniform_real_distribution<double> share(-1.0, 1.0);
    std::vector<Place> position;
    std::size_t before = 2;
    for (const std::size_t n : {0U, 1U, 100U, 1600U, 25600U, 409600U}) {
        while (position.size() < n) {
            position.push_back({share(random), share(random)});
        }
        const std::size_t size = suitable_size(position, 1.0, 512);
        EXPECT_GE(size, before);
        EXPECT_LE(size, 513U);
        before = size;
    }
    EXPECT_EQ(before, 513U);
    EXPECT_EQ(suitable_size(position, 1.0, 64), 65U);
    position = {{NAN, 0.0}, {3.0, 0.0}};
    EXPECT_EQ(suitable_size(position, 1.0, 512), 2U);
}

} // namespace
} // namespace gonio::model
