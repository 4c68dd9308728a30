// test_material_reader.cpp: [materials.NAME] tables of a scenario, per band, and what is refused.
#include "material_checks.hpp"

#include "material_reader.hpp"

namespace gonio::sim {
namespace {

class Reader : public testing::Test {
protected:
    std::map<std::string, Scatter_table> tables;
    std::unique_ptr<Material> read(const std::string &text, const std::string &band = "visible",
                                   double wavelength_nm = 550.0) const {
        toml::table const table = toml::parse(text);
        return read_material(Toml_table(table, "scenario.toml [materials.m]"), {band, wavelength_nm, tables, "."});
    }
    std::string refusal(const std::string &text) const {
        try {
            read(text);
        } catch (const Input_error &error) {
            return error.what();
        }
        return "";
    }
    Albedo normal(const std::string &text, const std::string &band = "visible", double wavelength_nm = 550.0) const {
        return read(text, band, wavelength_nm)->albedo(arrival(0.0));
    }
};

TEST_F(Reader, Reads_every_kind) {
    EXPECT_EQ(normal("kind = 'black'").reflectance, 0.0);
    EXPECT_EQ(normal("kind = 'lambertian'\nreflectance = 0.5\ntransmittance = 0.2").transmittance, 0.2);
    EXPECT_EQ(normal("kind = 'mirror'\nreflectance = 0.9").reflectance, 0.9);
    EXPECT_NEAR(normal("kind = 'mirror'\nreflectance_s = 0.9\nreflectance_p = 0.7").reflectance, 0.8, 1e-15);
    EXPECT_NEAR(normal("kind = 'metal'\nreflectance = 0.8\nspecularity = 0.9").reflectance, 0.8, 6e-3);
    EXPECT_NEAR(normal("kind = 'metal'\nreflectance = 0.8\nspecularity = 0.9\nroughness = 0.05").reflectance, 0.8,
                2e-3);
    EXPECT_NEAR(normal("kind = 'plastic'\nreflectance = 0.5\nspecularity = 0.04\nroughness = 0.1").reflectance, 0.52,
                1e-3);
    EXPECT_NEAR(normal("kind = 'glass'\ntransmissivity = 0.96").transmittance, 0.88, 2e-3);
    EXPECT_NEAR(normal("kind = 'dielectric'\nindex = 1.52").reflectance, 0.04258, 1e-5);
    EXPECT_EQ(normal("kind = 'ward-duer'\nreflectance = 0.9\nspecular_share = 1").reflectance, 0.9);
    EXPECT_NEAR(normal("kind = 'ggx-dielectric'\nalpha_x = 0.01").reflectance, 0.04258, 1e-4);
    EXPECT_NEAR(normal("kind = 'ggx-dielectric'\nalpha_x = 0").reflectance, 0.04258, 1e-5);
    EXPECT_NEAR(normal("kind = 'thin-plate'\nindex = 1.52").reflectance, 0.08168, 1e-5);
    EXPECT_EQ(normal("kind = 'thin-plate'\nreflectance_s = 0.6\nreflectance_p = 0.4\ntransmittance_s = 0.4\n"
                     "transmittance_p = 0.6")
                  .reflectance,
              0.5);
    EXPECT_NEAR(normal("kind = 'layers'\n[[layer]]\nkind = 'plate'\nindex = 1.52\n[[layer]]\nkind = 'glass'\n"
                       "transmissivity = 1.0")
                    .reflectance,
                4.0 * 0.04258 / (1.0 + 3.0 * 0.04258), 1e-5);
    EXPECT_EQ(normal("kind = 'layers'\n[[layer]]\nkind = 'coating'\nreflectance = 0.7\nback_reflectance = 0.2\n"
                     "transmittance = 0.25")
                  .transmittance,
              0.25);
}

TEST_F(Reader, Takes_the_values_of_the_band) {
    std::string const text = "kind = 'lambertian'\nreflectance = { visible = 0.8, near-infrared = 0.6 }";
    EXPECT_EQ(normal(text, "visible").reflectance, 0.8);
    EXPECT_EQ(normal(text, "near-infrared").reflectance, 0.6);
    EXPECT_THROW(normal(text, "red"), Input_error);
}

TEST_F(Reader, Evaluates_Cauchys_formula_at_the_wavelength) {
    // 1.5046 + 0.0042 / 0.55^2 = 1.51848.
    std::string const text = "kind = 'dielectric'\nindex = [1.5046, 0.0042]";
    EXPECT_NEAR(normal(text).reflectance, std::pow(0.51848 / 2.51848, 2), 1e-6);
    EXPECT_LT(normal(text, "visible", 1000.0).reflectance, normal(text).reflectance);
}

TEST_F(Reader, Takes_absorption_as_Radiance_gives_it_too) {
    EXPECT_NEAR(read("kind = 'dielectric'\ntransmission_per_mm = 0.9")->inside_absorption_per_mm(), -std::log(0.9),
                1e-14);
    EXPECT_NEAR(read("kind = 'ggx-dielectric'\nalpha_x = 0.1\nabsorption_per_mm = 0.2")->inside_absorption_per_mm(),
                0.2, 1e-15);
    EXPECT_NEAR(normal("kind = 'thin-plate'\nabsorption_per_mm = 0.1\nthickness_mm = 4").transmittance,
                normal("kind = 'glass'\ntransmissivity = " + std::to_string(std::exp(-0.4))).transmittance, 1e-6);
}

TEST_F(Reader, Finds_tables_by_their_name) {
    Scatter_table table;
    table.cells = 1;
    table.front.push_back({0.0, 0.0, {0.25 / std::numbers::pi}, {}});
    tables["coating.h5"] = table;
    EXPECT_NEAR(normal("kind = 'tabulated'\nfile = 'coating.h5'").reflectance, 0.25, 1e-15);
    EXPECT_NE(refusal("kind = 'tabulated'\nfile = 'absent.scatter'").find("no such file"), std::string::npos);
}

TEST_F(Reader, Refuses_what_it_does_not_know) {
    EXPECT_NE(refusal("kind = 'chrome'").find("known are black, lambertian"), std::string::npos);
    EXPECT_NE(refusal("reflectance = 0.5").find("'kind' is missing"), std::string::npos);
    EXPECT_NE(refusal("kind = 'lambertian'").find("'reflectance' is missing"), std::string::npos);
    EXPECT_NE(refusal("kind = 'lambertian'\nreflectence = 0.5\nreflectance = 0.5").find("'reflectence'"),
              std::string::npos);
    EXPECT_NE(refusal("kind = 'black'\nreflectance = 0.5").find("'reflectance'"), std::string::npos);
}

TEST_F(Reader, Refuses_values_without_physical_sense) {
    for (const char *text : {
             "kind = 'lambertian'\nreflectance = 1.1",
             "kind = 'lambertian'\nreflectance = -0.1",
             "kind = 'lambertian'\nreflectance = nan",
             "kind = 'lambertian'\nreflectance = 0.6\ntransmittance = 0.6",
             "kind = 'ward-duer'\nreflectance = 0.6\nspecular_share = 0.5\nroughness_x = 0\nroughness_y = 0.1",
             "kind = 'ggx-dielectric'\nalpha_x = 0.1\nalpha_y = 0",
             "kind = 'ggx-dielectric'\nalpha_x = 0.1\nindex = 1.3\noutside_index = 1.3",
             "kind = 'dielectric'\nindex = 0",
             "kind = 'dielectric'\ntransmission_per_mm = 0",
             "kind = 'dielectric'\ntransmission_per_mm = 0.9\nabsorption_per_mm = 0.1",
             "kind = 'thin-plate'\nabsorption_per_mm = 0.1",
             R"(kind = 'thin-plate'
                reflectance_s = 0.6
                reflectance_p = 0.4
                transmittance_s = 0.5
                transmittance_p = 0.6)",
             "kind = 'layers'",
             "kind = 'layers'\n[[layer]]\nkind = 'coating'\nreflectance = 0.7\ntransmittance = 0.4",
             "kind = 'layers'\n[[layer]]\nkind = 'foil'",
         }) {
        EXPECT_NE(refusal(text), "") << text;
    }
}

} // namespace
} // namespace gonio::sim
