// tabulated.cpp: neighbours of the incident direction, and drawing from their cells.
#include "tabulated.hpp"

#include <algorithm>
#include <cmath>

#include "elementary.hpp"
#include "toml_table.hpp"

namespace gonio::sim {
namespace {

constexpr double degree = elementary::pi / 180.0;
constexpr double full_turn = 2.0 * elementary::pi;
constexpr double most_energy = 1.0 + 1e-6; // rounding in the file

double wrapped(double angle_rad) {
    double const turns = angle_rad / full_turn;
    return (turns - std::floor(turns)) * full_turn;
}

Disc_point turned(const Disc_point &point, const Disc_point &turn) {
    return {point.x * turn.x - point.y * turn.y, point.x * turn.y + point.y * turn.x};
}

std::string describe(const std::string &name, const Scatter_table::Distribution &distribution) {
    return name + ": incident theta " + std::to_string(distribution.theta_deg) + ", phi " +
           std::to_string(distribution.phi_deg) + ": ";
}

} // namespace

Tabulated::Tabulated(const Scatter_table &table, const std::string &name)
    : cells_(table.cells), follow_(table.follow), isotropic_(table.isotropic),
      front_(rings(table.front, name, "front")), back_(table.back.empty() ? front_ : rings(table.back, name, "back")) {}

std::vector<Tabulated::Ring> Tabulated::rings(const std::vector<Scatter_table::Distribution> &distributions,
                                              const std::string &name, const std::string &side) const {
    if (distributions.empty()) {
        throw Input_error(name + ": no incident direction on the " + side + "; give at least one");
    }
    std::vector<Incident_cells> all;
    all.reserve(distributions.size());
    for (const Scatter_table::Distribution &distribution : distributions) {
        all.push_back(incident_cells(distribution, name));
    }
    std::sort(all.begin(), all.end(), [](const Incident_cells &a, const Incident_cells &b) {
        return a.theta_rad < b.theta_rad || (a.theta_rad == b.theta_rad && a.phi_rad < b.phi_rad);
    });
    std::vector<Ring> found;
    for (Incident_cells &cells : all) {
        if (found.empty() || found.back().front().theta_rad != cells.theta_rad) {
            found.emplace_back();
        } else if (isotropic_ || found.back().back().phi_rad == cells.phi_rad) {
            std::string message = name + ": incident theta " + std::to_string(cells.theta_rad / degree);
            message += " twice on the " + side + "; remove one of them";
            throw Input_error(message.append(isotropic_ ? " or declare the table not isotropic" : ""));
        }
        found.back().push_back(std::move(cells));
    }
    return found;
}

Tabulated::Incident_cells Tabulated::incident_cells(const Scatter_table::Distribution &distribution,
                                                    const std::string &name) const {
    if (!(distribution.theta_deg >= 0.0 && distribution.theta_deg <= 90.0) || !std::isfinite(distribution.phi_deg)) {
        throw Input_error(describe(name, distribution) + "theta must be from 0 to 90 degrees");
    }
    double const theta = distribution.theta_deg * degree;
    double const phi = wrapped(distribution.phi_deg * degree);
    double const sine = sine_cosine(theta).sine;
    Sine_cosine const azimuth = sine_cosine(phi);
    Incident_cells cells{theta,
                         phi,
                         {sine * azimuth.cosine, sine * azimuth.sine},
                         {azimuth.cosine, azimuth.sine},
                         0.0,
                         0.0,
                         distribution.reflected,
                         distribution.transmitted,
                         {},
                         {},
                         0};
    std::size_t const size = std::size_t{cells_} * cells_;
    double const each = elementary::pi / static_cast<double>(size);
    double sum = 0.0;
    auto const add = [&](const std::vector<double> &values, double &energy) {
        if (!values.empty() && values.size() != size) {
            throw Input_error(describe(name, distribution) + std::to_string(values.size()) + " cells where " +
                              std::to_string(size) + " or none are needed");
        }
        double const before = sum;
        for (double const value : values) {
            if (!(value >= 0.0) || !std::isfinite(value)) {
                throw Input_error(describe(name, distribution) + "a BSDF below 0 or not a number; correct the data");
            }
            sum += value * each;
            cells.last_cell = value > 0.0 ? cells.sums.size() : cells.last_cell;
            cells.sums.push_back(sum);
        }
        energy = sum - before;
    };
    add(cells.reflected, cells.reflectance);
    add(cells.transmitted, cells.transmittance);
    std::size_t cell = 0;
    for (std::size_t i = 0; i < guides; ++i) {
        while (cell < cells.last_cell && cells.sums[cell] <= sum * static_cast<double>(i) / guides) {
            ++cell;
        }
        cells.guide.at(i) = static_cast<std::uint32_t>(cell);
    }
    cells.guide.back() = static_cast<std::uint32_t>(cells.last_cell);
    if (sum > most_energy) {
        throw Input_error(describe(name, distribution) + "sends out " + std::to_string(sum) +
                          " of the light that it gets; scale the data to 1 or less");
    }
    return cells;
}

std::size_t Tabulated::Incident_cells::cell_at(double sum) const {
    auto const part = std::min(static_cast<std::size_t>(sum / sums.back() * guides), guides - 1);
    auto const begin = sums.begin() + guide[part];
    auto const end = sums.begin() + guide[part + 1]; // dark cells before it are never chosen
    return static_cast<std::size_t>(std::upper_bound(begin, end, sum) - sums.begin());
}

void Tabulated::add_ring(const Ring &ring, double phi_rad, double weight, Neighbours &found) {
    if (!(weight > 0.0)) {
        return;
    }
    if (ring.size() == 1) {
        found.of.at(found.count++) = {ring.data(), weight};
        return;
    }
    auto const above = std::upper_bound(ring.begin(), ring.end(), phi_rad,
                                        [](double phi, const Incident_cells &cells) { return phi < cells.phi_rad; });
    Incident_cells const &next = above == ring.end() ? ring.front() : *above;
    Incident_cells const &last = above == ring.begin() ? ring.back() : *(above - 1);
    double const part = wrapped(phi_rad - last.phi_rad) / wrapped(next.phi_rad - last.phi_rad);
    found.of.at(found.count++) = {&last, weight * (1.0 - part)};
    found.of.at(found.count++) = {&next, weight * part};
}

Tabulated::Neighbours Tabulated::neighbours(const Arrival &arrival) const {
    std::vector<Ring> const &side = arrival.from_front ? front_ : back_;
    double const theta = arc_cosine(arrival.towards.z);
    double const phi = isotropic_ ? 0.0 : wrapped(arc_tangent(arrival.towards.y, arrival.towards.x));
    auto const above = std::upper_bound(side.begin(), side.end(), theta,
                                        [](double angle, const Ring &ring) { return angle < ring.front().theta_rad; });
    Neighbours found;
    if (above == side.begin()) {
        add_ring(side.front(), phi, 1.0, found);
    } else if (above == side.end()) {
        add_ring(side.back(), phi, 1.0, found);
    } else {
        Ring const &below = *(above - 1);
        double const part = (theta - below.front().theta_rad) / (above->front().theta_rad - below.front().theta_rad);
        add_ring(below, phi, 1.0 - part, found);
        add_ring(*above, phi, part, found);
    }
    return found;
}

Tabulated::Passage Tabulated::passage(const Incident_cells &cells, const Vector &towards, bool reflected) const {
    Passage result{{1.0, 0.0}, cells.incident, {towards.x, towards.y}};
    if (isotropic_) {
        double const sine = std::sqrt(towards.x * towards.x + towards.y * towards.y);
        if (sine > 0.0) {
            result.turn = turned({towards.x / sine, towards.y / sine}, {cells.azimuth.x, -cells.azimuth.y});
        }
        result.from = turned(cells.incident, result.turn);
    }
    if (follow_ == Scatter_table::Follow::none) {
        result.to = result.from;
    } else if (!(follow_ == Scatter_table::Follow::retro && reflected)) {
        result.from = {-result.from.x, -result.from.y};
        result.to = {-result.to.x, -result.to.y};
    }
    return result;
}

Departure Tabulated::scatter(const Arrival &arrival, Photon_random &random) const {
    Neighbours const found = neighbours(arrival);
    std::array<double, 4> sums{};
    double share = 0.0;
    for (std::size_t i = 0; i < found.count; ++i) {
        share += found.of[i].weight * (found.of[i].cells->reflectance + found.of[i].cells->transmittance);
        sums[i] = share;
    }
    if (!(share > 0.0)) {
        return {arrival.towards, 0.0, {}};
    }
    double const wanted = random.uniform() * share;
    std::size_t chosen = 0;
    while (chosen + 1 < found.count && wanted >= sums[chosen]) {
        ++chosen;
    }
    double const before = chosen == 0 ? 0.0 : sums[chosen - 1];
    Incident_cells const &cells = *found.of[chosen].cells;
    double const within = (wanted - before) / found.of[chosen].weight;
    std::size_t const cell = cells.cell_at(within);
    bool const reflected = cell < cells.reflected.size();
    std::size_t const square = reflected ? cell : cell - cells.reflected.size();
    std::size_t const row = square / cells_;
    double const u = (static_cast<double>(square % cells_) + random.uniform()) / cells_;
    double const v = (static_cast<double>(row) + random.uniform()) / cells_;
    Passage const way = passage(cells, arrival.towards, reflected);
    Disc_point const out = move_within_disc(turned(disc_of_square(u, v), way.turn), way.from, way.to).point;
    double const z = std::sqrt(std::max(1.0 - out.x * out.x - out.y * out.y, 0x1p-60));
    return {{out.x, out.y, reflected ? z : -z}, share, {}};
}

double Tabulated::dsf_per_sr(const Arrival &arrival, const Vector &departing) const {
    Neighbours const found = neighbours(arrival);
    bool const reflected = departing.z > 0.0;
    double bsdf = 0.0;
    for (std::size_t i = 0; i < found.count; ++i) {
        Incident_cells const &cells = *found.of[i].cells;
        std::vector<double> const &values = reflected ? cells.reflected : cells.transmitted;
        if (values.empty()) {
            continue;
        }
        Passage const way = passage(cells, arrival.towards, reflected);
        Moved const origin = move_within_disc({departing.x, departing.y}, way.to, way.from);
        auto const [u, v] = square_of_disc(turned(origin.point, {way.turn.x, -way.turn.y}));
        auto const index = [&](double fraction) {
            return std::min(static_cast<std::size_t>(fraction * cells_), std::size_t{cells_} - 1);
        };
        bsdf += found.of[i].weight * origin.area * values[index(v) * cells_ + index(u)];
    }
    return bsdf * std::abs(departing.z);
}

Albedo Tabulated::albedo(const Arrival &arrival) const {
    Neighbours const found = neighbours(arrival);
    Albedo sum{0.0, 0.0};
    for (std::size_t i = 0; i < found.count; ++i) {
        sum.reflectance += found.of[i].weight * found.of[i].cells->reflectance;
        sum.transmittance += found.of[i].weight * found.of[i].cells->transmittance;
    }
    return sum;
}

} // namespace gonio::sim
