#pragma once

#include <memory>
#include <utility>

#include "core/messages/haptic.hpp"
#include "physics/world.hpp"

// Scenes whose exact answer is known, run by the tests and by `oos bench physics`. A setup error of such a scene is an
// error of the program: `value()` throws.
namespace physics::trials {

constexpr double kDt = 1e-3;
constexpr double kGravity = 9.81;  // m/s^2, applied as a load; the worlds themselves have no gravity

inline int AddDynamic(World* world, const core::Pose& X_WO, const MassProperties& mass, const core::Twist& V_WO = {}) {
  return world->AddBody({BodyKind::kDynamic, X_WO, V_WO, mass}).value();
}

inline int AddKinematic(World* world, const core::Pose& X_WO) {
  return world->AddBody({BodyKind::kKinematic, X_WO, {}, {}}).value();
}

template <typename M, typename... Args>
M* AddMechanism(World* world, int parent, int child, Args&&... args) {
  auto mechanism = std::make_unique<M>(std::forward<Args>(args)...);
  M* raw = mechanism.get();
  world->AddMechanism(parent, child, std::move(mechanism)).value();
  return raw;
}

// One plane of a contact set: points are float on the wire.
inline void AddPlane(core::ContactSet* set, std::uint32_t id, const glm::dvec3& p_S, const glm::dvec3& q_G,
                     const glm::dvec3& n_G, double stiffness_N_per_m) {
  core::ContactPlane plane;
  plane.id = id;
  plane.p_S = glm::vec3(p_S);
  plane.q_G = glm::vec3(q_G);
  plane.n_G = glm::vec3(n_G);
  plane.stiffness_N_per_m = static_cast<float>(stiffness_N_per_m);
  set->planes.push_back(plane);
}

}  // namespace physics::trials
