// layers.cpp: the adding method: two layers become one, front to back.
#include "layers.hpp"

#include <cmath>

namespace gonio::sim {
namespace {

// One of s, p and the part between them.
struct Channel {
    double front;
    double back;
    double through;

    // This layer before that one.
    [[nodiscard]] Channel before(const Channel &next) const {
        double const left = 1.0 - back * next.front;
        if (!(left > 0.0)) {
            return {front, next.back, 0.0}; // light between two ideal mirrors: none gets there
        }
        return {front + through * through * next.front / left, next.back + next.through * next.through * back / left,
                through * next.through / left};
    }
};

struct Channels {
    Channel s;
    Channel p;
    Channel cross;
};

Channels of(const Plate &plate, double cosine) {
    Two_way const powers = plate.powers(cosine);
    return {{powers.reflectance_s, powers.reflectance_s, powers.transmittance_s},
            {powers.reflectance_p, powers.reflectance_p, powers.transmittance_p},
            {powers.reflected_cross, powers.reflected_cross, powers.transmitted_cross}};
}

Channels of(const Coating &coating, double /*cosine*/) {
    return {{coating.front_reflectance_s, coating.back_reflectance_s, coating.transmittance_s},
            {coating.front_reflectance_p, coating.back_reflectance_p, coating.transmittance_p},
            {-std::sqrt(coating.front_reflectance_s * coating.front_reflectance_p),
             -std::sqrt(coating.back_reflectance_s * coating.back_reflectance_p),
             std::sqrt(coating.transmittance_s * coating.transmittance_p)}};
}

} // namespace

Two_way Layers::powers(const Arrival &arrival) const {
    auto const channels = [&](const Layer &layer) {
        return std::visit([&](const auto &known) { return of(known, arrival.towards.z); }, layer);
    };
    Channels all = channels(layers_.front());
    for (std::size_t i = 1; i < layers_.size(); ++i) {
        Channels const next = channels(layers_[i]);
        all = {all.s.before(next.s), all.p.before(next.p), all.cross.before(next.cross)};
    }
    bool const front = arrival.from_front;
    return {front ? all.s.front : all.s.back,
            front ? all.p.front : all.p.back,
            all.s.through,
            all.p.through,
            front ? all.cross.front : all.cross.back,
            0.0,
            all.cross.through};
}

Departure Layers::scatter(const Arrival &arrival, Photon_random &random) const {
    return depart_two_way(powers(arrival), arrival, -arrival.towards, random);
}

double Layers::dsf_per_sr(const Arrival & /*arrival*/, const Vector & /*departing*/) const {
    return 0.0;
}

Albedo Layers::albedo(const Arrival &arrival) const {
    return unpolarised(powers(arrival));
}

} // namespace gonio::sim
