#include "core/hash.hpp"
#include "nodes/physics_node/build_world.hpp"

namespace physics_node {
namespace {

class Digest {
 public:
  void Add(const std::string& text) { value_ = core::Hash64(text, value_); }
  void Add(double number) { value_ = core::Hash64(&number, sizeof(number), value_); }
  void Add(const glm::dvec3& v) {
    for (int i = 0; i < 3; ++i) Add(v[i]);
  }
  void Add(const core::Pose& X) {
    for (const double number : {X.rotation.w, X.rotation.x, X.rotation.y, X.rotation.z}) Add(number);
    Add(X.translation);
  }
  void Add(const physics::MassProperties& mass) {
    Add(mass.mass_kg);
    Add(mass.p_OCm_m);
    for (int i = 0; i < 3; ++i) Add(mass.I_Cm_O_kg_m2[i]);
  }
  [[nodiscard]] std::uint64_t value() const { return value_; }

 private:
  std::uint64_t value_ = 0;
};

}  // namespace

std::uint64_t ContentDigest(const scene::Scenario& scenario,
                            const std::vector<physics::MassProperties>& mass_of_object) {
  Digest digest;
  digest.Add(scenario.method);
  digest.Add(static_cast<double>(scenario.contact_input));
  for (std::size_t i = 0; i < scenario.objects.size(); ++i) {
    const scene::Object& object = scenario.objects[i];
    digest.Add(object.name);
    digest.Add(static_cast<double>(object.owner));
    digest.Add(object.X_WO);
    digest.Add(object.V_WO.linear_m_per_s);
    digest.Add(object.V_WO.angular_rad_per_s);
    if (object.owner == scene::Owner::kPhysics) digest.Add(mass_of_object[i]);
  }
  for (const scene::Pair& pair : scenario.pairs) {
    for (const double number :
         {static_cast<double>(pair.sampled), static_cast<double>(pair.field), static_cast<double>(pair.owner),
          pair.stiffness_N_per_m, pair.damping_N_s_per_m, pair.friction, pair.look_ahead_m}) {
      digest.Add(number);
    }
  }
  for (const scene::Mechanism& mechanism : scenario.mechanisms) {
    digest.Add(mechanism.name);
    digest.Add(static_cast<double>(mechanism.kind));
    digest.Add(mechanism.X_PJ);
    digest.Add(mechanism.X_CJ);
    for (const double number :
         {static_cast<double>(mechanism.parent), static_cast<double>(mechanism.child), mechanism.damping,
          mechanism.stiffness_N_per_m, mechanism.engage_force_N, mechanism.release_force_N, mechanism.travel_m}) {
      digest.Add(number);
    }
  }
  for (const scene::Device& device : scenario.devices) digest.Add(device.role);
  return digest.value();
}

}  // namespace physics_node
