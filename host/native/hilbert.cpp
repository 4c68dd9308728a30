// hilbert.cpp: keys along a Hilbert curve, and their radix sort.
#include "hilbert.hpp"

#include <algorithm>
#include <array>
#include <utility>

namespace gonio::sphere {
namespace {

constexpr int BITS = 16; // per side of a face: 1e-5 rad, finer than it matters

std::uint64_t key_of(const Vec &v) {
    const std::array<double, 3> size = {std::fabs(v.x), std::fabs(v.y), std::fabs(v.z)};
    const int axis = static_cast<int>(std::max_element(size.begin(), size.end()) - size.begin());
    const double along = component(v, axis);
    const double scale = size[axis] > 0.0 ? 0.5 / size[axis] : 0.0;
    const auto place = [&](int which) {
        const double t = component(v, which) * scale + 0.5;
        return static_cast<std::uint32_t>(std::clamp(t * (1 << BITS), 0.0, (1 << BITS) - 1.0));
    };
    std::uint32_t x = place((axis + 1) % 3);
    std::uint32_t y = place((axis + 2) % 3);
    std::uint64_t key = 2 * static_cast<std::uint64_t>(axis) + (along < 0.0 ? 1 : 0);
    // D. Hilbert's curve: each quadrant is the curve again, turned so that the ends meet.
    for (std::uint32_t half = 1U << (BITS - 1); half > 0; half >>= 1) {
        const std::uint32_t right = (x & half) != 0 ? 1 : 0;
        const std::uint32_t up = (y & half) != 0 ? 1 : 0;
        key = (key << 2) | ((3 * right) ^ up);
        if (up == 0) {
            if (right == 1) {
                x = ~x;
                y = ~y;
            }
            std::swap(x, y);
        }
    }
    return key;
}

} // namespace

std::vector<Index> hilbert_order(std::span<const Vec> directions) {
    struct Entry {
        std::uint64_t key;
        Index index;
    };
    const std::size_t n = directions.size();
    std::vector<Entry> entries(n);
    for (std::size_t i = 0; i < n; ++i) {
        entries[i] = {key_of(directions[i]), static_cast<Index>(i)};
    }
    constexpr int DIGIT = 12;
    constexpr std::uint64_t MASK = (1U << DIGIT) - 1;
    std::vector<Entry> other(n);
    for (int shift = 0; shift < 2 * BITS + 3; shift += DIGIT) {
        std::vector<std::size_t> start((1U << DIGIT) + 1, 0);
        for (const Entry &one : entries) {
            ++start[((one.key >> shift) & MASK) + 1];
        }
        for (std::size_t d = 1; d < start.size(); ++d) {
            start[d] += start[d - 1];
        }
        for (const Entry &one : entries) {
            other[start[(one.key >> shift) & MASK]++] = one;
        }
        entries.swap(other);
    }
    std::vector<Index> order(n);
    for (std::size_t i = 0; i < n; ++i) {
        order[i] = entries[i].index;
    }
    return order;
}

} // namespace gonio::sphere
