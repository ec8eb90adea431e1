#include <cmath>
#include <numbers>

#include "physics/hinge.hpp"
#include "physics/hook_and_loop.hpp"
#include "physics/snap.hpp"
#include "physics/spring_coupling.hpp"
#include "physics/testing/bodies.hpp"

namespace physics {
namespace {

using test::kDt;

constexpr double kDegree = std::numbers::pi / 180.0;

struct Switch {
  World world;
  HingeParams params;
  int lever = -1;
  int push = -1;
  Hinge* hinge = nullptr;

  explicit Switch(double start_deg, bool is_stuck = false) {
    params.X_PJ = {core::QuaternionFromRollPitchYaw({0.3, -0.2, 0.5}), {0.1, 0.2, 0.3}};
    params.X_CJ = {{1, 0, 0, 0}, {0, -0.01, 0}};
    params.axis.lower = -22 * kDegree;
    params.axis.upper = 22 * kDegree;
    params.has_detents = true;
    params.detents_rad[0] = -20 * kDegree;
    params.detents_rad[1] = 20 * kDegree;
    params.detent_torque_Nm = 0.2;
    params.axis.damping = 0.005;
    params.axis.locked = is_stuck ? 1.0 : 0.0;
    lever = test::AddDynamic(&world, HingePose(params, start_deg * kDegree), BoxMass(0.02, {0.01, 0.04, 0.01}));
    hinge = trials::AddMechanism<Hinge>(&world, world.world_body(), lever, params);
    push = world.AddContactPair(lever, world.world_body()).value();
  }
  // Pure torque about the hinge axis.
  void Torque(double torque_Nm) { world.SetContactWrench(push, {{}, params.X_PJ.rotate({0, 0, torque_Nm})}); }
  void Run(int steps) {
    for (int i = 0; i < steps; ++i) world.Step(kDt);
  }
};

TEST(Hinge, DetentSwitchRestsInItsTwoPositionsOnly) {
  for (const double start : {-21.0, -12.0, -3.0, 3.0, 11.0, 21.0}) {
    Switch s(start);
    s.Run(3000);
    EXPECT_NEAR(s.hinge->position() / kDegree, start < 0 ? -20.0 : 20.0, 0.01) << start;
    EXPECT_EQ(s.hinge->state(), start < 0 ? 0 : 1);
  }
}

TEST(Hinge, SwitchFlipsAboveItsDetentTorqueOnly) {
  Switch s(-20.0);
  for (int i = 0; i < 1000; ++i) {  // a ramp, so that the lever does not swing over by its momentum
    s.Torque(0.19 * i / 1000.0);
    s.Run(1);
  }
  s.Run(500);
  EXPECT_EQ(s.hinge->state(), 0);
  s.Torque(0.0);
  s.Run(1000);
  EXPECT_NEAR(s.hinge->position() / kDegree, -20.0, 0.01);
  s.Torque(0.21);
  s.Run(500);
  EXPECT_EQ(s.hinge->state(), 1);
  s.Torque(0.0);
  s.Run(1000);
  EXPECT_NEAR(s.hinge->position() / kDegree, 20.0, 0.01);
}

TEST(Hinge, KeepsItsAxisAndLimitsUnderAHardPush) {
  Switch s(-20.0);
  s.world.SetContactWrench(s.push, {{20.0, -30.0, 10.0}, s.params.X_PJ.rotate({0.3, 0.1, 2.0})});
  s.Run(2000);
  EXPECT_LT(s.hinge->position(), 22.1 * kDegree);
  const core::Pose wanted = HingePose(s.params, s.hinge->position());
  EXPECT_LT(glm::length(s.world.X_WO(s.lever).translation - wanted.translation), 2e-6);
}

TEST(Hinge, StuckSwitchDoesNotMove) {
  Switch s(-20.0, true);
  s.Torque(1.0);
  s.Run(2000);
  EXPECT_NEAR(s.hinge->position() / kDegree, -20.0, 0.05);
  EXPECT_EQ(s.hinge->state(), 0);
  EXPECT_NEAR(s.hinge->force(), -1.0, 0.01);
}

SnapParams Handle() {
  SnapParams p;
  p.engage_force_N = 15.0;
  p.release_force_N = 20.0;
  p.travel_m = 0.003;
  p.guide_length_m = 0.03;
  p.stiffness_N_per_m = 2.0e4;
  p.stiffness_Nm_per_rad = 40.0;
  p.damping_N_s_per_m = 30.0;
  return p;
}

// A part in front of a socket in W, pulled by a slow hand through a 3 kN/m spring.
struct SnapScene {
  World world;
  SnapParams params = Handle();
  int part = -1;
  int hand = -1;
  Snap* snap = nullptr;
  SpringCoupling* spring = nullptr;
  double z_hand = 0.0;

  explicit SnapScene(double start_z, bool engaged = false, double mass = 0.3) {
    params.is_initially_engaged = engaged;
    part = test::AddDynamic(&world, {{1, 0, 0, 0}, {0, 0, start_z}}, BoxMass(mass, {0.03, 0.03, 0.1}));
    hand = test::MustAdd(&world, BodyParams{BodyKind::kKinematic, {{1, 0, 0, 0}, {0, 0, start_z}}, {}, {}});
    snap = trials::AddMechanism<Snap>(&world, world.world_body(), part, params);
    spring = trials::AddMechanism<SpringCoupling>(&world, hand, part, SpringCouplingParams{3000.0, 40.0, 40.0, 0.6});
    spring->Attach(world.X_WO(hand), world.X_WO(part), world.X_WO(part).translation);
    z_hand = start_z;
  }
  // Largest force of the hand on the part along its motion.
  double MoveHand(double to_z, double speed) {
    double peak = 0.0;
    const double direction = to_z > z_hand ? 1.0 : -1.0;
    while ((to_z - z_hand) * direction > 1e-12) {
      const double step = std::min(speed * kDt, std::abs(to_z - z_hand));
      z_hand += direction * step;
      world.SetKinematic(hand, {{1, 0, 0, 0}, {0, 0, z_hand}}, {{}, {0, 0, direction * speed}});
      world.Step(kDt);
      peak = std::max(peak, -direction * spring->F_Po_W().force_N.z);
    }
    world.SetKinematic(hand, {{1, 0, 0, 0}, {0, 0, z_hand}}, {});
    for (int i = 0; i < 300; ++i) world.Step(kDt);
    return peak;
  }
};

TEST(Snap, EngagesHoldsAndReleasesAtItsForces) {
  SnapScene scene(0.02);
  EXPECT_EQ(scene.snap->state(), 0);
  scene.MoveHand(-0.008, 0.02);
  EXPECT_EQ(scene.snap->state(), 1);
  scene.MoveHand(0.0, 0.02);
  EXPECT_EQ(scene.snap->state(), 1);
  EXPECT_NEAR(scene.snap->position(), 0.0, 1e-4);
  scene.MoveHand(0.005, 0.01);  // 15 N of 20: holds
  EXPECT_EQ(scene.snap->state(), 1);
  const double pull = scene.MoveHand(0.02, 0.01);
  EXPECT_EQ(scene.snap->state(), 0);
  EXPECT_NEAR(pull, 20.0, 0.04 * 20.0);
}

TEST(Snap, EngageForceIsThePeakOfASlowPush) {
  SnapScene scene(0.004);
  double peak = 0.0;
  while (scene.snap->state() == 0 && scene.z_hand > -0.02) {
    scene.z_hand -= 0.01 * kDt;
    scene.world.SetKinematic(scene.hand, {{1, 0, 0, 0}, {0, 0, scene.z_hand}}, {{}, {0, 0, -0.01}});
    scene.world.Step(kDt);
    if (scene.snap->state() == 0) peak = std::max(peak, scene.spring->F_Po_W().force_N.z);
  }
  EXPECT_EQ(scene.snap->state(), 1);
  EXPECT_NEAR(peak, 15.0, 0.03 * 15.0);
}

TEST(Snap, ReleaseForceCanBeChangedWhileEngaged) {
  SnapScene scene(0.0, true);
  const int release = scene.world.FindTunable(0, "release_force_N");
  scene.world.BeginChange(0, release, {40.0});
  scene.MoveHand(0.010, 0.01);  // 30 N of 40
  EXPECT_EQ(scene.snap->state(), 1);
  scene.world.BeginChange(0, release, {20.0});
  for (int i = 0; i < 50; ++i) scene.world.Step(kDt);
  EXPECT_EQ(scene.snap->state(), 0);
}

TEST(Snap, DoesNotEngageAPartThatIsOffCentreOrTilted) {
  World world;
  const SnapParams p = Handle();
  const int off =
      test::AddDynamic(&world, {{1, 0, 0, 0}, {0.002, 0, 0.01}}, BoxMass(0.3, {0.03, 0.03, 0.1}), {{}, {0, 0, -0.05}});
  Snap* first = trials::AddMechanism<Snap>(&world, world.world_body(), off, p);
  const int tilted = test::AddDynamic(&world, {core::QuaternionFromRotationVector({0.1, 0, 0}), {0, 0, 0.01}},
                                      BoxMass(0.3, {0.03, 0.03, 0.1}), {{}, {0, 0, -0.05}});
  Snap* second = trials::AddMechanism<Snap>(&world, world.world_body(), tilted, p);
  for (int i = 0; i < 1000; ++i) world.Step(kDt);
  EXPECT_EQ(first->state(), 0);
  EXPECT_EQ(second->state(), 0);
  EXPECT_NEAR(world.X_WO(off).translation.z, -0.04, 1e-9);  // passed without any force
}

TEST(Snap, PassivePartNeverGainsEnergyHoweverItIsThrownIn) {
  // A free part, no hand: after any number of passes its kinetic energy is at most the initial one.
  for (const double speed : {0.05, 0.2, 0.35, 0.5, 1.0}) {
    for (const double mass : {0.02, 0.3, 3.0}) {
      World world;
      SnapParams p = Handle();
      p.damping_N_s_per_m = 0.0;
      const int part = test::AddDynamic(&world, {{1, 0, 0, 0}, {0.0005, 0, 0.035}}, BoxMass(mass, {0.03, 0.03, 0.1}),
                                        {{}, {0, 0, -speed}});
      trials::AddMechanism<Snap>(&world, world.world_body(), part, p);
      const double before = world.kinetic_energy_J(part);
      double largest = 0.0;
      for (int i = 0; i < 3000; ++i) {
        world.Step(kDt);
        largest = std::max(largest, world.kinetic_energy_J(part));
      }
      // When the guide catches a part 0.5 mm off centre, its spring may add the energy k x^2 / 2.
      EXPECT_LE(largest, before + 0.5 * 2.0e4 * 0.0005 * 0.0005) << speed << " " << mass;
    }
  }
}

TEST(Snap, SlowCycleNeverGainsEnergyForAnyReleaseForce) {
  SnapParams p = Handle();
  // Quasi-static work over a cycle, in and out again by steps of 1 um: never negative.
  for (const double release : {0.0, 5.0, 20.0, 100.0}) {
    p.release_force_N = release;
    bool engaged = false;
    double work_on_part = 0.0;
    constexpr double kStep = 1e-6;
    for (int i = 6000; i > -500; --i) {
      const double z = i * kStep;
      if (!engaged && z <= SnapEngagePoint_m(p)) engaged = true;
      work_on_part -= SnapAxialForce(p, engaged, z - 0.5 * kStep).force_N * kStep;
    }
    for (int i = -500; i < 6000; ++i) {
      const double z = i * kStep;
      if (engaged && z > SnapReleasePoint_m(p)) engaged = false;
      work_on_part += SnapAxialForce(p, engaged, z + 0.5 * kStep).force_N * kStep;
    }
    EXPECT_LE(work_on_part, 1e-6) << release;
    EXPECT_FALSE(engaged);
  }
}

TEST(Snap, MomentumIsConservedBetweenTwoFreePartsThatSnapTogether) {
  World world;
  const int module = test::AddDynamic(&world, {}, BoxMass(2.0, {0.08, 0.08, 0.1}));
  const int handle = test::AddDynamic(&world, {{1, 0, 0, 0}, {0.0004, 0.0003, 0.05}}, BoxMass(0.3, {0.03, 0.03, 0.1}),
                                      {{0, 0, 0.1}, {0.001, 0, -0.8}});
  SnapParams p = Handle();
  p.X_PJ.translation = {0, 0, 0.02};
  Snap* snap = trials::AddMechanism<Snap>(&world, module, handle, p);
  const auto total = [&] {
    glm::dvec3 momentum(0.0);
    glm::dvec3 angular(0.0);
    for (const int body : {module, handle}) {
      momentum += world.momentum_Ns(body);
      angular += world.spin_Nms(body) + glm::cross(world.center_of_mass_W(body), world.momentum_Ns(body));
    }
    return std::pair{momentum, angular};
  };
  const auto before = total();
  for (int i = 0; i < 2000; ++i) world.Step(kDt);
  EXPECT_EQ(snap->state(), 1);
  EXPECT_LT(glm::length(total().first - before.first), 1e-13);
  EXPECT_LT(glm::length(total().second - before.second), 1e-13);
  EXPECT_LT(world.impulse_balance().relative(), 1e-12);
}

TEST(Springs, TwoBodiesOnASpringOscillateAtTheReducedMassPeriodWithoutGrowing) {
  // Reduced mass of 1 and 3 kg is 0.75 kg; 300 N/m: period 2 pi sqrt(m / k) = 0.314 s.
  World world;
  const int a = test::AddDynamic(&world, {}, BoxMass(1.0, {0.1, 0.1, 0.1}));
  const int b = test::AddDynamic(&world, {}, BoxMass(3.0, {0.1, 0.1, 0.1}));
  auto* spring = trials::AddMechanism<SpringCoupling>(&world, a, b, SpringCouplingParams{300.0, 0.0, 0.0, 0.0});
  spring->Attach({{1, 0, 0, 0}, {0.01, 0, 0}}, {}, {0, 0, 0});  // rest: b lies 10 mm behind a
  double previous = -1.0;
  double first = 0.0;
  double last = 0.0;
  int crossings = 0;
  for (int i = 0; i < 3000; ++i) {
    world.Step(kDt);
    const double v = world.V_WO(b).linear_m_per_s.x;
    if (previous < 0.0 && v >= 0.0) {
      last = i * kDt;
      if (crossings++ == 0) first = last;
    }
    previous = v;
  }
  ASSERT_GT(crossings, 5);
  const double period = (last - first) / (crossings - 1);
  EXPECT_NEAR(period, 2.0 * std::numbers::pi * std::sqrt(0.75 / 300.0), 1e-3);
}

TEST(Springs, StiffSpringOnALightBodyIsStableAtOneMillisecond) {
  // k dt^2 / m = 200: an explicit spring would blow up in a few steps.
  World world;
  const int part = test::AddDynamic(&world, {}, BoxMass(0.001, {0.01, 0.01, 0.01}));
  auto* spring = trials::AddMechanism<SpringCoupling>(&world, world.world_body(), part,
                                                      SpringCouplingParams{2.0e5, 10.0, 40.0, 0.01});
  spring->Attach({{1, 0, 0, 0}, {0.005, 0, 0}}, {}, {0, 0, 0});
  const double energy = 0.5 * 2.0e5 * 0.005 * 0.005;
  for (int i = 0; i < 1000; ++i) {
    world.Step(kDt);
    EXPECT_LE(world.kinetic_energy_J(part), energy);
  }
  EXPECT_NEAR(world.X_WO(part).translation.x, -0.005, 1e-6);
}

TEST(HookAndLoop, PatchesBreakOneByOneAndStayBroken) {
  HookAndLoopParams p;
  p.p_PPatch_m = {{-0.1, -0.1, 0}, {-0.1, 0.1, 0}, {0.1, -0.1, 0}, {0.1, 0.1, 0}};
  p.release_force_N = 4.0;
  p.stiffness_N_per_m = 2000.0;
  p.damping_N_s_per_m = 2.0;
  World slow;
  const int sheet = test::AddDynamic(&slow, {}, BoxMass(0.1, {0.2, 0.2, 0.002}));
  auto* held = trials::AddMechanism<HookAndLoop>(&slow, slow.world_body(), sheet, p);
  const int pull = slow.AddContactPair(sheet, slow.world_body()).value();
  for (int i = 0; i <= 2000; ++i) {
    slow.SetContactWrench(pull, {{0, 0, 15.0 * i / 2000}, {}});
    slow.Step(kDt);
  }
  EXPECT_EQ(held->state(), 4);
  EXPECT_NEAR(held->force(), 15.0, 0.1);
  // Peeled by one edge: the two patches there go first.
  for (int i = 0; i <= 3000 && held->state() == 4; ++i) {
    slow.SetContactWrench(pull, {{0, 0, 15.0}, {0, -1.5 * i / 3000, 0}});
    slow.Step(kDt);
  }
  EXPECT_LT(held->state(), 4);
  slow.SetContactWrench(pull, {{0, 0, 30.0}, {}});
  for (int i = 0; i < 500; ++i) slow.Step(kDt);
  EXPECT_EQ(held->state(), 0);
  EXPECT_EQ(held->force(), 0.0);
}

// A hand that stands still and holds, with its jaws along x, a box of 0.5 kg by its middle.
class GripTest : public testing::Test {
 protected:
  GripTest() : world_(Gravity()) {
    hand_ = test::MustAdd(&world_, BodyParams{BodyKind::kKinematic, {}, {}, {}});
    object_ = test::AddDynamic(&world_, {}, BoxMass(kMass_kg, {0.03, 0.04, 0.1}));
  }
  static World::Options Gravity() {
    World::Options options;
    options.gravity_W_m_per_s2 = {0.0, 0.0, -kG};
    return options;
  }
  void Hold(double force_N, double torque_Nm, const glm::dvec3& p_W, const SpringCouplingParams& params = {}) {
    grasp_ = trials::AddMechanism<SpringCoupling>(&world_, hand_, object_, params);
    grasp_->Attach(world_.X_WO(hand_), world_.X_WO(object_), p_W);
    grasp_->SetGripLimit({{1.0, 0.0, 0.0}, force_N, torque_Nm});
  }
  void Run(int num_steps) {
    for (int i = 0; i < num_steps; ++i) world_.Step(kDt);
  }
  [[nodiscard]] glm::dvec3 p_WO() const { return world_.X_WO(object_).translation; }

  static constexpr double kMass_kg = 0.5;
  static constexpr double kG = 9.81;
  World world_;
  int hand_ = 0;
  int object_ = 0;
  SpringCoupling* grasp_ = nullptr;
};

TEST_F(GripTest, ATenthMoreThanTheWeightHoldsForTenSecondsWithoutCreep) {
  Hold(1.1 * kMass_kg * kG, 1.0, {0.0, 0.0, 0.0});
  for (int i = 0; i < 1000; ++i) {  // the weight comes on
    world_.SetLoad(object_, {{0.0, 0.0, (1.0 - i / 1000.0) * kMass_kg * kG}, {}});
    Run(1);
  }
  world_.SetLoad(object_, {});
  Run(1000);
  const glm::dvec3 after_2_s = p_WO();
  EXPECT_NEAR(after_2_s.z, -kMass_kg * kG / SpringCouplingParams{}.stiffness_N_per_m, 1e-6);
  Run(8000);
  EXPECT_LT(glm::length(p_WO() - after_2_s), 1e-9);
}

// m a = m g - F.
TEST_F(GripTest, HalfOfTheWeightLetsItSlipAtOnceWithHalfOfG) {
  Hold(0.5 * kMass_kg * kG, 1.0, {0.0, 0.0, 0.0});
  constexpr int kSteps = 200;
  Run(kSteps);
  const double t_s = kSteps * kDt;
  EXPECT_NEAR(world_.V_WO(object_).linear_m_per_s.z, -0.5 * kG * t_s, 0.02 * 0.5 * kG * t_s);
  EXPECT_NEAR(p_WO().z, -0.25 * kG * t_s * t_s, 0.05 * 0.25 * kG * t_s * t_s);
  EXPECT_NEAR(grasp_->F_Po_W().force_N.z, -0.5 * kMass_kg * kG, 1e-6);
}

// Held 40 mm beside its middle, along y: the weight's moment about the jaws' axis is m g r, its inertia about the grip
// point I + m r^2. The force that it takes to carry the grip point's share of the weight is far within the limit.
TEST_F(GripTest, ItTurnsInTheFingersByWhatTheWeightsMomentExceedsTheirFriction) {
  constexpr double kArm_m = 0.04;
  const double moment_Nm = kMass_kg * kG * kArm_m;
  const double inertia_kg_m2 = BoxMass(kMass_kg, {0.03, 0.04, 0.1}).I_Cm_O_kg_m2[0][0];
  Hold(1e5, 0.5 * moment_Nm, {0.0, -kArm_m, 0.0}, {1e6, 2000.0, 40.0, 0.6});
  constexpr int kSteps = 60;
  Run(kSteps);
  const double alpha = 0.5 * moment_Nm / (inertia_kg_m2 + kMass_kg * kArm_m * kArm_m);
  EXPECT_NEAR(world_.V_WO(object_).angular_rad_per_s.x, -alpha * kSteps * kDt, 0.05 * alpha * kSteps * kDt);
  EXPECT_LT(std::abs(glm::dot(core::RotationVector(world_.X_WO(object_).rotation), {0.0, 1.0, 0.0})), 1e-9);
}

// What it takes to turn the object is missing when it is pulled: (f / F)^2 + (tau / T)^2 = 1 while it slips.
TEST_F(GripTest, ForceAndTorqueShareTheLimit) {
  constexpr double kF_N = 4.0, kT_Nm = 0.08;
  Hold(kF_N, kT_Nm, {0.0, -0.03, 0.0});
  for (int i = 0; i < 50; ++i) {
    Run(1);
    const core::Wrench& F = grasp_->F_Po_W();
    const glm::dvec3 p_WGrip(0.0, -0.03, 0.0);
    const double tau_Nm = (F.torque_Nm - glm::cross(p_WGrip, F.force_N)).x;
    const double s = std::hypot(F.force_N.z / kF_N, tau_Nm / kT_Nm);
    EXPECT_LT(s, 1.05) << i;
    if (i <= 20) continue;
    EXPECT_GT(s, 0.95) << i;
  }
}

TEST_F(GripTest, AlongTheJawsAxisTheShapeHolds) {
  Hold(0.1, 0.01, {0.0, 0.0, 0.0});
  world_.SetLoad(object_, {{20.0, 0.0, kMass_kg * kG}, {}});
  Run(2000);
  EXPECT_NEAR(p_WO().x, 20.0 / SpringCouplingParams{}.stiffness_N_per_m, 1e-5);
}

TEST(Grasp, ReactionOnTheHandIsOppositeToTheForceOnTheObject) {
  World world;
  const int hand = test::MustAdd(&world, BodyParams{BodyKind::kKinematic, {{1, 0, 0, 0}, {0.1, 0, 0}}, {}, {}});
  MassProperties mass = BoxMass(0.3, {0.03, 0.03, 0.1});
  mass.p_OCm_m = {0.0, 0.0, 0.04};
  const int object = test::AddDynamic(&world, {{1, 0, 0, 0}, {0.1, 0.01, 0.1}}, mass);
  auto* grasp = trials::AddMechanism<SpringCoupling>(&world, hand, object, SpringCouplingParams{});
  grasp->Attach(world.X_WO(hand), world.X_WO(object), {0.1, 0.0, 0.1});
  const core::Pose moved{core::QuaternionFromRotationVector({0.05, -0.02, 0.1}), {0.103, 0.002, -0.001}};
  world.SetKinematic(hand, moved, {});
  world.Step(kDt);
  const glm::dvec3 dp = world.momentum_Ns(object);
  const glm::dvec3 dl = world.spin_Nms(object) + glm::cross(world.center_of_mass_W(object), dp);
  const core::Wrench& F = grasp->F_Po_W();
  EXPECT_GT(glm::length(F.force_N), 1.0);
  EXPECT_LT(glm::length(F.force_N * kDt + dp), 1e-12);
  // About the world origin: torque about the hand's origin plus its lever.
  EXPECT_LT(glm::length((F.torque_Nm + glm::cross(moved.translation, F.force_N)) * kDt + dl), 1e-12);
}

}  // namespace
}  // namespace physics
