// personality.cpp: the three sorts of drive.
#include "personality.hpp"

#include <stdexcept>

namespace gonio::sim {

Eds_file load_personality(const std::string &name, const std::filesystem::path &eds_directory) {
    if (name != "full" && name != "basic" && name != "fixed") {
        throw std::runtime_error("drive personality \"" + name + "\" is not known: use full, basic or fixed");
    }
    return read_eds(eds_directory / ("gonio_" + name + ".eds"));
}

} // namespace gonio::sim
