// thin_plate.hpp: holes of a grid spanned as a thin elastic plate would.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace gonio::model {

// Sets the nodes (size x size) that are not known to those of a plate which is bent the least: the sum of
// z_xx^2 + 2 z_xy^2 + z_yy^2, with a thousandth of a membrane's energy, sum of z_x^2 + z_y^2 per node distance squared.
// It passes through the known nodes where their variance is 0 (or none is given); noisy ones within four nodes of a
// hole hold it by springs: the plate's second differences are taken to have the variance that those of the known nodes
// have (from their median) beyond their noise. Nothing is done where no node is known. What is found is kept within
// the known values' range and a quarter of it beyond.
void span_holes(std::vector<double> &nodes, std::span<const unsigned char> known, std::span<const double> variance,
                std::size_t size);

} // namespace gonio::model
