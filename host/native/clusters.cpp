// clusters.cpp: rows and columns of cells, sorted, so that a window of a row is one run of clusters.
#include "clusters.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "threads.hpp"
#include "voronoi_parts.hpp"

namespace gonio::sphere {
namespace {

double polar_angle(const Vec &v) {
    return std::atan2(std::hypot(v.x, v.y), v.z);
}

double turn_of(const Vec &v) { // 0 to 1
    const double turn = std::atan2(v.y, v.x) / (2.0 * PI);
    return turn < 0.0 ? turn + 1.0 : turn;
}

} // namespace

std::size_t Clusters::row_of(double polar) const {
    const auto rows = static_cast<double>(columns_.size());
    return static_cast<std::size_t>(std::clamp(polar * (rows / PI), 0.0, rows - 1.0));
}

Clusters::Clusters(std::span<const Cluster> parts, double cell) {
    const auto rows = static_cast<std::size_t>(std::ceil(PI / cell));
    columns_.resize(rows);
    for (std::size_t row = 0; row < rows; ++row) {
        const double middle = (static_cast<double>(row) + 0.5) * PI / static_cast<double>(rows);
        columns_[row] =
            static_cast<Index>(std::max(1.0, std::ceil(2.0 * static_cast<double>(rows) * std::sin(middle))));
    }
    struct Member {
        std::uint64_t cell;
        Index part;
    };
    std::vector<Member> members(parts.size());
    in_threads(parts.size(), [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const std::size_t row = row_of(polar_angle(parts[i].unit));
            const auto column = static_cast<std::uint64_t>(turn_of(parts[i].unit) * columns_[row]);
            members[i] = {(row << 32) | std::min<std::uint64_t>(column, columns_[row] - 1), static_cast<Index>(i)};
        }
    });
    std::sort(members.begin(), members.end(), [](const Member &a, const Member &b) {
        return a.cell < b.cell || (a.cell == b.cell && a.part < b.part);
    });
    row_start_.assign(rows + 1, 0);
    for (std::size_t begin = 0; begin < members.size();) {
        const std::uint64_t own = members[begin].cell;
        Cluster sum;
        std::size_t end = begin;
        for (; end < members.size() && members[end].cell == own; ++end) {
            const Cluster &one = parts[members[end].part];
            sum.count += one.count;
            sum.unit += one.count * one.unit;
            for (std::size_t k = 0; k < 6; ++k) {
                sum.products[k] += one.count * one.products[k];
            }
            sum.value += one.count * one.value;
            sum.variance += one.count * one.count * one.variance;
        }
        const double share = 1.0 / sum.count;
        sum.unit = share * sum.unit;
        for (double &product : sum.products) {
            product *= share;
        }
        sum.value *= share;
        sum.variance *= share * share;
        clusters_.push_back(sum);
        column_.push_back(static_cast<Index>(own & 0xFFFFFFFFU));
        ++row_start_[(own >> 32) + 1];
        begin = end;
    }
    for (std::size_t row = 0; row < rows; ++row) {
        row_start_[row + 1] += row_start_[row];
    }
}

void Clusters::near(const Vec &direction, double reach, std::vector<const Cluster *> &found) const {
    found.clear();
    const double angle = angle_of_chord(reach);
    const double polar = polar_angle(direction);
    const double turn = turn_of(direction);
    // The widest part of a cap is its tangent meridians'; where it holds a pole it is all round.
    const bool all_round = polar <= angle || polar >= PI - angle;
    const double half = all_round ? 1.0 : std::asin(std::min(1.0, std::sin(angle) / std::sin(polar))) / (2.0 * PI);
    const std::size_t last_row = row_of(polar + angle);
    for (std::size_t row = row_of(polar - angle); row <= last_row; ++row) {
        const Index columns = columns_[row];
        const auto begin = column_.begin() + row_start_[row];
        const auto end = column_.begin() + row_start_[row + 1];
        if (begin == end) {
            continue;
        }
        const auto take = [&](Index first, Index last) {
            for (auto at = std::lower_bound(begin, end, first); at != end && *at <= last; ++at) {
                const Cluster &one = clusters_[at - column_.begin()];
                const Vec apart = one.unit - direction;
                if (dot(apart, apart) < reach * reach) {
                    found.push_back(&one);
                }
            }
        };
        const auto first = static_cast<Index>(std::floor((turn - half) * columns));
        const auto last = static_cast<Index>(std::floor((turn + half) * columns));
        if (last - first >= columns - 1) {
            take(0, columns - 1);
        } else if (first < 0) {
            take(0, last);
            take(first + columns, columns - 1);
        } else if (last >= columns) {
            take(0, last - columns);
            take(first, columns - 1);
        } else {
            take(first, last);
        }
    }
}

} // namespace gonio::sphere
