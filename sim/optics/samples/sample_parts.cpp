// sample_parts.cpp: materials by name, surfaces, and limits of values.
#include "sample_parts.hpp"

#include <sstream>
#include <utility>

#include "black.hpp"
#include "turned_over.hpp"

namespace gonio::sim {

Sample_parts::Sample_parts(Toml_table materials, const Material_context &context)
    : table_(std::move(materials)), context_(context) {}

const Material &Sample_parts::own(std::unique_ptr<Material> material) {
    return *model_.materials.emplace_back(std::move(material));
}

const Material &Sample_parts::material(Toml_table &table, const std::string &key) {
    return material_named(table.text(key), table, key);
}

const Material &Sample_parts::material_named(const std::string &name, const Toml_table &asking,
                                             const std::string &key) {
    if (auto const found = named_.find(name); found != named_.end()) {
        return *found->second;
    }
    if (!table_.has(name)) {
        asking.fail(key, "names the material '" + name + "', which is not there; add [materials." + name + "]");
    }
    const Material &read = own(read_material(table_.table(name), context_));
    named_.emplace(name, &read);
    return read;
}

const Material &Sample_parts::black() {
    if (black_ == nullptr) {
        black_ = &own(std::make_unique<Black>());
    }
    return *black_;
}

std::uint32_t Sample_parts::surface(const Material &front, const Material &back) {
    return lining(front, back, 0.0);
}

std::uint32_t Sample_parts::boundary(const Material &material) {
    return lining(material, material, material.inside_absorption_per_mm());
}

std::uint32_t Sample_parts::cavity(const Material &material) {
    const Material &turned = own(std::make_unique<Turned_over>(material));
    model_.surfaces.push_back({&turned, &turned, material.inside_absorption_per_mm(), 0.0});
    return static_cast<std::uint32_t>(model_.surfaces.size() - 1);
}

std::uint32_t Sample_parts::lining(const Material &front, const Material &back, double back_absorption_per_mm) {
    model_.surfaces.push_back({&front, &back, 0.0, back_absorption_per_mm});
    return static_cast<std::uint32_t>(model_.surfaces.size() - 1);
}

Sample_model Sample_parts::finish() {
    table_.finish("is a material that nothing uses; remove it, or name it where it belongs");
    return std::move(model_);
}

double positive(Toml_table &table, const std::string &key) {
    double const value = table.number(key);
    if (!(value > 0.0)) {
        table.fail(key, "must be above 0");
    }
    return value;
}

double positive(Toml_table &table, const std::string &key, double fallback) {
    return table.has(key) ? positive(table, key) : fallback;
}

double not_negative(Toml_table &table, const std::string &key, double fallback) {
    double const value = table.number(key, fallback);
    if (!(value >= 0.0)) {
        table.fail(key, "must not be negative");
    }
    return value;
}

double within(Toml_table &table, const std::string &key, double fallback, double least, double most) {
    double const value = table.number(key, fallback);
    if (!(value >= least && value <= most)) {
        std::ostringstream limits;
        limits << "must be from " << least << " to " << most;
        table.fail(key, limits.str());
    }
    return value;
}

} // namespace gonio::sim
