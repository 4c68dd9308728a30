// test_height_field.cpp: planes and paraboloids, which a quadratic B-spline reproduces exactly, against closed forms.
#include <gtest/gtest.h>

#include "random.hpp"
#include "shapes.hpp"

using namespace gonio::sim;

namespace {

constexpr double width = 12.0;
constexpr double depth = 9.0;
constexpr std::uint32_t columns = 10;
constexpr std::uint32_t rows = 8;

// z = plane . (x, y, 1) + bend (x^2 + y^2): a B-spline's control point for x^2 is the product of its two knots.
Ready_height_field paraboloid(const Frame &frame, const Vector &plane, double bend) {
    Height_field field{{1.0, 2.0, 3.0}, frame, width, depth, rows, columns, {}, 6};
    double const w = width / (columns - 2);
    double const d = depth / (rows - 2);
    for (std::uint32_t row = 0; row < rows; ++row) {
        for (std::uint32_t column = 0; column < columns; ++column) {
            double const x = (column - 0.5) * w;
            double const y = (row - 0.5) * d;
            field.heights.push_back(plane.x * x + plane.y * y + plane.z +
                                    bend * (x * x - 0.25 * w * w + y * y - 0.25 * d * d));
        }
    }
    return {field, 100};
}

double closest(const Ready_height_field &field, const Ray &ray, std::uint32_t &patch) {
    double best = no_meeting;
    for (std::uint32_t i = 0; i < field.patches(); ++i) {
        double const distance = field.patch(i).distance_mm(ray);
        if (distance < best) {
            best = distance;
            patch = i;
        }
    }
    return best;
}

// Roots of the paraboloid along the ray, ascending, within the rectangle.
std::vector<double> expected(const Frame &frame, const Vector &plane, double bend, const Ray &ray) {
    Vector const o = frame.to_local(ray.origin - Vector{1.0, 2.0, 3.0});
    Vector const d = frame.to_local(ray.direction);
    double const a = bend * (d.x * d.x + d.y * d.y);
    double const b = plane.x * d.x + plane.y * d.y - d.z + 2.0 * bend * (o.x * d.x + o.y * d.y);
    double const c = plane.x * o.x + plane.y * o.y + plane.z - o.z + bend * (o.x * o.x + o.y * o.y);
    std::vector<double> roots;
    if (a == 0.0) {
        roots = {-c / b};
    } else if (double const root = std::sqrt(b * b - 4.0 * a * c); root >= 0.0) {
        double const q = -0.5 * (b + std::copysign(root, b));
        roots = {std::min(q / a, c / q), std::max(q / a, c / q)};
    }
    std::erase_if(roots, [&](double t) {
        double const x = o.x + t * d.x;
        double const y = o.y + t * d.y;
        return !(t > 1e-6 && x > 0.0 && x < width && y > 0.0 && y < depth);
    });
    return roots;
}

TEST(Height_field, reproduces_planes_and_paraboloids) {
    Photon_random random(1, 1);
    for (double const bend : {0.0, 0.02, -0.3}) {
        Frame const frame = frame_about(unit({0.3, -0.2, 0.9}));
        Vector const plane{0.1, -0.2, 0.5};
        auto const field = paraboloid(frame, plane, bend);
        ASSERT_EQ(field.patches(), 48U);
        int met = 0;
        for (int i = 0; i < 4000; ++i) {
            auto const anywhere = [&]() {
                return Vector{1.0, 2.0, 3.0} +
                       frame.to_world({width * (1.4 * random.uniform() - 0.2), depth * (1.4 * random.uniform() - 0.2),
                                       6.0 * random.uniform() - 3.0});
            };
            Vector const from = anywhere();
            Ray const ray{from, unit(anywhere() - from)};
            auto const roots = expected(frame, plane, bend, ray);
            std::uint32_t patch = 0;
            double const distance = closest(field, ray, patch);
            if (roots.empty()) {
                EXPECT_EQ(distance, no_meeting) << i;
                continue;
            }
            ++met;
            ASSERT_NEAR(distance, roots[0], 1e-9) << i;
            Vector const local = frame.to_local(ray.at(distance) - Vector{1.0, 2.0, 3.0});
            Facing const facing = field.patch(patch).facing(ray.at(distance));
            Vector const slopes{plane.x + 2.0 * bend * local.x, plane.y + 2.0 * bend * local.y, 0.0};
            EXPECT_NEAR(length(facing.normal - frame.to_world(unit({-slopes.x, -slopes.y, 1.0}))), 0.0, 1e-12);
            EXPECT_NEAR(length(facing.tangent - frame.to_world(unit({1.0, 0.0, slopes.x}))), 0.0, 1e-12);
            // And on from there: the other root, by whichever patch, never the start.
            double const next = closest(field, {ray.at(distance), ray.direction, 100 + patch}, patch);
            if (roots.size() == 2) {
                EXPECT_NEAR(next, roots[1] - roots[0], 1e-9) << i;
            } else {
                EXPECT_EQ(next, no_meeting) << i;
            }
        }
        EXPECT_GT(met, 300);
    }
}

TEST(Height_field, no_ray_slips_between_patches) {
    Photon_random random(2, 1);
    Height_field shape{{-6.0, -4.5, 0.0}, frame_about({0.0, 0.0, 1.0}), width, depth, rows, columns, {}, 0};
    for (std::uint32_t i = 0; i < rows * columns; ++i) {
        shape.heights.push_back(random.uniform());
    }
    Ready_height_field const field(shape, 0);
    for (int i = 0; i < 5000; ++i) {
        // Straight down at seams and corners of patches, from near and from a metre; and slanting through them.
        double const x = 1.5 * std::floor(8.0 * random.uniform()) - 6.0;
        double const y = i % 3 == 0 ? 1.5 * std::floor(6.0 * random.uniform()) - 4.5 : 9.0 * random.uniform() - 4.5;
        if (x <= -6.0 || std::abs(y) > 4.0) {
            continue; // a border, over which a slanting ray may pass
        }
        Vector const way = i % 2 == 0 ? Vector{0.0, 0.0, -1.0} : unit({0.0, random.uniform() - 0.5, -1.0});
        std::uint32_t patch = 0;
        Vector const target{x, y, 0.5};
        EXPECT_LT(closest(field, {target - (i % 5 == 0 ? 1000.0 : 2.0) * way, way}, patch), no_meeting) << i;
    }
}

TEST(Height_field, patch_lies_within_its_bounds) {
    auto const field = paraboloid(frame_about(unit({1.0, 1.0, 1.0})), {0.5, 0.1, 0.0}, 0.1);
    Photon_random random(3, 1);
    int met = 0;
    for (int i = 0; i < 2000; ++i) {
        Vector const target{1.0 + 10.0 * random.uniform(), 2.0 + 10.0 * random.uniform(), 3.0 * random.uniform()};
        Ray const ray{{5.0, 5.0, 40.0}, unit(target - Vector{5.0, 5.0, 40.0})};
        std::uint32_t patch = 0;
        if (double const distance = closest(field, ray, patch); distance < no_meeting) {
            ++met;
            Box const box = field.patch(patch).bounds();
            Vector const place = ray.at(distance);
            EXPECT_TRUE(place.x > box.low.x - 1e-8 && place.y > box.low.y - 1e-8 && place.z > box.low.z - 1e-8 &&
                        place.x < box.high.x + 1e-8 && place.y < box.high.y + 1e-8 && place.z < box.high.z + 1e-8);
        }
    }
    EXPECT_GT(met, 200);
}

TEST(Height_field, refuses_too_few_control_points) {
    Shapes shapes;
    EXPECT_THROW(shapes.add(Height_field{{}, frame_about({0.0, 0.0, 1.0}), 1.0, 1.0, 2, 3, {0, 0, 0, 0, 0, 0}, 0}),
                 std::invalid_argument);
    EXPECT_THROW(shapes.add(Height_field{{}, frame_about({0.0, 0.0, 1.0}), 1.0, 1.0, 3, 3, {0, 0, 0}, 0}),
                 std::invalid_argument);
}

} // namespace
