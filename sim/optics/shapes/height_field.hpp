// height_field.hpp: a biquadratic B-spline surface over a rectangle, ready for rays, patch by patch.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "ray.hpp"

namespace gonio::sim {

struct Height_field;
class Height_patch;

class Ready_height_field {
public:
    // `number`: of its first patch.
    Ready_height_field(Height_field shape, std::uint32_t number);

    [[nodiscard]] std::uint32_t patches() const { return across_ * along_; }
    [[nodiscard]] Height_patch patch(std::uint32_t index) const;

    std::uint32_t number;
    std::uint32_t surface;

private:
    friend class Height_patch;

    Vector corner_;
    Frame frame_;
    double patch_width_;
    double patch_depth_;
    std::uint32_t across_; // patches along s
    std::uint32_t along_;  // patches along t
    std::vector<double> heights_;
};

// One of its patches; valid as long as the field. Tangent: along s.
class Height_patch {
public:
    Height_patch(const Ready_height_field &field, std::uint32_t index);

    [[nodiscard]] double distance_mm(const Ray &ray) const;
    [[nodiscard]] Facing facing(const Vector &place) const;
    [[nodiscard]] Box bounds() const;

    std::uint32_t number;
    std::uint32_t surface;

private:
    using Row = std::array<double, 3>;

    const Ready_height_field &field_;
    std::uint32_t column_;
    std::uint32_t row_;
    std::array<Row, 3> heights_; // Bernstein coefficients: [along t][along s]
    double lowest_;
    double highest_;
};

inline Height_patch Ready_height_field::patch(std::uint32_t index) const {
    return {*this, index};
}

} // namespace gonio::sim
