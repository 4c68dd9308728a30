// test_shading_rig.cpp: what stands in the light's way, traced as geometry: the sample's holder, and the detector's
// head against the overlap of circles that the twin reckons with.
#include <cmath>
#include <fstream>
#include <numbers>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "black.hpp"
#include "rig_scenario.hpp"
#include "shading.hpp"
#include "surrounded_scene.hpp"
#include "toml_table.hpp"
#include "virtual_goniophotometer.hpp"

namespace gonio::sim {
namespace {

constexpr double deg = std::numbers::pi / 180.0;

std::filesystem::path written(const std::string &text) {
    std::filesystem::path path = std::filesystem::path(testing::TempDir()) / "rig_under_test.toml";
    std::ofstream(path) << text;
    return path;
}

Photon_scenario load(const std::string &text) {
    return load_rig_scenario(written(text), GONIO_SOURCE_DIR, {});
}

std::string refusal(const std::string &text) {
    try {
        load(text);
    } catch (const Input_error &error) {
        return error.what();
    }
    return "";
}

const std::string diffuser =
    "[sample]\nkind = \"lambertian\"\nsize_mm = 100.0\nreflectance = 0.5\ntransmittance = 0.5\n"
    "[beam]\nkind = \"focused\"\ndiameter_mm = 10.0\n";

Vector direction(double theta_deg) {
    return {std::sin(theta_deg * deg), 0.0, std::cos(theta_deg * deg)};
}

Estimate reading(const Photon_scenario &scenario, double theta_deg, std::uint64_t photons) {
    Virtual_goniophotometer const bench(scenario, scenario.bands.front(), {0.0, 0.0}, true);
    constexpr double half_angle_rad = 2.0 * deg;
    Watch watch;
    auto const read = bench.read(std::vector<Vector>{direction(theta_deg)}, half_angle_rad, {0, photons}, 2, watch);
    return estimate(read.apertures.weight.at(0), read.apertures.square.at(0), read.apertures.hits.at(0), photons,
                    half_angle_rad);
}

} // namespace

// Paper [1], line 11 of PAPERS.md: the holder, a thick ring behind the sample, takes what leaves it at 90 to 130
// degrees.
TEST(Shading_rig, HolderShadowsFrom90To130Degrees) {
    // Depth 40 behind the sample, opening 95: the edge is seen from the centre at 180 - atan(47.5 / 40) = 130 degrees.
    Photon_scenario const held =
        load(diffuser + "[rig.holder]\nopening_mm = 95.0\nthickness_mm = 40.0\nsize_mm = 200.0\n"
                        "z_mm = -0.01\nreflectance = 0.0\n");
    Photon_scenario const alone = load(diffuser);
    constexpr std::uint64_t photons = 200000;
    for (double const theta_deg : {95.0, 110.0, 120.0}) {
        EXPECT_EQ(reading(held, theta_deg, photons).hits, 0U) << theta_deg;
        EXPECT_GT(reading(alone, theta_deg, photons).hits, 0U) << theta_deg;
    }
    for (double const theta_deg : {60.0, 140.0, 170.0}) {
        Estimate const clear = reading(held, theta_deg, photons);
        double const expected = 0.5 / std::numbers::pi * std::abs(std::cos(theta_deg * deg));
        EXPECT_NEAR(clear.dsf_per_sr, expected, 4.0 * clear.standard_error_per_sr + 0.005 * expected) << theta_deg;
    }
}

// The head as a black disc on the sphere, between the stop and the sample: the share that passes is the overlap's.
TEST(Shading_rig, TracedHeadTakesWhatTheOverlapSays) {
    constexpr double arm_mm = 1020.0;
    constexpr double beam_mm = 65.0;
    constexpr double head_mm = 50.0;
    for (double const angle_deg : {0.0, 1.5, 2.5, 4.0}) {
        Photon_scenario scenario = load("[sample]\nkind = \"lambertian\"\nreflectance = 1.0\n"
                                        "[beam]\nkind = \"collimated\"\ndiameter_mm = 65.0\nedge_deg = 0.0\n"
                                        "[source]\nopening_angle_deg = 0.0\n");
        scenario.sample = [sample = scenario.sample](const Band &band, bool mounted) {
            Sample_model model = sample(band, mounted);
            const Material *black = model.materials.emplace_back(std::make_unique<Black>()).get();
            model.surfaces.push_back({black, black});
            return model;
        };
        scenario.surround = [angle_deg](const Sample_model &model, std::unique_ptr<Scene> sample, const Frame &) {
            Shapes head;
            // Just outside the receiver sphere, or it would stand in scattered light's way to it.
            head.add(Disc{1.001 * arm_mm * direction(angle_deg),
                          {0.0, 0.0, 1.0},
                          0.0,
                          0.5 * head_mm,
                          static_cast<std::uint32_t>(model.surfaces.size() - 1)});
            return make_surrounded_scene(head, std::move(sample), {});
        };
        Virtual_goniophotometer const bench(scenario, scenario.bands.front(), {0.0, 0.0}, true);
        Watch watch;
        constexpr std::uint64_t photons = 40000;
        auto const stored = bench.store({0, photons}, 2, watch);
        Head const head{head_mm, beam_mm, arm_mm};
        Vector const to = direction(angle_deg);
        double const expected = head.transmitted({0.0, 0.0, 1.0}, {to.x, to.y, to.z});
        // The disc also takes what the sample sends back at it: at most its share of a Lambertian's light.
        double const passed = static_cast<double>(stored.balance.stored) / static_cast<double>(stored.balance.emitted);
        double const back = std::pow(0.5 * head_mm / arm_mm, 2);
        EXPECT_NEAR(passed, expected, 4.0 * std::sqrt(0.25 / photons) + back) << angle_deg;
    }
}

TEST(Rig_scenario, KeysAreStrict) {
    std::string const splitters = diffuser + "[rig.splitters]\nplate = { kind = \"thin-plate\", index = 1.5 }\n";
    EXPECT_EQ(refusal(splitters), "");
    EXPECT_TRUE(load(splitters).trace.polarised);
    EXPECT_TRUE(load(splitters).surround);
    EXPECT_FALSE(load(diffuser).surround);
    EXPECT_NE(refusal(splitters + "sides_mm = 3").find("sides_mm"), std::string::npos);
    EXPECT_NE(refusal(splitters + "sample_distance_mm = 30.0").find("sample_distance_mm"), std::string::npos);
    EXPECT_NE(refusal(splitters + "sample_distance_mm = 1020.0").find("arm"), std::string::npos);
    EXPECT_NE(refusal(diffuser + "[rig.splitters]\nside_mm = 50.0").find("kind"), std::string::npos);
    EXPECT_NE(refusal(diffuser + "[rig.head]").find("head"), std::string::npos);
    EXPECT_NE(refusal(diffuser + "[rig.holders]").find("holders"), std::string::npos);
}

} // namespace gonio::sim
