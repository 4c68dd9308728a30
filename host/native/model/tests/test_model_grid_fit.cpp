// test_model_grid_fit.cpp: grids through any points, under the sanitizers' eyes; the plate over holes.
#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>
#include <stdexcept>
#include <vector>

#include <gtest/gtest.h>

#include "model/grid_fit.hpp"
#include "model/grid_moments.hpp"
#include "model/thin_plate.hpp"

namespace gonio::model {
namespace {

TEST(GridFit, AnyPointsGiveNumbers) {
    std::mt19937_64 random(1);
    std::uniform_real_distribution<double> share(-1.2, 1.2);
    for (int round = 0; round < 200; ++round) {
        const std::size_t n = random() % 100;
        const double snap = round % 2 == 0 ? 1e-9 : 0.25;
        std::vector<Place> position(n);
        std::vector<double> value(n);
        std::vector<double> weight(n);
        for (std::size_t i = 0; i < n; ++i) {
            position[i] = {std::round(share(random) / snap) * snap, std::round(share(random) / snap) * snap};
            value[i] = i % 7 == 3 ? NAN : share(random);
            weight[i] = std::max(share(random), 0.0);
        }
        const std::vector<double> variance(n, round % 3 == 0 ? 0.0 : 0.04);
        const std::size_t size = (std::size_t{1} << (random() % 7)) + 1;
        const std::vector<double> nodes = fit_grid({position, value, variance, weight}, 1.0, size);
        ASSERT_EQ(nodes.size(), size * size);
        EXPECT_TRUE(std::all_of(nodes.begin(), nodes.end(), [](double one) { return std::fabs(one) < 20.0; }));
    }
}

TEST(GridFit, WrongSizesAreRefused) {
    const std::vector<Place> position(3);
    const std::vector<double> three(3, 1.0);
    const std::vector<double> two(2, 1.0);
    EXPECT_THROW(fit_grid({position, three, three, three}, 1.0, 1), std::invalid_argument);
    EXPECT_THROW(fit_grid({position, three, three, three}, 1.0, 6), std::invalid_argument);
    EXPECT_THROW(fit_grid({position, two, three, three}, 1.0, 5), std::invalid_argument);
    EXPECT_THROW(fit_grid({position, three, two, three}, 1.0, 5), std::invalid_argument);
    EXPECT_THROW(fit_grid({position, three, three, two}, 1.0, 5), std::invalid_argument);
}

// Moments of wide cells are those of the points themselves.
TEST(GridMoments, OfWideCellsFollowFromNarrowOnes) {
    std::mt19937_64 random(2);
    std::uniform_real_distribution<double> share(0.0, 4.0);
    Level fine{4, std::vector<Cell>(16), std::vector<Moments<3>>(16)};
    Cell whole{};
    for (int i = 0; i < 50; ++i) {
        const double x = share(random);
        const double y = share(random);
        const auto number = static_cast<std::size_t>(x) + 4 * static_cast<std::size_t>(y);
        for (std::size_t k = 0; k < 9; ++k) {
            const auto a = static_cast<double>(k % 3);
            const std::size_t power = k / 3;
            const auto b = static_cast<double>(power);
            fine.cell[number].mass[k] += std::pow(x - std::floor(x), a) * std::pow(y - std::floor(y), b);
            whole.mass[k] += std::pow(x / 4.0, a) * std::pow(y / 4.0, b);
        }
    }
    const Level one = coarser(coarser(fine));
    ASSERT_EQ(one.cells, 1U);
    for (std::size_t k = 0; k < 9; ++k) {
        EXPECT_NEAR(one.cell[0].mass[k], whole.mass[k], 1e-12);
    }
}

// A plate of no membrane would keep a plane to the last bit; the membrane's thousandth pulls a little at free borders.
TEST(ThinPlate, SpansPlanesAndParaboloids) {
    constexpr std::size_t SIZE = 17;
    const auto height = [](std::size_t k) {
        const double x = static_cast<double>(k % SIZE) - 8.0;
        const std::size_t row = k / SIZE;
        const double y = static_cast<double>(row) - 8.0;
        return 100.0 - x * x - 0.5 * y * y + 3.0 * x;
    };
    std::vector<double> nodes(SIZE * SIZE);
    std::vector<unsigned char> known(nodes.size(), 1);
    for (std::size_t k = 0; k < nodes.size(); ++k) {
        const auto column = static_cast<double>(k % SIZE);
        const std::size_t row = k / SIZE;
        known[k] = std::hypot(column - 8.0, static_cast<double>(row) - 7.0) < 4.0 ? 0 : 1;
        nodes[k] = known[k] != 0 ? height(k) : 0.0;
    }
    const std::vector<double> quiet(nodes.size(), 0.0);
    const std::vector<double> before = nodes;
    for (const std::span<const double> variance : {std::span<const double>{}, std::span<const double>{quiet}}) {
        nodes = before;
        span_holes(nodes, known, variance, SIZE);
        for (std::size_t k = 0; k < nodes.size(); ++k) {
            EXPECT_NEAR(nodes[k], height(k), known[k] != 0 ? 0.0 : 0.1) << k; // a membrane would be off by 12
        }
    }
}

TEST(ThinPlate, NothingKnownOrNothingToDo) {
    std::vector<double> nodes{1.0, 2.0, 3.0, 4.0};
    span_holes(nodes, std::vector<unsigned char>(4, 0), {}, 2);
    span_holes(nodes, std::vector<unsigned char>(4, 1), {}, 2);
    EXPECT_EQ(nodes, (std::vector{1.0, 2.0, 3.0, 4.0}));
    span_holes(nodes, std::vector<unsigned char>{1, 0, 0, 0}, {}, 2);
    for (const double one : nodes) {
        EXPECT_NEAR(one, 1.0, 1e-9);
    }
}

} // namespace
} // namespace gonio::model
