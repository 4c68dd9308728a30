// test_scenario.cpp: every scenario of the repository loads; a wrong one is refused in one line that names key and
// file.
#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>

#include "scenario.hpp"
#include "toml_table.hpp"

namespace gonio::sim {
namespace {

std::filesystem::path const scenarios = GONIO_SOURCE_DIR "/sim/scenarios";

Scenario load_text(const std::string &text) {
    std::filesystem::path const path = std::filesystem::path(testing::TempDir()) / "scenario_under_test.toml";
    std::ofstream(path) << text;
    return load_scenario(path, GONIO_SOURCE_DIR);
}

std::string refusal(const std::string &text) {
    try {
        load_text(text);
    } catch (const Input_error &error) {
        return error.what();
    }
    return "";
}

} // namespace

TEST(Scenario, AllOfTheRepositoryLoad) {
    int loaded = 0;
    for (const auto &entry : std::filesystem::recursive_directory_iterator(scenarios)) {
        bool const scenario = entry.path().extension() == ".toml";
        if (scenario && entry.path().filename().string().find("-axes") == std::string::npos) {
            EXPECT_NO_THROW(load_scenario(entry.path(), GONIO_SOURCE_DIR)) << entry.path();
            ++loaded;
        }
    }
    EXPECT_GE(loaded, 10);
}

TEST(Scenario, UnknownKeysAreRefusedByName) {
    for (const std::string text : {"colour = 3", "[sample]\nname = \"x\"", "[beam]\ndiametre_mm = 3",
                                   "[sample]\ncomponents = [{ kind = \"lambertian\", albedo = 0.5 }]",
                                   "[[fault]]\nkind = \"sync_lost\"\nwhen_s = 1"}) {
        std::string const said = refusal(text);
        EXPECT_NE(said.find("scenario_under_test.toml"), std::string::npos) << said;
        EXPECT_EQ(said.find('\n'), std::string::npos);
        EXPECT_NE(said.find("is not a key"), std::string::npos) << said;
    }
    EXPECT_NE(refusal("[beam]\ndiametre_mm = 3").find("diametre_mm"), std::string::npos);
}

TEST(Scenario, ImpossibleValuesAreRefused) {
    for (const std::string text :
         {"[beam]\nkind = \"wide\"", "[beam]\ndivergence_deg = 0.5\nedge_deg = 0.6", "[beam]\ndiameter_mm = \"big\"",
          "[sample]\ncomponents = [{ kind = \"gaussian\", about = \"up\", sigma_deg = 1 }]",
          "[sample]\ncomponents = [{ kind = \"gaussian\", about = \"mirror\" }]", "[drives]\nlatch_delay_us = [1, 2]",
          "[drives]\npersonality = [\"full\", \"full\", \"odd\", \"full\"]", "[[fault]]\nkind = \"earthquake\"",
          "[[fault]]\nkind = \"emcy\"\naxis = 4", "[timing]\nsync_jitter_us = -1",
          "seed = ", "instrument = \"nowhere.toml\""}) {
        std::string const said = refusal(text);
        EXPECT_NE(said.find(".toml"), std::string::npos) << text;
        EXPECT_EQ(said.find('\n'), std::string::npos) << said;
    }
}

TEST(Scenario, ValuesArrive) {
    Scenario const s = load_scenario(scenarios / "pairing.toml", GONIO_SOURCE_DIR);
    EXPECT_EQ(s.instrument.name, "reference goniophotometer, delays calibrated");
    EXPECT_DOUBLE_EQ(s.timing.sync_jitter_us, 120.0);
    EXPECT_DOUBLE_EQ(s.high_delay_us, 180.0);
    EXPECT_DOUBLE_EQ(s.drives.latch_delay_us.at(2), 70.0);
    EXPECT_EQ(s.drives.personality.at(3), "full");
    ASSERT_EQ(s.sample.lobes.size(), 1U);
    EXPECT_DOUBLE_EQ(s.sample.lobes.front().sigma_deg, 1.2);
    Scenario const losses = load_scenario(scenarios / "fault_losses.toml", GONIO_SOURCE_DIR);
    EXPECT_EQ(losses.faults.size(), 8U);
}

// A sample with a kind is the photon map's: its tables are left to their own reader, all others are read as ever.
TEST(Scenario, PhotonMapsTablesAreLeftToItsReader) {
    std::string const text = "[sample]\nkind = \"lambertian\"\nmaterial = \"white\"\nmounted = false\n"
                             "[materials.white]\nkind = \"lambertian\"\n[source]\nopening_angle_deg = 0.5\n"
                             "[[band]]\nname = \"visible\"\n[photons]\ncount = 1\n[readings]\nstep_deg = 2\n"
                             "[rig]\n[beam]\npower_counts = 7.0\n[detector]\nband = \"visible\"\n";
    Scenario const s = load_text(text + "map_memory_mib = 64\nincident_tolerance_deg = 0.1");
    EXPECT_TRUE(s.photon_map.wanted);
    EXPECT_FALSE(s.sample_mounted);
    EXPECT_DOUBLE_EQ(s.power_counts, 7.0);
    EXPECT_EQ(s.photon_map.band, "visible");
    EXPECT_DOUBLE_EQ(s.photon_map.memory_mib, 64.0);
    EXPECT_DOUBLE_EQ(s.photon_map.incident_tolerance_deg, 0.1);
    EXPECT_NE(refusal(text + "map_memory = 64").find("map_memory"), std::string::npos);
    EXPECT_NE(refusal(text + "map_memory_mib = 0").find("map_memory_mib"), std::string::npos);
    EXPECT_NE(refusal(text + "[sauce]").find("sauce"), std::string::npos);
    EXPECT_FALSE(load_text("seed = 1").photon_map.wanted);
    for (const std::string closed : {"[materials.white]", "[photons]", "[detector]\nmap_memory_mib = 64"}) {
        EXPECT_NE(refusal(closed).find("is not a key"), std::string::npos) << closed;
    }
}

// A collimated beam looks as wide as its diameter seen from the detector.
TEST(Scenario, CollimatedBeamsWidthIsItsDiameter) {
    Scenario const s = load_text("[beam]\nkind = \"collimated\"\ndiameter_mm = 65.0");
    EXPECT_NEAR(s.beam.full_width_rad, 2.0 * std::atan(32.5 / 1020.0), 1e-12);
    EXPECT_DOUBLE_EQ(s.beam_diameter_at_head_mm, 65.0);
}

TEST(Scenario, WiringAndTestPatternAreRead) {
    Scenario const plain = load_text("");
    EXPECT_FALSE(plain.counter_pattern);
    EXPECT_EQ(plain.drives.inverted, (std::array<bool, axis_count>{}));
    Scenario const odd =
        load_text("[digitiser]\npattern = \"counter\"\n[drives]\ninverted = [false, true, false, false]");
    EXPECT_TRUE(odd.counter_pattern);
    EXPECT_EQ(odd.drives.inverted, (std::array<bool, axis_count>{false, true, false, false}));
    EXPECT_NE(refusal("[digitiser]\npattern = \"stripes\"").find("light or counter"), std::string::npos);
    EXPECT_NE(refusal("[drives]\ninverted = [true]").find("4 times"), std::string::npos);
    EXPECT_TRUE(plain.drives.without.empty());
    Scenario const poor = load_text("[drives]\nwithout = [\"0x1400:05\", \"0x6007\"]");
    ASSERT_EQ(poor.drives.without.size(), 2U);
    EXPECT_EQ(object_text(poor.drives.without.front()), "0x1400:05");
    EXPECT_EQ(object_text(poor.drives.without.back()), "0x6007");
    EXPECT_NE(refusal("[drives]\nwithout = [\"deadline\"]").find("deadline"), std::string::npos);
}

} // namespace gonio::sim
