// test_slat_stack.cpp: which shapes a stack of slats becomes, their numbers, fronts and tangents.
#include <gtest/gtest.h>

#include "shapes.hpp"
#include "slat_stack.hpp"

using namespace gonio::sim;

namespace {

TEST(Slat_stack, numbers_run_slat_by_slat_and_piece_by_piece) {
    Slat_stack const stack{{Profile_line{1.0, -5.0, 2.0, 0.0, 3}, Profile_arc{0.0, 0.0, 4.0, 0.5, 1.0, 7},
                            Profile_line{2.0, 0.0, 1.0, 0.0, 4}},
                           10.0,
                           -2,
                           5,
                           100.0};
    Shapes shapes;
    shapes.add(Sphere{{0.0, 0.0, 0.0}, 1.0, 0});
    add_slats(stack, shapes);
    EXPECT_EQ(shapes.size(), 16U);
    ASSERT_EQ(shapes.parallelograms().size(), 10U);
    ASSERT_EQ(shapes.arcs().size(), 5U);
    for (std::size_t i = 0; i < 5; ++i) {
        const auto &line = shapes.parallelograms()[2 * i];
        EXPECT_EQ(line.number, 1 + 3 * i);
        EXPECT_EQ(line.surface, 3U);
        EXPECT_EQ(shapes.arcs()[i].number, 2 + 3 * i);
        EXPECT_EQ(shapes.arcs()[i].surface, 7U);
        EXPECT_EQ(shapes.parallelograms()[2 * i + 1].surface, 4U);
        // Slat i is shifted by (first + i) pitches.
        double const shift = 10.0 * (static_cast<double>(i) - 2.0);
        EXPECT_NEAR(line.distance_mm({{0.0, 1.5 + shift, 50.0}, {0.0, 0.0, -1.0}}), 52.5, 1e-12);
        Box const box = line.bounds();
        EXPECT_NEAR(box.low.x, -100.0, 1e-6);
        EXPECT_NEAR(box.high.x, 100.0, 1e-6);
        EXPECT_NEAR(box.low.y, 1.0 + shift, 1e-12);
        EXPECT_NEAR(box.high.y, 2.0 + shift, 1e-12);
    }
}

TEST(Slat_stack, front_of_a_line_is_to_the_left_and_of_an_arc_outside) {
    Slat_stack const stack{
        {Profile_line{0.0, -12.0, 0.0, 0.0, 0}, Profile_arc{20.0, -6.0, 5.0, 0.25, 2.5, 1}}, 10.0, 0, 1, 50.0};
    Shapes shapes;
    add_slats(stack, shapes);
    // Going towards +z, seen from +x with y to the right and z up, left is -y.
    Facing const line = shapes.parallelograms()[0].facing({});
    EXPECT_EQ(line.normal, (Vector{0.0, -1.0, 0.0}));
    EXPECT_EQ(line.tangent, (Vector{1.0, 0.0, 0.0}));
    // Angles go from +y towards +z.
    double const angle = 0.25 + 1.0;
    Vector const outwards{0.0, std::cos(angle), std::sin(angle)};
    Ray const ray{Vector{0.0, 20.0, -6.0} + 9.0 * outwards, -outwards};
    double const distance = shapes.arcs()[0].distance_mm(ray);
    EXPECT_NEAR(distance, 4.0, 1e-12);
    Facing const arc = shapes.arcs()[0].facing(ray.at(distance));
    EXPECT_NEAR(length(arc.normal - outwards), 0.0, 1e-14);
    EXPECT_EQ(arc.tangent, (Vector{1.0, 0.0, 0.0}));
    Vector const other{0.0, std::cos(-1.0), std::sin(-1.0)};
    EXPECT_NEAR(shapes.arcs()[0].distance_mm({Vector{0.0, 20.0, -6.0} + 9.0 * other, -other}), 14.0, 1e-12)
        << "through the gap to the far side";
}

} // namespace
