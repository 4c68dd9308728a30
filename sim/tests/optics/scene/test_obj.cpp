// test_obj.cpp: the OBJ reader: the format's forms, its errors, and files with random damage.
#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "obj.hpp"
#include "scene_tests.hpp"
#include "toml_table.hpp"

using namespace gonio::sim;

namespace {

std::vector<Triangle> read(const std::string &text, const Surface_names &surfaces = {{"", 9}}) {
    std::istringstream stream(text);
    return read_obj(stream, "mesh.obj", surfaces);
}

std::string error_of(const std::string &text, const Surface_names &surfaces = {{"", 9}}) {
    try {
        read(text, surfaces);
    } catch (const Input_error &error) {
        return error.what();
    }
    return "no error";
}

const std::string square = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

TEST(Obj, corners_may_name_texture_and_normal) {
    for (const std::string face : {"f 1 2 3", "f 1/1 2/2 3/1", "f 1//1 2//1 3//1", "f 1/1/1 2/2/1 3/1/1", "f -4 -3 -2",
                                   "f  1\t2   3  ", "f 1 2 3 # a comment", "f 1 \\\n2 3", "f +1 +2 +3"}) {
        auto const triangles = read(std::string(square).append("vt 0 0\nvt 1 1\nvn 0 0 1\n").append(face).append("\n"));
        ASSERT_EQ(triangles.size(), 1U) << face;
        EXPECT_EQ(triangles[0].a, (Vector{0.0, 0.0, 0.0}));
        EXPECT_EQ(triangles[0].b, (Vector{1.0, 0.0, 0.0}));
        EXPECT_EQ(triangles[0].c, (Vector{1.0, 1.0, 0.0}));
        EXPECT_EQ(triangles[0].surface, 9U);
    }
}

TEST(Obj, polygons_are_fanned_and_slivers_left_out) {
    auto const triangles = read(square + "f 1 2 3 4\nf 1 2 2\nf 1 1 1\n");
    ASSERT_EQ(triangles.size(), 2U);
    EXPECT_EQ(triangles[1].b, (Vector{1.0, 1.0, 0.0}));
    EXPECT_EQ(triangles[1].c, (Vector{0.0, 1.0, 0.0}));
}

TEST(Obj, line_ends_and_everything_else_of_the_format) {
    auto const triangles = read("# made by hand\r\nmtllib a.mtl\r\no thing\r\ng\r\nv 0 0 0 1\r\nv 1e0 .5 -0.5e-3 "
                                "0.1 0.2 0.3\r\nv 1 1. 0\r\n\r\ns off\r\nusemtl gold leaf \r\nf 1 2 3",
                                {{"gold leaf", 2}, {"tin", 3}});
    ASSERT_EQ(triangles.size(), 1U);
    EXPECT_EQ(triangles[0].surface, 2U);
    EXPECT_EQ(triangles[0].b, (Vector{1.0, 0.5, -0.5e-3}));
}

TEST(Obj, errors_name_file_and_line) {
    EXPECT_EQ(error_of(square + "f 1 2 5\n"), "mesh.obj:5: vertex 5 of 4 so far; give it before the face");
    EXPECT_EQ(error_of(square + "f 1 2 -5\n"), "mesh.obj:5: vertex -5 of 4 so far; give it before the face");
    std::string const corner = "a corner is v, v/vt, v//vn or v/vt/vn, whole numbers from 1, or from -1 backwards";
    for (const std::string face : {"0 1 2", "a b c", "1/ 2 3", "1// 2 3", "1/2/3/4 2 3", "1.5 2 3", "/1 2 3", "1/x 2 3",
                                   "1//0 2 3", "99999999999999999999 1 2", "+-1 2 3"}) {
        EXPECT_EQ(error_of(std::string(square).append("\n\nf ").append(face)), "mesh.obj:7: " + corner) << face;
    }
    EXPECT_EQ(error_of(square + "f 1 2"), "mesh.obj:5: a face needs three corners or more");
    for (const std::string vertex : {"0 0", "0 0 x", "nan 0 0", "inf 0 0", "1e7 0 0", "1e999 0 0", "0 0 0 0 0 0 0 0"}) {
        EXPECT_EQ(error_of("v " + vertex), "mesh.obj:1: a vertex needs three numbers, 1e6 mm at most") << vertex;
    }
    EXPECT_EQ(error_of("curv 0 1 2"), "mesh.obj:1: 'curv' is not read here; export the mesh as polygons");
    EXPECT_EQ(error_of(square), "mesh.obj: holds no face with an area; export the mesh as polygons");
    EXPECT_EQ(error_of(""), "mesh.obj: holds no face with an area; export the mesh as polygons");
    EXPECT_EQ(error_of(square + "f 1 2 3", {{"tin", 0}}), "mesh.obj:5: a face before any usemtl; name its material");
    EXPECT_EQ(error_of("usemtl lead", {{"gold", 1}, {"tin", 0}}),
              "mesh.obj:1: no surface is given for material 'lead'; there are: gold, tin");
    EXPECT_THROW(read_obj(std::filesystem::path("no/such/file.obj"), {}), Input_error);
}

// Whatever the damage, the reader ends: triangles that are numbers, or an error of one line.
TEST(Obj, survives_damage) {
    Dice dice(1);
    std::string const whole =
        "mtllib a\n" + square + "vt 0 0\nvn 0 0 1\nusemtl a\nf 1/1/1 2//1 3 -1\nf -1 -2 -3\\\n 1\n";
    std::string const letters = "0123456789-+./#\\ \n\r\tvfex\xff";
    int good = 0;
    for (int i = 0; i < 20000; ++i) {
        std::string text = whole;
        for (std::uint32_t k = dice.below(4) + 1; k > 0; --k) {
            text += text.empty() ? "f" : "";
            std::size_t const place = dice.below(static_cast<std::uint32_t>(text.size()));
            char const letter = letters.at(dice.below(static_cast<std::uint32_t>(letters.size())));
            switch (dice.below(4)) {
            case 0:
                text.at(place) = letter;
                break;
            case 1:
                text.insert(place, 1, letter);
                break;
            case 2:
                text.erase(place, 1 + dice.below(5));
                break;
            default:
                text.resize(place + 1);
                break;
            }
        }
        try {
            for (const Triangle &triangle : read(text, {{"", 0}, {"a", 1}})) {
                for (const Vector &corner : {triangle.a, triangle.b, triangle.c}) {
                    EXPECT_LE(std::abs(corner.x) + std::abs(corner.y) + std::abs(corner.z), 3e6);
                }
                EXPECT_LE(triangle.surface, 1U);
            }
            ++good;
        } catch (const Input_error &error) {
            EXPECT_EQ(std::string(error.what()).rfind("mesh.obj:", 0), 0U);
        }
    }
    EXPECT_GT(good, 1000);
    EXPECT_LT(good, 19000);
}

} // namespace
