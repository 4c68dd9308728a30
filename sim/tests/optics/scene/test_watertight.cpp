// test_watertight.cpp: no ray gets out of a closed surface of triangles or parallelograms.
#include <gtest/gtest.h>

#include <array>
#include <map>

#include "embree_scene.hpp"
#include "scene_tests.hpp"

using namespace gonio::sim;

namespace {

// An icosahedron's faces, each cut in four `levels` times, on a sphere.
class Tessellated_sphere {
public:
    Tessellated_sphere(const Vector &centre, double radius, int levels) : centre_(centre), radius_(radius) {
        double const golden = 0.5 * (1.0 + std::sqrt(5.0));
        for (double const s : {-1.0, 1.0}) {
            for (double const t : {-golden, golden}) {
                corner({0.0, s, t});
                corner({s, t, 0.0});
                corner({t, 0.0, s});
            }
        }
        for (std::size_t a = 0; a < 12; ++a) {
            for (std::size_t b = a + 1; b < 12; ++b) {
                for (std::size_t c = b + 1; c < 12; ++c) {
                    if (near(a, b) && near(b, c) && near(a, c)) {
                        cut(a, b, c, levels);
                    }
                }
            }
        }
    }

    Shapes shapes;
    std::vector<Vector> corners;

private:
    std::size_t corner(const Vector &direction) {
        corners.push_back(centre_ + radius_ * unit(direction));
        return corners.size() - 1;
    }
    [[nodiscard]] bool near(std::size_t a, std::size_t b) const {
        return length(corners[a] - corners[b]) < 1.1 * radius_;
    }
    std::size_t middle(std::size_t a, std::size_t b) {
        auto const [found, isnew] = middles_.try_emplace({std::min(a, b), std::max(a, b)}, corners.size());
        if (isnew) {
            corner(0.5 * (corners[a] + corners[b]) - centre_);
        }
        return found->second;
    }
    void cut(std::size_t a, std::size_t b, std::size_t c, int levels) {
        if (levels == 0) {
            shapes.add(Triangle{corners[a], corners[b], corners[c], 0});
            return;
        }
        std::size_t const ab = middle(a, b);
        std::size_t const bc = middle(b, c);
        std::size_t const ca = middle(c, a);
        cut(a, ab, ca, levels - 1);
        cut(ab, b, bc, levels - 1);
        cut(ca, bc, c, levels - 1);
        cut(ab, bc, ca, levels - 1);
    }

    Vector centre_;
    double radius_;
    std::map<std::pair<std::size_t, std::size_t>, std::size_t> middles_;
};

TEST(Watertight, sphere_of_triangles) {
    Dice dice(1);
    Vector const centre{300.0, -200.0, 100.0};
    Tessellated_sphere sphere(centre, 20.0, 4);
    ASSERT_EQ(sphere.shapes.size(), 5120U);
    auto const scene = make_embree_scene(sphere.shapes);
    int leaks = 0;
    int missed = 0;
    for (int i = 0; i < 50000; ++i) {
        Vector const origin = centre + dice.place(8.0);
        const Vector &a = sphere.corners[dice.below(static_cast<std::uint32_t>(sphere.corners.size()))];
        const Vector &b = sphere.corners[dice.below(static_cast<std::uint32_t>(sphere.corners.size()))];
        bool const edge = length(a - b) < 3.0;
        // At a corner, at an edge's middle where the two are neighbours, anywhere.
        std::array<Vector, 3> const targets{a, edge ? 0.5 * (a + b) : b, origin + dice.direction()};
        for (const Vector &target : targets) {
            Hit hit{};
            Vector const way = unit(target - origin);
            leaks += scene->closest({origin, way}, hit) ? 0 : 1;
            // From outside, a metre away, through the same place.
            missed += scene->closest({origin - 1000.0 * way, way}, hit) ? 0 : 1;
        }
    }
    EXPECT_EQ(leaks, 0);
    EXPECT_EQ(missed, 0);
}

// Six parallelograms, each with a corner of its own: turned, so that no edge is the same number in two of them.
class Closed_box {
public:
    Closed_box(const Vector &centre, const Frame &frame, const Vector &half)
        : centre_(centre), frame_(frame), half_(half) {
        for (double const side : {-1.0, 1.0}) {
            Vector const corner = at({side, side, side});
            Vector const x = (-2.0 * side * half.x) * frame.s;
            Vector const y = (-2.0 * side * half.y) * frame.t;
            Vector const z = (-2.0 * side * half.z) * frame.n;
            shapes.add(Parallelogram{corner, x, y, 0});
            shapes.add(Parallelogram{corner, y, z, 0});
            shapes.add(Parallelogram{corner, z, x, 0});
        }
    }
    [[nodiscard]] Vector at(const Vector &share) const {
        return centre_ + frame_.to_world({share.x * half_.x, share.y * half_.y, share.z * half_.z});
    }

    Shapes shapes;

private:
    Vector centre_;
    Frame frame_;
    Vector half_;
};

TEST(Watertight, box_of_parallelograms) {
    Dice dice(2);
    for (int k = 0; k < 20; ++k) {
        Closed_box const box(dice.place(1000.0), frame_about(dice.direction()),
                             {dice.between(0.5, 30.0), dice.between(0.5, 30.0), dice.between(0.5, 30.0)});
        auto const scene = make_embree_scene(box.shapes);
        int leaks = 0;
        for (int i = 0; i < 5000; ++i) {
            Vector const origin = box.at(dice.place(0.9));
            auto const end = [&]() { return dice.below(2) == 0 ? -1.0 : 1.0; };
            std::array<Vector, 3> const targets{Vector{end(), end(), dice.between(-1.0, 1.0)},
                                                Vector{dice.between(-1.0, 1.0), end(), end()},
                                                Vector{end(), end(), end()}};
            Hit hit{};
            leaks += scene->closest({origin, unit(box.at(targets.at(dice.below(3))) - origin)}, hit) ? 0 : 1;
        }
        EXPECT_EQ(leaks, 0);
    }
}

// Bounces without end. A ray gets out only if it starts within the least distance of an edge, since it meets nothing
// nearer: about one start in 1e8, if it does not graze.
TEST(Watertight, light_stays_in_a_box_and_in_a_sphere_of_triangles) {
    Dice dice(3);
    Closed_box const box({100.0, 50.0, -80.0}, frame_about(unit({1.0, 2.0, 3.0})), {5.0, 8.0, 13.0});
    Tessellated_sphere const sphere({100.0, 50.0, -80.0}, 12.0, 2);
    for (const Shapes *shapes : {&box.shapes, &sphere.shapes}) {
        auto const scene = make_embree_scene(*shapes);
        Ray ray{{100.0, 50.0, -80.0}, dice.direction()};
        int leaks = 0;
        for (int bounce = 0; bounce < 100000; ++bounce) {
            Hit hit{};
            if (!scene->closest(ray, hit)) {
                ++leaks;
                ray = {{100.0, 50.0, -80.0}, dice.direction()};
                continue;
            }
            Vector const inwards = dot(hit.normal, ray.direction) < 0.0 ? hit.normal : -hit.normal;
            Vector const any = dice.direction();
            Vector const flat = any - dot(any, inwards) * inwards;
            ray = {ray.at(hit.distance_mm), unit(unit(flat) + dice.between(0.01, 2.0) * inwards), hit.primitive};
        }
        EXPECT_EQ(leaks, 0);
    }
}

} // namespace
