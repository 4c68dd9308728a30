// fakes.hpp: planes, materials, sources and sinks that are simple enough to know what photons must do.
#pragma once

#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <utility>
#include <vector>

#include "tracer.hpp"

namespace gonio::sim::fakes {

inline const Frame same_axes{{1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}};

// A disc in a plane; infinite unless told.
struct Plane {
    Vector point;
    Vector normal{0.0, 0.0, 1.0};
    Vector tangent{1.0, 0.0, 0.0};
    double radius_mm = std::numeric_limits<double>::infinity();
};

// Each plane has the surface of its own number.
class Planes final : public Scene {
public:
    explicit Planes(std::vector<Plane> planes) : planes_(std::move(planes)) {}
    [[nodiscard]] bool closest(const Ray &ray, Hit &hit) const override {
        double nearest = std::numeric_limits<double>::infinity();
        for (std::uint32_t i = 0; i < planes_.size(); ++i) {
            Plane const &plane = planes_[i];
            double const distance = dot(plane.point - ray.origin, plane.normal) / dot(ray.direction, plane.normal);
            if (i != ray.from && distance > 0.0 && distance < nearest &&
                length(ray.origin + distance * ray.direction - plane.point) <= plane.radius_mm) {
                nearest = distance;
                hit = {distance, plane.normal, plane.tangent, i, i};
            }
        }
        return nearest < std::numeric_limits<double>::infinity();
    }

private:
    std::vector<Plane> planes_;
};

// What fakes do not say about themselves.
class Fake : public Material {
public:
    [[nodiscard]] double dsf_per_sr(const Arrival & /*arrival*/, const Vector & /*departing*/) const override {
        return 0.0;
    }
    [[nodiscard]] Albedo albedo(const Arrival & /*arrival*/) const override { return {0.0, 0.0}; }
};

class Matt final : public Fake {
public:
    explicit Matt(double reflectance) : reflectance_(reflectance) {}
    [[nodiscard]] Departure scatter(const Arrival & /*arrival*/, Photon_random &random) const override {
        double const square = random.uniform();
        double const turn = 2.0 * std::numbers::pi * random.uniform();
        double const sine = std::sqrt(square);
        return {{sine * std::cos(turn), sine * std::sin(turn), std::sqrt(1.0 - square)}, reflectance_, {}};
    }

private:
    double reflectance_;
};

class Mirror final : public Fake {
public:
    explicit Mirror(double share = 1.0) : share_(share) {}
    [[nodiscard]] Departure scatter(const Arrival &arrival, Photon_random & /*random*/) const override {
        Stokes const &light = arrival.stokes;
        return {{-arrival.towards.x, -arrival.towards.y, arrival.towards.z}, share_, {light.q, -light.u, -light.v}};
    }

private:
    double share_;
};

// Passes the light unchanged but for its share.
class Veil final : public Fake {
public:
    explicit Veil(double share = 1.0) : share_(share) {}
    [[nodiscard]] Departure scatter(const Arrival &arrival, Photon_random & /*random*/) const override {
        return {-arrival.towards, share_, arrival.stokes};
    }

private:
    double share_;
};

inline Surface both_sides(const Material &material) {
    return {&material, &material};
}

// All photons alike.
class Pencil final : public Source {
public:
    explicit Pencil(const Start &start) : start_(start) {}
    Pencil(const Vector &position, const Vector &direction) : start_{position, unit(direction), {}, {0.0, 1.0, 0.0}} {}
    [[nodiscard]] Start start(Photon_random & /*random*/) const override { return start_; }

private:
    Start start_;
};

// Straight down on a square about the axis.
class Shower final : public Source {
public:
    explicit Shower(double side_mm) : side_mm_(side_mm) {}
    [[nodiscard]] Start start(Photon_random &random) const override {
        double const x = side_mm_ * (random.uniform() - 0.5);
        double const y = side_mm_ * (random.uniform() - 0.5);
        return {{x, y, 500.0}, {0.0, 0.0, -1.0}, {}, {0.0, 1.0, 0.0}};
    }

private:
    double side_mm_;
};

// What arrived, as sums that do not depend on the order, and some of the hits.
class Tally final : public Hit_sink {
public:
    void take(std::span<const Receiver_hit> hits, unsigned worker) override {
        Part &part = parts_.at(worker);
        for (const Receiver_hit &hit : hits) {
            std::uint64_t bits = hit.weight;
            for (double const value :
                 {hit.place.x, hit.place.y, hit.place.z, hit.direction.x, hit.direction.y, hit.direction.z}) {
                bits = (bits ^ std::bit_cast<std::uint64_t>(value)) * 0x9E3779B97F4A7C15U;
                bits ^= bits >> 29U;
            }
            part.hash += bits;
            part.weight += hit.weight;
            if (part.hits.size() < 10000) {
                part.hits.push_back(hit);
            }
        }
    }
    [[nodiscard]] std::uint64_t hash() const {
        std::uint64_t sum = 0;
        for (const Part &part : parts_) {
            sum += part.hash;
        }
        return sum;
    }
    [[nodiscard]] std::int64_t weight() const {
        std::int64_t sum = 0;
        for (const Part &part : parts_) {
            sum += part.weight;
        }
        return sum;
    }
    // Of worker 0.
    [[nodiscard]] const std::vector<Receiver_hit> &hits() const { return parts_[0].hits; }

private:
    struct Part {
        std::uint64_t hash = 0;
        std::int64_t weight = 0;
        std::vector<Receiver_hit> hits;
    };
    std::array<Part, 4> parts_;
};

inline constexpr double whole = 1.0 / weight_unit; // of a photon

// Emitted and gained, less what became of it: must be zero.
inline std::int64_t excess(const Balance &balance) {
    return balance.emitted + balance.roulette - balance.stored - balance.absorbed - balance.lost;
}

} // namespace gonio::sim::fakes
