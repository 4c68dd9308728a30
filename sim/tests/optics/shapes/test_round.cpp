// test_round.cpp: arcs and spheres against closed forms.
#include <gtest/gtest.h>

#include "random.hpp"
#include "shapes.hpp"

using namespace gonio::sim;

namespace {

constexpr double pi = 3.14159265358979323846;

Vector random_unit(Photon_random &random) {
    double const z = 2.0 * random.uniform() - 1.0;
    double const angle = 2.0 * pi * random.uniform();
    double const across = std::sqrt(1.0 - z * z);
    return {across * std::cos(angle), across * std::sin(angle), z};
}

TEST(Round, arc_is_met_from_its_axis_within_sweep_and_length) {
    Photon_random random(1, 1);
    for (double const sweep : {0.01, 1.0, pi, 4.0, 6.0}) {
        Vector const axis = random_unit(random);
        Frame const frame = frame_about(axis);
        Vector const middle{10.0, -20.0, 30.0};
        Ready_arc const arc({middle, axis, 4.0, 2.0, frame.s, sweep, 0}, 3);
        for (int i = 0; i < 2000; ++i) {
            double const angle = 2.0 * pi * random.uniform();
            double const along = 12.0 * random.uniform() - 6.0;
            double const start_along = 2.0 * random.uniform() - 1.0;
            Vector const outwards = std::cos(angle) * frame.s + std::sin(angle) * frame.t;
            Vector const place = middle + 2.0 * outwards + along * axis;
            Vector const origin = middle + start_along * axis;
            Ray const ray{origin, unit(place - origin)};
            double const distance = arc.distance_mm(ray);
            bool const within = angle < sweep && std::abs(along) < 4.0;
            if (within) {
                EXPECT_NEAR(distance, length(place - origin), 1e-12);
                Facing const facing = arc.facing(ray.at(distance));
                EXPECT_NEAR(length(facing.normal - outwards), 0.0, 1e-13);
                EXPECT_EQ(facing.tangent, axis);
            } else {
                EXPECT_EQ(distance, no_meeting) << angle << " of " << sweep;
            }
        }
    }
}

TEST(Round, whole_cylinder_has_no_gap) {
    Photon_random random(3, 1);
    Ready_arc const pipe({{0.0, 0.0, 0.0}, {0.0, 0.0, 1.0}, 100.0, 1.0, {1.0, 0.0, 0.0}, 2.0 * pi, 0}, 0);
    for (int i = 0; i < 100000; ++i) {
        double const angle = 1e-8 * (random.uniform() - 0.5);
        EXPECT_LT(pipe.distance_mm({{0.0, 0.0, 0.0}, unit({std::cos(angle), std::sin(angle), 0.1})}), no_meeting);
    }
}

TEST(Round, ray_along_the_axis_meets_nothing) {
    Ready_arc const pipe({{0.0, 0.0, 0.0}, {0.0, 0.0, 1.0}, 1.0, 1.0, {1.0, 0.0, 0.0}, 2.0 * pi, 0}, 0);
    for (double const x : {0.0, 0.5, 1.0, 2.0}) {
        EXPECT_EQ(pipe.distance_mm({{x, 0.0, -5.0}, {0.0, 0.0, 1.0}}), no_meeting);
        EXPECT_EQ(pipe.distance_mm({{x, 0.0, -5.0}, {0.0, 0.0, 1.0}, 0}), no_meeting);
    }
}

// Whispering gallery: inside a sphere or pipe every chord is 2 r cos(angle of incidence), however grazing, and no ray
// ever gets out although each start is off the surface by its rounding.
TEST(Round, ray_that_leaves_meets_the_other_end_of_its_chord) {
    double const radius = 7.0;
    Ready_sphere const sphere({{1.0, 2.0, 3.0}, radius, 0}, 4);
    Ready_arc const pipe({{1.0, 2.0, 3.0}, {0.0, 0.0, 1.0}, 1e9, radius, {1.0, 0.0, 0.0}, 2.0 * pi, 0}, 4);
    for (double const cosine : {0.9, 0.1, 1e-3, 1e-5, 1e-7}) {
        double const sine = std::sqrt(1.0 - cosine * cosine);
        Ray ray{{1.0 + radius, 2.0, 3.0}, {-cosine, sine, 0.0}, 4};
        for (int bounce = 0; bounce < 1000; ++bounce) {
            double const distance = sphere.distance_mm(ray);
            ASSERT_NEAR(distance, 2.0 * radius * cosine, 1e-11);
            EXPECT_NEAR(pipe.distance_mm(ray), distance, 1e-11);
            Vector const normal = sphere.facing(ray.at(distance)).normal;
            Vector const out = ray.direction - (2.0 * dot(ray.direction, normal)) * normal;
            ray = {ray.at(distance), unit(out), 4};
        }
    }
}

TEST(Round, ray_that_leaves_outwards_does_not_return) {
    Photon_random random(5, 1);
    Vector const centre{400.0, -300.0, 200.0};
    Ready_sphere const sphere({centre, 3.0, 0}, 0);
    Ready_arc const pipe({centre, {0.0, 0.0, 1.0}, 5.0, 3.0, {1.0, 0.0, 0.0}, 2.0 * pi, 0}, 0);
    for (int i = 0; i < 20000; ++i) {
        Vector const outwards = random_unit(random);
        Vector const side = frame_about(outwards).s;
        double const grazing = std::pow(10.0, -6.0 * random.uniform());
        EXPECT_EQ(sphere.distance_mm({centre + 3.0 * outwards, unit(side + grazing * outwards), 0}), no_meeting);
        Vector const flat = unit({outwards.x, outwards.y, 0.0});
        Vector const tangent{-flat.y, flat.x, 0.2};
        EXPECT_EQ(pipe.distance_mm({centre + 3.0 * flat, unit(tangent + grazing * flat), 0}), no_meeting);
    }
}

TEST(Round, far_sphere_is_met_to_a_picometre) {
    Photon_random random(6, 1);
    Ready_sphere const bead({{0.0, 0.0, 0.0}, 0.03, 0}, 0);
    for (int i = 0; i < 20000; ++i) {
        Vector const target = 0.03 * random_unit(random);
        Vector const way = random_unit(random);
        Ray const ray{target - 1020.0 * way, way};
        double const distance = bead.distance_mm(ray);
        if (distance < no_meeting) {
            // Off the surface along its normal: along the ray a grazing hit may shift more.
            EXPECT_NEAR(length(ray.at(distance)), 0.03, 1e-11);
        } else {
            EXPECT_LT(std::abs(dot(way, target)), 1e-6) << "only a tangent may miss";
        }
    }
}

TEST(Round, bounds_hold_the_shape_and_touch_it) {
    Photon_random random(7, 1);
    for (int k = 0; k < 300; ++k) {
        Vector const axis = random_unit(random);
        Vector const start = frame_about(axis).t;
        double const sweep = 2.0 * pi * random.uniform();
        Ready_arc const arc({{1.0, 2.0, 3.0}, axis, 2.0, 5.0, start, sweep, 0}, 0);
        Ready_torus_arc const torus({{1.0, 2.0, 3.0}, axis, start, sweep, 4.0, 1.0, 0}, 0);
        Box const box = arc.bounds();
        Box const torus_box = torus.bounds();
        auto const holds = [](const Box &its, const Vector &place) {
            constexpr double slack = 1e-9;
            return place.x > its.low.x - slack && place.y > its.low.y - slack && place.z > its.low.z - slack &&
                   place.x < its.high.x + slack && place.y < its.high.y + slack && place.z < its.high.z + slack;
        };
        for (int i = 0; i <= 100; ++i) {
            double const angle = sweep * i / 100.0;
            Vector const outwards = std::cos(angle) * start + std::sin(angle) * cross(axis, start);
            for (double const end : {-2.0, 2.0}) {
                EXPECT_TRUE(holds(box, Vector{1.0, 2.0, 3.0} + 5.0 * outwards + end * axis));
            }
            double const turn = 2.0 * pi * random.uniform();
            EXPECT_TRUE(
                holds(torus_box, Vector{1.0, 2.0, 3.0} + (4.0 + std::cos(turn)) * outwards + std::sin(turn) * axis));
        }
        EXPECT_LE(length(box.high - box.low), 2.0 * std::sqrt(3.0) * std::sqrt(29.0));
    }
}

} // namespace
