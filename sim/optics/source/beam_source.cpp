// beam_source.cpp: checks the settings of the illuminator and draws its photons.
#include "beam_source.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "elementary.hpp"
#include "toml_table.hpp"

namespace gonio::sim {
namespace {

constexpr double rad_per_deg = elementary::pi / 180.0;
constexpr double most_angle_deg = 80.0; // of any light from the axis
// Full width at half maximum of a Gaussian over its standard deviation: sqrt(8 ln 2).
constexpr double fwhm_per_sigma = 2.3548200450309493;

double tangent(double angle_deg) {
    auto const angle = sine_cosine(rad_per_deg * angle_deg);
    return angle.sine / angle.cosine;
}

void require(bool holds, const std::string &what) {
    if (!holds) {
        throw Input_error(what);
    }
}

void check_profile(const Source_settings &s) {
    if (!s.filament.empty()) {
        double sum = 0.0;
        for (const Filament_bar &bar : s.filament) {
            require(bar.width_deg >= 0.0 && bar.height_deg >= 0.0,
                    "a filament bar's width and height must not be negative");
            require(bar.weight >= 0.0, "a filament bar's weight must not be negative");
            require(std::abs(bar.x_deg) + 0.5 * bar.width_deg <= most_angle_deg &&
                        std::abs(bar.y_deg) + 0.5 * bar.height_deg <= most_angle_deg,
                    "a filament bar must end within 80 degrees of the axis");
            sum += bar.weight;
        }
        require(sum > 0.0, "the weights of the filament bars must not all be zero");
        return;
    }
    if (!s.radial.empty()) {
        require(s.radial.size() > 1 && s.radial.front().angle_deg == 0.0,
                "the radial profile needs at least two rows, the first at 0 degrees");
        bool lit = false;
        for (std::size_t i = 0; i < s.radial.size(); ++i) {
            require(s.radial[i].relative >= 0.0, "the radial profile must not be negative");
            require(i == 0 || s.radial[i].angle_deg > s.radial[i - 1].angle_deg,
                    "the radial profile's angles must ascend");
            lit = lit || s.radial[i].relative > 0.0;
        }
        require(s.radial.back().angle_deg <= most_angle_deg,
                "the radial profile must end within 80 degrees of the axis");
        require(lit, "the radial profile must not be zero everywhere");
        return;
    }
    require(s.opening_angle_deg >= 0.0 && s.opening_angle_deg <= most_angle_deg,
            "the opening angle (divergence) must be 0 to 80 degrees");
    require(s.edge_deg >= 0.0 && s.edge_deg <= s.opening_angle_deg,
            "edge_deg must not be negative nor more than the opening angle (divergence)");
}

const Source_settings &checked(const Source_settings &s) {
    require(s.diameter_mm > 0.0, "diameter_mm must be above 0");
    require(s.diameter_edge_mm >= 0.0 && s.diameter_edge_mm <= s.diameter_mm,
            "the edge of the diameter must not be negative nor more than diameter_mm");
    require(s.stop_distance_mm > 0.0, "the stop's distance must be above 0 mm");
    require(s.lamp_distance_mm >= 0.0, "the lamp's distance must be above 0 mm, or 0 for a distant lamp");
    require(s.lamp_distance_mm == 0.0 || s.kind == Beam_kind::collimated,
            "a focused beam has no lamp distance; leave it out");
    require(s.stray_share >= 0.0 && s.stray_share < 1.0, "the stray share must be at least 0 and below 1");
    require(s.stray_half_angle_deg > 0.0 && s.stray_half_angle_deg <= most_angle_deg,
            "the stray light's half angle must be above 0 and at most 80 degrees");
    Stokes const &p = s.stokes;
    require(p.q * p.q + p.u * p.u + p.v * p.v <= 1.0 + 1e-12, "the Stokes vector must not be longer than 1");
    check_profile(s);
    return s;
}

std::optional<Radial_draw> angle_of(const Source_settings &s) {
    if (!s.filament.empty()) {
        return std::nullopt;
    }
    return s.radial.empty() ? squared_chord(Soft_disc{s.opening_angle_deg, s.edge_deg}) : squared_chord(s.radial);
}

} // namespace

Stokes linear_polarisation(double angle_deg) {
    auto const twice = sine_cosine(2.0 * rad_per_deg * angle_deg);
    return {twice.cosine, twice.sine, 0.0};
}

Beam_source::Beam_source(const Source_settings &settings)
    : focused_(checked(settings).kind == Beam_kind::focused), stop_distance_mm_(settings.stop_distance_mm),
      lamp_nearness_per_mm_(settings.lamp_distance_mm > 0.0 ? 1.0 / settings.lamp_distance_mm : 0.0),
      stray_share_(settings.stray_share), stray_squared_chord_(square_of_chord(settings.stray_half_angle_deg)),
      stokes_(settings.stokes), place_(squared_radius(Soft_disc{settings.diameter_mm, settings.diameter_edge_mm})),
      angle_(angle_of(settings)) {
    double sum = 0.0;
    for (const Filament_bar &bar : settings.filament) {
        sum += bar.weight;
    }
    double least = 0.0;
    for (const Filament_bar &bar : settings.filament) {
        if (bar.weight > 0.0) {
            double const scale = bar.gaussian ? 2.0 / fwhm_per_sigma : 2.0;
            bars_.push_back({{tangent(bar.x_deg), tangent(bar.y_deg)},
                             scale * tangent(0.5 * bar.width_deg),
                             scale * tangent(0.5 * bar.height_deg),
                             bar.gaussian,
                             least,
                             bar.weight / sum});
            least += bar.weight / sum;
        }
    }
}

Beam_source::Lamp_place Beam_source::bar_place(double u, double v) const {
    auto const after = std::upper_bound(bars_.begin() + 1, bars_.end(), u,
                                        [](double value, const Bar &bar) { return value < bar.least; });
    Bar const &bar = *(after - 1);
    // What is left of u is uniform again.
    double const rest = std::clamp((u - bar.least) / bar.share, 0x1p-33, 1.0 - 0x1p-33);
    if (bar.gaussian) {
        // Box and Muller 1958.
        double const radius = std::sqrt(-2.0 * logarithm(rest));
        auto const turn = sine_cosine_of_turns(v);
        return {bar.middle.x + bar.width * radius * turn.cosine, bar.middle.y + bar.height * radius * turn.sine};
    }
    return {bar.middle.x + bar.width * (rest - 0.5), bar.middle.y + bar.height * (v - 0.5)};
}

Vector Beam_source::direction(double u, double v, double x_mm, double y_mm) const {
    Lamp_place lamp{};
    if (angle_) {
        double const squared = angle_->draw(u);
        // Sine and cosine of an angle by the square of its chord.
        double sine = std::sqrt(squared * (1.0 - 0.25 * squared));
        double const cosine = 1.0 - 0.5 * squared;
        auto const turn = sine_cosine_of_turns(v);
        if (lamp_nearness_per_mm_ == 0.0) {
            return {-sine * turn.cosine, -sine * turn.sine, -cosine};
        }
        sine /= cosine;
        lamp = {sine * turn.cosine, sine * turn.sine};
    } else {
        lamp = bar_place(u, v);
    }
    return unit({lamp_nearness_per_mm_ * x_mm - lamp.x, lamp_nearness_per_mm_ * y_mm - lamp.y, -1.0});
}

Start Beam_source::start(Photon_random &random) const {
    double const radius_mm = std::sqrt(place_.draw(random.uniform()));
    auto const turn = sine_cosine_of_turns(random.uniform());
    double x_mm = radius_mm * turn.cosine;
    double y_mm = radius_mm * turn.sine;
    double const u = random.uniform();
    double const v = random.uniform();
    Vector way = direction(u, v, x_mm, y_mm);
    if (focused_) {
        // Back from the spot to the stop.
        double const back = stop_distance_mm_ / way.z;
        x_mm += back * way.x;
        y_mm += back * way.y;
    }
    if (stray_share_ > 0.0 && random.uniform() < stray_share_) {
        double const squared = u * stray_squared_chord_;
        double const sine = std::sqrt(squared * (1.0 - 0.25 * squared));
        auto const stray = sine_cosine_of_turns(v);
        way = {sine * stray.cosine, sine * stray.sine, 0.5 * squared - 1.0};
    }
    // The lab's Y, less its part along the direction.
    Vector const along = way.y * way;
    Vector const reference = unit(Vector{-along.x, 1.0 - along.y, -along.z});
    return {{x_mm, y_mm, stop_distance_mm_}, way, stokes_, reference};
}

} // namespace gonio::sim
