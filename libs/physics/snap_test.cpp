#include "physics/snap.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "physics/testing/closed_form/snap_work.hpp"
#include "physics/testing/trials/build.hpp"
#include "physics/testing/trials/snaps.hpp"

namespace physics {
namespace {

using trials::kDt;
using trials::MovedPart;

TEST(SnapProfile, LoopWorkEqualsThatOfTheProfileAtEverySpeed) {
  for (const double speed : {0.002, 0.01, 0.05, 0.2, 0.5}) {
    MovedPart scene;
    ASSERT_TRUE(scene.Cycle(speed));
    EXPECT_NEAR(scene.taken_J / closed_form::SnapCycleWork_J(scene.params), 1.0, 1e-4) << speed;
  }
}

TEST(SnapProfile, PeaksEqualThoseOfTheProfileAtHandSpeeds) {
  for (const double speed : {0.002, 0.01, 0.05}) {
    MovedPart scene;
    ASSERT_TRUE(scene.Cycle(speed));
    EXPECT_NEAR(scene.peak_in_N / scene.params.engage_force_N, 1.0, 0.01) << speed;
    EXPECT_NEAR(scene.peak_out_N / scene.params.release_force_N, 1.0, 0.01) << speed;
    EXPECT_LE(scene.largest_free_N, scene.params.engage_force_N * (1.0 + 1e-12)) << speed;
  }
}

TEST(SnapProfile, NoneOfAThousandCyclesGainsEnergy) {
  for (const double speed : {0.25, 0.37}) {
    MovedPart scene(0.1);
    const double exact = closed_form::SnapCycleWork_J(scene.params);
    for (int i = 0; i < 500; ++i) {
      const double before = scene.taken_J;
      ASSERT_TRUE(scene.Cycle(speed));
      ASSERT_NEAR((scene.taken_J - before) / exact, 1.0, 0.01) << speed << " cycle " << i;
    }
  }
}

TEST(SnapProfile, ATremblingHandGainsNoEnergy) {
  // Random steps to and fro over both ends of the hysteresis, which the mechanism cannot predict.
  MovedPart scene;
  std::uint64_t random = 1;
  double most_J = -1e9;
  double largest_drop_J = 0.0;
  int changes = 0;
  for (int i = 0; i < 50000; ++i) {
    random = random * 6364136223846793005ULL + 1442695040888963407ULL;
    const double wish = static_cast<double>(random >> 11) / 9007199254740992.0 - 0.5;
    const double centre_m = i % 500 < 250 ? -0.0065 : 0.0085;
    const int before = scene.snap->state();
    scene.Step(wish - 20.0 * (scene.z_m - centre_m));
    if (scene.snap->state() != before) ++changes;
    // Energy dissipated by the snap so far, with its potential at the position that matches the time of the speed.
    const double z =
        scene.world.X_WO(scene.part).translation.z - 0.5 * kDt * scene.world.V_WO(scene.part).linear_m_per_s.z;
    bool is_engaged = scene.snap->is_engaged();
    static_cast<void>(SnapWork_J(scene.params, z, z, &is_engaged));
    const double lost_J = scene.taken_J - SnapAxialEnergy_J(scene.params, is_engaged, z);
    most_J = std::max(most_J, lost_J);
    largest_drop_J = std::max(largest_drop_J, most_J - lost_J);
  }
  EXPECT_GT(changes, 100);
  // Half the changes are releases, and each cycle dissipates the loop work of the profile.
  EXPECT_NEAR(most_J / (changes / 2 * closed_form::SnapCycleWork_J(scene.params)), 1.0, 0.02);
  // A release moves from the well to the bump's higher potential; the rest is the error of one step.
  const double z_r = SnapReleasePoint_m(scene.params);
  const double step_up_J = SnapAxialEnergy_J(scene.params, false, z_r) - SnapAxialEnergy_J(scene.params, true, z_r);
  EXPECT_LT(largest_drop_J, step_up_J + 0.003);
}

TEST(SnapProfile, WorkOverAPathIsTheSumOverItsPieces) {
  SnapParams p;
  p.engage_force_N = 15.0;
  p.release_force_N = 20.0;
  bool once = false;
  const double in_one_J = SnapWork_J(p, 0.006, -0.001, &once);
  bool pieces = false;
  double sum_J = 0.0;
  for (int i = 0; i < 70; ++i) sum_J += SnapWork_J(p, 0.006 - 1e-4 * i, 0.006 - 1e-4 * (i + 1), &pieces);
  EXPECT_TRUE(once && pieces);
  EXPECT_NEAR(in_one_J, sum_J, 1e-15);
  // The way back; both together are the hysteresis loop.
  const double out_J = SnapWork_J(p, -0.001, 0.006, &once);
  EXPECT_FALSE(once);
  EXPECT_NEAR(-(in_one_J + out_J), closed_form::SnapCycleWork_J(p), 1e-15);
}

}  // namespace
}  // namespace physics
