// clusters.hpp: points averaged in cells of about equal size, and those of them that are near a direction.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "hilbert.hpp"

namespace gonio::sphere {

// Means over a number of points.
struct Cluster {
    double count = 0.0;
    Vec unit;
    std::array<double, 6> products{}; // of the components of unit: xx yy zz xy xz yz
    double value = 0.0;
    double variance = 0.0; // of the mean value
};

// A single point.
inline Cluster cluster_of(const Vec &u, double value, double variance) {
    return {1.0, u, {u.x * u.x, u.y * u.y, u.z * u.z, u.x * u.y, u.x * u.z, u.y * u.z}, value, variance};
}

// Smaller clusters joined in cells: rows of polar angle, divided in azimuth.
class Clusters {
public:
    Clusters(std::span<const Cluster> parts, double cell);

    [[nodiscard]] std::span<const Cluster> all() const { return clusters_; }

    // Those whose mean is nearer than the chord `reach`.
    void near(const Vec &direction, double reach, std::vector<const Cluster *> &found) const;

private:
    [[nodiscard]] std::size_t row_of(double polar) const;

    std::vector<Cluster> clusters_; // row by row, by column
    std::vector<Index> column_;     // of each
    std::vector<Index> row_start_;
    std::vector<Index> columns_; // per row
};

} // namespace gonio::sphere
