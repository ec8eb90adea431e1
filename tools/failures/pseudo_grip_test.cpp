// A hand without a motor grips by the three methods of pseudo-haptics, through the steps of haptic_node and
// physics_node: whether a part is lifted follows from friction.
#include "tracking/pseudo_grip.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>

#include "tools/failures/gripper.hpp"
#include "tools/failures/scene_kit.hpp"
#include "vps/testing/shapes.hpp"

namespace failures {
namespace {

constexpr double kPseudoPart_kg = 0.5, kPseudoG_m_per_s2 = 9.81, kPseudoMost_N = 80.0;
constexpr glm::dvec3 kPseudoPart_m{0.03, 0.04, 0.08};
constexpr double kPseudoMax_m = 0.1, kPseudoStiffness_N_per_m = 3000.0;

// How the person's fingers or stick make a force, with jaws on the part at `opening_m`.
using Method = std::function<tracking::GripWish(double force_N, double opening_m)>;

tracking::GripWish ByStick(double force_N, double /*opening_m*/) {
  return tracking::WishOfStick(-force_N / kPseudoMost_N, kPseudoMax_m, kPseudoMost_N);
}
tracking::GripWish ByDistance(double force_N, double opening_m) {
  return tracking::WishOfDistance(opening_m - force_N / kPseudoStiffness_N_per_m, opening_m, kPseudoMax_m,
                                  kPseudoStiffness_N_per_m, kPseudoMost_N);
}
tracking::GripWish ByPinch(double force_N, double /*opening_m*/) {
  return tracking::WishOfPinch(force_N / kPseudoMost_N, 0.0, kPseudoMax_m, kPseudoMost_N);
}

struct Lifted {
  double part_m = 0.0;     // how far the part is up after three seconds, when the hand is 20 mm up
  double dropped_m = 0.0;  // then with half of the grip, in a second
  double felt_N = 0.0;     // jaws' force while it was held
};

// The part stands on a table; two jaws of friction mu hold 2 mu F. The grip's force is `share` of what the weight
// needs.
Lifted LiftBy(const Method& method, double share) {
  SceneKit kit(Variants().back());
  kit.scenario.gravity_m_per_s2 = {0.0, 0.0, -kPseudoG_m_per_s2};
  kit.scenario.coupling.is_grip_by_friction = true;
  core::Pose X_WD{{1, 0, 0, 0}, {0.0, 0.0, kPseudoPart_m.z - kHeldTop_m}};
  const auto table = kit.AddFixed(vps::MakeBox({0.2, 0.2, 0.02}), {{1, 0, 0, 0}, {0, 0, -0.01}}, 1e-3);
  const auto part = AddHeldBox(&kit, X_WD, kPseudoPart_m, kPseudoPart_kg, 1e-3, 4096);
  kit.AddPair(part, table);
  const double needed_N = kPseudoPart_kg * kPseudoG_m_per_s2 / (2.0 * scene::Pair{}.friction);
  Loop loop(kit.scenario);
  tracking::PseudoJaws jaws(kPseudoMax_m, kit.device().opening_start_m);
  const auto TickWith = [&](double force_N) {
    const double reaction_N = loop.haptic().commands.empty() ? 0.0 : loop.haptic().commands[0].grip_force_N;
    jaws.Step(method(force_N, jaws.opening_m()), reaction_N, 1e-3);
    loop.SetOpening(jaws.opening_m());
    loop.Tick(X_WD);
  };
  // Closes with a little, then with what is wished; then up, by a smooth way, and three seconds still.
  for (int i = 0; i < 500; ++i) TickWith(0.05 * share * needed_N);
  for (int i = 0; i < 1000; ++i) TickWith(share * needed_N);
  const double start_m = loop.body(part).X_WO.translation.z;
  constexpr double kUp_m = 0.02;
  const double down_m = X_WD.translation.z;
  for (int i = 0; i < 4000; ++i) {
    const double t = std::min(1.0, 1e-3 * (i + 1));
    X_WD.translation.z = down_m + kUp_m * t * t * (3.0 - 2.0 * t);
    TickWith(share * needed_N);
  }
  Lifted lifted;
  lifted.felt_N = loop.haptic().commands[0].grip_force_N;
  lifted.part_m = loop.body(part).X_WO.translation.z - start_m;
  for (int i = 0; i < 1000; ++i) TickWith(0.5 * share * needed_N);
  lifted.dropped_m = lifted.part_m - (loop.body(part).X_WO.translation.z - start_m);
  return lifted;
}

class PseudoHaptics : public ::testing::TestWithParam<Method> {};

TEST_P(PseudoHaptics, LiftWhatTheirForceHoldsAndDropItAtHalf) {
  const Lifted lifted = LiftBy(GetParam(), 1.2);
  // It hangs on the grasp's spring.
  const double sag_m = kPseudoPart_kg * kPseudoG_m_per_s2 / scene::Coupling{}.grasp_stiffness_N_per_m;
  EXPECT_NEAR(lifted.part_m, 0.02 - sag_m, 2e-5);
  EXPECT_GT(lifted.dropped_m, 0.015);
  EXPECT_NEAR(lifted.felt_N, 1.2 * kPseudoPart_kg * kPseudoG_m_per_s2 / (2.0 * scene::Pair{}.friction), 0.05);
}

TEST_P(PseudoHaptics, LeaveBehindWhatTheirForceDoesNotHold) {
  EXPECT_LT(LiftBy(GetParam(), 0.8).part_m, 0.001);
}

INSTANTIATE_TEST_SUITE_P(ByStick, PseudoHaptics, ::testing::Values(ByStick));
INSTANTIATE_TEST_SUITE_P(ByDistance, PseudoHaptics, ::testing::Values(ByDistance));
INSTANTIATE_TEST_SUITE_P(ByPinch, PseudoHaptics, ::testing::Values(ByPinch));

}  // namespace
}  // namespace failures
