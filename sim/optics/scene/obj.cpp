// obj.cpp: see obj.hpp.
#include "obj.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <fstream>
#include <string_view>

#include "toml_table.hpp"

namespace gonio::sim {

namespace {

constexpr std::string_view blanks = " \t\r\v\f";
// Far above any sample, far below what would overflow in a product.
constexpr double largest_coordinate_mm = 1e6;
// Height over longest side at which a triangle counts as a line.
constexpr double sliver = 1e-12;

// The next word of the line, which loses it; empty at the end.
std::string_view take_word(std::string_view &line) {
    line.remove_prefix(std::min(line.find_first_not_of(blanks), line.size()));
    std::string_view const word = line.substr(0, line.find_first_of(blanks));
    line.remove_prefix(word.size());
    return word;
}

template <class Number> bool parse(std::string_view word, Number &number) {
    if (word.size() > 1 && word[0] == '+' && word[1] != '-') {
        word.remove_prefix(1);
    }
    auto const result = std::from_chars(word.data(), word.data() + word.size(), number);
    return result.ec == std::errc() && result.ptr == word.data() + word.size();
}

class Obj_reader {
public:
    Obj_reader(std::istream &text, const std::string &name, const Surface_names &surfaces)
        : text_(text), name_(name), surfaces_(surfaces), surface_(surfaces.find("")) {}

    std::vector<Triangle> read() {
        while (next_line()) {
            std::string_view rest = line_;
            rest = rest.substr(0, rest.find('#'));
            std::string_view const word = take_word(rest);
            if (word == "v") {
                read_vertex(rest);
            } else if (word == "f") {
                read_face(rest);
            } else if (word == "usemtl") {
                choose_surface(rest);
            } else if (!word.empty() && std::find(skipped.begin(), skipped.end(), word) == skipped.end()) {
                fail("'" + std::string(word.substr(0, 20)) + "' is not read here; export the mesh as polygons");
            }
        }
        if (triangles_.empty()) {
            throw Input_error(name_ + ": holds no face with an area; export the mesh as polygons");
        }
        return std::move(triangles_);
    }

private:
    static constexpr std::array<std::string_view, 10> skipped{"vn", "vt", "vp",     "o",  "g",
                                                              "s",  "l",  "mtllib", "mg", "p"};

    // Into line_; a backslash at the end continues it.
    bool next_line() {
        line_.clear();
        std::string part;
        bool any = false;
        while (std::getline(text_, part)) {
            any = true;
            ++number_;
            if (!part.empty() && part.back() == '\r') {
                part.pop_back();
            }
            bool const continues = !part.empty() && part.back() == '\\';
            if (continues) {
                part.back() = ' ';
            }
            line_ += part;
            if (!continues) {
                break;
            }
        }
        return any;
    }

    // Three coordinates; a weight or a colour that follows means nothing here.
    void read_vertex(std::string_view rest) {
        std::array<double, 7> numbers{};
        std::size_t count = 0;
        for (std::string_view word = take_word(rest); !word.empty(); word = take_word(rest)) {
            if (count == numbers.size() || !parse(word, numbers.at(count)) ||
                !(std::abs(numbers.at(count)) <= largest_coordinate_mm)) {
                fail("a vertex needs three numbers, 1e6 mm at most");
            }
            ++count;
        }
        if (count < 3) {
            fail("a vertex needs three numbers, 1e6 mm at most");
        }
        vertices_.push_back({numbers[0], numbers[1], numbers[2]});
    }

    void read_face(std::string_view rest) {
        if (surface_ == surfaces_.end()) {
            fail("a face before any usemtl; name its material");
        }
        corners_.clear();
        for (std::string_view word = take_word(rest); !word.empty(); word = take_word(rest)) {
            corners_.push_back(vertices_[corner(word)]);
        }
        if (corners_.size() < 3) {
            fail("a face needs three corners or more");
        }
        for (std::size_t i = 2; i < corners_.size(); ++i) {
            Triangle const triangle{corners_[0], corners_[i - 1], corners_[i], surface_->second};
            if (has_area(triangle)) {
                triangles_.push_back(triangle);
            }
        }
    }

    // v, v/vt, v//vn or v/vt/vn: the vertex's place in the list.
    std::size_t corner(std::string_view word) const {
        std::size_t place = 0;
        for (std::size_t part = 0; part < 3; ++part) {
            std::size_t const end = std::min(word.find('/'), word.size());
            std::int64_t index = 0;
            bool const left_out = end == 0 && part == 1 && word.size() > 1;
            if (!left_out && (!parse(word.substr(0, end), index) || index == 0)) {
                break;
            }
            if (part == 0) {
                place = vertex(index);
            }
            if (end == word.size()) {
                return place;
            }
            word.remove_prefix(end + 1);
        }
        fail("a corner is v, v/vt, v//vn or v/vt/vn, whole numbers from 1, or from -1 backwards");
    }

    std::size_t vertex(std::int64_t index) const {
        auto const count = static_cast<std::int64_t>(vertices_.size());
        if (index > count || index < -count) {
            fail("vertex " + std::to_string(index) + " of " + std::to_string(count) +
                 " so far; give it before the face");
        }
        return static_cast<std::size_t>(index > 0 ? index - 1 : count + index);
    }

    static bool has_area(const Triangle &triangle) {
        Vector const ab = triangle.b - triangle.a;
        Vector const ac = triangle.c - triangle.a;
        Vector const bc = triangle.c - triangle.b;
        double const longest_square = std::max({dot(ab, ab), dot(ac, ac), dot(bc, bc)});
        return length(cross(ab, ac)) > sliver * longest_square;
    }

    void choose_surface(std::string_view rest) {
        rest.remove_prefix(std::min(rest.find_first_not_of(blanks), rest.size()));
        std::string const material(rest.substr(0, rest.find_last_not_of(blanks) + 1));
        surface_ = surfaces_.find(material);
        if (surface_ == surfaces_.end()) {
            std::string known;
            for (const auto &[its_name, index] : surfaces_) {
                known += (known.empty() ? "" : ", ") + its_name;
            }
            fail("no surface is given for material '" + material.substr(0, 80) + "'; there are: " + known);
        }
    }

    [[noreturn]] void fail(const std::string &what) const {
        throw Input_error(name_ + ":" + std::to_string(number_) + ": " + what);
    }

    std::istream &text_;
    const std::string &name_;
    const Surface_names &surfaces_;
    Surface_names::const_iterator surface_;
    std::string line_;
    std::size_t number_ = 0;
    std::vector<Vector> vertices_;
    std::vector<Vector> corners_;
    std::vector<Triangle> triangles_;
};

} // namespace

std::vector<Triangle> read_obj(std::istream &text, const std::string &name, const Surface_names &surfaces) {
    return Obj_reader(text, name, surfaces).read();
}

std::vector<Triangle> read_obj(const std::filesystem::path &path, const Surface_names &surfaces) {
    std::ifstream file(path, std::ios::binary);
    if (!std::filesystem::is_regular_file(path) || !file) {
        throw Input_error(path.string() + ": no such file");
    }
    return read_obj(file, path.string(), surfaces);
}

} // namespace gonio::sim
