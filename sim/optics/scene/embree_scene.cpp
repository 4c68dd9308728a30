// embree_scene.cpp: see embree_scene.hpp. The only file that knows Embree.
//
// Embree culls boxes in single precision; whether and where a shape is met is computed by the shapes in double
// precision, from the ray that travels in the query's context. Nothing that Embree computes enters a result.
#include "embree_scene.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

#include "nearest.hpp"
#include "stretch.hpp"

namespace gonio::sim {

namespace {

#if RTC_VERSION_MAJOR >= 4
using Context = RTCRayQueryContext;
#else
using Context = RTCIntersectContext;
#endif

// A geometry of Embree's: the shapes of one kind, or the patches of one height field.
struct List {
    const void *shapes;
    double margin_mm; // by which boxes are too large
};

template <class Ready> decltype(auto) element(const List &list, std::uint32_t index) {
    const auto *shapes = static_cast<const Ready *>(list.shapes);
    if constexpr (std::is_same_v<Ready, Ready_height_field>) {
        return shapes->patch(index);
    } else {
        return (shapes[index]); // a reference
    }
}

using Describe = void (*)(const List &list, std::uint32_t index, const Ray &ray, double distance_mm, Hit &hit);

template <class Ready>
void describe_element(const List &list, std::uint32_t index, const Ray &ray, double distance_mm, Hit &hit) {
    describe(element<Ready>(list, index), ray, distance_mm, hit);
}

// What a callback sees of the ray and says of the shapes that it meets. The context comes first: Embree hands it on.
// A library built with instance arrays, an option, has a longer context and a longer hit than headers without them
// tell: hence the spare room.
struct Query : Context {
    std::uint32_t spare[4];
    const Ray *ray;
    double advance_mm; // of the origin that Embree sees
    Nearest nearest;
    Describe describe_nearest;
    const List *list;
    std::uint32_t index;
};
struct Coarse_ray {
    RTCRayHit rayhit;
    float spare[16];
};
static_assert(sizeof(RTCRay) == 48 && alignof(RTCRayHit) == 16 && offsetof(RTCRayHit, hit) == sizeof(RTCRay));

// To single precision, not below.
float upwards(double value) {
    return std::nextafter(static_cast<float>(value), std::numeric_limits<float>::infinity());
}

template <class Ready> void meet(const RTCIntersectFunctionNArguments *arguments) {
    auto &query = *static_cast<Query *>(arguments->context);
    const List &list = *static_cast<const List *>(arguments->geometryUserPtr);
    const auto &shape = element<Ready>(list, arguments->primID);
    if (query.nearest.offer(shape.distance_mm(*query.ray), shape.number)) {
        query.describe_nearest = describe_element<Ready>;
        query.list = &list;
        query.index = arguments->primID;
        // Boxes at this very distance stay in the race: a tie is ours to decide.
        reinterpret_cast<RTCRayHit *>(arguments->rayhit)->ray.tfar =
            upwards(query.nearest.distance_mm - query.advance_mm);
    }
}

template <class Ready> void give_bounds(const RTCBoundsFunctionArguments *arguments) {
    const List &list = *static_cast<const List *>(arguments->geometryUserPtr);
    Box const box = element<Ready>(list, arguments->primID).bounds();
    auto const low = [&](double value) { return static_cast<float>(value - list.margin_mm); };
    auto const high = [&](double value) { return static_cast<float>(value + list.margin_mm); };
    RTCBounds &bounds = *arguments->bounds_o;
    bounds.lower_x = low(box.low.x);
    bounds.lower_y = low(box.low.y);
    bounds.lower_z = low(box.low.z);
    bounds.upper_x = high(box.high.x);
    bounds.upper_y = high(box.high.y);
    bounds.upper_z = high(box.high.z);
}

// One for all scenes. One thread: a build takes milliseconds, and the tracer has threads of its own.
class Device {
public:
    Device() : device_(rtcNewDevice("threads=1")) { check(); }
    ~Device() { rtcReleaseDevice(device_); }
    Device(const Device &) = delete;
    Device &operator=(const Device &) = delete;

    [[nodiscard]] RTCDevice get() const { return device_; }
    void check() const {
        if (RTCError const error = rtcGetDeviceError(device_); error != RTC_ERROR_NONE) {
            throw std::runtime_error("Embree reports error " + std::to_string(error) +
                                     (error == RTC_ERROR_OUT_OF_MEMORY ? ": out of memory" : ""));
        }
    }

private:
    RTCDevice device_;
};

const Device &device() {
    static const Device only;
    return only;
}

struct Release {
    void operator()(RTCScene scene) const { rtcReleaseScene(scene); }
};

class Embree_scene : public Scene {
public:
    explicit Embree_scene(Shapes shapes)
        : shapes_(std::move(shapes)), box_(shapes_.bounds()), scene_(rtcNewScene(device().get())) {
        device().check();
        lists_.reserve(6 + shapes_.height_fields().size());
        include(shapes_.parallelograms());
        include(shapes_.discs());
        include(shapes_.arcs());
        include(shapes_.spheres());
        include(shapes_.torus_arcs());
        include(shapes_.triangles());
        for (const Ready_height_field &field : shapes_.height_fields()) {
            include(&field, field.patches());
        }
        set_margin();
        rtcCommitScene(scene_.get());
        device().check();
    }

    [[nodiscard]] bool closest(const Ray &ray, Hit &hit) const override {
        Stretch stretch{0.0, no_meeting};
        stretch.clip(ray.origin.x, ray.direction.x, box_.low.x, box_.high.x);
        stretch.clip(ray.origin.y, ray.direction.y, box_.low.y, box_.high.y);
        stretch.clip(ray.origin.z, ray.direction.z, box_.low.z, box_.high.z);
        if (stretch.empty()) {
            return false;
        }
        Query query;
        query.ray = &ray;
        query.advance_mm = stretch.begin;
        query.nearest = {};
        Coarse_ray coarse;
        start(ray, stretch.begin, coarse.rayhit);
        intersect(query, coarse.rayhit);
        if (query.nearest.distance_mm == no_meeting) {
            return false;
        }
        query.describe_nearest(*query.list, query.index, ray, query.nearest.distance_mm, hit);
        return true;
    }

private:
    template <class Ready> void include(const std::vector<Ready> &shapes) { include(shapes.data(), shapes.size()); }
    template <class Ready> void include(const Ready *shapes, std::size_t count) {
        if (count == 0) {
            return;
        }
        lists_.push_back({shapes, 0.0});
        auto *const geometry = rtcNewGeometry(device().get(), RTC_GEOMETRY_TYPE_USER);
        rtcSetGeometryUserPrimitiveCount(geometry, static_cast<unsigned>(count));
        rtcSetGeometryUserData(geometry, lists_.data() + (lists_.size() - 1));
        rtcSetGeometryBoundsFunction(geometry, give_bounds<Ready>, nullptr);
        rtcSetGeometryIntersectFunction(geometry, meet<Ready>);
        rtcCommitGeometry(geometry);
        rtcAttachGeometry(scene_.get(), geometry);
        rtcReleaseGeometry(geometry);
        device().check();
    }

    // Rounding origin (advanced into the box), direction and boxes to single precision, and the box test itself, shift
    // a ray by less than 10 units in the last place of the scene's largest coordinate; boxes grow by 32.
    void set_margin() {
        if (lists_.empty()) {
            return; // the box is one that nothing enters
        }
        double extent = 0.0;
        for (double const value : {box_.low.x, box_.low.y, box_.low.z, box_.high.x, box_.high.y, box_.high.z}) {
            extent = std::max(extent, std::abs(value));
        }
        double const margin = 0x1p-19 * extent;
        for (List &list : lists_) {
            list.margin_mm = margin;
        }
        box_ = {box_.low - Vector{margin, margin, margin}, box_.high + Vector{margin, margin, margin}};
    }

    static void start(const Ray &ray, double advance_mm, RTCRayHit &rayhit) {
        Vector const origin = ray.at(advance_mm);
        rayhit.ray.org_x = static_cast<float>(origin.x);
        rayhit.ray.org_y = static_cast<float>(origin.y);
        rayhit.ray.org_z = static_cast<float>(origin.z);
        rayhit.ray.tnear = 0.0F;
        rayhit.ray.dir_x = static_cast<float>(ray.direction.x);
        rayhit.ray.dir_y = static_cast<float>(ray.direction.y);
        rayhit.ray.dir_z = static_cast<float>(ray.direction.z);
        rayhit.ray.time = 0.0F;
        rayhit.ray.tfar = std::numeric_limits<float>::infinity();
        rayhit.ray.mask = 0xFFFFFFFFU;
        rayhit.ray.id = 0;
        rayhit.ray.flags = 0;
        rayhit.hit.geomID = RTC_INVALID_GEOMETRY_ID;
        rayhit.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
    }

    void intersect(Query &query, RTCRayHit &rayhit) const {
#if RTC_VERSION_MAJOR >= 4
        rtcInitRayQueryContext(&query);
        RTCIntersectArguments arguments;
        rtcInitIntersectArguments(&arguments);
        arguments.context = &query;
        rtcIntersect1(scene_.get(), &rayhit, &arguments);
#else
        rtcInitIntersectContext(&query);
        rtcIntersect1(scene_.get(), &query, &rayhit);
#endif
    }

    Shapes shapes_;
    Box box_;
    std::unique_ptr<std::remove_pointer_t<RTCScene>, Release> scene_;
    std::vector<List> lists_; // Embree keeps pointers to them
};

} // namespace

std::unique_ptr<Scene> make_embree_scene(Shapes shapes) {
    return std::make_unique<Embree_scene>(std::move(shapes));
}

} // namespace gonio::sim
