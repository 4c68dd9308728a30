// grid_moments.cpp: moments of four cells in the coordinates of the one that they make.
#include "grid_moments.hpp"

namespace gonio::model {
namespace {

// A place x in the left or right half is x/2 or (1 + x)/2 in the whole: rows of powers of these, in powers of x.
using Half = std::array<std::array<double, 3>, 3>;
constexpr std::array<Half, 2> HALVES = {
    {{{{1.0, 0.0, 0.0}, {0.0, 0.5, 0.0}, {0.0, 0.0, 0.25}}}, {{{1.0, 0.0, 0.0}, {0.5, 0.5, 0.0}, {0.25, 0.5, 0.25}}}}};

template <std::size_t N>
void add(Moments<N> &wide, const Moments<N> &narrow, const Half &along_x, const Half &along_y) {
    Moments<N> half{};
    for (std::size_t b = 0; b < N; ++b) {
        for (std::size_t a = 0; a < N; ++a) {
            for (std::size_t k = 0; k <= a; ++k) {
                half[a + N * b] += along_x[a][k] * narrow[k + N * b];
            }
        }
    }
    for (std::size_t b = 0; b < N; ++b) {
        for (std::size_t k = 0; k <= b; ++k) {
            for (std::size_t a = 0; a < N; ++a) {
                wide[a + N * b] += along_y[b][k] * half[a + N * k];
            }
        }
    }
}

} // namespace

Level coarser(const Level &fine) {
    const std::size_t cells = fine.cells / 2;
    Level level{cells, std::vector<Cell>(cells * cells), {}};
    level.noise.resize(fine.noise.empty() ? 0 : cells * cells);
    for (std::size_t row = 0; row < fine.cells; ++row) {
        for (std::size_t column = 0; column < fine.cells; ++column) {
            const std::size_t from = row * fine.cells + column;
            if (fine.cell[from].mass[0] == 0.0) {
                continue;
            }
            const std::size_t to = row / 2 * cells + column / 2;
            const Half &along_x = HALVES[column % 2];
            const Half &along_y = HALVES[row % 2];
            add<3>(level.cell[to].mass, fine.cell[from].mass, along_x, along_y);
            add<2>(level.cell[to].load, fine.cell[from].load, along_x, along_y);
            if (!fine.noise.empty()) {
                add<3>(level.noise[to], fine.noise[from], along_x, along_y);
            }
        }
    }
    return level;
}

} // namespace gonio::model
