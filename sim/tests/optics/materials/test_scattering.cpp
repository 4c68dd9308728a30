// test_scattering.cpp: materials that scatter: samples against density, energy, reciprocity.
#include "material_checks.hpp"

#include "black.hpp"
#include "ggx_dielectric.hpp"
#include "lambertian.hpp"
#include "radiance_finish.hpp"
#include "ward_duer.hpp"
#include "ward_lobe.hpp"

namespace gonio::sim {
namespace {

constexpr std::array<double, 4> thetas{0.0, 35.0, 65.0, 84.0};

TEST(Black, Absorbs_all_light) {
    Photon_random random(1, 1);
    EXPECT_EQ(Black().scatter(arrival(30.0), random).share, 0.0);
    EXPECT_EQ(Black().albedo(arrival(30.0)).reflectance, 0.0);
}

TEST(Lambertian_surface, Follows_its_density) {
    for (double const theta : thetas) {
        check_material(Lambertian(0.6), arrival(theta));
        check_material(Lambertian(0.3, 0.7), arrival(theta, 40.0, false));
        check_material(Lambertian(0.0, 0.5), arrival(theta));
    }
}

TEST(Lambertian_surface, Keeps_all_light_where_nothing_is_absorbed) {
    Lambertian const sheet(0.25, 0.75);
    for (std::uint64_t photon = 0; photon < 1000; ++photon) {
        Photon_random random(3, photon);
        EXPECT_EQ(sheet.scatter(arrival(50.0), random).share, 1.0);
    }
}

TEST(Ward_duer_finish, Follows_its_density_at_all_incidences) {
    for (double const theta : thetas) {
        SCOPED_TRACE(theta);
        check_material(Ward_duer(0.8, 0.6, 0.2, 0.2), arrival(theta), {.largest_share = 1.6});
        check_material(Ward_duer(0.9, 1.0, 0.1, 0.35), arrival(theta, 25.0), {.largest_share = 1.8});
        check_material(Ward_duer(0.7, 0.5, 0.0, 0.0), arrival(theta, 70.0, false));
    }
}

TEST(Ward_duer_finish, Is_an_ideal_mirror_at_roughness_0) {
    Ward_duer const mirror(0.93, 1.0, 0.0, 0.0);
    Photon_random random(1, 1);
    Departure const departure = mirror.scatter(arrival(40.0), random);
    EXPECT_TRUE(is_ideal(arrival(40.0), departure.direction));
    EXPECT_EQ(departure.share, 0.93);
}

// Brushed along x: the lobe is narrow in the plane of x, wide in that of y.
TEST(Ward_duer_finish, Spreads_across_the_tangent_by_the_second_roughness) {
    Ward_lobe const lobe(0.05, 0.3);
    Vector const normal{0.0, 0.0, 1.0};
    Vector const along = unit({0.2, 0.0, 1.0});
    Vector const across = unit({0.0, 0.2, 1.0});
    double const peak = lobe.dsf_per_sr(normal, normal);
    // Peak of a unit lobe at normal incidence: 1 / (4 pi alpha_x alpha_y).
    EXPECT_NEAR(peak, 1.0 / (4.0 * std::numbers::pi * 0.05 * 0.3), 1e-12);
    EXPECT_LT(lobe.dsf_per_sr(normal, along), 0.05 * peak);
    EXPECT_GT(lobe.dsf_per_sr(normal, across), 0.8 * peak);
}

TEST(Ward_duer_finish, Never_reflects_more_than_it_gets) {
    for (double const roughness : {0.02, 0.1, 0.3, 0.6}) {
        double last = 2.0;
        for (double const theta : {0.0, 30.0, 60.0, 75.0, 85.0, 89.0, 89.9}) {
            double const albedo = Ward_lobe(roughness, roughness).albedo(arrival(theta).towards);
            EXPECT_LE(albedo, 1.0 + 1e-9) << roughness << " " << theta;
            EXPECT_GT(albedo, 0.6) << roughness << " " << theta;
            last = albedo;
        }
        EXPECT_LT(last, 1.0);
    }
}

TEST(Radiance_finishes, Follow_their_density_at_all_incidences) {
    for (double const theta : thetas) {
        SCOPED_TRACE(theta);
        for (double const roughness : {0.0, 0.15}) {
            check_material(*radiance_metal(0.7, 0.8, roughness), arrival(theta), {.largest_share = 1.4});
            check_material(*radiance_plastic(0.6, 0.05, roughness), arrival(theta), {.largest_share = 1.3});
        }
        // Too little specularity for Radiance's rise at grazing incidence.
        check_material(*radiance_plastic(0.6, 0.01, 0.0), arrival(theta));
    }
}

TEST(Radiance_finishes, Rise_to_a_mirror_at_grazing_incidence) {
    auto const paint = radiance_plastic(0.5, 0.04, 0.0);
    double const rise = std::exp(-5.85 * std::cos(89.0 * std::numbers::pi / 180.0)) - 0.00202943064;
    double const specular = 0.04 + 0.96 * rise;
    Histogram const histogram = draw(*paint, arrival(89.0), 50000, 5);
    EXPECT_NEAR(histogram.ideal / 50000.0, specular, 4.0 * std::sqrt(specular * (1.0 - specular) / 50000.0));
    // White loses only what its diffuse part sends back to grazing directions: never a gain.
    for (double const theta : thetas) {
        EXPECT_LE(radiance_plastic(1.0, 0.04, 0.0)->albedo(arrival(theta)).reflectance, 1.0);
        EXPECT_LE(radiance_metal(1.0, 0.5, 0.0)->albedo(arrival(theta)).reflectance, 1.0);
    }
}

TEST(Ggx_boundary, Follows_its_density_from_both_sides) {
    Expectations const expect{.quadrature = 1e-3};
    for (bool const front : {true, false}) {
        for (double const theta : thetas) {
            SCOPED_TRACE(theta);
            check_material(Ggx_dielectric(0.3, 0.3, 1.52), arrival(theta, 0.0, front), expect);
            check_material(Ggx_dielectric(0.2, 0.5, 1.52), arrival(theta, 50.0, front), expect);
        }
    }
}

TEST(Ggx_boundary, Becomes_the_smooth_boundary) {
    // 4.26 % at n = 1.52; the few steep facets of so smooth a face lose nothing that counts.
    Albedo const albedo = Ggx_dielectric(0.002, 0.002, 1.52).albedo(arrival(0.0));
    EXPECT_NEAR(albedo.reflectance, 0.04258, 2e-5);
    EXPECT_NEAR(albedo.transmittance, 0.95742, 2e-4);
}

double bsdf_per_sr(const Material &material, const Arrival &light, const Vector &departing) {
    return material.dsf_per_sr(light, departing) / std::abs(departing.z);
}

TEST(Reciprocity, Holds_for_what_is_reflected) {
    std::vector<std::unique_ptr<Material>> materials;
    materials.push_back(std::make_unique<Lambertian>(0.5));
    materials.push_back(std::make_unique<Ward_duer>(0.8, 0.6, 0.1, 0.3));
    materials.push_back(radiance_metal(0.8, 0.7, 0.0));
    materials.push_back(radiance_plastic(0.8, 0.05, 0.2));
    materials.push_back(std::make_unique<Ggx_dielectric>(0.2, 0.4, 1.52));
    for (const auto &material : materials) {
        for (double const theta : {5.0, 40.0, 80.0}) {
            for (double const phi : {10.0, 130.0, 200.0}) {
                Arrival const one = arrival(30.0, 20.0);
                Arrival const other = arrival(theta, phi);
                double const there = bsdf_per_sr(*material, one, other.towards);
                EXPECT_GT(there, 0.0);
                EXPECT_NEAR(bsdf_per_sr(*material, other, one.towards) / there, 1.0, 1e-11);
            }
        }
    }
}

// Walter et al. (2007), section 2: f(i, o) / n_o^2 = f(o, i) / n_i^2.
TEST(Reciprocity, Holds_for_refraction_with_the_square_of_the_index) {
    double const index = 1.52;
    Ggx_dielectric const boundary(0.2, 0.4, index);
    int seen = 0;
    for (double const theta : {5.0, 25.0, 40.0}) {
        for (double const phi : {150.0, 200.0, 240.0}) {
            Arrival const outside = arrival(30.0, 20.0);
            Arrival const inside = arrival(theta, phi, false); // in the frame of the back: y and z turned over
            auto const other_frame = [](const Vector &v) { return Vector{v.x, -v.y, -v.z}; };
            double const in = bsdf_per_sr(boundary, outside, other_frame(inside.towards));
            double const out = bsdf_per_sr(boundary, inside, other_frame(outside.towards));
            if (in > 0.0) {
                ++seen;
                EXPECT_NEAR(in / (index * index) / out, 1.0, 1e-11);
            } else {
                EXPECT_EQ(out, 0.0);
            }
        }
    }
    EXPECT_GT(seen, 4);
}

} // namespace
} // namespace gonio::sim
