// test_photon_scenario.cpp: the examples load, every key lands where it belongs, and what is wrong is said.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>

#include "beam_reader.hpp"
#include "photon_scenario.hpp"
#include "toml_table.hpp"
#include "virtual_goniophotometer.hpp"

using namespace gonio::sim;

namespace {

const std::filesystem::path source_directory = GONIO_SOURCE_DIR;

class Photon_scenario_file : public ::testing::Test {
protected:
    void SetUp() override {
        folder_ =
            std::filesystem::temp_directory_path() /
            ("gonio_photon_scenario_" + std::string(::testing::UnitTest::GetInstance()->current_test_info()->name()));
        std::filesystem::create_directories(folder_);
    }
    void TearDown() override { std::filesystem::remove_all(folder_); }

    Photon_scenario load(const std::string &text) {
        std::ofstream(folder_ / "scenario.toml") << text;
        return load_photon_scenario(folder_ / "scenario.toml", source_directory, {});
    }
    std::string told(const std::string &text) {
        try {
            load(text);
        } catch (const Input_error &error) {
            return error.what();
        }
        return "nothing";
    }
    void write(const std::string &name, const std::string &text) const { std::ofstream(folder_ / name) << text; }

private:
    std::filesystem::path folder_;
};

const std::string mirror = "[sample]\nkind = \"mirror\"\nreflectance = { visible = 0.9, nir = 0.5 }\n";

Source_settings beam(const std::string &text) {
    toml::table const root = toml::parse(text);
    Toml_table table(root, "test.toml");
    return read_beam(table.table("beam"), table.table("source"), 1000.0);
}

} // namespace

TEST(Photon_scenario_examples, AllLoad) {
    int count = 0;
    for (const auto &entry : std::filesystem::directory_iterator(source_directory / "sim" / "scenarios" / "photon")) {
        if (entry.path().extension() == ".toml") {
            Photon_scenario const scenario = load_photon_scenario(entry.path(), source_directory, {});
            EXPECT_GT(scenario.sample(scenario.bands.front(), true).shapes.size(), 0U) << entry.path();
            EXPECT_EQ(scenario.sample(scenario.bands.front(), false).shapes.size(), 0U) << entry.path();
            EXPECT_EQ(scenario.receiver.radius_mm, 1020.0) << entry.path();
            ++count;
        }
    }
    EXPECT_GE(count, 12);
}

// From file to photons: balance without loss, and the mirror's answer through the whole chain.
TEST(Photon_scenario_examples, MirrorReturnsItsShare) {
    Photon_scenario const scenario =
        load_photon_scenario(source_directory / "sim" / "scenarios" / "photon" / "mirror.toml", source_directory, {});
    Virtual_goniophotometer const instrument(scenario, scenario.bands.front(), {30.0, 0.0}, true);
    Watch watch;
    double const theta = 30.0 * std::numbers::pi / 180.0;
    std::vector<Vector> const directions = {{-std::sin(theta), 0.0, std::cos(theta)}};
    std::uint64_t const photons = 2000;
    auto const sums = instrument.read(directions, 0.03, {0, photons}, 1, watch);
    EXPECT_EQ(sums.balance.lost, 0);
    EXPECT_EQ(sums.apertures.hits.front(), photons);
    EXPECT_NEAR(static_cast<double>(sums.apertures.weight.front()) * weight_unit / static_cast<double>(photons), 0.9,
                1e-6);
}

TEST_F(Photon_scenario_file, KeysLandWhereTheyBelong) {
    write("other.toml",
          "[instrument]\nname = \"x\"\narm_radius_mm = 700.0\ndetector_aperture_mm = 8.0\nhead_diameter_mm = 1.0\n");
    Photon_scenario const scenario = load("seed = 7\ninstrument = \"other.toml\"\n" + mirror + R"(
[[band]]
name = "visible"
wavelength_nm = 555.0
[[band]]
name = "nir"
wavelength_nm = 1000.0
[photons]
count = 5000
relative_error = 0.02
most_photons = 900000
low_discrepancy = true
polarised = true
roulette_below = 0.1
most_interactions = 77
[readings]
incident = [[45, 90.0], [60.5, 0]]
step_deg = 4.0
acceptance_deg = 10.0
estimator = "nearest"
bandwidth = 200
[rig]
holder = { opening_mm = 50.0 }
[detector]
dark_counts = [1.0, 2.0]
[beam]
power_counts = 1000.0
)");
    EXPECT_EQ(scenario.trace.seed, 7U);
    EXPECT_EQ(scenario.receiver.radius_mm, 700.0);
    EXPECT_EQ(scenario.trace.receiver_radius_mm, 700.0);
    EXPECT_EQ(scenario.receiver.aperture_mm, 8.0);
    EXPECT_EQ(scenario.photons, 5000U);
    EXPECT_EQ(scenario.relative_error, 0.02);
    EXPECT_EQ(scenario.most_photons, 900000U);
    EXPECT_TRUE(scenario.trace.low_discrepancy);
    EXPECT_TRUE(scenario.trace.polarised);
    EXPECT_EQ(scenario.trace.roulette_below, 0.1);
    EXPECT_EQ(scenario.trace.most_interactions, 77U);
    ASSERT_EQ(scenario.incidents.size(), 2U);
    EXPECT_EQ(scenario.incidents[0].theta_deg, 45.0);
    EXPECT_EQ(scenario.incidents[0].phi_deg, 90.0);
    EXPECT_EQ(scenario.incidents[1].theta_deg, 60.5);
    EXPECT_EQ(scenario.direction_step_deg, 4.0);
    EXPECT_EQ(scenario.receiver.acceptance_deg, 10.0);
    EXPECT_EQ(scenario.receiver.estimator, Estimator::nearest);
    EXPECT_EQ(scenario.receiver.bandwidth, 200U);
    ASSERT_EQ(scenario.bands.size(), 2U);
    EXPECT_EQ(scenario.bands[1].name, "nir");
    EXPECT_EQ(scenario.bands[1].wavelength_nm, 1000.0);
    // A mirror and the holder's four surfaces; the mirror is the band's own.
    Sample_model const sample = scenario.sample(scenario.bands[1], true);
    EXPECT_EQ(sample.shapes.size(), 5U);
    EXPECT_EQ(sample.materials.front()->albedo({{0.0, 0.0, 1.0}, true, {}}).reflectance, 0.5);
}

TEST_F(Photon_scenario_file, DefaultsAreTheReferenceInstrument) {
    Photon_scenario const scenario = load("[sample]\nkind = \"mirror\"\nreflectance = 1.0\n");
    EXPECT_EQ(scenario.receiver.radius_mm, 1020.0);
    EXPECT_EQ(scenario.receiver.aperture_mm, 10.0);
    ASSERT_EQ(scenario.bands.size(), 1U);
    EXPECT_EQ(scenario.bands[0].name, "visible");
    EXPECT_EQ(scenario.bands[0].wavelength_nm, 550.0);
    EXPECT_EQ(scenario.incidents.size(), 1U);
    EXPECT_EQ(scenario.receiver.estimator, Estimator::fixed);
}

TEST_F(Photon_scenario_file, WrongOnesAreRefused) {
    auto const says = [&](const std::string &text, const std::string &part) {
        std::string const message = told(text);
        EXPECT_NE(message.find(part), std::string::npos) << message;
        EXPECT_EQ(message.find('\n'), std::string::npos) << message;
    };
    std::string const plain = "[sample]\nkind = \"mirror\"\nreflectance = 0.9\n";
    says(plain + "[photon]\ncount = 1", "'photon'");
    says(plain + "[photons]\nnumber = 1", "'number'");
    says(plain + "[photons]\ncount = 0", "at least 1");
    says(plain + "[photons]\nmost_photons = 10", "relative_error");
    says(plain + "[readings]\nincident = [45, 90]", "[theta, phi]");
    says(plain + "[readings]\nincident = [[-1.0, 0.0]]", "theta from 0 to 180");
    says(plain + "[readings]\nestimator = \"best\"", "nearest");
    says(plain + "[readings]\nbandwidth = 10", "estimator");
    says(plain + "[rig]\nhodler = 1", "'hodler'");
    says(plain + "[beam]\ndivergence_deg = 2.0", "opening_angle_deg");
    says(plain + "[beam]\nkind = \"focused\"\n[source]\nopening_angle_deg = 2.0", "'opening_angle_deg'");
    says(plain + "[beam]\ndiameter_mm = 0.0", "above 0");
    says(plain + "[source]\nstray_share = 1.5", "[source]");
    says(plain + "[[band]]\nname = \"a\"\n[[band]]\nname = \"a\"", "twice");
    says(mirror + "[[band]]\nname = \"green\"", "'green'");
    says("instrument = \"none.toml\"\n" + plain, "no such file");
    says("[sample]\ncomponents = []", "'kind'");
    says(plain + "[photons]\ncount = 1000000000001", "at most");
    says(plain + "size_mm = inf", "finite");
    says(plain + "[beam]\ndiameter_mm = 5000.0", "arm's radius");
    says(plain + "[photons]\nlow_discrepancy = 1", "true or false");
    says(plain + "[source]\npolarisation_deg = 45.0", "'polarised' must be true");
    says(plain + "[beam]\nkind = \"focused\"\nedge_deg = 2.0", "[beam] and [source]: edge_deg");
    says(plain + "[readings]\nstep_deg = 0.0", "from 0.05 to 45");
    says(plain + "[materials.spare]\nkind = \"black\"", "'spare' is a material that nothing uses");
}

TEST(Photon_scenario_beam, CollimatedAndFocused) {
    Source_settings const wide = beam("[beam]\ndiameter_mm = 70.0\nedge_deg = 0.2\n[source]\nopening_angle_deg = 0.3\n"
                                      "stop_distance_mm = 1800.0\nlamp_distance_mm = 5000.0\npolarisation_deg = 90.0");
    EXPECT_EQ(wide.kind, Beam_kind::collimated);
    EXPECT_EQ(wide.diameter_mm, 70.0);
    // An edge of 0.2 degrees as seen from 1000 mm.
    EXPECT_NEAR(wide.diameter_edge_mm, 3.4907, 1e-4);
    EXPECT_EQ(wide.opening_angle_deg, 0.3);
    EXPECT_EQ(wide.edge_deg, 0.0);
    EXPECT_EQ(wide.stop_distance_mm, 1800.0);
    EXPECT_EQ(wide.lamp_distance_mm, 5000.0);
    EXPECT_NEAR(wide.stokes.q, -1.0, 1e-12);

    Source_settings const narrow = beam("[beam]\nkind = \"focused\"\ndivergence_deg = 2.0\nedge_deg = 0.3\n[source]\n"
                                        "stray_share = 0.01\nstray_half_angle_deg = 20.0\nstokes = [0.1, 0.2, 0.3]");
    EXPECT_EQ(narrow.kind, Beam_kind::focused);
    EXPECT_EQ(narrow.diameter_mm, 10.0);
    EXPECT_EQ(narrow.opening_angle_deg, 2.0);
    EXPECT_EQ(narrow.edge_deg, 0.3);
    EXPECT_EQ(narrow.diameter_edge_mm, 0.0);
    EXPECT_EQ(narrow.stray_share, 0.01);
    EXPECT_EQ(narrow.stray_half_angle_deg, 20.0);
    EXPECT_EQ(narrow.stokes.v, 0.3);
}

TEST(Photon_scenario_beam, LampProfiles) {
    Source_settings const radial =
        beam("[[source.radial]]\nangle_deg = 0.0\nrelative = 1.0\n[[source.radial]]\nangle_deg = 1.5\nrelative = 0.0");
    ASSERT_EQ(radial.radial.size(), 2U);
    EXPECT_EQ(radial.radial[1].angle_deg, 1.5);
    Source_settings const filament = beam("[[source.filament]]\nx_deg = 0.5\nwidth_deg = 0.2\nheight_deg = 1.0\n"
                                          "weight = 2.0\ngaussian = true");
    ASSERT_EQ(filament.filament.size(), 1U);
    EXPECT_EQ(filament.filament[0].x_deg, 0.5);
    EXPECT_EQ(filament.filament[0].weight, 2.0);
    EXPECT_TRUE(filament.filament[0].gaussian);
}
