// test_weave.cpp: the basket weave: openness, thickness, and its surfaces against an independent distance function.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "sample_walk.hpp"

using namespace gonio::sim;

namespace {

std::string weave(const std::string &keys, double reflectance) {
    return "[sample]\nkind = \"weave\"\nmaterial = \"thread\"\n" + keys +
           "\n[materials.thread]\nkind = \"lambertian\"\nreflectance = " + std::to_string(reflectance) + "\n";
}

// A band is all points within `radius` of a strip: a curve, extruded across. The curve here is a fine polygon of
// points. It is put together from the two touching circles and their common tangent, which is found by search.
class Band_model {
public:
    Band_model(double width, double thickness, double pitch, double clearance)
        : radius_(0.25 * (thickness - clearance)), lift_(radius_ + 0.5 * clearance), half_flat_(0.5 * width - radius_),
          pitch_(pitch) {
        double const run = pitch - 2.0 * half_flat_;
        double angle = 0.0;
        double best = 1e9;
        for (double a = 0.0; a < 1.5; a += 1e-6) {
            double const off = std::abs((run - 4.0 * lift_ * std::sin(a)) * std::sin(a) +
                                        (2.0 * lift_ - 4.0 * lift_ * std::cos(a)) * std::cos(a));
            if (off < best) {
                best = off;
                angle = a;
            }
        }
        // One period from a crossing over to the next over, then mirrored.
        auto const falls = [&](double u) {
            double const from_edge = u - half_flat_;
            double const to_edge = half_flat_ + run - u;
            double const reach = 2.0 * lift_ * std::sin(angle);
            if (from_edge <= 0.0) {
                return lift_;
            }
            if (to_edge <= 0.0) {
                return -lift_;
            }
            if (from_edge < reach) {
                return -lift_ + std::sqrt(4.0 * lift_ * lift_ - from_edge * from_edge);
            }
            if (to_edge < reach) {
                return lift_ - std::sqrt(4.0 * lift_ * lift_ - to_edge * to_edge);
            }
            double const begin = -lift_ + 2.0 * lift_ * std::cos(angle);
            return begin - (from_edge - reach) * std::tan(angle);
        };
        for (int i = 0; i < points; ++i) {
            heights_.push_back(falls(pitch * i / points));
        }
    }

    // From (u, across, w) to a band that is over at u = 0; w from the screen's middle.
    [[nodiscard]] double distance(double u, double across, double w) const {
        double const beside = std::max(0.0, std::abs(across) - half_flat_);
        double least = 1e9;
        auto const nearest = static_cast<long>(std::floor(u / pitch_ * points));
        for (long i = nearest - points; i <= nearest + points; i += 1) {
            double const du = u - pitch_ * static_cast<double>(i) / points;
            double const dw = w - height(i);
            least = std::min(least, du * du + dw * dw);
        }
        return std::sqrt(least + beside * beside) - radius_;
    }
    [[nodiscard]] double distance_to_screen(const Vector &place) const {
        double const w = place.z + lift_ + radius_;
        double least = 1e9;
        for (long k = -1; k <= 1; ++k) {
            auto const row = std::lround(place.y / pitch_) + k;
            auto const column = std::lround(place.x / pitch_) + k;
            double const shift_row = row % 2 == 0 ? 0.0 : pitch_;
            double const shift_column = column % 2 == 0 ? pitch_ : 0.0;
            least = std::min(least, distance(place.x + shift_row, place.y - row * pitch_, w));
            least = std::min(least, distance(place.y + shift_column, place.x - column * pitch_, w));
        }
        return least;
    }

private:
    static constexpr long points = 400;
    [[nodiscard]] double height(long i) const {
        long const half = ((i % (2 * points)) + 2 * points) % (2 * points);
        return half < points ? heights_[static_cast<std::size_t>(half)]
                             : -heights_[static_cast<std::size_t>(half - points)];
    }

    double radius_;
    double lift_;
    double half_flat_;
    double pitch_;
    std::vector<double> heights_;
};

} // namespace

TEST(Weave, OpennessAtNormalIncidence) {
    double const gap = 1.0 - 0.58 / 0.747;
    EXPECT_NEAR(gap * gap, 0.05, 5e-4);
    Sample_walk const walk(weave("size_mm = 6.0", 0.5));
    // Along the middle of the gaps, then across, to a point in 4000; then the whole, where a row of the grid more or
    // less in each gap is 3 % of it.
    int along_x = 0;
    int along_y = 0;
    for (int i = 0; i < 4000; ++i) {
        double const place = 1.494 * ((i + 0.5) / 4000.0 - 0.5);
        along_x += walk.passes({{place, 0.5 * 0.747, 1.0}, {0.0, 0.0, -1.0}}) ? 1 : 0;
        along_y += walk.passes({{0.5 * 0.747, place, 1.0}, {0.0, 0.0, -1.0}}) ? 1 : 0;
    }
    EXPECT_NEAR(along_x / 4000.0, gap, 1e-3);
    EXPECT_NEAR(along_y / 4000.0, gap, 1e-3);
    EXPECT_NEAR(direct_transmittance(walk, 0.0, 0.0, 300, 300), gap * gap, 0.06 * gap * gap);
    Sample_walk const open(weave("size_mm = 9.0\npitch_mm = 1.16", 0.5));
    EXPECT_NEAR(direct_transmittance(open, 0.0, 0.0, 300, 300), 0.25, 0.06 * 0.25);
}

TEST(Weave, IsAsThickAsItSays) {
    Sample_walk const walk(weave("size_mm = 6.0", 0.5));
    double highest = -1.0;
    double lowest = 1.0;
    for (int i = 0; i < 40000; ++i) {
        double const x = 0.747 * 2.0 * ((i % 200) / 200.0 - 0.5);
        double const y = 0.747 * 2.0 * ((i / 200) / 200.0 - 0.5);
        Hit hit{};
        if (walk.scene().closest({{x, y, 1.0}, {0.0, 0.0, -1.0}}, hit)) {
            highest = std::max(highest, 1.0 - hit.distance_mm);
        }
        if (walk.scene().closest({{x, y, -2.0}, {0.0, 0.0, 1.0}}, hit)) {
            lowest = std::min(lowest, hit.distance_mm - 2.0);
        }
    }
    EXPECT_NEAR(highest, 0.0, 1e-9);
    EXPECT_NEAR(lowest, -0.43, 1e-9);
}

// Rays march through the distance function until they touch; the scene must say the same. The polygon is fine to 1e-5.
TEST(Weave, SurfacesAreWhereTheyShouldBe) {
    Sample_walk const walk(weave("size_mm = 8.0", 0.5));
    Band_model const model(0.58, 0.43, 0.747, 0.001);
    int misses = 0;
    for (std::uint64_t number = 0; number < 600; ++number) {
        Photon_random random(3, number);
        // From above and from below, through places at mid-height.
        double const side = number % 2 == 0 ? 1.0 : -1.0;
        Vector const up = towards(75.0 * random.uniform(), 360.0 * random.uniform());
        Vector const from{up.x, up.y, side * up.z};
        Vector const middle{1.5 * (random.uniform() - 0.5), 1.5 * (random.uniform() - 0.5), -0.215};
        Ray const ray{middle + 0.26 / up.z * from, -from};
        double marched = 0.0;
        double gap = 1.0;
        while (gap > 1e-5 && std::abs((ray.origin + marched * ray.direction).z + 0.215) < 0.27) {
            gap = model.distance_to_screen(ray.origin + marched * ray.direction);
            marched += gap;
        }
        Hit hit{};
        bool const met = walk.scene().closest(ray, hit);
        ASSERT_EQ(met, gap <= 1e-5) << number;
        misses += met ? 0 : 1;
        if (met) {
            // Grazing rays stop early: compare across the surface.
            EXPECT_NEAR((hit.distance_mm - marched) * std::abs(dot(hit.normal, ray.direction)), 0.0, 1e-4) << number;
        }
    }
    EXPECT_LT(misses, 60);
}

// White threads lose nothing: no ray finds its way into a band.
TEST(Weave, WhiteThreadsLoseNothing) {
    Sample_walk const walk(weave("size_mm = 12.0", 1.0));
    int interactions = 0;
    shine(walk, towards(30.0, 40.0), 4000, [&](const Light &light) {
        EXPECT_NEAR(light.weight, 1.0, 1e-12);
        interactions = std::max(interactions, light.interactions);
    });
    EXPECT_LT(interactions, 1000);
}
