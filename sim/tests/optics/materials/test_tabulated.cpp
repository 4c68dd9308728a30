// test_tabulated.cpp: materials from data: drawing, interpolation, peaks that move, and the text form.
#include "material_checks.hpp"

#include <filesystem>
#include <fstream>

#include "tabulated.hpp"
#include "toml_table.hpp"
#include "ward_duer.hpp"

namespace gonio::sim {
namespace {

using Follow = Scatter_table::Follow;
constexpr double degree = std::numbers::pi / 180.0;

// BSDF of a material at the cells' centres, scaled to this energy.
std::vector<double> sampled(const Material &material, const Arrival &light, std::uint32_t cells, double energy) {
    std::vector<double> values;
    double sum = 0.0;
    for (std::uint32_t i = 0; i < cells * cells; ++i) {
        std::uint32_t const row = i / cells;
        auto const [x, y] = disc_of_square((i % cells + 0.5) / cells, (row + 0.5) / cells);
        double const z = std::sqrt(1.0 - x * x - y * y);
        values.push_back(material.dsf_per_sr(light, {x, y, z}) / z);
        sum += values.back() * std::numbers::pi / (cells * cells);
    }
    for (double &value : values) {
        value *= energy / sum;
    }
    return values;
}

Scatter_table ward_table(std::uint32_t cells, Follow follow, const std::vector<double> &thetas_deg) {
    Ward_duer const finish(1.0, 0.7, 0.15, 0.15);
    Scatter_table table;
    table.cells = cells;
    table.follow = follow;
    for (double const theta : thetas_deg) {
        table.front.push_back({theta, 0.0, sampled(finish, arrival(theta), cells, 0.6),
                               sampled(finish, arrival(theta), cells, 0.1 + theta / 300.0)});
    }
    return table;
}

// One cell alone is bright: a peak. `x`, `y`: where.
std::vector<double> peak(std::uint32_t cells, double x, double y, double energy) {
    std::vector<double> values(std::size_t{cells} * cells, 0.0);
    auto const [u, v] = square_of_disc({x, y});
    values[static_cast<std::size_t>(v * cells) * cells + static_cast<std::size_t>(u * cells)] =
        energy * cells * cells / std::numbers::pi;
    return values;
}

TEST(Disc, Is_covered_by_the_square_with_equal_areas) {
    for (double const u : {0.0, 0.1, 0.37, 0.5, 0.9, 1.0}) {
        for (double const v : {0.0, 0.2, 0.5, 0.63, 1.0}) {
            Disc_point const point = disc_of_square(u, v);
            EXPECT_LE(point.x * point.x + point.y * point.y, 1.0 + 1e-14);
            auto const [back_u, back_v] = square_of_disc(point);
            EXPECT_NEAR(back_u, u, 1e-12);
            EXPECT_NEAR(back_v, v, 1e-12);
        }
    }
    // Areas: the map's determinant is pi everywhere.
    for (double const u : {0.3, 0.8}) {
        constexpr double step = 1e-6;
        Disc_point const origin = disc_of_square(u, 0.6);
        Disc_point const right = disc_of_square(u + step, 0.6);
        Disc_point const up = disc_of_square(u, 0.6 + step);
        double const area = (right.x - origin.x) * (up.y - origin.y) - (right.y - origin.y) * (up.x - origin.x);
        EXPECT_NEAR(area / (step * step), std::numbers::pi, 1e-4);
    }
}

TEST(Disc, Moves_onto_itself_and_back) {
    Disc_point const from{-0.3, 0.4};
    Disc_point const to{-0.85, 0.3};
    for (double const x : {-0.9, -0.3, 0.0, 0.6}) {
        for (double const y : {-0.4, 0.0, 0.4}) {
            Moved const moved = move_within_disc({x, y}, from, to);
            EXPECT_LE(moved.point.x * moved.point.x + moved.point.y * moved.point.y, 1.0 + 1e-14);
            Moved const back = move_within_disc(moved.point, to, from);
            EXPECT_NEAR(back.point.x, x, 1e-12);
            EXPECT_NEAR(back.point.y, y, 1e-12);
            EXPECT_NEAR(back.area * moved.area, 1.0, 1e-12);
            // The factor on areas against differences.
            constexpr double step = 1e-6;
            Disc_point const right = move_within_disc({x + step, y}, from, to).point;
            Disc_point const up = move_within_disc({x, y + step}, from, to).point;
            Disc_point const &p = moved.point;
            double const area = (right.x - p.x) * (up.y - p.y) - (right.y - p.y) * (up.x - p.x);
            EXPECT_NEAR(area / (step * step), moved.area, 1e-4 * moved.area);
        }
    }
    // Near the centre it is a plain shift.
    Disc_point const near = move_within_disc({-0.28, 0.41}, from, to).point;
    EXPECT_NEAR(near.x, -0.83, 1e-15);
    EXPECT_NEAR(near.y, 0.31, 1e-15);
}

TEST(Tabulated_surface, Follows_its_density) {
    for (Follow const follow : {Follow::none, Follow::mirror, Follow::retro}) {
        Tabulated const surface(ward_table(16, follow, {0.0, 30.0, 60.0}), "test");
        for (double const theta : {0.0, 12.0, 48.0, 78.0}) {
            SCOPED_TRACE(theta);
            // Jumps from cell to cell make the quadrature coarse.
            check_material(surface, arrival(theta, 77.0, theta < 40.0), {.quadrature = 5e-3, .steps = 11});
        }
    }
}

TEST(Tabulated_surface, Keeps_the_energy_of_its_data) {
    Tabulated const surface(ward_table(16, Follow::mirror, {0.0, 30.0, 60.0}), "test");
    EXPECT_NEAR(surface.albedo(arrival(30.0)).reflectance, 0.6, 1e-12);
    EXPECT_NEAR(surface.albedo(arrival(30.0)).transmittance, 0.2, 1e-12);
    EXPECT_NEAR(surface.albedo(arrival(40.0)).transmittance, 0.2 + 10.0 / 300.0, 1e-12);
    EXPECT_NEAR(surface.albedo(arrival(80.0)).transmittance, 0.3, 1e-12); // beyond: the last one
    for (std::uint64_t photon = 0; photon < 100; ++photon) {
        Photon_random random(1, photon);
        EXPECT_NEAR(surface.scatter(arrival(40.0), random).share, 0.8 + 10.0 / 300.0, 1e-12);
    }
}

// A peak in the mirror direction of 30 and 60 degrees is in that of 45, not in two halves beside it.
TEST(Tabulated_surface, Moves_a_peak_with_the_direction_that_it_follows) {
    constexpr std::uint32_t cells = 64;
    auto const mean_direction = [&](Follow follow, double sign, double photon_theta, double photon_phi) {
        Scatter_table table;
        table.cells = cells;
        table.follow = follow;
        for (double const theta : {30.0, 60.0}) {
            table.front.push_back({theta, 0.0, peak(cells, sign * std::sin(theta * degree), 0.0, 0.9), {}});
        }
        Tabulated const surface(table, "test");
        Vector mean{};
        double spread = 0.0;
        Arrival const light = arrival(photon_theta, photon_phi);
        constexpr int photons = 2000;
        for (std::uint64_t photon = 0; photon < photons; ++photon) {
            Photon_random random(1, photon);
            Vector const out = surface.scatter(light, random).direction;
            mean = mean + (1.0 / photons) * out;
            double const dx = out.x - sign * light.towards.x;
            double const dy = out.y - sign * light.towards.y;
            spread = std::max(spread, std::sqrt(dx * dx + dy * dy));
        }
        EXPECT_LT(spread, 3.0 / cells);
        return mean;
    };
    Vector const mirror = mean_direction(Follow::mirror, -1.0, 45.0, 120.0);
    EXPECT_NEAR(mirror.x, -arrival(45.0, 120.0).towards.x, 1.5 / cells);
    EXPECT_NEAR(mirror.y, -arrival(45.0, 120.0).towards.y, 1.5 / cells);
    Vector const retro = mean_direction(Follow::retro, 1.0, 45.0, -60.0);
    EXPECT_NEAR(retro.x, arrival(45.0, -60.0).towards.x, 1.5 / cells);
}

// Anisotropic: the table stays where it is, and its azimuths are interpolated all round.
TEST(Tabulated_surface, Interpolates_around_a_ring_of_azimuths) {
    constexpr std::uint32_t cells = 16;
    Scatter_table table;
    table.cells = cells;
    table.isotropic = false;
    std::vector<double> const flat(std::size_t{cells} * cells, 1.0 / std::numbers::pi);
    auto const scaled = [&](double energy) {
        std::vector<double> values = flat;
        for (double &value : values) {
            value *= energy;
        }
        return values;
    };
    table.front.push_back({0.0, 0.0, scaled(0.5), {}});
    for (int i = 0; i < 4; ++i) {
        table.front.push_back({60.0, 90.0 * i, scaled(0.2 + 0.1 * i), {}});
    }
    Tabulated const surface(table, "test");
    EXPECT_NEAR(surface.albedo(arrival(60.0, 45.0)).reflectance, 0.25, 1e-12);
    EXPECT_NEAR(surface.albedo(arrival(60.0, 270.0)).reflectance, 0.5, 1e-12);
    EXPECT_NEAR(surface.albedo(arrival(60.0, 315.0)).reflectance, 0.35, 1e-12);
    EXPECT_NEAR(surface.albedo(arrival(30.0, 45.0)).reflectance, 0.375, 1e-12);
    check_material(surface, arrival(40.0, 200.0));
}

TEST(Tabulated_surface, Refuses_data_without_physical_sense) {
    Scatter_table table = ward_table(8, Follow::none, {0.0});
    table.front[0].reflected[3] += 100.0;
    EXPECT_THROW(Tabulated(table, "test"), Input_error);
    table = ward_table(8, Follow::none, {0.0});
    table.front[0].reflected[3] = -0.1;
    EXPECT_THROW(Tabulated(table, "test"), Input_error);
    table.front[0].reflected[3] = std::nan("");
    EXPECT_THROW(Tabulated(table, "test"), Input_error);
    table.front[0].reflected.pop_back();
    EXPECT_THROW(Tabulated(table, "test"), Input_error);
    EXPECT_THROW(Tabulated(Scatter_table{}, "test"), Input_error);
    EXPECT_THROW(Tabulated(ward_table(8, Follow::none, {20.0, 20.0}), "test"), Input_error);
    EXPECT_THROW(Tabulated(ward_table(8, Follow::none, {91.0}), "test"), Input_error);
}

class Table_file : public testing::Test {
protected:
    std::filesystem::path path =
        std::filesystem::temp_directory_path() /
        (std::string("gonio-") + testing::UnitTest::GetInstance()->current_test_info()->name() + ".scatter");
    void write(const std::string &text) const { std::ofstream(path) << text; }
    void TearDown() override { std::filesystem::remove(path); }
    std::string message() const {
        try {
            load_scatter_table(path);
        } catch (const Input_error &error) {
            return error.what();
        }
        return "";
    }
    const std::string header = "gonio-scatter-table 1\ncells 2\nfollow retro\nisotropic no\n";
};

TEST_F(Table_file, Is_read) {
    write("# measured\n" + header + "\nfront 30 90 reflected # part\n0.1 2e-1\n0.3\t0.4\r\nfront 30 90 transmitted\n" +
          "0 0\n0 0.01\nback 10 0 reflected\n1 1\n1 1\n");
    Scatter_table const table = load_scatter_table(path);
    EXPECT_EQ(table.cells, 2U);
    EXPECT_EQ(table.follow, Follow::retro);
    EXPECT_FALSE(table.isotropic);
    ASSERT_EQ(table.front.size(), 1U);
    EXPECT_EQ(table.front[0].phi_deg, 90.0);
    EXPECT_EQ(table.front[0].reflected, (std::vector<double>{0.1, 0.2, 0.3, 0.4}));
    EXPECT_EQ(table.front[0].transmitted, (std::vector<double>{0.0, 0.0, 0.0, 0.01}));
    EXPECT_EQ(table.back.at(0).theta_deg, 10.0);
    EXPECT_TRUE(table.back.at(0).transmitted.empty());
}

TEST_F(Table_file, Says_where_it_is_wrong) {
    EXPECT_NE(message().find("no such file"), std::string::npos);
    write("gonio-scatter-table 2\n");
    EXPECT_NE(message().find("line 1: only version 1"), std::string::npos);
    write("gonio-scatter-table 1\ncells 0\n");
    EXPECT_NE(message().find("line 2: 'cells'"), std::string::npos);
    write("gonio-scatter-table 1\ncells 2\nfollow sun\n");
    EXPECT_NE(message().find("line 3: 'follow'"), std::string::npos);
    write(header);
    EXPECT_NE(message().find("no incident direction"), std::string::npos);
    write(header + "front 30 0\n");
    EXPECT_NE(message().find("line 5: expected side"), std::string::npos);
    write(header + "front 30 0 reflected\n0.1 0.2\n0.3\n");
    EXPECT_NE(message().find("line 7: needs 2 numbers, has 1"), std::string::npos);
    write(header + "front 30 0 reflected\n0.1 0.2\n0.3 0,4\n");
    EXPECT_NE(message().find("line 7: '0,4' is not a number"), std::string::npos);
    write(header + "front 30 0 reflected\n0.1 0.2\n");
    EXPECT_NE(message().find("needs 2 numbers, has 0"), std::string::npos);
    write(header + "front 3 0 reflected\n0 0\n0 0\nfront 3 0 reflected\n0 0\n0 0\n");
    EXPECT_NE(message().find("second time"), std::string::npos);
}

} // namespace
} // namespace gonio::sim
