#pragma once

#include <gtest/gtest.h>

#include "physics/world.hpp"

namespace physics::test {

inline int MustAdd(World* world, const BodyParams& params) {
  const auto body = world->AddBody(params);
  EXPECT_TRUE(body.has_value()) << (body ? "" : body.error().detail);
  return body.value_or(-1);
}

inline int AddDynamic(World* world, const core::Pose& X_WO, const MassProperties& mass, const core::Twist& V_WO = {}) {
  return MustAdd(world, BodyParams{BodyKind::kDynamic, X_WO, V_WO, mass});
}

template <typename M, typename... Args>
M* MustAddMechanism(World* world, int parent, int child, Args&&... args) {
  auto mechanism = std::make_unique<M>(std::forward<Args>(args)...);
  M* raw = mechanism.get();
  EXPECT_TRUE(world->AddMechanism(parent, child, std::move(mechanism)).has_value());
  return raw;
}

// One plane of a contact set: points are float on the wire.
inline void AddPlane(core::ContactSet* set, std::uint32_t id, const glm::dvec3& p_S, const glm::dvec3& q_G,
                     const glm::dvec3& n_G, double stiffness) {
  core::ContactPlane plane;
  plane.id = id;
  plane.p_S = glm::vec3(p_S);
  plane.q_G = glm::vec3(q_G);
  plane.n_G = glm::vec3(n_G);
  plane.stiffness_N_per_m = static_cast<float>(stiffness);
  set->planes.push_back(plane);
}

constexpr double kDt = 1e-3;

}  // namespace physics::test
