// stretch.hpp: a stretch of a ray, clipped to slabs.
#pragma once

namespace gonio::sim {

struct Stretch {
    double begin;
    double end;

    // Keeps what lies where low <= place + distance * way <= high. A stretch that is left empty has begin > end.
    void clip(double place, double way, double low, double high) {
        if (way == 0.0) {
            if (!(place >= low && place <= high)) {
                end = begin - 1.0;
            }
            return;
        }
        double const per_way = 1.0 / way;
        double const at_low = (low - place) * per_way;
        double const at_high = (high - place) * per_way;
        double const first = at_low < at_high ? at_low : at_high;
        double const last = at_low < at_high ? at_high : at_low;
        begin = first > begin ? first : begin;
        end = last < end ? last : end;
    }
    [[nodiscard]] bool empty() const { return !(begin < end); }
};

} // namespace gonio::sim
