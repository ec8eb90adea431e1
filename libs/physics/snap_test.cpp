#include "physics/snap.hpp"

#include <algorithm>
#include <cmath>

#include "physics/closed_form/snap_work.hpp"
#include "physics/spring_coupling.hpp"
#include "physics/test_support.hpp"

namespace physics {
namespace {

using test::kDt;

// A part on a snap without damping, moved in and out by a hand through a spring. What the snap does to the part is read
// from the part: the work of a force is what it changes of the kinetic energy, F dt (v + v') / 2.
struct MovedPart {
  World world;
  SnapParams params;
  int part = -1, hand = -1;
  Snap* snap = nullptr;
  double z_m = 0.02;
  double taken_J = 0.0;     // by the snap
  double peak_in_N = 0.0;   // while it is free and pushed in
  double peak_out_N = 0.0;  // while it is engaged and pulled out
  double largest_free_N = 0.0;

  explicit MovedPart(double mass_kg = 0.3, SpringCouplingParams spring = {}) {
    params.engage_force_N = 15.0;
    params.release_force_N = 20.0;
    params.damping_N_s_per_m = 0.0;
    const core::Pose X{{1, 0, 0, 0}, {0, 0, z_m}};
    part = test::AddDynamic(&world, X, BoxMass(mass_kg, {0.03, 0.03, 0.1}));
    hand = test::MustAdd(&world, BodyParams{BodyKind::kKinematic, X, {}, {}});
    snap = test::MustAddMechanism<Snap>(&world, world.world_body(), part, params);
    auto* grip = test::MustAddMechanism<SpringCoupling>(&world, hand, part, spring);
    grip->Attach(X, X, X.translation);
  }
  void Step(double hand_speed) {
    z_m += hand_speed * kDt;
    world.SetKinematic(hand, {{1, 0, 0, 0}, {0, 0, z_m}}, {{}, {0, 0, hand_speed}});
    const double before = world.V_WO(part).linear_m_per_s.z;
    world.Step(kDt);
    taken_J -= snap->force() * 0.5 * (before + world.V_WO(part).linear_m_per_s.z) * kDt;
    if (snap->state() == 0) largest_free_N = std::max(largest_free_N, snap->force());
    if (snap->state() == 0 && hand_speed < 0.0) peak_in_N = std::max(peak_in_N, snap->force());
    if (snap->state() == 1 && hand_speed > 0.0) peak_out_N = std::max(peak_out_N, -snap->force());
  }
  void Move(double to_m, double speed) {
    const double direction = to_m > z_m ? 1.0 : -1.0;
    const int steps = static_cast<int>(std::lround(std::abs(to_m - z_m) / (speed * kDt)));
    for (int i = 0; i < steps; ++i) Step(direction * speed);
    for (int i = 0; i < 50; ++i) Step(0.0);
  }
  void Cycle(double speed) {
    Move(-0.012, speed);
    ASSERT_EQ(snap->state(), 1);
    Move(0.02, speed);
    ASSERT_EQ(snap->state(), 0);
  }
};

TEST(SnapProfile, LoopWorkIsThatOfTheProfileAtEverySpeed) {
  for (const double speed : {0.002, 0.01, 0.05, 0.2, 0.5}) {
    MovedPart scene;
    scene.Cycle(speed);
    EXPECT_NEAR(scene.taken_J / closed_form::SnapCycleWork_J(scene.params), 1.0, 1e-4) << speed;
  }
}

TEST(SnapProfile, PeaksAreThoseOfTheFileAtHandsSpeeds) {
  for (const double speed : {0.002, 0.01, 0.05}) {
    MovedPart scene;
    scene.Cycle(speed);
    EXPECT_NEAR(scene.peak_in_N / scene.params.engage_force_N, 1.0, 0.01) << speed;
    EXPECT_NEAR(scene.peak_out_N / scene.params.release_force_N, 1.0, 0.01) << speed;
    EXPECT_LE(scene.largest_free_N, scene.params.engage_force_N * (1.0 + 1e-12)) << speed;
  }
}

TEST(SnapProfile, NoCycleOfAThousandGivesEnergy) {
  for (const double speed : {0.25, 0.37}) {
    MovedPart scene(0.1);
    const double exact = closed_form::SnapCycleWork_J(scene.params);
    for (int i = 0; i < 500; ++i) {
      const double before = scene.taken_J;
      scene.Cycle(speed);
      ASSERT_NEAR((scene.taken_J - before) / exact, 1.0, 0.01) << speed << " cycle " << i;
    }
  }
}

TEST(SnapProfile, ATremblingHandGetsNoEnergyOutOfIt) {
  // To and fro over both ends of the hysteresis with steps that the mechanism cannot foresee.
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
    // What the snap has turned to heat so far, with its energy at the place that belongs to the speed.
    const double z =
        scene.world.X_WO(scene.part).translation.z - 0.5 * kDt * scene.world.V_WO(scene.part).linear_m_per_s.z;
    bool is_engaged = scene.snap->is_engaged();
    static_cast<void>(SnapWork_J(scene.params, z, z, &is_engaged));
    const double lost_J = scene.taken_J - SnapAxialEnergy_J(scene.params, is_engaged, z);
    most_J = std::max(most_J, lost_J);
    largest_drop_J = std::max(largest_drop_J, most_J - lost_J);
  }
  EXPECT_GT(changes, 100);
  // Half the changes are releases, and each cycle takes what the profile takes.
  EXPECT_NEAR(most_J / (changes / 2 * closed_form::SnapCycleWork_J(scene.params)), 1.0, 0.02);
  // A release goes from the well to the bump's higher potential; beyond that there is what one step did not foresee.
  const double z_r = SnapReleasePoint_m(scene.params);
  const double step_up_J = SnapAxialEnergy_J(scene.params, false, z_r) - SnapAxialEnergy_J(scene.params, true, z_r);
  EXPECT_LT(largest_drop_J, step_up_J + 0.003);
}

TEST(SnapProfile, WorkOverAWayDoesNotDependOnItsPieces) {
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
  // And the way back; the two are the hysteresis loop.
  const double out_J = SnapWork_J(p, -0.001, 0.006, &once);
  EXPECT_FALSE(once);
  EXPECT_NEAR(-(in_one_J + out_J), closed_form::SnapCycleWork_J(p), 1e-15);
}

}  // namespace
}  // namespace physics
