// test_sheet.cpp: flat sheets, the holder's opening, meshes, and what a wrong scenario is told.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "sample_walk.hpp"

using namespace gonio::sim;

namespace {

std::string told(const std::string &scenario) {
    try {
        Sample_walk const walk(scenario);
    } catch (const Input_error &error) {
        return error.what();
    }
    return "nothing";
}

} // namespace

// Mean cosine of Lambertian light is 2/3, its weight the reflectance; the part through goes on behind.
TEST(Sheet, LambertianKnownAnswer) {
    Sample_walk const walk(
        "[sample]\nkind = \"lambertian\"\nreflectance = { visible = 0.5, nir = 0.2 }\ntransmittance = 0.25");
    int const photons = 40000;
    double reflected = 0.0;
    double cosines = 0.0;
    shine(walk, towards(60.0, 20.0), photons, [&](const Light &light) {
        EXPECT_NEAR(light.weight, 0.75, 1e-12);
        if (light.direction.z > 0.0) {
            reflected += light.weight / photons;
            cosines += light.direction.z;
        }
    });
    EXPECT_NEAR(reflected, 0.5, 4.0 * 0.75 * std::sqrt(2.0 / 9.0 / photons));
    EXPECT_NEAR(cosines / (photons * reflected / 0.75), 2.0 / 3.0, 4.0 * std::sqrt(1.0 / 18.0 / (photons * 2.0 / 3.0)));
}

TEST(Sheet, MirrorKnownAnswer) {
    Sample_walk const walk(
        "[sample]\nkind = \"mirror\"\nreflectance = 0.9\nshape = \"rectangle\"\nsize_mm = [20.0, 10.0]");
    Photon_random random(1, 1);
    Light const light = walk.follow(Sample_walk::ray_to(9.9, -4.9, towards(40.0, 30.0)), random);
    EXPECT_LT(length(light.direction - towards(40.0, 210.0)), 1e-12);
    EXPECT_NEAR(light.weight, 0.9, 1e-12);
    EXPECT_TRUE(walk.passes(Sample_walk::ray_to(9.9, -5.1, towards(40.0, 30.0))));
    EXPECT_TRUE(walk.passes(Sample_walk::ray_to(10.1, -4.9, towards(40.0, 30.0))));
}

TEST(Sheet, SidesMayDiffer) {
    Sample_walk const walk(
        "[sample]\nkind = \"sheet\"\nmaterial = \"a\"\nback = \"b\"\n[materials.a]\nkind = \"mirror\"\n"
        "reflectance = 0.9\n[materials.b]\nkind = \"mirror\"\nreflectance = 0.4");
    EXPECT_NEAR(sums(walk, 30.0, 0.0, 10).reflected, 0.9, 1e-12);
    EXPECT_NEAR(sums(walk, 150.0, 0.0, 10).transmitted, 0.4, 1e-12); // back to where it came from: z < 0
}

// Of light at normal incidence the holder's opening passes its circle; the plate is as thick as it says.
TEST(Sheet, HolderHasItsOpening) {
    Sample_walk const walk(
        "[sample]\nkind = \"mirror\"\nreflectance = 1.0\nsize_mm = 8.0\n[rig]\nholder = { opening_mm = 10.0, "
        "thickness_mm = 4.0, size_mm = 50.0, reflectance = 0.0 }");
    Vector const from = towards(0.0, 0.0);
    EXPECT_TRUE(walk.passes(Sample_walk::ray_to(4.9, 0.0, from)));
    EXPECT_FALSE(walk.passes(Sample_walk::ray_to(5.1, 0.0, from)));
    EXPECT_FALSE(walk.passes(Sample_walk::ray_to(24.9, 0.0, from)));
    EXPECT_TRUE(walk.passes(Sample_walk::ray_to(25.1, 0.0, from)));
    // At 45 degrees a wall of 4 mm hides 4 mm of the opening.
    EXPECT_TRUE(walk.passes({Vector{-0.9, 0.0, 4.0} + 100.0 * towards(45.0, 0.0), -towards(45.0, 0.0)}));
    EXPECT_FALSE(walk.passes({Vector{-1.1, 0.0, 4.0} + 100.0 * towards(45.0, 0.0), -towards(45.0, 0.0)}));
}

TEST(Sheet, MeshStandsWhereItIsPut) {
    auto const path = std::filesystem::temp_directory_path() / "gonio_test_sheet.obj";
    std::ofstream(path) << "usemtl white\nv -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nf 1 2 3 4\n";
    Sample_walk const walk("[sample]\nkind = \"mesh\"\nfile = \"" + path.string() +
                           "\"\nmaterials = [\"white\"]\nunit_mm = 10.0\nposition_mm = [0.0, 5.0, -2.0]\n"
                           "[materials.white]\nkind = \"lambertian\"\nreflectance = 0.7");
    std::filesystem::remove(path);
    Hit hit{};
    ASSERT_TRUE(walk.scene().closest({{9.0, 14.0, 10.0}, {0.0, 0.0, -1.0}}, hit));
    EXPECT_NEAR(hit.distance_mm, 12.0, 1e-12);
    EXPECT_NEAR(hit.normal.z, 1.0, 1e-12);
    EXPECT_TRUE(walk.passes({{9.0, -6.0, 10.0}, {0.0, 0.0, -1.0}}));
}

TEST(Sheet, WrongScenariosAreRefused) {
    EXPECT_NE(told("[sample]\nkind = \"louvre\"").find("must be one of lambertian"), std::string::npos);
    EXPECT_NE(told("[sample]\nkind = \"mirror\"\nreflectance = 0.9\nsise_mm = 3.0").find("'sise_mm'"),
              std::string::npos);
    EXPECT_NE(told("[sample]\nkind = \"sheet\"\nmaterial = \"a\"").find("add [materials.a]"), std::string::npos);
    EXPECT_NE(told("[sample]\nkind = \"mirror\"\nreflectance = 0.9\n[materials.b]\nkind = \"black\"").find("'b'"),
              std::string::npos);
    EXPECT_NE(told("[sample]\nkind = \"mirror\"\nreflectance = 1.9").find("from 0 to 1"), std::string::npos);
    EXPECT_NE(told("[sample]\nkind = \"lambertian\"\nreflectance = 0.9\ntransmittance = 0.2").find("from 0 to 1"),
              std::string::npos);
    EXPECT_NE(told("[sample]\nkind = \"weave\"\nmaterial = \"a\"\npitch_mm = 0.686\n[materials.a]\nkind = \"black\"")
                  .find("no room to bend"),
              std::string::npos);
    EXPECT_NE(
        told("[sample]\nkind = \"mesh\"\nfile = \"none.obj\"\nmaterials = [\"a\"]\n[materials.a]\nkind = \"black\"")
            .find("none.obj"),
        std::string::npos);
}
