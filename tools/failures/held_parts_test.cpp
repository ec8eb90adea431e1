// What jaws hold, or squeeze.
#include <gtest/gtest.h>

#include <algorithm>

#include "tools/failures/gripper.hpp"
#include "tools/failures/loop.hpp"
#include "vps/testing/shapes.hpp"

namespace failures {
namespace {

// Closes jaws on a box that is wider than they are; how far the box has come at most [m].
double ComesAwayBetweenHardJaws_m(const Variant& variant, double close_m_per_s) {
  constexpr glm::dvec3 kSize_m{0.02, 0.06, 0.01};
  SceneKit kit(variant);
  kit.scenario.contact_input = scene::ContactInput::kManifold;
  const core::Pose X_WD;
  const auto box = AddHeldBox(&kit, X_WD, kSize_m, 0.01, 1e-3, 4096);
  Loop loop(kit.scenario);
  double away_m = 0.0;
  double opening_m = kSize_m.x + 0.01;
  for (int i = 0; i < 700; ++i) {
    opening_m = std::max(opening_m - 1e-3 * close_m_per_s, kSize_m.x - 2.0 * kSqueeze_m);
    loop.SetOpening(opening_m);
    loop.Tick(X_WD);
    away_m = std::max(away_m, glm::length(loop.body(box).X_WO.translation));
  }
  EXPECT_TRUE(loop.is_holding());
  return away_m;
}

// The jaws' contacts contradict each other until the grasp takes over.
TEST(HeldParts, HardJawsDoNotShootOutWhatTheySqueeze) {
  EXPECT_LT(ComesAwayBetweenHardJaws_m(Variants().back(), 0.3), 0.001);
  EXPECT_LT(ComesAwayBetweenHardJaws_m(Variants().front(), 0.5), 0.001);
}

// A box that jaws take from a post, and two links that hang from it, each on a hinge.
struct HangingChain {
  SceneKit kit{Variants().back()};
  double mass_kg = 0.25;

  HangingChain() {
    kit.scenario.gravity_m_per_s2 = {0.0, 0.0, -9.81};
    constexpr glm::dvec3 kBox_m{0.03, 0.04, 0.08};
    const core::Pose X_WD{{1, 0, 0, 0}, {0.0, 0.0, kBox_m.z - kHeldTop_m}};
    const auto post = kit.AddFixed(vps::MakeBox({0.05, 0.05, 0.02}), {{1, 0, 0, 0}, {0, 0, -0.01}}, 1e-3);
    const auto box = AddHeldBox(&kit, X_WD, kBox_m, mass_kg, 1e-3, 4096);
    kit.AddPair(box, post);
    AddLink(box, {0.0, 0.0, kHeldTop_m - kBox_m.z});
    AddLink(kit.scenario.mechanisms.back().child, {0.0, 0.0, -kLink_m});
  }
  // Its mesh's origin is at the hinge.
  void AddLink(int parent, const glm::dvec3& p_PJ_m) {
    constexpr double kLink_kg = 0.1;
    scene::Mechanism hinge;
    hinge.name = "hinge" + std::to_string(kit.scenario.mechanisms.size());
    hinge.parent = parent;
    hinge.X_PJ.translation = p_PJ_m;
    const core::Pose X_WL = kit.scenario.objects[static_cast<std::size_t>(parent)].X_WO * hinge.X_PJ;
    const auto mesh = MakeBoxAt({0.01, 0.01, kLink_m}, {0.0, 0.0, -0.5 * kLink_m});
    hinge.child = kit.AddBody(mesh, X_WL, kLink_kg, 1e-3, 64);
    hinge.damping = 1e-3;
    kit.scenario.mechanisms.push_back(hinge);
    mass_kg += kLink_kg;
  }
  static constexpr double kLink_m = 0.06;
};

// What hangs from a held part gives its weight to the hand, too, and the work of lowering it.
TEST(HeldParts, AHandLowersAChainWithWeight) {
  const HangingChain chain;
  constexpr double kDown_m = 0.1;
  LoopOptions options;
  options.script =
      "grip 0.0298 force 30\nwait until held object4\npush 1 0 0 by 0.06 speed 0.1\n"
      "push 0 0 -1 by 0.1 speed 0.05\nwait 100\n";
  Loop loop(chain.kit.scenario, options);
  loop.Run(12.0);
  ASSERT_TRUE(loop.is_holding());
  const double weight_N = 9.81 * chain.mass_kg;
  EXPECT_NEAR(loop.command().force_N.z, -weight_N, 0.01 * weight_N);
  const device_bridge::RoleFigures figures = loop.bridge().figures(0);
  EXPECT_NEAR(figures.energy_J, -weight_N * kDown_m, 0.1 * weight_N * kDown_m);
  EXPECT_EQ(figures.samples_made_passive, 0u);
}

}  // namespace
}  // namespace failures
