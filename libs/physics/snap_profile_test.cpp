#include "physics/snap_profile.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "physics/snap.hpp"
#include "physics/testing/bodies.hpp"

namespace physics {
namespace {

using test::kDt;

SnapParams Measured() {
  SnapParams p;
  p.engage_force_N = 15.0;
  p.release_force_N = 20.0;
  p.damping_N_s_per_m = 0.0;
  p.travel_m = 0.0035;
  p.profile.num_points = 4;
  p.profile.z_m = {0.0005, 0.001, 0.002, 0.0035};
  p.profile.share = {0.0, 0.6, 1.0, 0.0};
  return p;
}

TEST(MeasuredSnap, ForcePassesThroughThePointsAndEnergyIsItsIntegral) {
  const SnapParams p = Measured();
  EXPECT_NEAR(SnapAxialForce(p, false, 0.001).force_N, 9.0, 1e-12);
  EXPECT_NEAR(SnapAxialForce(p, false, 0.0015).force_N, 12.0, 1e-12);
  EXPECT_NEAR(SnapAxialForce(p, false, 0.002).force_N, 15.0, 1e-12);
  EXPECT_EQ(SnapAxialForce(p, false, 0.004).force_N, 0.0);
  EXPECT_EQ(SnapAxialForce(p, false, 0.0003).force_N, 0.0);
  double sum_J = 0.0;
  for (int i = 40000; i-- > 0;) {
    const double z = (i + 0.5) * 1e-7;
    sum_J += SnapAxialForce(p, false, z).force_N * 1e-7;
    if (i % 1000 == 0) {
      EXPECT_NEAR(SnapAxialEnergy_J(p, false, i * 1e-7), sum_J, 1e-9) << i;
    }
  }
}

TEST(MeasuredSnap, APartThrownInLosesTheLoopWorkOfTheProfile) {
  // 50 mJ against a barrier of 21.9 mJ: it engages, with its initial energy less the barrier and the well's start.
  SnapParams p = Measured();
  World world;
  const int part = test::AddDynamic(&world, {{1, 0, 0, 0}, {0, 0, 0.006}}, BoxMass(0.3, {0.03, 0.03, 0.1}),
                                    {{}, {0, 0, -std::sqrt(2.0 * 0.05 / 0.3)}});
  auto* snap = trials::AddMechanism<Snap>(&world, world.world_body(), part, p);
  const double barrier_J = SnapAxialEnergy_J(p, false, 0.0);
  EXPECT_NEAR(barrier_J, 1e-3 * (0.5 * 9.0 * 0.5 + 12.0 + 0.5 * 15.0 * 1.5), 1e-12);
  const double z_e = SnapEngagePoint_m(p);
  const double left_J = 0.05 - barrier_J + 0.5 * p.stiffness_N_per_m * z_e * z_e;
  bool has_engaged = false;
  for (int i = 0; i < 40; ++i) {
    world.Step(kDt);
    if (!snap->is_engaged()) continue;
    has_engaged = true;
    const double z = world.X_WO(part).translation.z - 0.5 * kDt * world.V_WO(part).linear_m_per_s.z;
    if (z > 0.0 || world.V_WO(part).linear_m_per_s.z > 0.0) continue;  // moving in, past the engage point
    EXPECT_NEAR(world.kinetic_energy_J(part) + SnapAxialEnergy_J(p, true, z), left_J, 0.002 * left_J);
  }
  EXPECT_TRUE(has_engaged);
}

}  // namespace
}  // namespace physics
