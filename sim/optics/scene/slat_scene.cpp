// slat_scene.cpp: see slat_scene.hpp.
//
// Every slat is the same, so no hierarchy is needed: seen along x, a ray is a line, and whether it can meet a piece of
// slat i is an inequality in i. One line of arithmetic per piece gives the slats in question.
#include "slat_scene.hpp"

#include <array>
#include <cmath>
#include <vector>

#include "nearest.hpp"
#include "shapes.hpp"
#include "sweep.hpp"

namespace gonio::sim {

namespace {

// By which culling is generous: far more than rounding and edge_mm, far less than a slat.
constexpr double margin_mm = 1e-6;
// The y that a ray makes per z, above which it is said to run along the stack: keeps rounding within the margin.
constexpr double steepest = 1e5;

// A rectangle about a piece of slat 0, in the profile's plane.
struct Outline {
    double y, z;             // middle
    double along_y, along_z; // half sides
    double across_y, across_z;
    bool is_arc;
};

struct Outlined {
    Outline operator()(const Profile_line &line) const {
        return {0.5 * (line.y0 + line.y1),
                0.5 * (line.z0 + line.z1),
                0.5 * (line.y1 - line.y0),
                0.5 * (line.z1 - line.z0),
                0.0,
                0.0,
                false};
    }
    Outline operator()(const Profile_arc &arc) const {
        auto const start = sine_cosine(arc.start_rad);
        Sweep const sweep = sweep_about({1.0, 0.0, 0.0}, {0.0, start.cosine, start.sine}, arc.sweep_rad, 0.0);
        double const middle = 0.5 * arc.radius * (1.0 + sweep.cosine);
        double const thick = 0.5 * arc.radius * (1.0 - sweep.cosine);
        double const wide = arc.radius * sweep.widest_sine;
        return {arc.y + middle * sweep.mid.y,
                arc.z + middle * sweep.mid.z,
                -wide * sweep.mid.z,
                wide * sweep.mid.y,
                thick * sweep.mid.y,
                thick * sweep.mid.z,
                true};
    }
};

// The ray in the profile's plane: y = y_at_0 + slope z.
struct View {
    double y, z, way_y, way_z;
    double slope;
    double margin; // along y, of outlines that are larger by margin_mm all around; infinite along the stack
    double y_at_0;
    double only_up;   // 0 if the ray rises, else -infinity
    double only_down; // 0 if it falls, else infinity
    double sign_z;

    explicit View(const Ray &ray)
        : y(ray.origin.y), z(ray.origin.z), way_y(ray.direction.y), way_z(ray.direction.z), slope(way_y / way_z) {
        bool const along_stack = !(std::abs(slope) < steepest);
        slope = along_stack ? 0.0 : slope;
        margin = along_stack ? no_meeting : margin_mm * (1.0 + std::abs(slope));
        y_at_0 = y - slope * z;
        only_up = way_y > 0.0 ? 0.0 : -no_meeting;
        only_down = way_y < 0.0 ? 0.0 : no_meeting;
        sign_z = way_z > 0.0 ? 1.0 : (way_z < 0.0 ? -1.0 : 0.0);
    }
};

// Some pieces of slat 0, culled together, without a branch.
struct Pieces {
    static constexpr std::size_t most = 4;
    using Numbers = std::array<double, most>;

    std::size_t count = 0;
    std::array<bool, most> is_arc{};
    std::array<std::uint32_t, most> first_shape{}; // among the shapes of its kind
    Numbers y{}, z{}, along_y{}, along_z{}, across_y{}, across_z{};
    Numbers half_y{}, half_z{}; // of the box about it

    void add(const Outline &outline, double shift_y, std::uint32_t shape) {
        is_arc[count] = outline.is_arc;
        first_shape[count] = shape;
        y[count] = outline.y + shift_y;
        z[count] = outline.z;
        along_y[count] = outline.along_y;
        along_z[count] = outline.along_z;
        across_y[count] = outline.across_y;
        across_z[count] = outline.across_z;
        half_y[count] = std::abs(outline.along_y) + std::abs(outline.across_y) + margin_mm;
        half_z[count] = std::abs(outline.along_z) + std::abs(outline.across_z) + margin_mm;
        ++count;
    }

    // The slats whose piece the ray's line passes through and that are not all behind its origin.
    void cull(const View &view, double per_pitch, double last_slat, Numbers &first, Numbers &last) const {
        for (std::size_t i = 0; i < most; ++i) {
            double const middle = view.y_at_0 + view.slope * z[i] - y[i];
            double const half = std::abs(along_y[i] - view.slope * along_z[i]) +
                                std::abs(across_y[i] - view.slope * across_z[i]) + view.margin;
            double const above = (view.y - y[i] - half_y[i]) * per_pitch + view.only_up;
            double const below = (view.y - y[i] + half_y[i]) * per_pitch + view.only_down;
            double low = (middle - half) * per_pitch;
            double high = (middle + half) * per_pitch;
            low = low > above ? low : above;
            high = high < below ? high : below;
            low = low > 0.0 ? low : 0.0;
            high = high < last_slat ? high : last_slat;
            bool const behind = view.sign_z * (view.z - z[i]) > half_z[i];
            first[i] = std::ceil(low);
            last[i] = behind ? -1.0 : std::floor(high);
        }
    }
};

class Slat_scene : public Scene {
public:
    explicit Slat_scene(const Slat_stack &stack)
        : pitch_(stack.pitch), per_pitch_(1.0 / stack.pitch), last_(static_cast<double>(stack.count) - 1.0) {
        add_slats(stack, shapes_);
        for (const Profile_piece &piece : stack.profile) {
            if (groups_.empty() || groups_.back().count == Pieces::most) {
                groups_.emplace_back();
            }
            Outline const outline = std::visit(Outlined{}, piece);
            groups_.back().add(outline, stack.first * stack.pitch, outline.is_arc ? arcs_++ : lines_++);
        }
    }

    [[nodiscard]] bool closest(const Ray &ray, Hit &hit) const override {
        View const view(ray);
        Found found;
        for (const Pieces &pieces : groups_) {
            Pieces::Numbers first;
            Pieces::Numbers last;
            pieces.cull(view, per_pitch_, last_, first, last);
            for (std::size_t k = 0; k < pieces.count; ++k) {
                if (first[k] <= last[k]) {
                    walk(ray, view, pieces, k, static_cast<std::int32_t>(first[k]), static_cast<std::int32_t>(last[k]),
                         found);
                }
            }
        }
        if (found.arc != nullptr) {
            describe(*found.arc, ray, found.nearest.distance_mm, hit);
        } else if (found.line != nullptr) {
            describe(*found.line, ray, found.nearest.distance_mm, hit);
        }
        return found.nearest.distance_mm < no_meeting;
    }

private:
    struct Found {
        Nearest nearest;
        const Ready_arc *arc = nullptr;
        const Ready_parallelogram *line = nullptr;
    };

    // Tries a piece of the slats from first to last, in the ray's order.
    void walk(const Ray &ray, const View &view, const Pieces &pieces, std::size_t k, std::int32_t first,
              std::int32_t last, Found &found) const {
        std::int32_t const step = view.way_y > 0.0 ? 1 : -1;
        double const to_near_side = step * view.y + pieces.half_y[k];
        for (std::int32_t i = step > 0 ? first : last; i >= first && i <= last; i += step) {
            // All of it lies further along the ray than what was found.
            if (step * (pieces.y[k] + i * pitch_) - to_near_side > found.nearest.distance_mm * std::abs(view.way_y)) {
                break;
            }
            auto const slat = static_cast<std::uint32_t>(i);
            if (pieces.is_arc[k]) {
                const Ready_arc &arc = shapes_.arcs()[pieces.first_shape[k] + slat * arcs_];
                if (found.nearest.offer(arc.distance_mm(ray), arc.number)) {
                    found.arc = &arc;
                    found.line = nullptr;
                }
            } else {
                const Ready_parallelogram &line = shapes_.parallelograms()[pieces.first_shape[k] + slat * lines_];
                if (found.nearest.offer(line.distance_mm(ray), line.number)) {
                    found.line = &line;
                    found.arc = nullptr;
                }
            }
        }
    }

    Shapes shapes_;
    std::vector<Pieces> groups_;
    std::uint32_t arcs_ = 0;  // per slat
    std::uint32_t lines_ = 0; // per slat
    double pitch_;
    double per_pitch_;
    double last_;
};

} // namespace

std::unique_ptr<Scene> make_slat_scene(const Slat_stack &stack) {
    return std::make_unique<Slat_scene>(stack);
}

} // namespace gonio::sim
