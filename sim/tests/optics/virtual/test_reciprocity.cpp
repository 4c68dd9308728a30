// test_reciprocity.cpp: source and detector change places (Helmholtz): patch by patch over the louver's whole matrix,
// and with the goniophotometer itself; uniform light from all sides leaves a lossless sample uniform (the white
// furnace).
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>

#include "patch_matrix.hpp"
#include "written_scenario.hpp"

namespace gonio::sim::test {
namespace {

constexpr double rad_per_deg = std::numbers::pi / 180.0;

struct Ring {
    double low_deg;
    double high_deg;
    int patches;
};

std::vector<Patch> patches() {
    constexpr std::array rings = {Ring{0, 20, 1}, Ring{20, 40, 6}, Ring{40, 60, 6}, Ring{60, 90, 4}};
    std::vector<Patch> list;
    for (const Ring &ring : rings) {
        double const width_deg = 360.0 / ring.patches;
        for (int i = 0; i < ring.patches; ++i) {
            list.push_back({ring.low_deg, ring.high_deg, (i - 0.5) * width_deg, width_deg});
        }
    }
    return list;
}

// Integral of the cosine over a patch.
double projected_sr(const Patch &patch) {
    double const low = std::sin(patch.theta_low_deg * rad_per_deg);
    double const high = std::sin(patch.theta_high_deg * rad_per_deg);
    return 0.5 * patch.phi_width_deg * rad_per_deg * (high * high - low * low);
}

struct Part {
    double share; // of the incident patch's light
    double variance;
};
// All patches of the front, then all of the back.
std::vector<std::vector<Part>> matrix(const std::string &text, std::uint64_t photons) {
    Photon_scenario const scenario = written_scenario(text);
    Patch_matrix const matrix(scenario, scenario.bands.front(), patches());
    std::size_t const size = patches().size();
    std::vector<std::vector<Part>> parts(2 * size, std::vector<Part>(2 * size));
    auto const count = static_cast<double>(photons);
    for (std::size_t i = 0; i < 2 * size; ++i) {
        bool const front = i < size;
        Watch watch;
        Patch_matrix::Column const column = matrix.column(i % size, front, {0, photons}, 2, watch);
        for (std::size_t o = 0; o < 2 * size; ++o) {
            const Aperture_sums &sums = (o < size) == front ? column.reflected : column.transmitted;
            double const mean = static_cast<double>(sums.weight[o % size]) * weight_unit / count;
            double const square = static_cast<double>(sums.square[o % size]) * weight_unit / count;
            parts[i][o] = {mean, (square - mean * mean) / count};
        }
    }
    return parts;
}

// Slats long enough for light that enters at up to 85 degrees; the few that leave at the ends do so both ways.
constexpr const char *long_stack = "count = 199\nlength_mm = 4000.0";

TEST(Reciprocity, of_the_louver_patch_by_patch) {
    constexpr std::uint64_t photons = 20000;
    std::vector<Patch> const list = patches();
    auto const parts = matrix(louver("kind = \"ward-duer\"\nreflectance = 0.9\nspecular_share = 0.9\nroughness_x = 0.2",
                                     "kind = \"lambertian\"\nreflectance = 0.8", long_stack),
                              photons);
    double chi_square = 0.0;
    int freedom = 0;
    for (std::size_t i = 0; i < parts.size(); ++i) {
        for (std::size_t o = 0; o < i; ++o) {
            double const of_i = projected_sr(list[i % list.size()]);
            double const of_o = projected_sr(list[o % list.size()]);
            Part const &to = parts[i][o];
            Part const &from = parts[o][i];
            double const variance = of_i * of_i * to.variance + of_o * of_o * from.variance;
            // Enough hits both ways for the variance to be known.
            if (to.share * static_cast<double>(photons) > 50 && from.share * static_cast<double>(photons) > 50) {
                double const difference = of_i * to.share - of_o * from.share;
                chi_square += difference * difference / variance;
                ++freedom;
            }
        }
    }
    EXPECT_GT(freedom, 200);
    EXPECT_NEAR(chi_square, freedom, 4.0 * std::sqrt(2.0 * freedom));
}

TEST(Reciprocity, uniform_light_leaves_a_white_louver_uniform) {
    std::vector<Patch> const list = patches();
    auto const parts = matrix(
        louver("kind = \"mirror\"\nreflectance = 1.0", "kind = \"lambertian\"\nreflectance = 1.0", long_stack), 10000);
    for (std::size_t o = 0; o < parts.size(); ++o) {
        double sum = 0.0;
        double variance = 0.0;
        for (std::size_t i = 0; i < parts.size(); ++i) {
            double const weight = projected_sr(list[i % list.size()]);
            sum += weight * parts[i][o].share;
            variance += weight * weight * parts[i][o].variance;
        }
        EXPECT_NEAR(sum, projected_sr(list[o % list.size()]), 4.5 * std::sqrt(variance)) << "patch " << o;
    }
}

// Source cone and detector cap of equal size; the material is broad, so that within them nothing varies much.
TEST(Reciprocity, source_and_detector_change_places) {
    constexpr std::uint64_t photons = 400000;
    Photon_scenario const scenario = written_scenario(
        louver("kind = \"lambertian\"\nreflectance = 0.9", "kind = \"lambertian\"\nreflectance = 0.7") +
        "[beam]\ndiameter_mm = 130.0\nedge_deg = 0.0\n[source]\nopening_angle_deg = 8.0\nstop_distance_mm = 100.0\n");
    struct Angles {
        double theta_deg;
        double phi_deg;
    };
    constexpr std::array<std::array<Angles, 2>, 3> pairs = {
        {{{{25.0, 90.0}, {50.0, 60.0}}}, {{{40.0, 100.0}, {140.0, 80.0}}}, {{{50.0, 90.0}, {30.0, 120.0}}}}};
    for (const auto &[one, other] : pairs) {
        auto const bsdf = [&](const Angles &from, const Angles &to) {
            std::array const detector = {direction(to.theta_deg, to.phi_deg)};
            constexpr double half_angle = 4.0 * rad_per_deg;
            Watch watch;
            auto const [sums, balance] =
                at(scenario, from.theta_deg, from.phi_deg).read(detector, half_angle, {0, photons}, 2, watch);
            Estimate found = estimate(sums.weight[0], sums.square[0], sums.hits[0], photons, half_angle);
            double const cosine = std::abs(detector[0].z);
            return std::array{found.dsf_per_sr / cosine, found.standard_error_per_sr / cosine};
        };
        auto const [there, there_error] = bsdf(one, other);
        auto const [back, back_error] = bsdf(other, one);
        // 4 sigma, and 1 % for what the phase of the slats under the beam's rim does.
        EXPECT_NEAR(there, back, 4.0 * std::hypot(there_error, back_error) + 0.01 * there);
        EXPECT_LT(there_error, 0.05 * there);
    }
}

} // namespace
} // namespace gonio::sim::test
