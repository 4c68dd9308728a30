// test_balance.cpp: no power is lost or made, whatever threads and ranges share the work.
#include <stdexcept>

#include <gtest/gtest.h>

#include "fakes.hpp"

namespace gonio::sim {
namespace {

using namespace fakes;

// Two grey plates that face each other, the upper lets light in from above, before a clear slanted plane: many bounces,
// some ways out.
struct Plates {
    Planes scene{{{.point = {0.0, 0.0, 0.0}, .radius_mm = 10.0},
                  {.point = {0.0, 0.0, 4.0}, .normal = {0.0, 0.0, -1.0}, .radius_mm = 9.0},
                  {.point = {0.0, 0.0, 5.0}, .normal = {0.6, 0.0, 0.8}, .tangent = {0.8, 0.0, -0.6}}}};
    Matt bright{0.9};
    Matt grey{0.6};
    Veil half{0.5};
    Veil clear{};
    std::array<Surface, 3> surfaces{both_sides(bright), {&grey, &half}, both_sides(clear)};
    Shower source{18.0};

    Balance trace(const Trace_settings &settings, const Photon_range &range, unsigned threads, Tally &tally) const {
        Watch watch;
        Tracer const tracer(scene, surfaces, source, same_axes, settings);
        Balance const balance = tracer.trace(range, threads, tally, watch);
        EXPECT_EQ(watch.photons, range.count);
        return balance;
    }
};

void expect_same(const Balance &a, const Balance &b) {
    EXPECT_EQ(a.photons, b.photons);
    EXPECT_EQ(a.emitted, b.emitted);
    EXPECT_EQ(a.stored, b.stored);
    EXPECT_EQ(a.absorbed, b.absorbed);
    EXPECT_EQ(a.lost, b.lost);
    EXPECT_EQ(a.roulette, b.roulette);
}

TEST(Balance, is_exact_and_nothing_is_lost) {
    Plates const plates;
    for (bool const polarised : {false, true}) {
        Tally tally;
        Balance const balance = plates.trace({.polarised = polarised}, {0, 30000}, 1, tally);
        EXPECT_EQ(balance.photons, 30000U);
        EXPECT_EQ(balance.emitted, 30000 * static_cast<std::int64_t>(whole));
        EXPECT_EQ(excess(balance), 0);
        EXPECT_EQ(balance.lost, 0);
        EXPECT_EQ(balance.stored, tally.weight());
        EXPECT_GT(balance.stored, 0);
        EXPECT_GT(balance.absorbed, 0);
        EXPECT_NE(balance.roulette, 0);
    }
}

TEST(Balance, same_bits_for_any_threads_and_ranges) {
    Plates const plates;
    constexpr std::uint64_t first = (1ULL << 32U) - 9000; // across the end of the 32-bit numbers
    for (bool const low_discrepancy : {false, true}) {
        Trace_settings const settings{.seed = 77, .low_discrepancy = low_discrepancy};
        Tally reference;
        Balance const whole_range = plates.trace(settings, {first, 20001}, 1, reference);
        for (unsigned const threads : {2U, 3U}) {
            Tally tally;
            expect_same(plates.trace(settings, {first, 20001}, threads, tally), whole_range);
            EXPECT_EQ(tally.hash(), reference.hash());
        }
        Tally pieces;
        Balance sum;
        std::uint64_t next = first;
        for (std::uint64_t const count : {1ULL, 4096ULL, 0ULL, 7ULL, 12345ULL, 3552ULL}) {
            sum += plates.trace(settings, {next, count}, 2, pieces);
            next += count;
        }
        expect_same(sum, whole_range);
        EXPECT_EQ(pieces.hash(), reference.hash());
    }
}

TEST(Balance, another_seed_is_another_run) {
    Plates const plates;
    Tally one;
    Tally two;
    plates.trace({.seed = 1}, {0, 1000}, 1, one);
    plates.trace({.seed = 2}, {0, 1000}, 1, two);
    EXPECT_NE(one.hash(), two.hash());
}

TEST(Balance, low_discrepancy_fills_the_source_evenly) {
    Planes const nothing({});
    Shower const source(100.0);
    Tracer const tracer(nothing, {}, source, same_axes, {.low_discrepancy = true});
    Tally tally;
    Watch watch;
    tracer.trace({0, 4096}, 1, tally, watch);
    std::array<int, 4> quadrants{};
    for (const Receiver_hit &hit : tally.hits()) {
        ++quadrants.at((hit.place.x > 0.0 ? 1U : 0U) + (hit.place.y > 0.0 ? 2U : 0U));
    }
    EXPECT_EQ(quadrants, (std::array<int, 4>{1024, 1024, 1024, 1024}));
}

// Half of the light of each meeting goes on with half of its weight, the rest comes back with half: between two such
// planes one photon leaves with weight 2^-k after k meetings with probability 2^-k, so 1/3 on average.
class Coin final : public Fake {
public:
    [[nodiscard]] Departure scatter(const Arrival &arrival, Photon_random &random) const override {
        double const side = random.uniform() < 0.5 ? 1.0 : -1.0;
        return {{0.0, 0.0, side * arrival.towards.z}, 0.5, {}};
    }
};

TEST(Balance, roulette_has_no_bias) {
    Planes const scene({{.point = {0.0, 0.0, 0.0}}, {.point = {0.0, 0.0, 1.0}}});
    Coin const coin;
    Veil const veil;
    // Light starts between the planes.
    std::array<Surface, 2> const surfaces{both_sides(coin), both_sides(coin)};
    Pencil const source({0.0, 0.0, 0.5}, {0.0, 0.0, -1.0});
    constexpr std::int64_t photons = 200000;
    for (double const limit : {0.0, 0.05, 0.4, 0.9}) {
        Tracer const tracer(scene, surfaces, source, same_axes, {.roulette_below = limit});
        Tally tally;
        Watch watch;
        Balance const balance = tracer.trace({0, photons}, 2, tally, watch);
        EXPECT_EQ(excess(balance), 0);
        EXPECT_EQ(balance.lost, 0);
        // A weight below 1 has a variance below its mean; so has each game of roulette.
        double const sigma = std::sqrt(photons / 3.0) * whole;
        EXPECT_NEAR(static_cast<double>(balance.stored), photons / 3.0 * whole, 4.0 * sigma) << limit;
        EXPECT_NEAR(static_cast<double>(balance.roulette), 0.0, 4.0 * std::sqrt(1.0 * photons) * whole) << limit;
        EXPECT_EQ(balance.roulette == 0, limit == 0.0);
        for (const Receiver_hit &hit : tally.hits()) {
            EXPECT_GE(hit.weight, limit * whole - 0.5);
        }
    }
}

// What a faulty material may send.
class Fault final : public Fake {
public:
    explicit Fault(const Departure &departure) : departure_(departure) {}
    [[nodiscard]] Departure scatter(const Arrival & /*arrival*/, Photon_random & /*random*/) const override {
        return departure_;
    }

private:
    Departure departure_;
};

TEST(Balance, faults_and_endless_walks_are_counted_as_lost) {
    double const none = std::nan("");
    Planes const scene({{.point = {0.0, 0.0, 0.0}}, {.point = {0.0, 0.0, 1.0}}});
    Pencil const source({0.0, 0.0, 0.5}, {0.0, 0.0, -1.0});
    Mirror const mirror;
    Fault const no_share({{0.0, 0.0, 1.0}, none, {}});
    Fault const negative({{0.0, 0.0, 1.0}, -0.5, {}});
    Fault const growing({{0.0, 0.0, 1.0}, 3.9, {}});
    Fault const no_direction({{none, 0.0, 1.0}, 1.0, {}});
    Fault const long_direction({{0.0, 0.0, 1.1}, 1.0, {}});
    for (const Material *material : std::initializer_list<const Material *>{&mirror, &no_share, &negative, &growing,
                                                                            &no_direction, &long_direction}) {
        std::array<Surface, 2> const surfaces{both_sides(*material), both_sides(*material)};
        Tracer const tracer(scene, surfaces, source, same_axes, {.most_interactions = 100});
        Tally tally;
        Watch watch;
        Balance const balance = tracer.trace({0, 10}, 1, tally, watch);
        EXPECT_EQ(balance.lost + balance.absorbed, balance.emitted);
        EXPECT_GE(balance.lost, balance.emitted);
        EXPECT_EQ(balance.stored, 0);
        EXPECT_EQ(excess(balance), 0);
    }
}

TEST(Balance, black_ends_a_photon_without_roulette) {
    Planes const scene({{.point = {0.0, 0.0, 0.0}}});
    Veil const black(0.0);
    std::array<Surface, 1> const surfaces{both_sides(black)};
    Pencil const source({0.0, 0.0, 0.5}, {0.0, 0.0, -1.0});
    Tracer const tracer(scene, surfaces, source, same_axes, {});
    Tally tally;
    Watch watch;
    Balance const balance = tracer.trace({0, 10}, 1, tally, watch);
    EXPECT_EQ(balance.absorbed, balance.emitted);
    EXPECT_EQ(balance.roulette, 0);
}

// Cancels, or fails, when the first hits arrive.
class Interrupter final : public Hit_sink {
public:
    Interrupter(Watch &watch, bool throws) : watch_(watch), throws_(throws) {}
    void take(std::span<const Receiver_hit> /*hits*/, unsigned /*worker*/) override {
        if (throws_) {
            throw std::runtime_error("no memory");
        }
        watch_.cancelled = true;
    }

private:
    Watch &watch_;
    bool throws_;
};

TEST(Balance, cancelled_run_accounts_for_what_it_traced) {
    Plates const plates;
    Watch watch;
    Interrupter sink(watch, false);
    Tracer const tracer(plates.scene, plates.surfaces, plates.source, same_axes, {});
    Balance const balance = tracer.trace({0, 1000000000000ULL}, 3, sink, watch);
    EXPECT_GT(balance.photons, 0U);
    EXPECT_EQ(balance.photons, watch.photons);
    EXPECT_EQ(balance.emitted, static_cast<std::int64_t>(balance.photons) << 24U);
    EXPECT_EQ(excess(balance), 0);
    EXPECT_EQ(balance.lost, 0);
}

TEST(Balance, failure_of_a_sink_stops_all_threads_and_reaches_the_caller) {
    Plates const plates;
    Watch watch;
    Interrupter sink(watch, true);
    Tracer const tracer(plates.scene, plates.surfaces, plates.source, same_axes, {});
    EXPECT_THROW(tracer.trace({0, 1000000000000ULL}, 3, sink, watch), std::runtime_error);
}

} // namespace
} // namespace gonio::sim
