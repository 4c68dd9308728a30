// sample_parts.hpp: what the kinds of sample are put together from: materials by name, surfaces, shapes.
#pragma once

#include <map>
#include <string>

#include "material_reader.hpp"
#include "sample.hpp"
#include "toml_table.hpp"

namespace gonio::sim {

class Sample_parts {
public:
    // `materials`: the scenario's [materials]. Keeps a reference to `context`.
    Sample_parts(Toml_table materials, const Material_context &context);

    [[nodiscard]] const Material_context &context() const { return context_; }

    // The material that is named by `key` of a sample's table; read when it is first asked for.
    const Material &material(Toml_table &table, const std::string &key);
    // The material of that name; `asking`: who names it, for the error.
    const Material &material_named(const std::string &name, const Toml_table &asking, const std::string &key);
    // A material that has no name in the file.
    const Material &own(std::unique_ptr<Material> material);
    const Material &black();

    // A surface; its number is what shapes are given.
    std::uint32_t surface(const Material &front, const Material &back);
    // A surface with air on its front and the medium of the material (dielectric, ggx-dielectric) on its back.
    std::uint32_t boundary(const Material &material);
    // The other way round: the medium on the front, air on the back.
    std::uint32_t cavity(const Material &material);
    // A surface with air on its front; on its back a medium that absorbs.
    std::uint32_t lining(const Material &front, const Material &back, double back_absorption_per_mm);

    Shapes &shapes() { return model_.shapes; }
    Sample_model &model() { return model_; }

    // To be called last: refuses materials that nobody asked for.
    Sample_model finish();

private:
    Toml_table table_;
    const Material_context &context_;
    std::map<std::string, const Material *> named_;
    const Material *black_ = nullptr;
    Sample_model model_;
};

// Values with a lower limit. Throw Input_error.
double positive(Toml_table &table, const std::string &key);
double positive(Toml_table &table, const std::string &key, double fallback);
double not_negative(Toml_table &table, const std::string &key, double fallback);
double within(Toml_table &table, const std::string &key, double fallback, double least, double most);

} // namespace gonio::sim
