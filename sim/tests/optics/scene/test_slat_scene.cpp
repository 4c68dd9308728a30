// test_slat_scene.cpp: the fast walk meets what Embree's scene meets, bit by bit; and a blind's transmission.
#include <gtest/gtest.h>

#include "embree_scene.hpp"
#include "scene_tests.hpp"
#include "slat_scene.hpp"

using namespace gonio::sim;

namespace {

// An arc through two points that rises by `rise` between them, to the left of the way.
Profile_arc bow(double y0, double z0, double y1, double z1, double rise, std::uint32_t surface) {
    double const chord = std::hypot(y1 - y0, z1 - z0);
    double const radius = (0.25 * chord * chord + rise * rise) / (2.0 * rise);
    double const left_y = -(z1 - z0) / chord;
    double const left_z = (y1 - y0) / chord;
    double const half = std::asin(0.5 * chord / radius);
    return {0.5 * (y0 + y1) + left_y * (rise - radius),
            0.5 * (z0 + z1) + left_z * (rise - radius),
            radius,
            std::atan2(left_z, left_y) - half,
            2.0 * half,
            surface};
}

// Two-section slats, a mirror above and white below.
Slat_stack louver() {
    return {{bow(2.0, -12.0, 0.5, -6.0, 0.4, 0), bow(0.5, -6.0, 2.0, 0.0, 0.4, 0), bow(2.05, -12.0, 0.55, -6.0, 0.4, 1),
             bow(0.55, -6.0, 2.05, 0.0, 0.4, 1)},
            10.0,
            -19,
            39,
            300.0};
}

// Thick flat slats, tilted.
Slat_stack blind(double tilt_rad) {
    double const y = std::sin(tilt_rad);
    double const z = std::cos(tilt_rad);
    auto const side = [&](double along0, double up0, double along1, double up1, std::uint32_t surface) {
        return Profile_line{along0 * y + up0 * z, along0 * z - up0 * y, along1 * y + up1 * z, along1 * z - up1 * y,
                            surface};
    };
    return {{side(-12.5, 0.1, 12.5, 0.1, 0), side(12.5, 0.1, 12.5, -0.1, 1), side(12.5, -0.1, -12.5, -0.1, 2),
             side(-12.5, -0.1, -12.5, 0.1, 3)},
            20.0,
            3,
            25,
            60.0};
}

// Closed tubes and plates, closer than they are large: slats overlap.
Slat_stack tubes() {
    return {{Profile_arc{1.0, -3.0, 2.5, 0.0, 2.0 * pi, 0}, Profile_line{-4.0, -8.0, 9.0, -7.0, 1},
             Profile_arc{0.0, -15.0, 4.0, 2.0, 4.5, 2}},
            1.5,
            -10,
            30,
            40.0};
}

void expect_same(const Slat_stack &stack, std::uint64_t seed, int rays) {
    Shapes shapes;
    add_slats(stack, shapes);
    auto const embree = make_embree_scene(shapes);
    auto const walk = make_slat_scene(stack);
    Dice dice(seed);
    double const height = stack.pitch * stack.count;
    double const middle = stack.pitch * (stack.first + 0.5 * stack.count);
    int differ = 0;
    for (int i = 0; i < rays; ++i) {
        Vector const target{dice.between(-1.1, 1.1) * stack.half_length, middle + dice.between(-0.6, 0.6) * height,
                            dice.between(-16.0, 2.0)};
        Vector way = dice.direction();
        switch (i % 8) {
        case 0: // along the stack, or nearly
            way = unit({0.1 * way.x, way.y, std::pow(10.0, dice.between(-12.0, -2.0)) * way.z});
            break;
        case 1: // level
            way = unit({way.x, 0.0, way.z});
            break;
        case 2: // upright
            way = unit({way.x, way.y, 0.0});
            break;
        case 3: // along the slats
            way = unit({1.0, 1e-9 * way.y, 1e-9 * way.z});
            break;
        default:
            break;
        }
        differ += differences(*embree, *walk, dice, {target - (i % 2 == 0 ? 1000.0 : 3.0) * way, way}, 6);
    }
    EXPECT_EQ(differ, 0);
}

TEST(Slat_scene, meets_the_same_bits_in_a_louver) {
    expect_same(louver(), 1, 120000);
}
TEST(Slat_scene, meets_the_same_bits_in_a_blind) {
    for (double const tilt : {0.0, 0.5 * pi, 0.4, -1.2}) {
        expect_same(blind(tilt), 2, 20000);
    }
}
TEST(Slat_scene, meets_the_same_bits_where_slats_overlap) {
    expect_same(tubes(), 3, 30000);
}
TEST(Slat_scene, one_slat_is_a_stack_too) {
    Slat_stack stack = louver();
    stack.count = 1;
    expect_same(stack, 4, 10000);
}

// Between level slats of no thickness, depth D and pitch p, the share 1 - D tan(profile angle) / p passes.
TEST(Slat_scene, direct_transmission_of_level_slats) {
    Slat_stack const stack{{Profile_line{0.0, -12.0, 0.0, 0.0, 0}}, 10.0, -10, 21, 100.0};
    auto const scene = make_slat_scene(stack);
    for (double const profile_deg : {5.0, 20.0, 35.0, 39.0, 45.0}) {
        double const tangent = std::tan(profile_deg * pi / 180.0);
        Vector const way = unit({0.3, -tangent, -1.0});
        int passed = 0;
        constexpr int rays = 10000;
        for (int i = 0; i < rays; ++i) {
            Hit hit{};
            Vector const front{0.0, 20.0 + 10.0 * (i + 0.5) / rays, 0.0};
            passed += scene->closest({front - 1000.0 * way, way}, hit) ? 0 : 1;
        }
        EXPECT_NEAR(static_cast<double>(passed) / rays, std::max(0.0, 1.0 - 1.2 * tangent), 1.01 / rays);
    }
}

} // namespace
