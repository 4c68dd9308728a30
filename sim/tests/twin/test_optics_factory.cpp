// test_optics_factory.cpp: a scenario's optics reach the world through their factory, and learn there what a photon map
// needs to know.
#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "bench_host.hpp"
#include "journal.hpp"
#include "toml_table.hpp"
#include "world.hpp"

namespace gonio::sim {
namespace {

constexpr std::int64_t longest_ns = 600000000000;

// Remembers what it was asked.
class Asked final : public Optics {
public:
    explicit Asked(std::vector<Reading> &readings) : readings_(readings) {}
    [[nodiscard]] double apparent_dsf_per_sr(const Reading &reading) const override {
        readings_.push_back(reading);
        return 0.25;
    }
    [[nodiscard]] std::string account() const override { return std::to_string(readings_.size()) + " asked"; }

private:
    std::vector<Reading> &readings_;
};

Scenario scenario_of(const std::string &name) {
    return load_scenario(GONIO_SOURCE_DIR "/sim/scenarios/" + name + ".toml", GONIO_SOURCE_DIR);
}

} // namespace

TEST(Optics_factory, TheWorldAsksTheOpticsOfItsFactory) {
    std::vector<Reading> readings;
    Scenario const scenario = scenario_of("lambertian");
    Bench_host host(scenario.instrument, 3000);
    World world(scenario, host, {}, [&](const Scenario &wanted) {
        EXPECT_EQ(wanted.path, scenario.path);
        return std::make_unique<Asked>(readings);
    });
    host.connect(world);
    while (!host.finished() && world.scheduler().run_one(longest_ns)) {
    }
    ASSERT_EQ(host.result().trouble, "");
    ASSERT_GT(readings.size(), 3000U);
    // The flight turns the sample all the time but for its ends.
    std::size_t turning = 0;
    for (const Reading &reading : readings) {
        turning += reading.sample_turning ? 1 : 0;
        EXPECT_NEAR(reading.lab_up[2], 0.0, 1e-12) << "the reference instrument rolls before it turns";
        EXPECT_NEAR(reading.lab_up[0] * reading.incident[0] + reading.lab_up[1] * reading.incident[1], 0.0, 1e-12);
    }
    EXPECT_GT(turning, 2000U);
    EXPECT_LT(turning, readings.size()) << "it stood before the flight began";

    std::filesystem::path const path = std::filesystem::path(testing::TempDir()) / "optics_journal.json";
    write_journal(path, world, "test", 0.0);
    std::ifstream file(path);
    std::string const text{std::istreambuf_iterator<char>(file), {}};
    EXPECT_NE(text.find("\"optics\": \"" + std::to_string(readings.size()) + " asked\""), std::string::npos) << text;
}

TEST(Optics_factory, AProgramWithoutPhotonMapSaysSoInOneLine) {
    Scenario scenario = scenario_of("lambertian");
    scenario.photon_map.wanted = true;
    try {
        closed_form_optics(scenario);
        FAIL() << "there is no closed form to answer";
    } catch (const Input_error &error) {
        std::string const said = error.what();
        EXPECT_NE(said.find("lambertian.toml"), std::string::npos) << said;
        EXPECT_NE(said.find("GONIO_EMBREE=ON"), std::string::npos) << said;
        EXPECT_EQ(said.find('\n'), std::string::npos) << said;
    }
}

} // namespace gonio::sim
