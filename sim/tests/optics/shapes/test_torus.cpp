// test_torus.cpp: the torus against sphere tracing of its distance function, and the root finder below it.
#include <gtest/gtest.h>

#include "bernstein.hpp"
#include "random.hpp"
#include "shapes.hpp"

using namespace gonio::sim;

namespace {

constexpr double pi = 3.14159265358979323846;

template <std::size_t count> std::vector<double> all_roots(const Bernstein<count> &polynomial) {
    std::vector<double> roots;
    first_root(polynomial, [&](double root) {
        roots.push_back(root);
        return false;
    });
    return roots;
}

// (x - r0)(x - r1)(x - r2)(x - r3): the blossom at 0 ... 0, 1 ... 1, averaged over the orders of the factors.
Bernstein<5> with_roots(const std::array<double, 4> &roots) {
    std::array<double, 5> sums{};
    std::array<double, 5> counts{};
    for (unsigned ones = 0; ones < 16; ++ones) {
        double product = 1.0;
        std::size_t number = 0;
        for (std::size_t i = 0; i < 4; ++i) {
            bool const one = ((ones >> i) & 1U) != 0;
            product *= (one ? 1.0 : 0.0) - roots.at(i);
            number += one ? 1 : 0;
        }
        sums.at(number) += product;
        counts.at(number) += 1.0;
    }
    Bernstein<5> polynomial{};
    for (std::size_t i = 0; i < 5; ++i) {
        polynomial.coefficients.at(i) = sums.at(i) / counts.at(i);
    }
    return polynomial;
}

TEST(Bernstein, finds_every_root_between_0_and_1_in_order) {
    Photon_random random(1, 1);
    for (int i = 0; i < 5000; ++i) {
        std::array<double, 4> roots{};
        for (double &root : roots) {
            root = 3.0 * random.uniform() - 1.0;
        }
        std::sort(roots.begin(), roots.end());
        std::vector<double> expected;
        double gap = 1.0;
        for (std::size_t k = 0; k < 4; ++k) {
            gap = std::min(
                {gap, k > 0 ? roots.at(k) - roots.at(k - 1) : 1.0, std::abs(roots.at(k)), std::abs(roots.at(k) - 1.0)});
            if (roots.at(k) > 0.0 && roots.at(k) < 1.0) {
                expected.push_back(roots.at(k));
            }
        }
        if (gap < 1e-4) {
            continue;
        }
        auto const found = all_roots(with_roots(roots));
        ASSERT_EQ(found.size(), expected.size()) << i;
        for (std::size_t k = 0; k < found.size(); ++k) {
            EXPECT_NEAR(found[k], expected[k], 1e-10);
        }
    }
}

TEST(Bernstein, touch_is_no_root_but_a_triple_root_is_one) {
    EXPECT_TRUE(all_roots(with_roots({0.3, 0.3, 2.0, 3.0})).size() % 2 == 0);
    EXPECT_TRUE(all_roots(Bernstein<3>{{1.0, 0.0, 1.0}}).empty());
    auto const triple = all_roots(with_roots({0.3, 0.3, 0.3, 2.0}));
    ASSERT_EQ(triple.size() % 2, 1U);
    EXPECT_NEAR(triple.front(), 0.3, 1e-4);
}

TEST(Bernstein, known_root_at_0_is_divided_out) {
    auto const rest = all_roots(without_root_at_0(with_roots({0.0, 0.25, 0.5, 2.0})));
    ASSERT_EQ(rest.size(), 2U);
    EXPECT_NEAR(rest[0], 0.25, 1e-14);
    EXPECT_NEAR(rest[1], 0.5, 1e-14);
}

struct Ring {
    Vector centre;
    Frame frame;
    double major;
    double minor;

    [[nodiscard]] double gap(const Vector &place) const {
        Vector const p = frame.to_local(place - centre);
        double const beside = std::sqrt(p.x * p.x + p.y * p.y) - major;
        return std::sqrt(beside * beside + p.z * p.z) - minor;
    }
    // First place where the gap changes sign, by steps that cannot pass it.
    [[nodiscard]] double traced(const Ray &ray, double begin, double end) const {
        double distance = begin;
        double const sign = gap(ray.at(begin)) < 0.0 ? -1.0 : 1.0;
        while (distance < end) {
            double const step = sign * gap(ray.at(distance));
            if (step < 1e-11) {
                return distance;
            }
            distance += step;
        }
        return no_meeting;
    }
};

TEST(Torus, meets_what_sphere_tracing_meets) {
    Photon_random random(2, 1);
    int met = 0;
    for (int i = 0; i < 20000; ++i) {
        Vector const axis = unit({random.uniform() - 0.5, random.uniform() - 0.5, random.uniform() - 0.4});
        double const major = 1.0 + 4.0 * random.uniform();
        double const minor = major * (0.02 + 0.95 * random.uniform());
        Ring const ring{{3.0, -2.0, 1.0}, frame_about(axis), major, minor};
        Ready_torus_arc const torus({ring.centre, axis, ring.frame.s, 2.0 * pi, major, minor, 0}, 1);
        auto const in_box = [&]() {
            return ring.centre +
                   Vector{10.0 * random.uniform() - 5.0, 10.0 * random.uniform() - 5.0, 10.0 * random.uniform() - 5.0};
        };
        Vector const target = in_box();
        Vector const way = unit(target - in_box());
        Ray const ray{target - (i % 2 == 0 ? 10.0 : 1000.0) * way, way};
        double const expected = ring.traced(ray, 0.0, 1020.0);
        double const distance = torus.distance_mm(ray);
        if (distance < no_meeting) {
            ++met;
            EXPECT_NEAR(ring.gap(ray.at(distance)), 0.0, 1e-11) << i;
            // Sphere tracing stops short of grazing surfaces: it is never later.
            double const grazing = std::abs(dot(torus.facing(ray.at(distance)).normal, way));
            EXPECT_LE(expected, distance + 1e-10);
            EXPECT_TRUE(grazing < 1e-3 || expected > distance - 1e-7 || ring.gap(ray.at(expected)) < 1e-10) << i;
            if (grazing > 1e-3 && ring.traced(ray, 0.0, distance - 1e-6) == no_meeting) {
                EXPECT_NEAR(expected, distance, 1e-7);
            }
        } else {
            EXPECT_TRUE(expected == no_meeting || ring.gap(ray.at(expected)) > -1e-11) << i;
        }
    }
    EXPECT_GT(met, 5000);
}

TEST(Torus, ray_that_leaves_meets_the_next_wall_and_never_its_start) {
    Photon_random random(3, 1);
    Ring const ring{{0.0, 0.0, 0.0}, {{1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}}, 2.0, 0.5};
    Ready_torus_arc const torus({ring.centre, ring.frame.n, ring.frame.s, 2.0 * pi, 2.0, 0.5, 0}, 8);
    Ray ray{{2.5, 0.0, 0.0}, unit({-1.0, 0.3, 0.2}), 8};
    for (int bounce = 0; bounce < 20000; ++bounce) {
        double const distance = torus.distance_mm(ray);
        ASSERT_LT(distance, 5.0) << "closed tube: bounce " << bounce;
        ASSERT_NEAR(ring.gap(ray.at(distance)), 0.0, 1e-12);
        for (double const share : {0.1, 0.5, 0.9}) {
            ASSERT_LE(ring.gap(ray.at(share * distance)), 1e-12) << "inside all the way";
        }
        Vector const inwards = -torus.facing(ray.at(distance)).normal;
        Frame const frame = frame_about(inwards);
        double const height = std::pow(10.0, -4.0 * random.uniform());
        double const turn = 2.0 * pi * random.uniform();
        Vector const side = std::cos(turn) * frame.s + std::sin(turn) * frame.t;
        ray = {ray.at(distance), unit(side + height * inwards), 8};
    }
}

TEST(Torus, only_the_sweep_is_met) {
    Ready_torus_arc const bend({{0.0, 0.0, 0.0}, {0.0, 0.0, 1.0}, {1.0, 0.0, 0.0}, 0.5 * pi, 3.0, 1.0, 0}, 0);
    for (int turn = 0; turn < 125; ++turn) {
        double const angle = 0.01 + 0.05 * turn;
        Vector const outwards{std::cos(angle), std::sin(angle), 0.0};
        double const distance = bend.distance_mm({3.0 * outwards + Vector{0.0, 0.0, 10.0}, {0.0, 0.0, -1.0}});
        if (angle < 0.5 * pi) {
            EXPECT_NEAR(distance, 9.0, 1e-12);
            Facing const facing = bend.facing(3.0 * outwards + Vector{0.0, 0.0, 1.0});
            EXPECT_NEAR(facing.normal.z, 1.0, 1e-15);
            EXPECT_NEAR(dot(facing.tangent, cross({0.0, 0.0, 1.0}, outwards)), 1.0, 1e-15);
        } else {
            EXPECT_EQ(distance, no_meeting);
        }
    }
}

} // namespace
