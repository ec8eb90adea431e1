#include <cmath>

#include "physics/snap.hpp"
#include "physics/spring_coupling.hpp"
#include "physics/testing/bodies.hpp"

namespace physics {
namespace {

using test::kDt;

// The insertion of the scenario module_replacement, with analytic planes in place of collision detection. A 2 kg module
// of 80 x 80 x 100 mm on a 0.3 kg handle (snapped on) is held through a grasp spring of 3 kN/m by a hand that moves
// along a given path. It enters a cavity with 1.6 mm total clearance and snaps into its latch. Contacts are the
// module's eight corners against the cavity's four walls, for corners inside the cavity, and its floor; 20 kN/m for the
// pair.
struct InsertionScene {
  static constexpr double kHalf = 0.04;         // module half width
  static constexpr double kLength = 0.1;        // module length along z
  static constexpr double kClearance = 0.0008;  // per side
  static constexpr double kDepth = 0.1;         // cavity floor at z = 0, mouth at z = kDepth

  World world;
  int module = -1, handle = -1, hand = -1, cavity_pair = -1;
  Snap* latch = nullptr;
  Snap* hook = nullptr;
  SpringCoupling* grasp = nullptr;
  core::Pose X_WHand;
  double largest_grasp_N = 0.0;
  double largest_jump_N = 0.0;  // largest change of the grasp force from one tick to the next; a jolt for the operator
  double largest_depth = 0.0;

  explicit InsertionScene(const core::Pose& start_error) {
    // Module's mesh origin: centre of its bottom face; the seat is at the floor.
    const core::Pose X_WM{{1, 0, 0, 0}, {0, 0, kDepth + 0.03}};
    MassProperties mass = BoxMass(2.0, {2 * kHalf, 2 * kHalf, kLength});
    mass.p_OCm_m = {0, 0, kLength / 2};
    module = test::AddDynamic(&world, X_WM, mass);
    const core::Pose X_WHandle{{1, 0, 0, 0}, {0, 0, X_WM.translation.z + kLength}};
    MassProperties grip = BoxMass(0.3, {0.03, 0.03, 0.12});
    grip.p_OCm_m = {0, 0, 0.06};
    handle = test::AddDynamic(&world, X_WHandle, grip);
    SnapParams hook_params;
    hook_params.X_PJ.translation = {0, 0, kLength};
    hook_params.engage_force_N = 15.0;
    hook_params.release_force_N = 45.0;
    hook_params.guide_length_m = 0.02;
    hook_params.is_initially_engaged = true;
    hook = trials::AddMechanism<Snap>(&world, module, handle, hook_params);
    SnapParams latch_params;
    latch_params.engage_force_N = 15.0;
    latch_params.release_force_N = 25.0;
    latch_params.guide_length_m = 0.06;
    latch = trials::AddMechanism<Snap>(&world, world.world_body(), module, latch_params);

    X_WHand = {{1, 0, 0, 0}, {0, 0, X_WHandle.translation.z + 0.1}};
    hand = test::MustAdd(&world, BodyParams{BodyKind::kKinematic, X_WHand, {}, {}});
    grasp = trials::AddMechanism<SpringCoupling>(&world, hand, handle, SpringCouplingParams{});
    grasp->Attach(X_WHand, X_WHandle, X_WHand.translation);
    // The hand is offset by this much on its whole path.
    X_WHand = start_error * X_WHand;
    cavity_pair = world.AddContactPair(module, world.world_body()).value();
  }

  void FeedPlanes() {
    const core::Pose X_WM = world.X_WO(module);
    core::ContactSet set;
    set.damping_N_s_per_m = 20.0f;
    set.friction = 0.2f;
    std::uint32_t id = 0;
    const double wall = kHalf + kClearance;
    struct Candidate {
      std::uint32_t id;
      glm::dvec3 p_S, q_G, n_G;
      double gap;
    };
    std::vector<Candidate> found;
    for (const double z : {0.0, kLength}) {
      for (const double x : {-kHalf, kHalf}) {
        for (const double y : {-kHalf, kHalf}) {
          const glm::dvec3 p_S(x, y, z);
          const glm::dvec3 p_W = X_WM * p_S;
          const glm::dvec3 normals[] = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}};
          for (const glm::dvec3& n : normals) {
            ++id;
            if (p_W.z > kDepth || p_W.z < -0.01) continue;
            const double gap = glm::dot(n, p_W) + wall;
            if (gap < 0.002) found.push_back({id, p_S, -wall * n, n, gap});
          }
          ++id;
          if (z == 0.0 && p_W.z < 0.002) found.push_back({id, p_S, {0, 0, -0.0003}, {0, 0, 1}, p_W.z + 0.0003});
        }
      }
    }
    int pushing = 0;
    for (const Candidate& c : found) pushing += c.gap < 0.0 ? 1 : 0;
    for (const Candidate& c : found) {
      test::AddPlane(&set, c.id, c.p_S, c.q_G, c.n_G, 2.0e4 / std::max(1, pushing));
      largest_depth = std::max(largest_depth, -c.gap);
    }
    world.SetContactPlanes(cavity_pair, set);
  }

  void MoveHand(const glm::dvec3& velocity, double seconds) {
    for (int i = 0; i < static_cast<int>(std::lround(seconds / kDt)); ++i) {
      X_WHand.translation += kDt * velocity;
      world.SetKinematic(hand, X_WHand, {{}, velocity});
      FeedPlanes();
      const glm::dvec3 before = grasp->F_Po_W().force_N;
      world.Step(kDt);
      const glm::dvec3 now = grasp->F_Po_W().force_N;
      largest_grasp_N = std::max(largest_grasp_N, glm::length(now));
      largest_jump_N = std::max(largest_jump_N, glm::length(now - before));
    }
  }
};

TEST(Insertion, ModuleOnAHandleSlidesInAndSnapsWithoutJolts) {
  for (const double offset : {0.0, 0.0006, -0.001}) {
    for (const double tilt : {0.0, 0.003}) {
      InsertionScene scene({core::QuaternionFromRotationVector({tilt, 0.5 * tilt, 0}), {offset, 0.5 * offset, 0}});
      // The tilt turns about the world origin: move the hand back over the cavity.
      scene.X_WHand.translation.x = offset;
      scene.X_WHand.translation.y = 0.5 * offset;
      scene.MoveHand({}, 0.3);
      scene.largest_jump_N = 0.0;
      // On beyond the seat, until the grasp's spring has 24 N against a latch of 15 N.
      constexpr double kSpeed = 0.08;
      const double beyond_m = 24.0 / SpringCouplingParams{}.stiffness_N_per_m;
      scene.MoveHand({0, 0, -kSpeed}, (0.13 + beyond_m) / kSpeed);
      scene.MoveHand({}, 0.5);
      EXPECT_EQ(scene.latch->state(), 1) << offset << " " << tilt;
      EXPECT_EQ(scene.hook->state(), 1) << offset << " " << tilt;
      EXPECT_LT(std::abs(scene.latch->position()), 0.002) << offset << " " << tilt;
      EXPECT_LT(scene.largest_depth, 0.0015) << offset << " " << tilt;
      EXPECT_LT(scene.largest_grasp_N, 40.0) << offset << " " << tilt;
      // No more than a stop from the speed of the hand within one tick, by the grasp's damper and spring: B v + K v dt.
      const SpringCouplingParams grasp;
      EXPECT_LT(scene.largest_jump_N, 1.05 * kSpeed * (grasp.damping_N_s_per_m + grasp.stiffness_N_per_m * kDt))
          << offset << " " << tilt;
      EXPECT_LT(glm::length(scene.world.V_WO(scene.module).linear_m_per_s), 1e-3) << "comes to rest";
      EXPECT_LT(scene.world.impulse_balance().relative(), 1e-10);
      RecordProperty("grasp_N", std::to_string(scene.largest_grasp_N));
    }
  }
}

TEST(Insertion, PullsOutOfTheLatchWhileTheHookHolds) {
  InsertionScene scene({});
  scene.MoveHand({0, 0, -0.08}, (0.13 + 0.008) / 0.08);
  scene.MoveHand({}, 0.3);
  ASSERT_EQ(scene.latch->state(), 1);
  scene.MoveHand({0, 0, 0.05}, 0.16 / 0.05);
  EXPECT_EQ(scene.latch->state(), 0);
  EXPECT_EQ(scene.hook->state(), 1);  // 45 N holds against 25 N
  EXPECT_GT(scene.world.X_WO(scene.module).translation.z, 0.1);
}

TEST(Insertion, ModuleTooWideForItsCavityStaysOut) {
  InsertionScene scene({});
  // Its corners meet the rim of the cavity: planes across the mouth under all four.
  core::ContactSet rim;
  rim.damping_N_s_per_m = 20.0f;
  rim.friction = 0.2f;
  std::uint32_t id = 0;
  for (const double x : {-0.04, 0.04}) {
    for (const double y : {-0.04, 0.04}) {
      test::AddPlane(&rim, ++id, {x, y, 0}, {0, 0, InsertionScene::kDepth}, {0, 0, 1}, 5.0e3);
    }
  }
  for (int i = 0; i < 2000; ++i) {
    scene.X_WHand.translation.z -= 0.08 * kDt * (i < 500 ? 1.0 : 0.0);
    scene.world.SetKinematic(scene.hand, scene.X_WHand, {{}, {0, 0, i < 500 ? -0.08 : 0.0}});
    scene.world.SetContactPlanes(scene.cavity_pair, rim);
    scene.world.Step(kDt);
  }
  EXPECT_EQ(scene.latch->state(), 0);
  EXPECT_GT(scene.world.X_WO(scene.module).translation.z, InsertionScene::kDepth - 0.003);
}

}  // namespace
}  // namespace physics
