// test_apertures.cpp: streamed, batched and mapped sums are those of counting hit by hit, to the last bit.
#include <algorithm>
#include <thread>

#include <gtest/gtest.h>

#include "batched_readings.hpp"
#include "direction_index.hpp"
#include "drawn_hits.hpp"
#include "hit_map.hpp"

namespace gonio::sim {

namespace {

// Evenly spread light, peaks of every width, a beam within a point, the poles, the seams of the cube.
std::vector<Receiver_hit> mixed_hits() {
    std::vector<Receiver_hit> hits;
    std::vector<Vector> const peaks = {{0.0, 0.0, 1.0},          {0.0, 0.0, -1.0},          {-1.0, 0.0, 0.0},
                                       unit({1.0, 1.0, 1.0}),    unit({1.0, 0.0, -1.0}),    at_angles(0.8, 0.0),
                                       at_angles(1.3, 3.141592), at_angles(1.570796, 1e-9), at_angles(2.0, 5.0)};
    for (std::uint64_t i = 0; i < 12000; ++i) {
        Photon_random random(5, i);
        double const weight = 2.0 * random.uniform() * random.uniform();
        hits.push_back(radial_hit(anywhere(random), weight));
        if (i < 6000) {
            const Vector &axis = peaks[i % peaks.size()];
            hits.push_back(radial_hit(in_lobe(axis, std::pow(10.0, 2.0 + 10.0 * random.uniform()), random), weight));
        }
        if (i < 300) {
            hits.push_back(radial_hit(peaks[i % 3], weight));
        }
    }
    return hits;
}

std::vector<Vector> mixed_directions() {
    std::vector<Vector> directions = spread_directions(40);
    for (double const theta : {0.0, 1e-7, 0.01, 45.0, 54.7356, 89.9, 90.0, 90.1, 179.99, 180.0}) {
        for (double const phi : {0.0, 45.0, 179.999, 180.0, 359.9999}) {
            directions.push_back(at_angles(theta * degree, phi * degree));
        }
    }
    directions.push_back(directions.front()); // asked twice
    return directions;
}

Aperture_sums counted(const std::vector<Receiver_hit> &hits, const std::vector<Vector> &directions, double half_angle) {
    Half_angle const angle(half_angle);
    Aperture_sums sums(directions.size());
    for (const Receiver_hit &hit : hits) {
        Place const place = place_of(hit.place);
        for (std::size_t i = 0; i < directions.size(); ++i) {
            if (holds(on_face(directions[i], angle, face_of(place)), face_coordinate(place.u),
                      face_coordinate(place.v))) {
                sums.add(i, {hit.weight, whole_square(hit.weight), 1});
            }
        }
    }
    return sums;
}

void expect_same(const Aperture_sums &a, const Aperture_sums &b) {
    EXPECT_EQ(a.weight, b.weight);
    EXPECT_EQ(a.square, b.square);
    EXPECT_EQ(a.hits, b.hits);
}

// Three threads take hits in turns.
void stream(Hit_sink &sink, std::span<const Receiver_hit> hits) {
    std::vector<std::jthread> workers;
    for (unsigned worker = 0; worker < 3; ++worker) {
        workers.emplace_back([&sink, hits, worker] {
            std::size_t const at_once = 100;
            for (std::size_t i = worker * at_once; i < hits.size(); i += 3 * at_once) {
                sink.take(hits.subspan(i, std::min(at_once, hits.size() - i)), worker);
            }
        });
    }
}

constexpr double all_arrives = std::numbers::pi;

} // namespace

TEST(Apertures, EqualCountingHitByHit) {
    std::vector<Receiver_hit> const hits = mixed_hits();
    std::vector<Vector> const directions = mixed_directions();
    Hit_map const map(stored(hits), hits.size(), 2);
    for (double const aperture_deg : {0.01, 0.1, 0.56, 4.0, 20.0, 60.0, 100.0, 180.0, 230.0, 360.0}) {
        SCOPED_TRACE(aperture_deg);
        double const half_angle = 0.5 * aperture_deg * degree;
        Aperture_sums const truth = counted(hits, directions, half_angle);
        expect_same(map.sums(directions, half_angle, 1), truth);
        Direction_index index(directions, half_angle, all_arrives, 3);
        stream(index, hits);
        expect_same(index.sums(), truth);
        Batched_readings batched(directions, half_angle, all_arrives, 3, 9000);
        stream(batched, hits);
        expect_same(batched.sums(), truth);
    }
}

TEST(Apertures, AWholeSphereHoldsEverything) {
    std::vector<Receiver_hit> const hits = mixed_hits();
    std::vector<Vector> const directions = {{0.0, 0.0, 1.0}, at_angles(1.0, 2.0)};
    Aperture_sums const sums = Hit_map(stored(hits), hits.size()).sums(directions, std::numbers::pi, 1);
    EXPECT_EQ(sums.hits, (std::vector<std::uint64_t>(2, hits.size())));
}

TEST(Apertures, DoNotDependOnThreadsOrTheOrderOfHits) {
    std::vector<Receiver_hit> hits = mixed_hits();
    std::vector<Vector> const directions = spread_directions(700);
    Aperture_sums const truth = Hit_map(stored(hits), 1).sums(directions, 3.0 * degree, 1);
    std::reverse(hits.begin(), hits.end());
    expect_same(Hit_map(stored(hits), 1, 3).sums(directions, 3.0 * degree, 3), truth);
}

TEST(Apertures, OneCrowdedPointIsRead) {
    Vector const point = at_angles(0.7, 0.3);
    std::vector<Receiver_hit> const hits(5000, radial_hit(point, 1.0));
    Hit_map const map(stored(hits), hits.size());
    Aperture_sums const sums = map.sums(std::vector<Vector>{point, at_angles(0.7001, 0.3)}, 5e-5, 1);
    EXPECT_EQ(sums.hits, (std::vector<std::uint64_t>{5000, 0}));
}

TEST(Apertures, NoHitsAndNoDirections) {
    std::vector<Vector> const directions = spread_directions(5);
    Hit_map const map({}, 1000, 2);
    EXPECT_EQ(map.sums(directions, 0.1, 2).hits, std::vector<std::uint64_t>(5, 0));
    EXPECT_EQ(map.fixed(directions[0], 0.1).dsf_per_sr, 0.0);
    EXPECT_EQ(map.nearest(directions[0], 10, 0.1).dsf_per_sr, 0.0);
    Direction_index index({}, 0.1, all_arrives, 2);
    index.take(mixed_hits(), 1);
    EXPECT_EQ(index.sums().size(), 0U);
}

TEST(Apertures, StreamingKeepsNoHits) {
    std::vector<Vector> const directions = spread_directions(2000, 0.0);
    Direction_index index(directions, 1.0 * degree, all_arrives, 1);
    Hit_store store(all_arrives, 1);
    std::size_t const before = index.bytes();
    std::vector<Receiver_hit> hits;
    for (std::uint64_t i = 0; i < 700000; ++i) { // more than wait at a time
        Photon_random random(6, i);
        double const u = random.uniform();
        Vector const place = unit({u - 0.5, random.uniform() - 0.5, 0.4});
        hits.push_back(radial_hit(place, u));
        if (hits.size() == 50000) {
            index.take(hits, 0);
            store.take(hits, 0);
            hits.clear();
        }
    }
    EXPECT_EQ(index.bytes(), before);
    expect_same(index.sums(), Hit_map(store.release(), 1).sums(directions, 1.0 * degree, 1));
    expect_same(index.sums(), index.sums());
}

TEST(Apertures, LightBeyondTheAcceptanceIsNotSeen) {
    std::vector<Vector> const directions = {{0.0, 0.0, 1.0}};
    std::vector<Receiver_hit> hits;
    for (double const arrival_deg : {0.0, 9.9, 10.1, 60.0, 89.0}) {
        hits.push_back({directions[0], at_angles(arrival_deg * degree, 1.0), whole_weight(1.0)});
    }
    for (auto const &[acceptance_deg, seen] : {std::pair{10.0, 2U}, {70.0, 4U}, {90.0, 5U}, {180.0, 5U}}) {
        Direction_index index(directions, 0.01, acceptance_deg * degree, 1);
        index.take(hits, 0);
        EXPECT_EQ(index.sums().hits[0], seen);
        Batched_readings batched(directions, 0.01, acceptance_deg * degree, 1);
        batched.take(hits, 0);
        EXPECT_EQ(batched.sums().hits[0], seen);
        Hit_store store(acceptance_deg * degree, 1);
        store.take(hits, 0);
        EXPECT_EQ(store.release().size(), seen);
        EXPECT_EQ(store.release().size(), 0U);
    }
}

} // namespace gonio::sim
