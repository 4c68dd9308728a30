// test_ideal.cpp: materials without scattering: Fresnel, polarisation, plates and stacks against textbook values.
#include "material_checks.hpp"

#include "dielectric.hpp"
#include "fresnel.hpp"
#include "layers.hpp"
#include "mirror.hpp"
#include "thin_plate.hpp"

namespace gonio::sim {
namespace {

constexpr double degree = std::numbers::pi / 180.0;

struct Means {
    double reflected = 0.0;
    double transmitted = 0.0;
};

Means mean_shares(const Material &material, const Arrival &light, int photons = 40000) {
    Means means;
    for (int photon = 0; photon < photons; ++photon) {
        Photon_random random(7, static_cast<std::uint64_t>(photon));
        Departure const departure = material.scatter(light, random);
        (departure.direction.z > 0.0 ? means.reflected : means.transmitted) += departure.share / photons;
        EXPECT_LE(departure.share, 1.0 + 1e-12);
    }
    return means;
}

void check_ideal(const Material &material, const Arrival &light) {
    Albedo const albedo = material.albedo(light);
    Means const means = mean_shares(material, light);
    EXPECT_NEAR(means.reflected + means.transmitted, albedo.reflectance + albedo.transmittance, 1e-9);
    EXPECT_NEAR(means.reflected, albedo.reflectance, 4.0 * 0.5 / std::sqrt(40000.0));
    EXPECT_EQ(material.dsf_per_sr(light, {0.0, 0.0, 1.0}), 0.0);
}

TEST(Fresnel, Gives_textbook_powers) {
    EXPECT_NEAR(unpolarised(refract(1.0, 1.52).powers).reflectance, std::pow(0.52 / 2.52, 2), 1e-15);
    EXPECT_NEAR(unpolarised(refract(1.0, 1.0 / 1.52).powers).reflectance, 0.04258, 1e-5);
    // Hecht, Optics, ch. 4: glass 1.5 at 30 degrees: r_s = -0.2404, r_p = 0.1589.
    Refraction const hecht = refract(std::cos(30.0 * degree), 1.5);
    EXPECT_NEAR(hecht.powers.reflectance_s, 0.2404 * 0.2404, 5e-5);
    EXPECT_NEAR(hecht.powers.reflectance_p, 0.1589 * 0.1589, 5e-5);
    EXPECT_NEAR(hecht.powers.reflected_cross, -0.2404 * 0.1589, 5e-5);
    // Brewster: no p; the refracted ray is at right angles to the mirrored one.
    double const brewster = std::atan(1.52);
    Refraction const polarising = refract(std::cos(brewster), 1.52);
    EXPECT_NEAR(polarising.powers.reflectance_p, 0.0, 1e-30);
    EXPECT_NEAR(polarising.cosine, std::sin(brewster), 1e-14);
    EXPECT_NEAR(refract(1e-9, 1.52).powers.reflectance_s, 1.0, 1e-7);
}

TEST(Fresnel, Reflects_totally_beyond_the_critical_angle) {
    double const critical = std::asin(1.0 / 1.52);
    EXPECT_LT(refract(std::cos(critical - 0.01), 1.0 / 1.52).powers.reflectance_s, 1.0);
    Refraction const total = refract(std::cos(critical + 0.01), 1.0 / 1.52);
    EXPECT_EQ(total.powers.reflectance_p, 1.0);
    EXPECT_EQ(total.cosine, 0.0);
    // Born & Wolf 1.5.4 (60): tan(delta / 2) = cos sqrt(sin^2 - n^2) / sin^2. Fresnel's rhomb: n = 1.51 at 54.6 degrees
    // has 45 degrees (their example: 54 degrees 37 minutes).
    double const angle = (54.0 + 37.0 / 60.0) * degree;
    Two_way const rhomb = refract(std::cos(angle), 1.0 / 1.51).powers;
    EXPECT_NEAR(std::atan2(rhomb.reflected_cross_imaginary, rhomb.reflected_cross) / degree, 45.0, 0.1);
}

// Two reflections in Fresnel's rhomb turn linear light at 45 degrees into circular light.
TEST(Fresnel, Makes_circular_light_in_a_rhomb) {
    Dielectric const glass(1.51);
    Arrival light = arrival(54.0 + 37.0 / 60.0, 0.0, false);
    light.stokes = {0.0, 1.0, 0.0};
    for (int reflection = 0; reflection < 2; ++reflection) {
        Photon_random random(1, 1);
        Departure const departure = glass.scatter(light, random);
        EXPECT_GT(departure.direction.z, 0.0);
        EXPECT_EQ(departure.share, 1.0);
        light.stokes = departure.stokes;
    }
    EXPECT_NEAR(std::abs(light.stokes.v), 1.0, 1e-4);
    EXPECT_NEAR(light.stokes.q, 0.0, 1e-12);
}

TEST(Dielectric_boundary, Refracts_by_Snell_and_keeps_all_light) {
    Dielectric const glass(1.52, 1.0, 0.01);
    EXPECT_EQ(glass.inside_absorption_per_mm(), 0.01);
    for (double const theta : {0.0, 30.0, 60.0, 85.0}) {
        check_ideal(glass, arrival(theta, 30.0));
        check_ideal(glass, arrival(theta, 30.0, false));
    }
    for (std::uint64_t photon = 0; photon < 50; ++photon) {
        Photon_random random(2, photon);
        Departure const departure = glass.scatter(arrival(60.0, 30.0), random);
        if (departure.direction.z < 0.0) {
            Vector const towards = arrival(60.0, 30.0).towards;
            EXPECT_NEAR(departure.direction.x, -towards.x / 1.52, 1e-15);
            EXPECT_NEAR(departure.direction.y, -towards.y / 1.52, 1e-15);
            EXPECT_NEAR(length(departure.direction), 1.0, 1e-15);
        }
    }
}

// A bubble in glass: the same boundary named the other way round.
TEST(Dielectric_boundary, Depends_on_the_ratio_of_the_indices_only) {
    Albedo const bubble = Dielectric(1.0, 1.52).albedo(arrival(30.0));
    Albedo const pane = Dielectric(1.52).albedo(arrival(30.0, 0.0, false));
    EXPECT_NEAR(bubble.reflectance, pane.reflectance, 1e-15);
}

TEST(Polarisation, Light_from_the_Brewster_angle_is_s) {
    Dielectric const glass(1.52);
    double const brewster_deg = std::atan(1.52) / degree;
    double const through_q_wanted = [] {
        double const r_s = refract(std::cos(std::atan(1.52)), 1.52).powers.reflectance_s;
        return -r_s / (2.0 - r_s);
    }();
    for (std::uint64_t photon = 0; photon < 100; ++photon) {
        Photon_random random(4, photon);
        Departure const departure = glass.scatter(arrival(brewster_deg), random);
        EXPECT_NEAR(departure.stokes.q, departure.direction.z > 0.0 ? 1.0 : through_q_wanted, 1e-12);
    }
    // p light does not see the boundary.
    Arrival light = arrival(brewster_deg);
    light.stokes = {-1.0, 0.0, 0.0};
    EXPECT_NEAR(mean_shares(glass, light, 1000).transmitted, 1.0, 1e-12);
}

TEST(Polarisation, A_polarised_beam_stays_polarised) {
    std::vector<std::unique_ptr<Material>> materials;
    materials.push_back(std::make_unique<Dielectric>(1.52));
    materials.push_back(std::make_unique<Mirror>(0.9, 0.7));
    materials.push_back(std::make_unique<Splitter>(0.6, 0.4, 0.3, 0.5));
    for (const auto &material : materials) {
        for (double const theta : {10.0, 50.0, 80.0}) {
            Arrival light = arrival(theta);
            light.stokes = {0.36, 0.48, 0.8};
            for (std::uint64_t photon = 0; photon < 20; ++photon) {
                Photon_random random(9, photon);
                Stokes const out = material->scatter(light, random).stokes;
                EXPECT_NEAR(out.q * out.q + out.u * out.u + out.v * out.v, 1.0, 1e-12);
            }
        }
    }
}

TEST(Polarisation, A_mirror_at_normal_incidence_turns_the_hand) {
    Arrival light = arrival(0.0);
    light.stokes = {0.0, 0.0, 1.0};
    Photon_random random(1, 1);
    EXPECT_NEAR(Mirror(0.9).scatter(light, random).stokes.v, -1.0, 1e-15);
    EXPECT_NEAR(Mirror(0.9).scatter(light, random).share, 0.9, 1e-15);
}

TEST(Thin_plate_surface, Adds_up_all_internal_reflections) {
    // Clear: R = 2 r / (1 + r) for each state (Born & Wolf 1.6.4; Duffie & Beckman 5.1).
    for (double const theta : {0.0, 45.0, 70.0, 89.0}) {
        Two_way const face = refract(std::cos(theta * degree), 1.52).powers;
        Two_way const plate = Plate{1.52, 0.0}.powers(std::cos(theta * degree));
        EXPECT_NEAR(plate.reflectance_s, 2.0 * face.reflectance_s / (1.0 + face.reflectance_s), 1e-14);
        EXPECT_NEAR(plate.reflectance_p, 2.0 * face.reflectance_p / (1.0 + face.reflectance_p), 1e-14);
        EXPECT_NEAR(plate.transmittance_s, 1.0 - plate.reflectance_s, 1e-13);
        check_ideal(Thin_plate({1.52, 0.3}), arrival(theta));
    }
    EXPECT_NEAR(Thin_plate({1.52, 0.0}).albedo(arrival(0.0)).reflectance, 0.0816817, 1e-6);
}

// Radiance's own formulas (reference manual, glass): R and T of the transmissivity.
TEST(Glass, Has_the_energy_of_Radiances_formula) {
    // Its transmissivity for ordinary glass: 0.96 for a transmittance of 88 %; 0.918 for 84 %.
    EXPECT_NEAR(Thin_plate(glass_plate(0.96)).albedo(arrival(0.0)).transmittance, 0.88, 2e-3);
    double const wanted = 0.84;
    double const transmissivity =
        (std::sqrt(0.8402528435 + 0.0072522239 * wanted * wanted) - 0.9166530661) / 0.0036261119 / wanted;
    EXPECT_NEAR(Thin_plate(glass_plate(transmissivity)).albedo(arrival(0.0)).transmittance, wanted, 1e-6);
    for (double const theta : {20.0, 60.0, 80.0}) {
        double const cosine = std::cos(theta * degree);
        double const inside = std::sqrt(1.0 - (1.0 - cosine * cosine) / (1.52 * 1.52));
        double const d = std::pow(0.9, 1.0 / inside);
        double reflectance = 0.0;
        double transmittance = 0.0;
        Two_way const face = refract(cosine, 1.52).powers;
        for (double const r : {face.reflectance_s, face.reflectance_p}) {
            reflectance += 0.5 * r * (1.0 + (1.0 - 2.0 * r) * d * d) / (1.0 - r * r * d * d);
            transmittance += 0.5 * (1.0 - r) * (1.0 - r) * d / (1.0 - r * r * d * d);
        }
        Albedo const albedo = Thin_plate(glass_plate(0.9)).albedo(arrival(theta));
        EXPECT_NEAR(albedo.reflectance, reflectance, 1e-14);
        EXPECT_NEAR(albedo.transmittance, transmittance, 1e-14);
    }
    EXPECT_NEAR(Thin_plate(glass_plate(0.0)).albedo(arrival(0.0)).reflectance, std::pow(0.52 / 2.52, 2), 1e-14);
}

TEST(Splitters, Polarise_by_their_powers) {
    Splitter const splitter(0.7, 0.3, 0.2, 0.6);
    check_ideal(splitter, arrival(45.0));
    Arrival light = arrival(45.0);
    light.stokes.q = 1.0;
    EXPECT_NEAR(mean_shares(splitter, light).reflected, 0.7, 0.01);
    light.stokes.q = -1.0;
    EXPECT_NEAR(mean_shares(splitter, light).reflected, 0.3, 0.01);
}

// m plates of two faces are 2 m faces in a row: R = 2 m r / (1 + (2 m - 1) r) for each state (Stokes 1862).
TEST(Stack, Of_clear_plates_agrees_with_its_faces_in_a_row) {
    for (double const theta : {0.0, 50.0, 80.0}) {
        Two_way const face = refract(std::cos(theta * degree), 1.52).powers;
        for (int const plates : {1, 2, 3}) {
            Layers const stack(std::vector<Layers::Layer>(static_cast<std::size_t>(plates), Plate{1.52, 0.0}));
            auto const in_a_row = [&](double r) { return 2.0 * plates * r / (1.0 + (2.0 * plates - 1.0) * r); };
            double const wanted = 0.5 * (in_a_row(face.reflectance_s) + in_a_row(face.reflectance_p));
            EXPECT_NEAR(stack.albedo(arrival(theta)).reflectance, wanted, 1e-13);
            EXPECT_NEAR(stack.albedo(arrival(theta)).transmittance, 1.0 - wanted, 1e-13);
            check_ideal(stack, arrival(theta, 0.0, false));
        }
    }
}

TEST(Stack, Knows_its_sides) {
    // A mirror coating behind absorbing glass: dark from the glass, bright from the back. By hand: along the normal
    // r = 0.04258, d = exp(-0.5).
    Layers const stack({Plate{1.52, 0.5}, Coating{0.9, 0.9, 0.8, 0.8, 0.05, 0.05}});
    Albedo const plate = Thin_plate({1.52, 0.5}).albedo(arrival(0.0));
    double const left = 1.0 - plate.reflectance * 0.9;
    Albedo const front = stack.albedo(arrival(0.0));
    EXPECT_NEAR(front.reflectance, plate.reflectance + plate.transmittance * plate.transmittance * 0.9 / left, 1e-14);
    EXPECT_NEAR(front.transmittance, plate.transmittance * 0.05 / left, 1e-14);
    Albedo const back = stack.albedo(arrival(0.0, 0.0, false));
    EXPECT_NEAR(back.reflectance, 0.8 + 0.05 * 0.05 * plate.reflectance / left, 1e-14);
    EXPECT_NEAR(back.transmittance, front.transmittance, 1e-14);
    // Two perfect mirrors: nothing goes through, and nothing divides by 0.
    Layers const closed({Coating{1.0, 1.0, 1.0, 1.0, 0.0, 0.0}, Coating{1.0, 1.0, 1.0, 1.0, 0.0, 0.0}});
    EXPECT_EQ(closed.albedo(arrival(0.0)).reflectance, 1.0);
    EXPECT_EQ(closed.albedo(arrival(0.0)).transmittance, 0.0);
}

} // namespace
} // namespace gonio::sim
