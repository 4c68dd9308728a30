// test_splitter_rig.cpp: paper [0]'s splitters: how the detector sees the sample in them, and what they leave of the
// light.
#include <cmath>
#include <numbers>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "lambertian.hpp"
#include "mirror.hpp"
#include "splitter_rig.hpp"
#include "thin_plate.hpp"
#include "virtual_goniophotometer.hpp"

namespace gonio::sim {
namespace {

constexpr double deg = std::numbers::pi / 180.0;
constexpr double arm_mm = 1020.0;
constexpr double cap_rad = 7.5 * deg; // the region about the ideal direction that paper [0] keeps
const Vector detector{1.0, 0.0, 0.0};
const Vector reference{-1.0, 0.0, 0.0};

// Towards the sample through the middle of the splitter: a spot of 10 mm, or one ray.
class Pencil final : public Source {
public:
    Pencil(double half_width_mm, const Stokes &stokes) : half_width_mm_(half_width_mm), stokes_(stokes) {}
    [[nodiscard]] Start start(Photon_random &random) const override {
        double const x = half_width_mm_ * (2.0 * random.uniform() - 1.0);
        double const y = half_width_mm_ * (2.0 * random.uniform() - 1.0);
        return {{x, y, 500.0}, {0.0, 0.0, -1.0}, stokes_, {0.0, 1.0, 0.0}};
    }

private:
    double half_width_mm_;
    Stokes stokes_;
};

struct Powers {
    double reflectance_s, reflectance_p, transmittance_s, transmittance_p;
};

// A square of 60 mm with this finish in the splitters; s is along the lab's Y, on edge as the splitters are.
template <typename Finish>
Photon_scenario scenario_of(Finish finish, const Powers &p, const Stokes &stokes = {}, double half_width_mm = 5.0,
                            const Splitter_rig &rig = {}) {
    Photon_scenario scenario{};
    scenario.bands = {{"visible", 550.0}};
    scenario.trace.seed = 5;
    scenario.sample = [finish](const Band &, bool mounted) {
        Sample_model model;
        if (mounted) {
            model.materials.push_back(std::make_unique<Finish>(finish));
            const Material *made = model.materials.back().get();
            model.surfaces.push_back({made, made});
            model.shapes.add(Parallelogram{{-30.0, -30.0, 0.0}, {60.0, 0.0, 0.0}, {0.0, 60.0, 0.0}, 0});
        }
        return model;
    };
    scenario.source = [half_width_mm, stokes](const Band &) { return std::make_unique<Pencil>(half_width_mm, stokes); };
    surround_with_splitters(scenario, rig, [p](const Band &) {
        return std::make_unique<Splitter>(p.reflectance_s, p.reflectance_p, p.transmittance_s, p.transmittance_p);
    });
    return scenario;
}

// The share of the source's power in a cap about a direction of the lab, with its standard error.
struct Share {
    double value;
    double error;
};
Share share_about(const Photon_scenario &scenario, const Vector &direction, bool mounted, std::uint64_t photons) {
    Virtual_goniophotometer const bench(scenario, scenario.bands.front(), {0.0, 0.0}, mounted);
    Watch watch;
    auto const read = bench.read(std::vector<Vector>{direction}, cap_rad, {0, photons}, 2, watch);
    EXPECT_EQ(read.balance.lost, 0);
    Estimate const found =
        estimate(read.apertures.weight.at(0), read.apertures.square.at(0), read.apertures.hits.at(0), photons, cap_rad);
    return {found.dsf_per_sr * cap_sr(cap_rad), found.standard_error_per_sr * cap_sr(cap_rad)};
}

} // namespace

// Slip S11 of the papers: eq. 2 with the straight way gives 6.797 degrees for 7.5; the exact one 6.801, over 1124.2 mm.
TEST(Splitter_view, EffectiveDirectionIsExact) {
    Splitter_view const view = seen_in_splitter({}, {std::cos(cap_rad), 0.0, std::sin(cap_rad)}, arm_mm);
    double const theta_deg = std::atan2(std::hypot(view.outgoing.x, view.outgoing.y), view.outgoing.z) / deg;
    double const by_eq_2_deg = std::asin(1020.0 / 1125.0 * std::sin(cap_rad)) / deg;
    EXPECT_NEAR(theta_deg, 6.801, 5e-4);
    EXPECT_NEAR(by_eq_2_deg, 6.797, 5e-4);
    EXPECT_NEAR(view.distance_mm, 1124.2, 0.05);
    EXPECT_GT(view.outgoing.x, 0.0) << "the splitter exchanges X and Z";
    Splitter_view const straight = seen_in_splitter({}, detector, arm_mm);
    EXPECT_NEAR(straight.outgoing.z, 1.0, 1e-12);
    EXPECT_NEAR(straight.dsf_factor, 1.2165, 5e-5);
}

TEST(Splitter_view, InverseFindsTheDetector) {
    for (double const x : {-0.1, 0.0, 0.07}) {
        for (double const y : {-0.12, 0.05}) {
            Vector const outgoing = unit({x, y, 1.0});
            Vector const found = seen_in_splitter({}, seen_from_sample({}, outgoing, arm_mm), arm_mm).outgoing;
            EXPECT_NEAR(length(found - outgoing), 0.0, 1e-12);
        }
    }
}

// The traced way of one ray, not the formula's: a mirror sends it off at 6.8 degrees, and it lands at 7.5.
TEST(Splitter_rig, TracedRayLandsWhereTheViewSaysItDoes) {
    constexpr double tilt = 0.5 * 6.8015 * deg;
    Photon_scenario scenario = scenario_of(Mirror({1.0, 1.0}), {0.5, 0.5, 0.5, 0.5}, {}, 0.0);
    Virtual_goniophotometer const bench(scenario, scenario.bands.front(), {tilt / deg, 0.0}, true);
    Watch watch;
    // The sample is turned by the tilt about the lab's Y; directions are in its frame.
    auto const in_sample = [&](const Vector &lab) {
        return Vector{std::cos(tilt) * lab.x + std::sin(tilt) * lab.z, lab.y,
                      std::cos(tilt) * lab.z - std::sin(tilt) * lab.x};
    };
    Vector const sent = {-std::sin(2.0 * tilt), 0.0, std::cos(2.0 * tilt)};
    Vector const expected = in_sample(seen_from_sample({}, sent, arm_mm));
    double const theta_by_eq_2 = std::asin(1125.0 / 1020.0 * std::sin(2.0 * tilt));
    Vector const by_eq_2 = in_sample({std::cos(theta_by_eq_2), 0.0, -std::sin(theta_by_eq_2)});
    constexpr double narrow_rad = 0.001 * deg;
    auto const read = bench.read(std::vector<Vector>{expected, by_eq_2}, narrow_rad, {0, 1000}, 1, watch);
    EXPECT_GT(read.apertures.hits.at(0), 0U);
    EXPECT_EQ(read.apertures.hits.at(1), 0U) << "eq. 2 would have it 0.005 degrees beside";
}

// Section 2.3: "with an ideal BS ... 0.50 x 0.50 = 0.25". A mirror returns all of it.
TEST(Splitter_rig, IdealSplitterLeavesAQuarter) {
    Share const found = share_about(scenario_of(Mirror({1.0, 1.0}), {0.5, 0.5, 0.5, 0.5}), detector, true, 100000);
    EXPECT_NEAR(found.value, 0.25, 4.0 * found.error);
    EXPECT_LT(found.error, 0.002);
}

// R*T on the way to the reference, T*R on that of the sample: the same for s and for p, whatever the plate does.
TEST(Splitter_rig, PathsAreEqualForEachPolarisation) {
    Powers const plate{0.68, 0.30, 0.30, 0.68};
    for (auto const &[stokes, expected] :
         {std::pair{Stokes{1.0, 0.0, 0.0}, 0.68 * 0.30}, {Stokes{-1.0, 0.0, 0.0}, 0.30 * 0.68}}) {
        Photon_scenario const scenario = scenario_of(Mirror({1.0, 1.0}), plate, stokes);
        for (bool const mounted : {true, false}) {
            Share const found = share_about(scenario, mounted ? detector : reference, mounted, 100000);
            EXPECT_NEAR(found.value, expected, 4.0 * found.error) << stokes.q << mounted;
        }
    }
    // A plate that is not the same for both tells them apart.
    Powers const uneven{0.5, 0.1, 0.4, 0.8};
    Share const s = share_about(scenario_of(Mirror({1.0, 1.0}), uneven, {1.0, 0.0, 0.0}), detector, true, 100000);
    Share const p = share_about(scenario_of(Mirror({1.0, 1.0}), uneven, {-1.0, 0.0, 0.0}), detector, true, 100000);
    EXPECT_NEAR(s.value, 0.5 * 0.4, 4.0 * s.error);
    EXPECT_NEAR(p.value, 0.1 * 0.8, 4.0 * p.error);
}

// Slip S12: a sample that depolarises gives <T><R> = 0.2401, the reference <T R> = 0.204: an 18 % step, traced.
TEST(Splitter_rig, DepolarisingSampleIsBrighterThanItsReference) {
    Powers const plate{0.68, 0.30, 0.30, 0.68};
    Photon_scenario const white = scenario_of(Lambertian(1.0), plate);
    Share const sample = share_about(white, detector, true, 1000000);
    Share const beam = share_about(white, reference, false, 100000);
    EXPECT_NEAR(beam.value, 0.204, 4.0 * beam.error);
    // A Lambertian sends sin^2 of a cone's half angle into it; the cone is what the cap is seen as.
    Splitter_view const rim = seen_in_splitter({}, {std::cos(cap_rad), 0.0, std::sin(cap_rad)}, arm_mm);
    double const cone = 1.0 - rim.outgoing.z * rim.outgoing.z;
    double const step = sample.value / (beam.value * cone);
    double const error = step * std::hypot(sample.error / sample.value, beam.error / beam.value);
    EXPECT_NEAR(step, 0.2401 / 0.204, 4.0 * error);
    EXPECT_LT(error, 0.03) << "a step of 1.18 is told from none";
    // A mirror keeps the polarisation: no step.
    Share const kept = share_about(scenario_of(Mirror({1.0, 1.0}), plate), detector, true, 100000);
    EXPECT_NEAR(kept.value / beam.value, 1.0, 4.0 * std::hypot(kept.error, beam.error) / beam.value);
}

// The detector sees the sample in the splitter alone: with plates that reflect nothing it is dark.
TEST(Splitter_rig, BaffleStopsTheStraightWay) {
    Powers const nothing{0.0, 0.0, 1.0, 1.0};
    Splitter_rig bare;
    bare.baffle = false;
    EXPECT_EQ(share_about(scenario_of(Lambertian(1.0), nothing), detector, true, 200000).value, 0.0);
    EXPECT_GT(share_about(scenario_of(Lambertian(1.0), nothing, {}, 5.0, bare), detector, true, 200000).value, 0.0);
}

} // namespace gonio::sim
