// test_same_bits.cpp: the result does not depend on how it is computed: walk, threads, pieces, stored or streamed.
#include <gtest/gtest.h>

#include <array>

#include "written_scenario.hpp"

namespace gonio::sim::test {
namespace {

constexpr std::uint64_t photons = 30000;
constexpr double half_angle = 0.1;

std::vector<Vector> directions() {
    std::vector<Vector> list;
    for (int theta = 0; theta <= 180; theta += 10) {
        for (int phi = 0; phi < 360; phi += 30) {
            list.push_back(direction(theta, phi));
        }
    }
    return list;
}

bool same(const Balance &a, const Balance &b) {
    return a.photons == b.photons && a.emitted == b.emitted && a.stored == b.stored && a.absorbed == b.absorbed &&
           a.lost == b.lost && a.roulette == b.roulette;
}

void expect_same(const Virtual_goniophotometer::Sums &a, const Virtual_goniophotometer::Sums &b) {
    EXPECT_EQ(a.apertures.weight, b.apertures.weight);
    EXPECT_EQ(a.apertures.square, b.apertures.square);
    EXPECT_EQ(a.apertures.hits, b.apertures.hits);
    EXPECT_TRUE(same(a.balance, b.balance));
}

Virtual_goniophotometer::Sums read(const Virtual_goniophotometer &twin, const Photon_range &range, unsigned threads) {
    Watch watch;
    return twin.read(directions(), half_angle, range, threads, watch);
}

const std::string mirror = "kind = \"metal\"\nreflectance = 0.9\nspecularity = 1.0";
const std::string paint = "kind = \"plastic\"\nreflectance = 0.8\nspecularity = 0.04\nroughness = 0.1";

class Same_bits : public testing::TestWithParam<std::string> {};

TEST_P(Same_bits, by_either_walk_for_any_threads_and_pieces) {
    Photon_scenario const scenario = written_scenario(GetParam());
    ASSERT_TRUE(scenario.sample(scenario.bands.front(), true).slats);
    Virtual_goniophotometer const fast = at(scenario, 45.0, 80.0);
    Virtual_goniophotometer::Sums const whole = read(fast, {0, photons}, 1);
    EXPECT_GT(whole.balance.stored, 0);
    expect_same(read(at(scenario, 45.0, 80.0, Walk::embree), {0, photons}, 1), whole);
    expect_same(read(fast, {0, photons}, 3), whole);
    Virtual_goniophotometer::Sums pieces = read(fast, {0, 7}, 1);
    for (Photon_range const piece : {Photon_range{7, 12345}, Photon_range{12352, photons - 12352}}) {
        Virtual_goniophotometer::Sums const more = read(fast, piece, 2);
        pieces.apertures += more.apertures;
        pieces.balance += more.balance;
    }
    expect_same(pieces, whole);
}

INSTANTIATE_TEST_SUITE_P(
    Slats, Same_bits,
    testing::Values(louver(mirror, paint), louver(mirror, paint, "tilt_deg = 4.0\noffset_mm = 1.25\ncount = 20"),
                    louver(mirror, paint, "shelf_sagitta_mm = 0.0\nretro_sagitta_mm = -1.0\napex_offset_mm = 0.3"),
                    louver(mirror, paint) + "[photons]\nlow_discrepancy = true\n",
                    louver("kind = \"mirror\"\nreflectance_s = 0.9\nreflectance_p = 0.8", paint) +
                        "[photons]\npolarised = true\n"));

TEST(Stored_map, reads_what_streamed_photons_read) {
    Photon_scenario const scenario = written_scenario(louver(mirror, paint));
    Virtual_goniophotometer const twin = at(scenario, 45.0, 80.0);
    Virtual_goniophotometer::Sums const streamed = read(twin, {0, photons}, 2);
    Watch watch;
    Virtual_goniophotometer::Stored const stored = twin.store({0, photons}, 2, watch);
    EXPECT_TRUE(same(stored.balance, streamed.balance));
    Aperture_sums const sums = stored.map.sums(directions(), half_angle, 2);
    EXPECT_EQ(sums.weight, streamed.apertures.weight);
    EXPECT_EQ(sums.hits, streamed.apertures.hits);
}

TEST(Watch_of_a_run, counts_photons_and_ends_it) {
    Photon_scenario const scenario = written_scenario(louver(mirror, paint));
    Virtual_goniophotometer const twin = at(scenario, 45.0, 80.0);
    Watch watch;
    static_cast<void>(twin.read(directions(), half_angle, {0, photons}, 2, watch));
    EXPECT_EQ(watch.photons.load(), photons);
    watch.cancelled = true;
    EXPECT_LT(twin.read(directions(), half_angle, {0, 100000000}, 2, watch).balance.photons, 100000000U);
}

} // namespace
} // namespace gonio::sim::test
