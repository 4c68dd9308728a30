// test_model_evaluate.cpp: resolved models under the sanitizers' eyes: any arrays that agree, and some that do not.
#include <array>
#include <cmath>
#include <numeric>
#include <random>
#include <stdexcept>
#include <vector>

#include <gtest/gtest.h>

#include "model/bilinear.hpp"
#include "model/evaluate.hpp"

namespace gonio::model {
namespace {

// Arrays of slices and grids, owned.
struct Owned {
    std::vector<double> scale;
    std::vector<std::int64_t> lobe_start{0};
    std::vector<std::int64_t> field_start{0};
    std::vector<Vec> frame;
    std::vector<double> whitening;
    std::vector<double> peak;
    std::vector<std::int64_t> patch_start{0};
    std::vector<std::int64_t> patch_grid;
    std::vector<double> patch_weight;
    std::vector<std::int64_t> field_grid;
    std::vector<double> field_weight;
    std::vector<double> matrix;
    std::vector<double> shift;
    std::array<bool, 64> as_bsdf{};
    std::vector<float> values;
    std::vector<std::int64_t> start;
    std::vector<std::int64_t> size;

    Slices slices() const {
        return {scale,        lobe_start,
                field_start,  frame,
                whitening,    peak,
                patch_start,  patch_grid,
                patch_weight, field_grid,
                field_weight, matrix,
                shift,        std::span(as_bsdf).first(field_weight.size())};
    }
    Grids grids() const { return {values, start, size}; }
};

Vec direction(std::mt19937_64 &random) {
    std::normal_distribution<double> normal;
    const Vec any = sphere::normalised({normal(random), normal(random), normal(random) + 1e-9});
    return {any.x, any.y, std::fabs(any.z)};
}

void add_lobe(Owned &to, const Vec &centre, double sigma, double peak) {
    const auto [e1, e2] = sphere::tangents(centre);
    to.frame.insert(to.frame.end(), {e1, e2, centre});
    to.whitening.insert(to.whitening.end(), {1.0 / sigma, 0.0, 0.0, 1.0 / sigma});
    to.peak.push_back(peak);
}

Owned any(std::mt19937_64 &random) {
    Owned made;
    std::uniform_int_distribution<int> few(0, 3);
    std::uniform_real_distribution<double> share(-1.0, 1.0);
    for (const std::int64_t size : {2, 5, 17}) {
        made.start.push_back(static_cast<std::int64_t>(made.values.size()));
        made.size.push_back(size);
        for (std::int64_t k = 0; k < size * size; ++k) {
            made.values.push_back(static_cast<float>(share(random)));
        }
    }
    for (int s = 0; s < 5; ++s) {
        made.scale.push_back(1.0 + share(random));
        for (int l = few(random); l > 0; --l) {
            add_lobe(made, direction(random), std::pow(10.0, 2.0 * share(random) - 1.0), share(random));
            for (int p = few(random); p > 0; --p) {
                made.patch_grid.push_back(few(random) % 3);
                made.patch_weight.push_back(share(random));
            }
            made.patch_start.push_back(static_cast<std::int64_t>(made.patch_grid.size()));
        }
        made.lobe_start.push_back(static_cast<std::int64_t>(made.peak.size()));
        for (int f = few(random); f > 0; --f) {
            made.field_grid.push_back(few(random) % 3);
            made.field_weight.push_back(share(random));
            const double turn = 3.0 * share(random);
            made.matrix.insert(made.matrix.end(), {std::cos(turn), std::sin(turn), -std::sin(turn), std::cos(turn)});
            made.shift.insert(made.shift.end(), {few(random) == 0 ? 0.0 : 2.0 * share(random), 0.0});
        }
        made.field_start.push_back(static_cast<std::int64_t>(made.field_grid.size()));
    }
    return made;
}

TEST(ModelEvaluate, AnyArraysAreReadWithinThemselves) {
    std::mt19937_64 random(1);
    for (int round = 0; round < 50; ++round) {
        const Owned made = any(random);
        std::vector<Vec> unit(300);
        std::vector<std::int64_t> which(unit.size());
        for (std::size_t i = 0; i < unit.size(); ++i) {
            unit[i] = direction(random);
            which[i] = static_cast<std::int64_t>(i % 5);
        }
        unit[0] = {1.0, 0.0, 0.0};
        unit[1] = {-1.0, 0.0, 0.0};
        unit[2] = {0.0, 0.0, 1.0};
        unit[3] = {NAN, 0.0, 1.0};
        std::vector<double> dsf(unit.size(), -1.0);
        evaluate(made.slices(), made.grids(), unit, which, dsf);
        for (std::size_t i = 0; i < unit.size(); ++i) {
            EXPECT_TRUE(i == 3 ? std::isnan(dsf[i]) : dsf[i] >= 0.0);
        }
    }
}

// At every angle from the centre, the 30 and 120 degrees where the way of computing changes included.
TEST(ModelEvaluate, ALobeFallsWithTheAngle) {
    Owned made;
    made.scale = {1.0};
    add_lobe(made, {1.0, 0.0, 0.0}, 0.7, 2.0);
    made.lobe_start = {0, 1};
    made.patch_start = {0, 0};
    made.field_start = {0, 0};
    std::vector<Vec> unit;
    std::vector<double> angle;
    for (int k = 0; k < 3140; ++k) {
        angle.push_back(0.001 * k);
        unit.push_back({std::cos(angle.back()), 0.6 * std::sin(angle.back()), 0.8 * std::sin(angle.back())});
    }
    std::vector<double> dsf(unit.size());
    evaluate(made.slices(), made.grids(), unit, {}, dsf);
    for (std::size_t k = 0; k < unit.size(); ++k) {
        EXPECT_NEAR(dsf[k] / (2.0 * std::exp(-0.5 * angle[k] * angle[k] / 0.49)), 1.0, 1e-12) << angle[k];
    }
}

TEST(ModelEvaluate, ArraysThatDoNotAgreeAreRefused) {
    std::mt19937_64 random(7);
    const Owned made = any(random);
    ASSERT_FALSE(made.patch_grid.empty());
    ASSERT_FALSE(made.field_grid.empty());
    const std::vector<Vec> unit{{0.0, 0.0, 1.0}};
    std::vector<double> dsf(1);
    const auto refused = [&](const auto &change) {
        Owned changed = made;
        change(changed);
        EXPECT_THROW(evaluate(changed.slices(), changed.grids(), unit, {}, dsf), std::invalid_argument);
    };
    evaluate(made.slices(), made.grids(), unit, {}, dsf);
    refused([](Owned &one) { one.patch_grid.back() = 3; });
    refused([](Owned &one) { one.field_grid.front() = -1; });
    refused([](Owned &one) { one.size.back() += 1; });
    refused([](Owned &one) { one.size.front() = 1; });
    refused([](Owned &one) { one.start.front() = -1; });
    refused([](Owned &one) { one.size.back() = std::int64_t{1} << 62; });
    refused([](Owned &one) { one.lobe_start[1] = 1000; });
    refused([](Owned &one) { one.lobe_start.front() = -1; });
    refused([](Owned &one) { one.patch_start.pop_back(); });
    refused([](Owned &one) { one.field_start.back() += 1; });
    refused([](Owned &one) { one.whitening.pop_back(); });
    refused([](Owned &one) { one.patch_weight.pop_back(); });
    refused([](Owned &one) { one.shift.pop_back(); });
    for (const std::int64_t which : {std::int64_t{-1}, std::int64_t{5}}) {
        EXPECT_THROW(evaluate(made.slices(), made.grids(), unit, std::span(&which, 1), dsf), std::invalid_argument);
    }
}

TEST(Bilinear, NodesRimAndNoNumber) {
    const std::array<double, 9> nodes{0.0, 1.0, 2.0, 10.0, 11.0, 12.0, 20.0, 21.0, 22.0};
    EXPECT_EQ(bilinear(nodes.data(), 3, 2.0, 2.0), 22.0);
    EXPECT_EQ(bilinear(nodes.data(), 3, 0.5, 1.25), 13.0);
    EXPECT_EQ(bilinear(nodes.data(), 3, 7.0, -7.0), 2.0);
    EXPECT_EQ(bilinear(nodes.data(), 3, NAN, HUGE_VAL), 20.0);
}

} // namespace
} // namespace gonio::model
