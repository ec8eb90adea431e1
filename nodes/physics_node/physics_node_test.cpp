#include "nodes/physics_node/physics_node.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "core/clock.hpp"
#include "nodes/physics_node/grasp_keeper.hpp"
namespace physics_node {
namespace {

// A two-finger gripper and a free 40 mm block between its jaws; given planes replace collision detection.
struct Bench {
  enum Object : std::uint16_t { kPalm, kJawLeft, kJawRight, kBlock, kWall };
  enum PairIndex : std::size_t { kLeft, kRight, kBlockWall, kNumPairs };
  static constexpr double kHalf_m = 0.02;

  scene::Scenario scenario;
  std::unique_ptr<PhysicsNode> node;
  Inputs inputs;
  Outputs outputs;
  std::vector<core::ContactSet> contacts;
  std::vector<core::Event> events;
  std::uint64_t cycle = 0;
  core::Pose X_WD;
  core::Twist V_WD;
  double opening_m = 0.06;
  bool is_haptic_alive = true;
  bool sends_contacts = true;

  static scene::Scenario MakeScenario() {
    scene::Scenario s;
    const auto add = [&](const char* name, scene::Owner owner, scene::HandPart part) {
      scene::Object object;
      object.name = name;
      object.owner = owner;
      object.part = part;
      object.role = owner == scene::Owner::kHand ? 0 : -1;
      s.objects.push_back(object);
    };
    add("palm", scene::Owner::kHand, scene::HandPart::kPalm);
    add("jaw_left", scene::Owner::kHand, scene::HandPart::kJawLeft);
    add("jaw_right", scene::Owner::kHand, scene::HandPart::kJawRight);
    add("block", scene::Owner::kPhysics, scene::HandPart::kNone);
    add("wall", scene::Owner::kFixed, scene::HandPart::kNone);
    s.objects[kBlock].mass_kg = 0.5;
    scene::Device device;
    device.role = "right";
    device.palm = kPalm;
    device.jaw_left = kJawLeft;
    device.jaw_right = kJawRight;
    s.devices.push_back(device);
    const auto pair = [&](std::uint16_t a, std::uint16_t b) {
      scene::Pair p;
      p.sampled = a;
      p.field = b;
      s.pairs.push_back(p);
    };
    pair(kJawLeft, kBlock);
    pair(kJawRight, kBlock);
    pair(kBlock, kWall);
    return s;
  }

  explicit Bench(const scene::Scenario& s = MakeScenario()) : scenario(s), contacts(s.pairs.size()) {
    std::vector<physics::MassProperties> masses(scenario.objects.size());
    for (std::size_t i = kBlock; i < scenario.objects.size(); ++i) {
      masses[i] = physics::BoxMass(0.5, glm::dvec3(2.0 * kHalf_m));
    }
    auto created = PhysicsNode::Create(scenario, masses);
    EXPECT_TRUE(created.has_value()) << (created ? "" : created.error().detail);
    node = std::move(*created);
    inputs.proxies.resize(1);
  }

  void SetJaw(std::size_t pair, double side) {
    core::ContactSet& set = contacts[pair];
    set.header.sequence = cycle;
    set.cycle = cycle;
    set.pair_index = static_cast<std::uint16_t>(pair);
    set.sampled_body = scenario.pairs[pair].sampled;
    set.field_body = kBlock;
    set.damping_N_s_per_m = 20.0f;
    set.planes.clear();
    core::ContactPlane plane;
    plane.id = 1;
    plane.q_G = {static_cast<float>(side * kHalf_m), 0.0f, 0.0f};
    plane.n_G = {static_cast<float>(side), 0.0f, 0.0f};
    plane.stiffness_N_per_m = 2500.0f;
    set.planes.push_back(plane);
    const int slot_body_block = 4;  // world body 0, then objects in order
    const core::Pose X_WJaw =
        scene::PartPose(side < 0 ? scene::HandPart::kJawLeft : scene::HandPart::kJawRight, X_WD, opening_m);
    const core::Pose X_BJ = node->world().X_WO(slot_body_block).inverse() * X_WJaw;
    set.signed_distance_m = side * X_BJ.translation.x - kHalf_m;
    set.is_in_contact = set.signed_distance_m < 0.0;
  }

  void Tick() {
    ++cycle;
    inputs.now_ns += core::kTick_ns;
    if (is_haptic_alive) {
      core::HapticProxy& proxy = inputs.proxies[0];
      proxy.header.sequence = cycle;
      proxy.header.direct = core::Trace{};
      proxy.header.direct.id = core::MakeTraceId(0, cycle);
      proxy.header.direct.origin_ns = inputs.now_ns;
      proxy.cycle = cycle;
      proxy.X_WD = X_WD;
      proxy.V_WD = V_WD;
      proxy.opening_m = opening_m;
      if (sends_contacts) {
        SetJaw(kLeft, -1.0);
        SetJaw(kRight, 1.0);
      }
    }
    inputs.contacts = contacts.data();
    inputs.num_contacts = contacts.size();
    node->Step(inputs, &outputs);
    inputs.num_changes = 0;
    events.insert(events.end(), outputs.events.begin(), outputs.events.end());
  }
  void Run(int ticks) {
    for (int i = 0; i < ticks; ++i) Tick();
  }
  void MoveHand(const glm::dvec3& velocity, int ticks) {
    V_WD.linear_m_per_s = velocity;
    for (int i = 0; i < ticks; ++i) {
      X_WD.translation += velocity * core::kTick_s;
      Tick();
    }
    V_WD = {};
  }
  void MoveJaws(double to_m, double speed) {
    while (std::abs(to_m - opening_m) > 1e-9) {
      opening_m += std::clamp(to_m - opening_m, -speed * core::kTick_s, speed * core::kTick_s);
      Tick();
    }
  }
  [[nodiscard]] const core::BodyState& block() const { return outputs.state.bodies[0]; }
  [[nodiscard]] std::uint16_t held() const { return outputs.reactions[0].grasped_object; }
};

TEST(PhysicsNode, ReportsExactlyThePhysicsObjects) {
  Bench bench;
  bench.Tick();
  ASSERT_EQ(bench.outputs.state.bodies.size(), 1u);
  EXPECT_EQ(bench.block().object, Bench::kBlock);
  EXPECT_EQ(bench.outputs.state.tick, 1u);
  EXPECT_EQ(bench.outputs.state.time_ns, core::kTick_ns);
  ASSERT_EQ(bench.outputs.reactions.size(), 1u);
  EXPECT_EQ(bench.held(), core::kNoObject);
}

TEST(PhysicsNode, GraspsWithBothJawsCarriesAndReleases) {
  Bench bench;
  bench.MoveJaws(0.038, 0.05);
  bench.Run(50);
  ASSERT_EQ(bench.held(), Bench::kBlock);
  ASSERT_FALSE(bench.events.empty());
  EXPECT_EQ(bench.events.back().name, "grasp_attached");
  EXPECT_EQ(bench.events.back().detail, "right block");

  bench.MoveHand({0.1, 0.05, 0.2}, 1000);
  bench.Run(500);
  EXPECT_EQ(bench.held(), Bench::kBlock);
  EXPECT_LT(glm::length(bench.block().X_WO.translation - glm::dvec3(0.1, 0.05, 0.2)), 1e-3);

  bench.MoveJaws(0.05, 0.05);
  bench.Run(10);
  EXPECT_EQ(bench.held(), core::kNoObject);
  EXPECT_EQ(bench.events.back().name, "grasp_detached");
  EXPECT_EQ(bench.outputs.reactions[0].F_Do_W.force_N, glm::dvec3(0.0));
  EXPECT_LT(bench.node->impulse_balance().relative(), 1e-10);
}

// Jaws pressed in by d each hold 2 mu k d.
class GripBench : public Bench {
 public:
  explicit GripBench(double share_of_weight) : Bench(Scenario()) {
    const double weight_N = 0.5 * 9.81;
    const double pressed_m =
        share_of_weight * weight_N / (2.0 * scenario.pairs[kLeft].friction * scenario.coupling.jaw_stiffness_N_per_m);
    opening_m = 2.0 * (kHalf_m - pressed_m);
  }
  static scene::Scenario Scenario() {
    scene::Scenario scenario = MakeScenario();
    scenario.coupling.is_grip_by_friction = true;
    scenario.gravity_m_per_s2 = {0.0, 0.0, -9.81};
    return scenario;
  }
  [[nodiscard]] double z_m() const { return block().X_WO.translation.z; }
};

TEST(PhysicsNode, JawsHoldForTenSecondsWhatTheirFrictionHoldsWithATenthToSpare) {
  GripBench bench(1.1);
  bench.Run(1000);
  ASSERT_EQ(bench.held(), Bench::kBlock);
  const double after_1_s = bench.z_m();
  EXPECT_GT(after_1_s, -0.01);
  bench.Run(9000);
  EXPECT_EQ(bench.held(), Bench::kBlock);
  EXPECT_NEAR(bench.z_m(), after_1_s, 1e-6);
  EXPECT_NEAR(bench.outputs.reactions[0].F_Do_W.force_N.z, -0.5 * 9.81, 1e-6);
}

TEST(PhysicsNode, WhatHalfOfTheFrictionHoldsSlipsAtOnceWithHalfOfG) {
  GripBench bench(0.5);
  bench.Run(20);
  ASSERT_EQ(bench.held(), Bench::kBlock);
  const double before = bench.block().V_WO.linear_m_per_s.z;
  bench.Run(100);
  EXPECT_NEAR(bench.block().V_WO.linear_m_per_s.z - before, -0.5 * 9.81 * 0.1, 0.02 * 0.5 * 9.81 * 0.1);
  EXPECT_NEAR(bench.outputs.reactions[0].F_Do_W.force_N.z, -0.25 * 9.81, 0.01);
}

TEST(PhysicsNode, WhatJawsNoLongerPressStaysBehind) {
  GripBench bench(1.5);
  bench.Run(1000);
  ASSERT_EQ(bench.held(), Bench::kBlock);
  bench.MoveJaws(2.0 * Bench::kHalf_m + 1e-4, 0.05);  // opened by less than what a grasp by its spring bears
  bench.Run(20);
  EXPECT_EQ(bench.held(), core::kNoObject);
  bench.Run(100);
  EXPECT_LT(bench.block().V_WO.linear_m_per_s.z, -0.5);
}

TEST(PhysicsNode, ABrushOfBothJawsDoesNotHold) {
  Bench bench;
  bench.opening_m = 0.0385;  // both jaws press from one tick to the next
  bench.Run(GraspKeeper::kPressTicks - 1);
  bench.opening_m = 0.05;
  bench.Run(50);
  EXPECT_TRUE(bench.events.empty());
  bench.opening_m = 0.0385;
  bench.Run(GraspKeeper::kPressTicks + 1);
  EXPECT_EQ(bench.held(), Bench::kBlock);
}

TEST(PhysicsNode, AJawThatLosesItForAMomentKeepsIt) {
  Bench bench;
  bench.MoveJaws(0.0385, 0.05);
  bench.Run(50);
  ASSERT_EQ(bench.held(), Bench::kBlock);
  const auto lose = [&bench](int ticks) {
    bench.sends_contacts = false;
    for (int i = 0; i < ticks; ++i) {
      for (const std::size_t pair : {Bench::kLeft, Bench::kRight}) {
        const double side = pair == Bench::kLeft ? -1.0 : 1.0;
        bench.SetJaw(pair, side);
        core::ContactSet& set = bench.contacts[pair];
        set.header.sequence = set.cycle = bench.cycle + 1;
        set.planes[0].q_G.x -= static_cast<float>(side * 0.003);  // 2 mm or more from the jaw
      }
      bench.Tick();
    }
    bench.sends_contacts = true;
  };
  lose(GraspKeeper::kLostTicks - 1);
  bench.Run(1);
  EXPECT_EQ(bench.held(), Bench::kBlock);
  lose(GraspKeeper::kLostTicks + 1);
  EXPECT_EQ(bench.held(), core::kNoObject);
}

TEST(PhysicsNode, JawsTurnALeverWithoutHoldingIt) {
  scene::Scenario scenario = Bench::MakeScenario();
  scene::Mechanism hinge;  // about z, 0.1 m beside the block
  hinge.name = "switch";
  hinge.parent = Bench::kWall;
  hinge.child = Bench::kBlock;
  hinge.X_PJ.translation = hinge.X_CJ.translation = {0.0, -0.1, 0.0};
  scenario.mechanisms.push_back(hinge);
  Bench bench(scenario);
  bench.MoveJaws(0.038, 0.05);
  bench.Run(50);
  EXPECT_EQ(bench.held(), core::kNoObject);
  EXPECT_TRUE(bench.events.empty());
  bench.MoveHand({0.05, 0.0, 0.0}, 200);
  EXPECT_GT(bench.block().X_WO.translation.x, 0.005);
  EXPECT_NEAR(glm::length(bench.block().X_WO.translation - hinge.X_PJ.translation), 0.1, 1e-4);
}

// E.g. two panels joined by a hinge.
TEST(PhysicsNode, ABodyHingedOnAFreeBodyCanBeHeld) {
  scene::Scenario scenario = Bench::MakeScenario();
  scene::Object panel;
  panel.name = "panel";
  panel.owner = scene::Owner::kPhysics;
  scenario.objects.push_back(panel);
  scene::Mechanism hinge;
  hinge.name = "fold";
  hinge.parent = static_cast<int>(scenario.objects.size()) - 1;
  hinge.child = Bench::kBlock;
  scenario.mechanisms.push_back(hinge);
  Bench bench(scenario);
  bench.MoveJaws(0.038, 0.05);
  bench.Run(50);
  EXPECT_EQ(bench.held(), Bench::kBlock);
}

TEST(PhysicsNode, OneJawPushesButDoesNotHold) {
  Bench bench;
  bench.opening_m = 0.06;
  bench.X_WD.translation.x = 0.0105;  // left jaw at -19.5 mm: 0.5 mm into the block; the right one far away
  bench.Run(200);
  EXPECT_EQ(bench.held(), core::kNoObject);
  EXPECT_GT(bench.block().X_WO.translation.x, 0.0004);
}

TEST(PhysicsNode, FingertipsOnOneFaceDoNotHold) {
  Bench bench;
  bench.sends_contacts = false;
  for (int i = 0; i < 100; ++i) {
    for (const std::size_t pair : {Bench::kLeft, Bench::kRight}) {
      core::ContactSet& set = bench.contacts[pair];
      set.header.sequence = bench.cycle + 1;
      set.cycle = bench.cycle + 1;
      set.is_in_contact = true;
      set.signed_distance_m = -0.0005;
      set.planes.clear();
      core::ContactPlane plane;
      plane.q_G = {0.0f, 0.0f, 0.0005f};
      plane.n_G = {0.0f, 0.0f, 1.0f};
      plane.stiffness_N_per_m = 10.0f;
      set.planes.push_back(plane);
    }
    bench.Tick();
    EXPECT_EQ(bench.held(), core::kNoObject);
  }
}

TEST(PhysicsNode, HeldObjectStaysHeldUnderLoadAcrossTheJaws) {
  scene::Scenario scenario = Bench::MakeScenario();
  scenario.contact_input = scene::ContactInput::kPlanes;
  Bench bench(scenario);
  bench.MoveJaws(0.0385, 0.05);
  bench.Run(30);
  ASSERT_EQ(bench.held(), Bench::kBlock);
  // The wall holds the block back along the jaws' axis while the hand moves on by 10 mm: the gap to one jaw is far
  // above the lost margin.
  const auto hold = [&] {
    core::ContactSet& set = bench.contacts[Bench::kBlockWall];
    set.header.sequence = bench.cycle + 1;
    set.cycle = bench.cycle + 1;
    set.planes.clear();
    core::ContactPlane plane;
    plane.id = 9;
    plane.p_S = {0.02f, 0.0f, 0.0f};
    plane.q_G = {0.0201f, 0.0f, 0.0f};
    plane.n_G = {-1.0f, 0.0f, 0.0f};
    plane.stiffness_N_per_m = 2.0e5f;
    set.planes.push_back(plane);
  };
  for (int i = 0; i < 200; ++i) {
    hold();
    bench.MoveHand({0.05, 0.0, 0.0}, 1);
  }
  for (int i = 0; i < 200; ++i) {
    hold();
    bench.Tick();
  }
  EXPECT_EQ(bench.held(), Bench::kBlock);
  // The grasp's spring and the wall's, in a row, are 9.9 mm long.
  const double K_N_per_m = 1.0 / (1.0 / scenario.coupling.grasp_stiffness_N_per_m + 1.0 / 2.0e5);
  EXPECT_NEAR(bench.outputs.reactions[0].F_Do_W.force_N.x, -K_N_per_m * 0.0099, 0.1);
}

TEST(PhysicsNode, TheReactionOfAGraspIsOppositeToTheObjectsChangeOfMomentum) {
  Bench bench;
  bench.MoveJaws(0.0385, 0.05);
  bench.Run(50);
  ASSERT_EQ(bench.held(), Bench::kBlock);
  for (int i = 0; i < 100; ++i) {
    const glm::dvec3 before = bench.block().V_WO.linear_m_per_s;
    bench.MoveHand({0.0, 0.3, -0.1}, 1);
    const glm::dvec3 dp = 0.5 * (bench.block().V_WO.linear_m_per_s - before);
    EXPECT_LT(glm::length(bench.outputs.reactions[0].F_Do_W.force_N * core::kTick_s + dp), 1e-12);
  }
}

TEST(PhysicsNode, SilentHapticNodeLeavesNoForceAndNoHandVelocity) {
  Bench bench;
  bench.X_WD.translation.x = 0.010;  // left jaw touches from the left
  bench.MoveHand({0.05, 0.0, 0.0}, 100);
  bench.is_haptic_alive = false;
  bench.inputs.proxies[0].V_WD.linear_m_per_s = {0.05, 0.0, 0.0};
  bench.Run(PhysicsNode::kMaxAgeTicks + 2);
  const glm::dvec3 drift = bench.block().V_WO.linear_m_per_s;
  for (int i = 0; i < 200; ++i) {
    bench.Tick();
    EXPECT_EQ(bench.block().V_WO.linear_m_per_s, drift);
    EXPECT_EQ(bench.outputs.reactions[0].F_Do_W.force_N, glm::dvec3(0.0));
  }
  EXPECT_EQ(bench.node->world().V_WO(1).linear_m_per_s, glm::dvec3(0.0));
}

TEST(PhysicsNode, NothingFallsWhileNobodyTestsWhatItStandsOn) {
  GripBench bench(0.0);
  bench.is_haptic_alive = false;
  bench.Run(200);
  EXPECT_EQ(bench.z_m(), 0.0) << "before the first contacts";
  bench.is_haptic_alive = true;
  bench.Run(101);
  const double speed_m_per_s = bench.block().V_WO.linear_m_per_s.z;
  EXPECT_NEAR(speed_m_per_s, -9.81 * 0.1, 0.02);
  bench.is_haptic_alive = false;
  bench.Run(PhysicsNode::kMaxAgeTicks + 2);
  const glm::dvec3 drift = bench.block().V_WO.linear_m_per_s;
  bench.Run(100);
  EXPECT_EQ(bench.block().V_WO.linear_m_per_s, drift);
}

TEST(PhysicsNode, ContactSetsOfOldCyclesAreDropped) {
  Bench bench;
  bench.X_WD.translation.x = 0.0105;
  bench.Run(2);
  bench.sends_contacts = false;  // proxies go on, this pair's sets stop
  bench.Run(PhysicsNode::kMaxAgeTicks);
  bench.X_WD.translation.x = 0.1;  // a stale plane would throw the block
  const glm::dvec3 drift = bench.block().V_WO.linear_m_per_s;
  bench.Run(50);
  EXPECT_EQ(bench.block().V_WO.linear_m_per_s, drift);
}

TEST(PhysicsNode, TracePassesThroughPhysicsOnlyInContactWithAMovingObject) {
  Bench bench;
  bench.Run(10);
  EXPECT_EQ(bench.outputs.state.header.direct.id, core::MakeTraceId(0, bench.cycle));
  EXPECT_FALSE(bench.outputs.state.header.through_physics.valid());
  EXPECT_FALSE(bench.outputs.state.is_in_contact);
  bench.X_WD.translation.x = 0.0105;
  bench.Tick();
  EXPECT_TRUE(bench.outputs.state.is_in_contact);
  EXPECT_EQ(bench.outputs.state.header.through_physics.id, core::MakeTraceId(0, bench.cycle));
  EXPECT_EQ(bench.outputs.reactions[0].header.through_physics.id, core::MakeTraceId(0, bench.cycle));
}

TEST(PhysicsNode, InactivePairDoesNotPush) {
  Bench bench;
  bench.X_WD.translation.x = 0.0105;
  const core::ParameterChange off{"pair.jaw_left/block.active", 0.0};
  EXPECT_TRUE(bench.node->AcceptsParameter(off));
  EXPECT_FALSE(bench.node->AcceptsParameter({off.name, -1.0}));
  EXPECT_FALSE(bench.node->AcceptsParameter({off.name, std::numeric_limits<double>::quiet_NaN()}));
  EXPECT_FALSE(bench.node->AcceptsParameter({"force_cap_N", 1.0}));
  const std::vector<std::string> names = bench.node->ParameterNames();
  EXPECT_TRUE(std::binary_search(names.begin(), names.end(), off.name));
  bench.inputs.changes = &off;
  bench.inputs.num_changes = 1;
  bench.Run(50);
  EXPECT_EQ(bench.block().V_WO.linear_m_per_s, glm::dvec3(0.0));
}

TEST(PhysicsNode, WrenchInputAppliesTheForceOfThePaper) {
  scene::Scenario scenario = Bench::MakeScenario();
  scenario.contact_input = scene::ContactInput::kWrench;
  Bench bench(scenario);
  bench.sends_contacts = false;
  for (int i = 0; i < 100; ++i) {
    core::ContactSet& set = bench.contacts[Bench::kLeft];
    set.header.sequence = bench.cycle + 1;
    set.cycle = bench.cycle + 1;
    set.is_in_contact = true;
    set.F_So_W.force_N = {-2.0, 0.0, 0.0};
    bench.Tick();
  }
  EXPECT_NEAR(bench.block().V_WO.linear_m_per_s.x, 2.0 * 0.1 / 0.5, 1e-9);
}

// The forces of opposing jaws on the hand cancel, so the wrench in the message cannot show a grasp.
TEST(PhysicsNode, WrenchInputGraspsCarriesAndReleasesToo) {
  scene::Scenario scenario = Bench::MakeScenario();
  scenario.contact_input = scene::ContactInput::kWrench;
  Bench bench(scenario);
  bench.MoveJaws(0.038, 0.05);
  bench.Run(50);
  ASSERT_EQ(bench.held(), Bench::kBlock);
  EXPECT_EQ(bench.block().V_WO.linear_m_per_s, glm::dvec3(0.0)) << "only the wrench pushes";
  bench.MoveHand({0.1, 0.05, 0.2}, 1000);
  bench.Run(500);
  EXPECT_EQ(bench.held(), Bench::kBlock);
  EXPECT_LT(glm::length(bench.block().X_WO.translation - glm::dvec3(0.1, 0.05, 0.2)), 1e-3);
  bench.MoveJaws(0.05, 0.05);
  bench.Run(10);
  EXPECT_EQ(bench.held(), core::kNoObject);
}

TEST(PhysicsNode, ChangedReleaseForceActsFromTheNextTickAndIsAnEvent) {
  scene::Scenario scenario = Bench::MakeScenario();
  scene::Mechanism snap;
  snap.name = "latch";
  snap.kind = scene::MechanismKind::kSnap;
  snap.parent = Bench::kWall;
  snap.child = Bench::kBlock;
  snap.engage_force_N = 10.0;
  snap.release_force_N = 30.0;
  snap.stiffness_N_per_m = 2.0e4;
  snap.stiffness_Nm_per_rad = 40.0;
  snap.damping = 30.0;
  snap.is_initially_engaged = true;
  scenario.mechanisms.push_back(snap);
  Bench bench(scenario);
  bench.MoveJaws(0.0385, 0.05);
  bench.Run(50);
  ASSERT_EQ(bench.held(), Bench::kBlock);
  // Until the grasp's spring pulls with 18 N, less what the latch gives way.
  bench.MoveHand({0.0, 0.0, 0.02}, static_cast<int>(18.0 / scenario.coupling.grasp_stiffness_N_per_m / 2e-5));
  ASSERT_EQ(bench.outputs.state.mechanisms[0].state, 1);
  const core::ParameterChange change{"latch.release_force_N", 10.0};
  bench.inputs.changes = &change;
  bench.inputs.num_changes = 1;
  bench.Tick();
  EXPECT_EQ(bench.outputs.state.mechanisms[0].state, 0);
  EXPECT_EQ(bench.events.back().name, "snap_released");
  EXPECT_EQ(bench.events.back().detail, "latch");
}

TEST(PhysicsNode, TwoRunsAreEqualBitForBit) {
  const auto run = [] {
    Bench bench;
    bench.MoveJaws(0.038, 0.05);
    bench.MoveHand({0.1, 0.05, 0.2}, 300);
    bench.MoveJaws(0.06, 0.1);
    bench.Run(100);
    return bench.node->StateHash();
  };
  EXPECT_EQ(run(), run());
}

TEST(PhysicsNode, NonFiniteDevicePoseIsIgnored) {
  Bench bench;
  bench.Run(10);
  bench.X_WD.translation.x = std::nan("");
  bench.sends_contacts = false;
  bench.Run(10);
  EXPECT_TRUE(std::isfinite(bench.node->world().X_WO(1).translation.x));
  EXPECT_TRUE(std::isfinite(bench.block().X_WO.translation.x));
}

TEST(PhysicsNode, RefusesAMechanismBetweenFixedObjectsByName) {
  scene::Scenario scenario = Bench::MakeScenario();
  scene::Mechanism hinge;
  hinge.name = "dead_hinge";
  hinge.parent = -1;
  hinge.child = Bench::kWall;
  scenario.mechanisms.push_back(hinge);
  const auto node = PhysicsNode::Create(scenario, std::vector<physics::MassProperties>(scenario.objects.size()));
  ASSERT_FALSE(node.has_value());
  EXPECT_NE(node.error().detail.find("dead_hinge"), std::string::npos);
}

}  // namespace
}  // namespace physics_node
