// sample_reader.cpp: which kind of sample, and what holds it.
#include "sample_reader.hpp"

#include <array>
#include <utility>

#include "holder.hpp"
#include "kinds.hpp"

namespace gonio::sim {
namespace {

using Add = void (*)(Toml_table &, Sample_parts &);

constexpr std::array<std::pair<const char *, Add>, 10> kinds = {{{"lambertian", add_lambertian},
                                                                 {"mirror", add_mirror},
                                                                 {"sheet", add_sheet},
                                                                 {"blind", add_blind},
                                                                 {"louver", add_louver},
                                                                 {"weave", add_weave},
                                                                 {"window-glass", add_window_glass},
                                                                 {"retro-beads", add_retro_beads},
                                                                 {"retro-cubes", add_retro_cubes},
                                                                 {"mesh", add_mesh}}};

} // namespace

Sample_model read_sample(const toml::table &scenario, const std::string &where, const Material_context &context) {
    Toml_table root(scenario, where);
    Sample_parts parts(root.table("materials"), context);
    Toml_table sample = root.table("sample");
    sample.ignore({"mounted"});
    std::string const kind = sample.text("kind");
    Add add = nullptr;
    std::string known;
    for (const auto &[name, function] : kinds) {
        add = kind == name ? function : add;
        known += (known.empty() ? "" : ", ") + std::string(name);
    }
    if (add == nullptr) {
        sample.fail("kind", "must be one of " + known);
    }
    add(sample, parts);
    sample.finish();
    Toml_table rig = root.table("rig");
    if (rig.has("holder")) {
        Toml_table holder = rig.table("holder");
        add_holder(holder, parts);
    }
    return parts.finish();
}

Sample_model free_beam() {
    return {};
}

} // namespace gonio::sim
