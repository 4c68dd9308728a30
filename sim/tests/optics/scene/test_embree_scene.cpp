// test_embree_scene.cpp: Embree's hierarchy finds what trying every shape finds, bit by bit.
#include <gtest/gtest.h>

#include <xmmintrin.h>

#include "embree_scene.hpp"
#include "scene_tests.hpp"

using namespace gonio::sim;

namespace {

// Rays that begin anywhere, and on from where they arrive.
TEST(Embree_scene, agrees_with_trying_every_shape) {
    for (std::uint64_t const seed : {1U, 2U, 3U, 4U}) {
        Dice dice(seed);
        double const half = seed == 4 ? 2000.0 : 50.0 * static_cast<double>(seed);
        Shapes const shapes = random_shapes(dice, 8, half);
        Brute_scene const brute(shapes);
        auto const embree = make_embree_scene(shapes);
        int steps = 0;
        int differ = 0;
        for (int i = 0; i < 12000; ++i) {
            Vector const target = dice.place(half);
            Vector const way = dice.direction();
            Vector const origin = i % 3 == 0 ? target : target - (i % 3 == 1 ? 1020.0 : 2.0 * half) * way;
            differ += differences(brute, *embree, dice, {origin, way}, 4);
            steps += 4;
        }
        EXPECT_EQ(differ, 0) << "of up to " << steps << ", seed " << seed;
    }
}

// Along edges and faces, through corners and centres, along the axes of single precision.
TEST(Embree_scene, agrees_along_edges_and_faces_of_boxes) {
    Dice dice(5);
    Shapes const shapes = random_shapes(dice, 10, 40.0);
    std::vector<Box> boxes;
    auto const include = [&](const auto &list) {
        for (const auto &shape : list) {
            boxes.push_back(shape.bounds());
        }
    };
    include(shapes.parallelograms());
    include(shapes.arcs());
    include(shapes.spheres());
    include(shapes.triangles());
    Brute_scene const brute(shapes);
    auto const embree = make_embree_scene(shapes);
    int differ = 0;
    for (int i = 0; i < 20000; ++i) {
        const Box &box = boxes[dice.below(static_cast<std::uint32_t>(boxes.size()))];
        auto const pick = [&](double low, double high) {
            std::array<double, 4> const choice{low, high, 0.5 * (low + high), dice.between(low, high)};
            return choice.at(dice.below(4));
        };
        auto const corner = [&]() {
            return Vector{pick(box.low.x, box.high.x), pick(box.low.y, box.high.y), pick(box.low.z, box.high.z)};
        };
        Vector const from = corner();
        Vector const to = corner();
        if (from == to) {
            continue;
        }
        Vector const way = unit(to - from);
        differ += differences(brute, *embree, dice, {from - (dice.below(2) * 500.0) * way, way}, 2);
        double const small = std::pow(10.0, dice.between(-20.0, -3.0));
        std::array<Vector, 3> const along{unit({1.0, small, -small}), unit({-small, -1.0, small}),
                                          unit({0.0, small, 1.0})};
        differ +=
            differences(brute, *embree, dice, {from - 60.0 * along.at(dice.below(3)), along.at(dice.below(3))}, 2);
    }
    EXPECT_EQ(differ, 0);
}

TEST(Embree_scene, of_equal_distances_the_lowest_number_wins) {
    Shapes shapes;
    auto const square = [](std::uint32_t surface) {
        return Parallelogram{{-1.0, -1.0, 0.0}, {2.0, 0.0, 0.0}, {0.0, 2.0, 0.0}, surface};
    };
    shapes.add(Sphere{{0.0, 0.0, -1.0}, 1.0, 0});
    shapes.add(square(1));
    shapes.add(Disc{{0.0, 0.0, 0.0}, {0.0, 0.0, 1.0}, 0.0, 1.0, 2});
    shapes.add(square(3));
    auto const scene = make_embree_scene(shapes);
    Ray ray{{0.3, 0.1, 5.0}, {0.0, 0.0, -1.0}};
    Hit hit{};
    ASSERT_TRUE(scene->closest(ray, hit));
    EXPECT_EQ(hit.primitive, 1U);
    ray.from = 1;
    ASSERT_TRUE(scene->closest(ray, hit));
    EXPECT_EQ(hit.primitive, 2U);
    EXPECT_EQ(hit.surface, 2U);
    ray = {{0.0, 0.0, 5.0}, {0.0, 0.0, -1.0}};
    ASSERT_TRUE(scene->closest(ray, hit));
    EXPECT_EQ(hit.primitive, 0U) << "where the sphere touches the plane";
}

TEST(Embree_scene, empty_scene_is_never_met) {
    auto const scene = make_embree_scene({});
    Hit hit{};
    EXPECT_FALSE(scene->closest({{0.0, 0.0, 0.0}, {0.0, 0.0, 1.0}}, hit));
}

// Embree likes denormal numbers flushed; results must not depend on whether a scene was built before.
TEST(Embree_scene, leaves_the_processors_arithmetic_alone) {
    unsigned const before = _mm_getcsr();
    Dice dice(6);
    auto const scene = make_embree_scene(random_shapes(dice, 50, 100.0));
    Hit hit{};
    (void)scene->closest({{0.0, 0.0, 500.0}, {0.0, 0.0, -1.0}}, hit);
    constexpr unsigned flags = 0x3F; // which exceptions have occurred: no part of the arithmetic
    EXPECT_EQ(_mm_getcsr() & ~flags, before & ~flags);
}

} // namespace
