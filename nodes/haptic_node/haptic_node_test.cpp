#include "nodes/haptic_node/haptic_node.hpp"

#include <gtest/gtest.h>

#include <fstream>

#include "bus/rt/worker_pool.hpp"
#include "collision/collision_matrix.hpp"
#include "core/clock.hpp"
#include "core/hand_limits.hpp"
#include "core/testing/allocations.hpp"

namespace {
std::atomic<std::uint64_t> num_allocations{0};
}
namespace haptic_node {
namespace {

constexpr double kHalfBall_m = 0.01;

void WriteBox(const std::filesystem::path& file, const glm::dvec3& half_m) {
  std::ofstream out(file);
  for (int i = 0; i < 8; ++i) {
    out << "v " << ((i & 1) != 0 ? half_m.x : -half_m.x) << ' ' << ((i & 2) != 0 ? half_m.y : -half_m.y) << ' '
        << ((i & 4) != 0 ? half_m.z : -half_m.z) << "\n";
  }
  out << "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n";
}

// A fixed plate with its top at z = 0, a free block on one side, and two hands, each a small box.
scene::Scenario TwoHands() {
  const std::filesystem::path folder = std::filesystem::path(::testing::TempDir()) / "haptic_node_test";
  std::filesystem::create_directories(folder);
  WriteBox(folder / "plate.obj", {0.15, 0.1, 0.02});
  WriteBox(folder / "tip.obj", glm::dvec3(kHalfBall_m));
  scene::Scenario scenario;
  scenario.name = "two_hands";
  const auto add = [&](const std::string& name, scene::Owner owner, const std::string& mesh, const glm::dvec3& p_W) {
    scene::Object object;
    object.name = name;
    object.owner = owner;
    object.collision_mesh = folder / mesh;
    object.X_WO.translation = p_W;
    scenario.objects.push_back(object);
    return static_cast<std::uint16_t>(scenario.objects.size() - 1);
  };
  const auto plate = add("plate", scene::Owner::kFixed, "plate.obj", {0, 0, -0.02});
  const auto block = add("block", scene::Owner::kPhysics, "plate.obj", {0, 0.5, -0.02});
  for (const std::uint16_t field : {plate, block}) scenario.objects[field].voxel_size_m = 0.001;
  for (int role = 0; role < 2; ++role) {
    const auto palm = add("palm" + std::to_string(role), scene::Owner::kHand, "tip.obj", {0.05 * role, 0, 0.1});
    scenario.objects[palm].part = scene::HandPart::kPalm;
    scenario.objects[palm].role = role;
    scenario.objects[palm].num_points = 2000;
    scene::Device device;
    device.role = "op1/arm." + std::to_string(role);
    device.palm = palm;
    device.X_WD_start.translation = {0.05 * role, 0, 0.1};
    scenario.devices.push_back(device);
    for (const std::uint16_t field : {plate, block}) {
      scene::Pair pair;
      pair.sampled = palm;
      pair.field = field;
      scenario.pairs.push_back(pair);
    }
  }
  return scenario;
}

class Bench {
 public:
  explicit Bench(core::ParallelFor& workers, const scene::Scenario& scenario = TwoHands()) : scenario_(scenario) {
    Options options;
    options.collision.cache = std::filesystem::path(::testing::TempDir()) / "haptic_node_cache";
    auto made = HapticNode::Create(scenario_, workers, options);
    EXPECT_TRUE(made) << made.error().detail;
    node_ = std::move(*made);
    node_->PrepareOutputs(&out);
    for (std::uint8_t role = 0; role < 2; ++role) {
      core::DeviceState device;
      device.role_index = role;
      device.is_engaged = true;
      device.X_WD = scenario_.devices[role].X_WD_start;
      inputs.devices.push_back(device);
      core::Reaction reaction;
      reaction.role_index = role;
      inputs.reactions.push_back(reaction);
    }
    core::BodyState block;
    block.object = 1;
    block.X_WO = scenario_.objects[1].X_WO;
    physics.bodies.push_back(block);
    inputs.physics = &physics;
  }

  void Tick() {
    inputs.now_ns += core::kTick_ns;
    for (core::DeviceState& device : inputs.devices) device.header.sequence += device_speaks ? 1 : 0;
    for (core::Reaction& reaction : inputs.reactions) reaction.header.sequence += physics_speaks ? 1 : 0;
    physics.header.sequence += physics_speaks ? 1 : 0;
    node_->Step(inputs, &out);
    inputs.num_changes = 0;
  }
  void Run(int ticks) {
    for (int i = 0; i < ticks; ++i) Tick();
  }
  void Set(const std::string& name, double value) {
    change_ = {name, value};
    inputs.changes = &change_;
    inputs.num_changes = 1;
  }
  // Bottom of the hand's box at this height above the plane z = 0, moved there at 50 mm/s.
  void Press(std::size_t role, double depth_m, double y_m = 0.0) {
    glm::dvec3& p = inputs.devices[role].X_WD.translation;
    const glm::dvec3 from = p;
    const glm::dvec3 to(p.x, y_m, kHalfBall_m - depth_m);
    for (int i = 1; i <= 500; ++i) {
      p = from + (i / 500.0) * (to - from);
      Tick();
    }
    Run(300);
  }
  [[nodiscard]] const core::Wrench& force(std::size_t role) const { return out.commands[role].F_Do_W; }

  scene::Scenario scenario_;
  std::unique_ptr<HapticNode> node_;
  core::PhysicsState physics;
  Inputs inputs;
  Outputs out;
  bool device_speaks = true;
  bool physics_speaks = true;

 private:
  core::ParameterChange change_;
};

TEST(HapticNode, AFreeHandFeelsNothing) {
  core::SerialFor serial;
  Bench bench(serial);
  bench.Run(50);
  EXPECT_EQ(glm::length(bench.force(0).force_N), 0.0);
  EXPECT_FALSE(bench.out.is_in_contact);
}

TEST(HapticNode, APressedHandFeelsTheCouplingSpringAndItsProxyStaysOnTheSurface) {
  core::SerialFor serial;
  Bench bench(serial);
  bench.Press(0, 0.004);
  const double k = bench.scenario_.coupling.stiffness_N_per_m;
  // The surface is known to one voxel.
  EXPECT_NEAR(bench.force(0).force_N.z, k * 0.004, k * 0.001);
  EXPECT_NEAR(bench.out.proxies[0].X_WC.translation.z, kHalfBall_m, 0.001);
  EXPECT_LT(glm::length(glm::dvec2(bench.force(0).force_N)), 0.05 * bench.force(0).force_N.z);
  EXPECT_TRUE(bench.out.proxies[0].is_in_contact);
}

TEST(HapticNode, AContactOfOneHandDoesNotActOnTheOther) {
  core::SerialFor serial;
  Bench bench(serial);
  bench.Press(1, 0.004);
  EXPECT_EQ(glm::length(bench.force(0).force_N), 0.0);
  EXPECT_GT(bench.force(1).force_N.z, 5.0);
}

TEST(HapticNode, TheStiffnessFollowsTheLimitOfItsLoopWithoutAStepOfTheForce) {
  for (const char* type : {"paper", "god_object"}) {
    core::SerialFor serial;
    scene::Scenario scenario = TwoHands();
    scenario.coupling.type = type;
    Bench bench(serial, scenario);
    bench.Press(0, 0.004);
    const double full_N = bench.force(0).force_N.z;
    ASSERT_GT(full_N, 5.0);
    const auto largest_step_N = [&bench] {
      double largest_N = 0.0;
      for (int i = 0; i < 300; ++i) {
        const double before_N = bench.force(0).force_N.z;
        bench.Tick();
        largest_N = std::max(largest_N, std::abs(bench.force(0).force_N.z - before_N));
      }
      return largest_N;
    };
    const double usual_N = largest_step_N();
    bench.Set(core::StiffnessLimitName("op1/arm.0"), 0.5);
    EXPECT_LT(largest_step_N(), usual_N + 0.006 * full_N) << type;
    EXPECT_NEAR(bench.force(0).force_N.z, 0.5 * full_N, 0.02 * full_N) << type;
    EXPECT_NEAR(bench.node_->stiffness_share(), 0.5, 1e-12);
    bench.Set(core::StiffnessLimitName("op1/arm.0"), 3.0);  // more than is wanted
    bench.Run(300);
    EXPECT_NEAR(bench.force(0).force_N.z, full_N, 0.02 * full_N) << type;
    EXPECT_EQ(bench.node_->stiffness_share(), 1.0);
    EXPECT_NEAR(bench.node_->least_stiffness_share(), 0.5, 1e-12);
  }
}

TEST(HapticNode, TheDamperOfAToolWithMassStaysWithinWhatTheDelayAllows) {
  core::SerialFor serial;
  scene::Scenario scenario = TwoHands();
  scenario.coupling.type = "god_object";
  constexpr std::size_t kPalm0 = 2;
  scenario.objects[kPalm0].mass_kg = 0.3;
  Bench bench(serial, scenario);
  const double wanted = 2.0 * std::sqrt(scenario.coupling.stiffness_N_per_m * 0.3);
  EXPECT_NEAR(bench.node_->damping_N_s_per_m(0), wanted, 1e-9);
  bench.Set(core::DampingLimitName("op1/arm.0"), 0.5 * wanted);
  bench.Tick();
  EXPECT_NEAR(bench.node_->damping_N_s_per_m(0), 0.5 * wanted, 1e-9);
  bench.Set(core::DampingLimitName("op1/arm.0"), 3.0 * wanted);  // more than is wanted
  bench.Tick();
  EXPECT_NEAR(bench.node_->damping_N_s_per_m(0), wanted, 1e-9);
  EXPECT_FALSE(bench.node_->AcceptsParameter({core::DampingLimitName("op1/arm.1"), 1.0})) << "it has no mass";
}

TEST(HapticNode, TheCapLimitsTheNormAndKeepsTheDirection) {
  core::SerialFor serial;
  Bench bench(serial);
  bench.Press(0, 0.004);
  const glm::dvec3 before = glm::normalize(bench.force(0).force_N);
  bench.Set("force_cap_N", 1.0);
  bench.Tick();
  EXPECT_NEAR(glm::length(bench.force(0).force_N), 1.0, 1e-9);
  EXPECT_GT(glm::dot(glm::normalize(bench.force(0).force_N), before), 0.999);
}

TEST(HapticNode, DeactivatingThePairRemovesTheForce) {
  core::SerialFor serial;
  Bench bench(serial);
  bench.Press(0, 0.004);
  bench.Set("pair.palm0/plate.active", 0.0);
  bench.Run(200);
  EXPECT_NEAR(glm::length(bench.force(0).force_N), 0.0, 1e-9);
}

TEST(HapticNode, AcceptsOnlyItsOwnParameters) {
  core::SerialFor serial;
  Bench bench(serial);
  EXPECT_TRUE(bench.node_->AcceptsParameter({"force_cap_N", 10.0}));
  EXPECT_FALSE(bench.node_->AcceptsParameter({"force_cap_N", -1.0}));
  EXPECT_TRUE(bench.node_->AcceptsParameter({"pair.palm0/block.active", 0.0}));
  EXPECT_FALSE(bench.node_->AcceptsParameter({"latch_a.release_force_N", 1.0}));
  const std::vector<std::string> names = bench.node_->ParameterNames();
  const auto has = [&](const char* name) { return std::find(names.begin(), names.end(), name) != names.end(); };
  EXPECT_TRUE(has("force_cap_N"));
  EXPECT_TRUE(has("pair.palm0/block.active"));
  EXPECT_FALSE(has("pair.palm0/block.stiffness_N_per_m"));  // a hand's pair has the coupling's
}

TEST(HapticNode, ASilentDeviceGetsNoForceAfterTenMilliseconds) {
  core::SerialFor serial;
  Bench bench(serial);
  bench.Press(0, 0.004);
  bench.device_speaks = false;
  bench.Run(11);
  EXPECT_EQ(glm::length(bench.force(0).force_N), 0.0);
  EXPECT_FALSE(bench.out.proxies[0].is_engaged);
}

TEST(HapticNode, SilentPhysicsFadesTheForceOutWithinFiftyMilliseconds) {
  core::SerialFor serial;
  Bench bench(serial);
  bench.Press(0, 0.004, 0.5);
  bench.inputs.reactions[0].F_Do_W.force_N = {3.0, 0.0, 0.0};
  bench.Run(10);
  const double before_N = glm::length(bench.force(0).force_N);
  EXPECT_GT(before_N, 5.0);
  bench.physics_speaks = false;
  for (int i = 0; i < 50; ++i) {
    bench.Tick();
    // The proxy of a resting hand moves by a few hundredths of a millimetre; beyond that the force may only fall.
    EXPECT_LE(glm::length(bench.force(0).force_N), 1.05 * before_N);
    if (i >= 30) {
      EXPECT_LT(glm::length(bench.force(0).force_N), 0.6 * before_N);
    }
  }
  EXPECT_EQ(glm::length(bench.force(0).force_N), 0.0);
}

TEST(HapticNode, TheReactionOfPhysicsActsOnTheHand) {
  core::SerialFor serial;
  Bench bench(serial);
  bench.inputs.reactions[1].F_Do_W = {{3.0, -4.0, 0.0}, {0.0, 0.0, 0.1}};
  bench.Tick();
  EXPECT_EQ(bench.force(1).force_N, glm::dvec3(3.0, -4.0, 0.0));
  EXPECT_EQ(bench.force(0).force_N, glm::dvec3(0.0));
}

TEST(HapticNode, AHeldObjectActsOnTheHandOnlyByTheReaction) {
  core::SerialFor serial;
  Bench bench(serial);
  bench.Press(0, 0.004, 0.5);
  EXPECT_GT(bench.force(0).force_N.z, 5.0);
  bench.inputs.reactions[0].grasped_object = 1;
  bench.Run(200);
  EXPECT_NEAR(glm::length(bench.force(0).force_N), 0.0, 1e-9);
  // Its contact is still sent to physics_node, which needs to know that the object is touched.
  EXPECT_EQ(bench.out.contacts_updated[1], 1);
  EXPECT_TRUE(bench.out.contacts[1].is_in_contact);
}

TEST(HapticNode, ForcesOnHandAndObjectAreOpposite) {
  core::SerialFor serial;
  Bench bench(serial);
  bench.Press(0, 0.004, 0.5);
  const core::ContactSet& set = bench.out.contacts[1];
  ASSERT_EQ(bench.out.contacts_updated[1], 1);
  EXPECT_EQ(set.F_So_W.force_N, bench.out.proxies[0].F_Do_W.force_N);  // on the hand; the block gets the opposite
  // Planes evaluated at the device pose give the same force: sum of k * depth * n.
  glm::dvec3 sum_N(0.0);
  const core::Pose X_WS = bench.inputs.devices[0].X_WD;
  const core::Pose X_WG = bench.scenario_.objects[1].X_WO;
  for (const core::ContactPlane& plane : set.planes) {
    const glm::dvec3 n_W = X_WG.rotate(glm::dvec3(plane.n_G));
    const double gap_m = glm::dot(n_W, X_WS * glm::dvec3(plane.p_S) - X_WG * glm::dvec3(plane.q_G));
    sum_N += plane.stiffness_N_per_m * std::max(-gap_m, 0.0) * n_W;
  }
  EXPECT_NEAR(sum_N.z, set.F_So_W.force_N.z, 0.25 * set.F_So_W.force_N.z);
}

TEST(HapticNode, PublishesTheEndOfAContact) {
  core::SerialFor serial;
  Bench bench(serial);
  bench.Press(0, 0.004, 0.5);
  bench.inputs.devices[0].X_WD.translation.z = 0.2;
  int num_empty = 0;
  for (int i = 0; i < 400; ++i) {
    bench.Tick();
    if (bench.out.contacts_updated[1] != 0 && !bench.out.contacts[1].is_in_contact &&
        bench.out.contacts[1].planes.empty()) {
      ++num_empty;
    }
  }
  EXPECT_GE(num_empty, 3);
  EXPECT_LT(num_empty, 20);
}

const core::CollisionMatrix& NextMatrix(Bench* bench) {
  do {
    bench->Tick();
  } while (!bench->out.is_collisions_updated);
  return bench->out.collisions;
}

TEST(HapticNode, TheCollisionMatrixSaysWhoTouchesHowDeepAndHowHard) {
  core::SerialFor serial;
  Bench bench(serial);
  EXPECT_EQ(NextMatrix(&bench).num_touching, 0U);
  bench.Press(0, 0.004);
  const core::CollisionMatrix& matrix = NextMatrix(&bench);
  constexpr std::uint16_t kPlate = 0, kBlock = 1, kPalm0 = 2, kPalm1 = 3;
  EXPECT_EQ(matrix.num_touching, 1U);
  EXPECT_FALSE(collision::AreColliding(matrix, kPalm1, kPlate));
  EXPECT_FALSE(collision::AreColliding(matrix, kPalm0, kBlock));
  const core::Collision* touch = collision::FindCollision(matrix, kPlate, kPalm0);
  ASSERT_NE(touch, nullptr);
  EXPECT_EQ(touch->pair_index, 0);
  EXPECT_GT(touch->depth_m, 0.0f);
  EXPECT_LT(touch->depth_m, 0.001f) << "the proxy stays on the surface, up to a voxel";
  EXPECT_NEAR(touch->force_N, glm::length(bench.force(0).force_N), 1e-4);
}

TEST(HapticNode, TheForcesOfAHandsPairsInTheMatrixAddUpToTheCouplingsForce) {
  core::SerialFor serial;
  scene::Scenario scenario = TwoHands();
  scenario.objects[1].X_WO.translation = {0.0, 0.2, -0.02};  // side by side with the plate
  Bench bench(serial, scenario);
  bench.Press(0, 0.004, 0.1);
  const core::CollisionMatrix& matrix = NextMatrix(&bench);
  ASSERT_EQ(matrix.collisions.size(), 2U);
  const float sum_N = matrix.collisions[0].force_N + matrix.collisions[1].force_N;
  EXPECT_NEAR(sum_N, glm::length(bench.out.proxies[0].F_Do_W.force_N), 1e-3);
}

TEST(HapticNode, AHeldObjectIsInTheMatrixWithThePressOfTheJaw) {
  core::SerialFor serial;
  Bench bench(serial);
  bench.Press(0, 0.004, 0.5);
  bench.inputs.reactions[0].grasped_object = 1;
  const core::CollisionMatrix& matrix = NextMatrix(&bench);
  const core::Collision* touch = collision::FindCollision(matrix, 1, 2);
  ASSERT_NE(touch, nullptr);
  ASSERT_GT(touch->depth_m, 0.0f);
  EXPECT_NEAR(touch->force_N, bench.scenario_.coupling.jaw_stiffness_N_per_m * touch->depth_m, 1e-3);
}

// A hand that presses on the free block, and physics' answer to the cycle before: the block has moved so far along z.
class AnsweredBench : public Bench {
 public:
  explicit AnsweredBench(core::ParallelFor& workers, const scene::Scenario& scenario = TwoHands())
      : Bench(workers, scenario) {
    Press(0, 0.004, 0.5);
    Answer(0.0);
  }
  void Answer(double block_z_m) {
    physics.bodies[0].X_WO.translation.z += block_z_m;
    ++physics.tick;
    ++physics.header.sequence;
    for (core::Reaction& reaction : inputs.reactions) {
      reaction.tick = physics.tick;
      ++reaction.header.sequence;
    }
    inputs.reactions[0].header.through_physics = {core::MakeTraceId(0, physics.tick), 2, {}};
  }
  const core::DeviceCommand& Reevaluate(std::size_t role = 0) {
    node_->Reevaluate(inputs, &reevaluated);
    return reevaluated.commands[role];
  }
  Outputs reevaluated;
};

scene::Scenario WithGodObject() {
  scene::Scenario scenario = TwoHands();
  scenario.method = "fast";
  scenario.coupling.type = "god_object";
  return scenario;
}

TEST(Reevaluate, FeelsWithTheGodObjectAtOnceByHowMuchTheObjectGivesWay) {
  core::SerialFor serial;
  for (const double moved_m : {-1e-4, 1e-4}) {
    AnsweredBench bench(serial, WithGodObject());
    const double still_N = bench.Reevaluate().F_Do_W.force_N.z;
    EXPECT_NEAR(still_N, bench.force(0).force_N.z, 0.01);
    bench.Answer(moved_m);
    const double now_N = bench.Reevaluate().F_Do_W.force_N.z;
    EXPECT_NEAR(now_N - still_N, moved_m * bench.scenario_.coupling.stiffness_N_per_m, 0.01);
  }
}

TEST(Reevaluate, FeelsThatTheObjectGivesWayWithoutWaitingForTheNextCycle) {
  core::SerialFor serial;
  for (const double moved_m : {-1e-4, 1e-4}) {
    AnsweredBench bench(serial);
    const double before_N = bench.force(0).force_N.z;
    const double still_N = bench.Reevaluate().F_Do_W.force_N.z;
    EXPECT_NEAR(still_N, before_N, 0.02 * before_N) << "nothing has moved";
    bench.Answer(moved_m);
    const double change_N = bench.Reevaluate().F_Do_W.force_N.z - still_N;
    EXPECT_GT(change_N * moved_m, 0.0) << "the block that follows the hand's push is felt less";
    bench.Tick();  // the next cycle, with a query at the new poses
    // Against the hand the field of the method paper steps by a voxel, which no plane says.
    if (moved_m < 0.0) {
      EXPECT_NEAR(still_N + change_N, bench.force(0).force_N.z, 0.01 * std::abs(change_N));
    } else {
      EXPECT_GT(bench.force(0).force_N.z, still_N);
    }
  }
}

TEST(Reevaluate, TakesTheNewestSampleAndReaction) {
  core::SerialFor serial;
  AnsweredBench bench(serial);
  const glm::dvec3 before_N = bench.Reevaluate().F_Do_W.force_N;
  ++bench.inputs.devices[0].header.sequence;
  bench.inputs.devices[0].X_WD.translation.z -= 1e-4;
  bench.inputs.reactions[0].F_Do_W.force_N = {1.5, 0.0, 0.0};
  const glm::dvec3 now_N = bench.Reevaluate().F_Do_W.force_N;
  EXPECT_NEAR(now_N.x - before_N.x, 1.5, 0.01);
  EXPECT_NEAR(now_N.z - before_N.z, 1e-4 * bench.scenario_.coupling.stiffness_N_per_m, 0.05);
  EXPECT_EQ(glm::length(bench.Reevaluate(1).F_Do_W.force_N), 0.0) << "the other hand is free";
}

TEST(Reevaluate, LetsGoOfAnObjectInTheTickInWhichItIsGrasped) {
  core::SerialFor serial;
  AnsweredBench bench(serial);
  bench.inputs.reactions[0].grasped_object = 1;
  EXPECT_NEAR(glm::length(bench.Reevaluate().F_Do_W.force_N), 0.0, 1e-9) << "else it is felt twice";
}

TEST(Reevaluate, ChangesNothingOfWhatFollows) {
  core::SerialFor serial;
  for (const scene::Scenario& scenario : {TwoHands(), WithGodObject()}) {
    AnsweredBench with(serial, scenario), without(serial, scenario);
    for (int i = 0; i < 300; ++i) {
      for (AnsweredBench* bench : {&with, &without}) {
        bench->inputs.devices[0].X_WD.translation.x += 1e-5;
        bench->Tick();
        bench->Answer(i % 2 == 0 ? 2e-4 : -2e-4);
      }
      with.Reevaluate();
      ASSERT_EQ(with.force(0).force_N, without.force(0).force_N) << i;
      ASSERT_EQ(with.out.proxies[0].X_WC.translation, without.out.proxies[0].X_WC.translation) << i;
      ASSERT_EQ(with.out.counters.points_tested, without.out.counters.points_tested) << i;
      ASSERT_EQ(with.out.counters.pairs_coherent, without.out.counters.pairs_coherent) << i;
    }
  }
}

TEST(Reevaluate, FillsOnlyTheCommands) {
  core::SerialFor serial;
  AnsweredBench bench(serial);
  bench.node_->PrepareOutputs(&bench.reevaluated);
  bench.reevaluated.contacts_updated[1] = 1;
  const core::DeviceCommand& command = bench.Reevaluate();
  EXPECT_EQ(command.header.through_physics.id, bench.inputs.reactions[0].header.through_physics.id);
  EXPECT_FALSE(bench.reevaluated.commands[1].header.through_physics.valid()) << "not to be sent";
  EXPECT_TRUE(bench.reevaluated.proxies.empty());
  EXPECT_EQ(bench.reevaluated.contacts_updated[1], 0);
}

TEST(Reevaluate, IsForAWholeAnswerOfATickThatAHandTouchesSomethingIn) {
  core::SerialFor serial;
  AnsweredBench bench(serial);
  EXPECT_TRUE(bench.node_->IsToReevaluate(bench.inputs));
  ++bench.physics.tick;
  EXPECT_FALSE(bench.node_->IsToReevaluate(bench.inputs)) << "the reactions are of the tick before";
  bench.Answer(0.0);
  bench.inputs.reactions[0].header.through_physics = {};
  EXPECT_FALSE(bench.node_->IsToReevaluate(bench.inputs)) << "no hand touches what physics moves";
  scene::Scenario scenario = TwoHands();
  scenario.coupling.is_reevaluated = false;
  AnsweredBench off(serial, scenario);
  EXPECT_FALSE(off.node_->IsToReevaluate(off.inputs));
}

TEST(Reevaluate, DoesNotAllocate) {
  core::SerialFor serial;
  AnsweredBench bench(serial);
  bench.Reevaluate();
  const std::uint64_t before = core::test::NumAllocations();
  for (int i = 0; i < 100; ++i) bench.Reevaluate();
  EXPECT_EQ(core::test::NumAllocations(), before);
}

TEST(HapticNode, EchoesASampleDirectlyAndOnceThroughPhysics) {
  core::SerialFor serial;
  Bench bench(serial);
  bench.inputs.devices[0].header.direct = {core::MakeTraceId(0, 7), 5, {}};
  bench.physics.header.through_physics = {core::MakeTraceId(0, 3), 2, {}};
  bench.Tick();
  EXPECT_EQ(bench.out.commands[0].header.direct.id, core::MakeTraceId(0, 7));
  EXPECT_EQ(bench.out.commands[0].header.through_physics.id, core::MakeTraceId(0, 3));
  bench.Tick();
  EXPECT_FALSE(bench.out.commands[0].header.through_physics.valid());
}

TEST(HapticNode, ResultsDoNotDependOnTheNumberOfWorkers) {
  core::SerialFor serial;
  bus::WorkerPool pool(3);
  Bench one(serial);
  Bench three(pool);
  for (Bench* bench : {&one, &three}) {
    bench->Press(0, 0.003);
    bench->Press(1, 0.002, 0.5);
  }
  for (std::size_t role = 0; role < 2; ++role) {
    EXPECT_GT(glm::length(one.force(role).force_N), 1.0);
    EXPECT_EQ(one.force(role).force_N, three.force(role).force_N);
    EXPECT_EQ(one.force(role).torque_Nm, three.force(role).torque_Nm);
  }
  EXPECT_EQ(one.out.counters.points_tested, three.out.counters.points_tested);
}

TEST(HapticNode, AStepInContactDoesNotAllocate) {
  core::SerialFor serial;
  Bench bench(serial);
  bench.Press(0, 0.003);
  const std::uint64_t before = core::test::NumAllocations();
  bench.Run(100);  // several collision matrices among them
  EXPECT_EQ(core::test::NumAllocations(), before);
}

TEST(HapticNode, AStepOfTheGodObjectInContactDoesNotAllocate) {
  scene::Scenario scenario = TwoHands();
  scenario.method = "fast";
  scenario.coupling.type = "god_object";
  core::SerialFor serial;
  Bench bench(serial, scenario);
  bench.Press(0, 0.003);
  EXPECT_NEAR(bench.force(0).force_N.z, 0.003 * scenario.coupling.stiffness_N_per_m, 0.05);
  const std::uint64_t before = core::test::NumAllocations();
  bench.Run(100);
  EXPECT_EQ(core::test::NumAllocations(), before);
}

}  // namespace
}  // namespace haptic_node
