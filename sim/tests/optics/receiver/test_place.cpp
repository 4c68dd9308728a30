// test_place.cpp: places are kept to a billionth of a radian, and caps hold what is within their angle.
#include <gtest/gtest.h>

#include "drawn_hits.hpp"
#include "stretches.hpp"

namespace gonio::sim {

namespace {

Vector direction_of(const Place &place) {
    unsigned const face = face_of(place);
    double const u = face_coordinate(place.u);
    double const v = face_coordinate(place.v);
    double const outward = face % 2 == 0 ? 1.0 : -1.0;
    switch (face / 2) {
    case 0:
        return unit({outward, u, v});
    case 1:
        return unit({v, outward, u});
    default:
        return unit({u, v, outward});
    }
}

double angle_between(const Vector &a, const Vector &b) {
    return std::atan2(length(cross(a, b)), dot(a, b));
}

std::vector<Vector> awkward_places() {
    std::vector<Vector> places;
    for (int x = -1; x <= 1; ++x) {
        for (int y = -1; y <= 1; ++y) {
            for (int z = -1; z <= 1; ++z) {
                if (x != 0 || y != 0 || z != 0) {
                    Vector const corner = unit({double(x), double(y), double(z)});
                    places.push_back(corner);
                    places.push_back(unit(corner + Vector{1e-9, -1e-9, 2e-9}));
                }
            }
        }
    }
    return places;
}

} // namespace

TEST(Place, KeepsADirectionToABillionthOfARadian) {
    std::vector<Vector> places = awkward_places();
    for (std::uint64_t i = 0; i < 50000; ++i) {
        Photon_random random(1, i);
        places.push_back(anywhere(random));
    }
    for (const Vector &place : places) {
        EXPECT_LT(angle_between(place, direction_of(place_of(place))), 1.4e-9);
    }
}

TEST(Place, IsThatOfTheDirectionWhateverItsLength) {
    for (const Vector &place : awkward_places()) {
        Place const once = place_of(place);
        Place const twice = place_of(2.0 * place);
        EXPECT_EQ(once.u, twice.u);
        EXPECT_EQ(once.v, twice.v);
    }
}

TEST(Cap, HoldsWhatIsWithinItsHalfAngle) {
    for (std::uint64_t i = 0; i < 50000; ++i) {
        Photon_random random(2, i);
        Vector const direction = anywhere(random);
        // A place anywhere from the cap's middle to far outside, mostly near the rim.
        double const half_angle = std::numbers::pi * std::pow(10.0, -4.0 * random.uniform());
        double const angle = std::min(half_angle * 2.0 * random.uniform(), std::numbers::pi);
        double const phi = 2.0 * std::numbers::pi * random.uniform();
        Vector const place = frame_about(direction).to_world(at_angles(angle, phi));
        Place const kept = place_of(place);
        double const kept_angle = angle_between(direction, direction_of(kept));
        if (std::abs(kept_angle - half_angle) > 1e-11) {
            Face_cap const cap = on_face(direction, Half_angle(half_angle), face_of(kept));
            EXPECT_EQ(holds(cap, face_coordinate(kept.u), face_coordinate(kept.v)), kept_angle < half_angle);
        }
    }
}

TEST(Cap, OverlapOfASquareIsNeverWrong) {
    int decided = 0;
    for (std::uint64_t i = 0; i < 20000; ++i) {
        Photon_random random(3, i);
        Vector const direction = anywhere(random);
        double const half_width = std::pow(2.0, -std::floor(8.0 * random.uniform()));
        double const u = (1.0 - half_width) * (2.0 * random.uniform() - 1.0);
        double const v = (1.0 - half_width) * (2.0 * random.uniform() - 1.0);
        Half_angle const angle(std::numbers::pi * std::pow(10.0, -3.0 * random.uniform()));
        Face_cap const cap = on_face(direction, angle, static_cast<unsigned>(6.0 * random.uniform()));
        Overlap const held = overlap(cap, u, v, half_width);
        decided += held == Overlap::part ? 0 : 1;
        for (double const du : {-1.0, -0.3, 0.5, 1.0}) {
            for (double const dv : {-1.0, -0.6, 0.2, 1.0}) {
                bool const inside = holds(cap, u + du * half_width, v + dv * half_width);
                EXPECT_FALSE(inside ? held == Overlap::none : held == Overlap::all);
            }
        }
    }
    EXPECT_GT(decided, 10000);
}

TEST(Cap, StretchesAreItsChords) {
    for (std::uint64_t i = 0; i < 20000; ++i) {
        Photon_random random(4, i);
        Vector const direction = anywhere(random);
        Half_angle const angle(0.49 * std::numbers::pi * std::pow(10.0, -2.0 * random.uniform()));
        Face_cap const cap = on_face(direction, angle, static_cast<unsigned>(6.0 * random.uniform()));
        double const u = 2.0 * random.uniform() - 1.0;
        Range const chord = Stretches(cap, true).at(u);
        for (int j = -20; j <= 20; ++j) {
            double const v = j / 20.0;
            if (std::abs(v - chord.low) > 1e-9 && std::abs(v - chord.high) > 1e-9) {
                EXPECT_EQ(holds(cap, u, v), v > chord.low && v < chord.high);
            }
        }
    }
}

} // namespace gonio::sim
