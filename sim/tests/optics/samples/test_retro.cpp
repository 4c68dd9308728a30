// test_retro.cpp: beads and corner cubes return light.
#include <gtest/gtest.h>

#include <cmath>

#include "sample_walk.hpp"

using namespace gonio::sim;

namespace {

std::string beads(double index, const std::string &keys) {
    return "[sample]\nkind = \"retro-beads\"\nglass = \"glass\"\ncup = \"cup\"\nbinder = \"binder\"\nsize_mm = 8.0\n" +
           keys + "\n[materials.glass]\nkind = \"dielectric\"\nindex = " + std::to_string(index) +
           "\n[materials.cup]\nkind = \"mirror\"\nreflectance = 1.0\n[materials.binder]\nkind = \"black\"\n";
}

double fresnel(double index, double incident_rad) {
    double const inside = std::asin(std::sin(incident_rad) / index);
    double const s = std::sin(incident_rad - inside) / std::sin(incident_rad + inside);
    double const p = std::tan(incident_rad - inside) / std::tan(incident_rad + inside);
    return 0.5 * (s * s + p * p);
}

// Share of a bead's area from which light comes back within `cone_deg` after one reflection, losses of the two passages
// included. Angles of incidence from 0 to 90 degrees, by area.
double returned(double index, double cone_deg) {
    double sum = 0.0;
    int const steps = 20000;
    for (int i = 0; i < steps; ++i) {
        double const incident = std::asin(std::sqrt((i + 0.5) / steps));
        double const turned_deg = std::abs(2.0 * incident - 4.0 * std::asin(std::sin(incident) / index)) / deg;
        double const passes = 1.0 - fresnel(index, incident);
        sum += turned_deg < cone_deg ? passes * passes / steps : 0.0;
    }
    return sum;
}

} // namespace

// Index 2: everything that strikes a bead within 30 degrees returns within 2.1. The beads cover pi / (2 sqrt 3)
// / 1.02^2. Light straight back from the front, at R within an angle of half the cone's, comes on top.
TEST(RetroBeads, ReturnLightWithinACone) {
    for (double const index : {1.9, 2.0}) {
        Sample_walk const walk(beads(index, ""));
        double const cone_deg = 2.1;
        int const photons = 40000;
        double back = 0.0;
        shine(walk, towards(0.0, 0.0), photons, [&](const Light &light) {
            // Deeper reflections inside are left out: they have a weight of R and hardly return within the cone.
            if (light.interactions == 3 && light.direction.z > std::cos(cone_deg * deg)) {
                back += light.weight / photons;
            }
        });
        double const covered = std::numbers::pi / (2.0 * std::sqrt(3.0)) / (1.02 * 1.02);
        double const expected = covered * returned(index, cone_deg);
        EXPECT_GT(expected, 0.15);
        EXPECT_NEAR(back, expected, 4.0 * std::sqrt(expected * (1.0 - expected) / photons)) << index;
    }
}

// Mirrors and glass without loss, and a white binder: all light comes out, by the front.
TEST(RetroBeads, LoseNothing) {
    std::string scenario = beads(1.95, "");
    scenario.replace(scenario.find("kind = \"black\""), 14, "kind = \"lambertian\"\nreflectance = 1.0");
    Sample_walk const walk(scenario);
    int through = 0;
    shine(walk, towards(40.0, 70.0), 3000, [&](const Light &light) {
        EXPECT_NEAR(light.weight, 1.0, 1e-12);
        through += light.direction.z < 0.0 ? 1 : 0;
    });
    // The sample's rim is open: hardly any light creeps that far between the cups.
    EXPECT_LT(through, 5);
}

// Hollow cubes at normal incidence: every ray meets three mirrors and returns exactly.
TEST(RetroCubes, HollowOnesReturnExactly) {
    Sample_walk const walk(
        "[sample]\nkind = \"retro-cubes\"\nmirror = \"m\"\nedge_mm = 1.5\nsize_mm = 12.0\n[materials.m]\n"
        "kind = \"mirror\"\nreflectance = 0.9");
    shine(walk, towards(0.0, 0.0), 3000, [](const Light &light) {
        EXPECT_EQ(light.interactions, 3);
        EXPECT_NEAR(light.weight, 0.9 * 0.9 * 0.9, 1e-12);
        EXPECT_LT(length(light.direction - Vector{0.0, 0.0, 1.0}), 1e-12);
    });
    // Aslant: what meets three mirrors returns exactly, and that is most of it.
    Vector const from = towards(15.0, 50.0);
    int three = 0;
    shine(walk, from, 3000, [&](const Light &light) {
        if (light.interactions == 3 && light.direction.z > 0.0 && dot(light.direction, from) > 0.9) {
            EXPECT_LT(length(light.direction - from), 1e-12);
            ++three;
        }
    });
    EXPECT_GT(three, 1500);
}

// Prisms: total reflection returns all of it at normal incidence, a part R from the front.
TEST(RetroCubes, PrismsReturnAllAtNormalIncidence) {
    Sample_walk const walk(
        "[sample]\nkind = \"retro-cubes\"\nglass = \"g\"\nedge_mm = 1.5\nsize_mm = 12.0\n[materials.g]\n"
        "kind = \"dielectric\"\nindex = 1.5");
    int const photons = 10000;
    int front = 0;
    shine(walk, towards(0.0, 0.0), photons, [&](const Light &light) {
        EXPECT_NEAR(light.weight, 1.0, 1e-12);
        EXPECT_LT(length(light.direction - Vector{0.0, 0.0, 1.0}), 1e-9);
        front += light.interactions == 1 ? 1 : 0;
    });
    EXPECT_NEAR(front / static_cast<double>(photons), 0.04, 4.0 * std::sqrt(0.04 * 0.96 / photons));
}

// Glass that absorbs: the way to the faces and back is the same for all rays of a cube corner, twice its depth.
TEST(RetroCubes, PrismsAbsorbAlongTheWay) {
    double const edge = 1.5;
    Sample_walk const walk(
        "[sample]\nkind = \"retro-cubes\"\nglass = \"g\"\nedge_mm = 1.5\nland_mm = 0.4\nsize_mm = 12.0\n"
        "[materials.g]\nkind = \"dielectric\"\nindex = 1.5\nabsorption_per_mm = 0.1");
    double const way = 2.0 * (0.4 + 2.0 * edge / std::sqrt(3.0));
    int returned = 0;
    shine(walk, towards(0.0, 0.0), 2000, [&](const Light &light) {
        if (light.interactions == 5) {
            EXPECT_NEAR(light.weight, std::exp(-0.1 * way), 1e-9);
            ++returned;
        }
    });
    EXPECT_GT(returned, 1700);
}
