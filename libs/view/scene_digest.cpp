#include "view/scene_digest.hpp"

#include <cmath>

#include "core/hash.hpp"

namespace view {
namespace {

constexpr double kStepsPerM = 1e6;     // rounds lengths to 1 um
constexpr double kStepsPerUnit = 1e6;  // of quaternions and colours

class Digest {
 public:
  void Add(double value, double steps) {
    const std::int64_t rounded = std::llround(value * steps);
    hash_ = core::Hash64(&rounded, sizeof rounded, hash_);
  }
  void Add(const glm::dvec3& v, double steps) {
    for (int i = 0; i < 3; ++i) Add(v[i], steps);
  }
  void Add(const core::Pose& X) {
    Add(X.translation, kStepsPerM);
    const glm::dquat q = X.rotation.w < 0.0 ? -X.rotation : X.rotation;  // q and -q are one rotation
    for (const double part : {q.w, q.x, q.y, q.z}) Add(part, kStepsPerUnit);
  }
  void Add(const std::string& text) { hash_ = core::Hash64(text.data(), text.size(), hash_); }
  [[nodiscard]] std::uint64_t value() const { return hash_ & 0xffff'ffff'ffffULL; }

 private:
  std::uint64_t hash_ = 0;
};

}  // namespace

std::uint64_t SceneDigest(const Scene& scene) {
  Digest digest;
  for (const Instance& instance : scene.instances) {
    if (!instance.is_scenery) digest.Add(instance.X_WM);  // scenery is on no topic
  }
  for (const Sheet& sheet : scene.sheets) {
    for (const glm::vec3& p_W : sheet.p_W) digest.Add(glm::dvec3(p_W), kStepsPerM);
  }
  for (const Lamp& lamp : scene.lamps) {
    digest.Add(static_cast<double>(lamp.instance), 1.0);
    digest.Add(glm::dvec3(lamp.color), kStepsPerUnit);
  }
  digest.Add(scene.step);
  digest.Add((scene.is_final ? 1.0 : 0.0) + (scene.is_failed ? 2.0 : 0.0), 1.0);
  return digest.value();
}

}  // namespace view
