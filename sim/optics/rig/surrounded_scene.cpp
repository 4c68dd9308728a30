// surrounded_scene.cpp: the nearer of what the rig's scene and the sample's answer.
#include "surrounded_scene.hpp"

#include "embree_scene.hpp"

namespace gonio::sim {
namespace {

class Surrounded_scene final : public Scene {
public:
    Surrounded_scene(const Shapes &rig, std::unique_ptr<Scene> sample, const Vector &sample_at)
        : rig_(make_embree_scene(rig)), sample_(std::move(sample)), sample_at_(sample_at), of_rig_(rig.size()) {}

    [[nodiscard]] bool closest(const Ray &ray, Hit &hit) const override {
        bool const leaves_sample = ray.from != no_primitive && ray.from >= of_rig_;
        bool const met = rig_->closest({ray.origin, ray.direction, leaves_sample ? no_primitive : ray.from}, hit);
        Hit other{};
        Ray const there{ray.origin - sample_at_, ray.direction, leaves_sample ? ray.from - of_rig_ : no_primitive};
        if (!sample_->closest(there, other) || (met && hit.distance_mm <= other.distance_mm)) {
            return met;
        }
        hit = other;
        hit.primitive += of_rig_;
        return true;
    }

private:
    std::unique_ptr<Scene> rig_;
    std::unique_ptr<Scene> sample_;
    Vector sample_at_;
    std::uint32_t of_rig_;
};

} // namespace

std::unique_ptr<Scene> make_surrounded_scene(const Shapes &rig, std::unique_ptr<Scene> sample,
                                             const Vector &sample_at) {
    return std::make_unique<Surrounded_scene>(rig, std::move(sample), sample_at);
}

} // namespace gonio::sim
