#pragma once

#include <gtest/gtest.h>

#include "physics/testing/trials/build.hpp"
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

using trials::AddPlane;

// 1 kg with these moments about its principal axes [kg m2].
inline MassProperties Triaxial(double a, double b, double c) {
  MassProperties m;
  m.I_Cm_O_kg_m2 = glm::dmat3(0.0);
  m.I_Cm_O_kg_m2[0][0] = a;
  m.I_Cm_O_kg_m2[1][1] = b;
  m.I_Cm_O_kg_m2[2][2] = c;
  return m;
}

using trials::kDt;

}  // namespace physics::test
