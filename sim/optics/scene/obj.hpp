// obj.hpp: reads triangle meshes from Wavefront OBJ files.
#pragma once

#include <filesystem>
#include <istream>
#include <map>
#include <string>
#include <vector>

#include "shapes.hpp"

namespace gonio::sim {

// Surface index by the name that `usemtl` gives; "" is for faces that come before any.
using Surface_names = std::map<std::string, std::uint32_t>;

// The file's faces as triangles, polygons fanned from their first corner (so they should be convex), slivers without
// area left out. Corners run counter-clockwise seen from the front, as the format has it. Lengths as they stand in the
// file. Reads v, f, usemtl; skips normals, texture, groups, lines and points. Throws Input_error with file and line.
std::vector<Triangle> read_obj(const std::filesystem::path &path, const Surface_names &surfaces);
// `name`: what errors call it.
std::vector<Triangle> read_obj(std::istream &text, const std::string &name, const Surface_names &surfaces);

} // namespace gonio::sim
