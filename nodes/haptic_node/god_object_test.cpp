// The coupling god_object in steps of the node, with method fast.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <vector>

#include "core/clock.hpp"
#include "nodes/haptic_node/haptic_node.hpp"
#include "scene/load_scenario.hpp"
#include "vps/mesh/load_mesh.hpp"

namespace haptic_node {
namespace {

scene::Scenario Touch() {
  auto scenario = scene::LoadScenario(std::string(VR_OOS_SOURCE_DIR) + "/scenarios/touch/scenario.xml");
  EXPECT_TRUE(scenario);
  scenario->method = "fast";
  scenario->coupling.type = "god_object";
  return *scenario;
}

void WriteBox(const std::filesystem::path& file, const glm::dvec3& least_m, const glm::dvec3& most_m) {
  std::ofstream out(file);
  for (int i = 0; i < 8; ++i) {
    out << "v " << ((i & 1) != 0 ? most_m.x : least_m.x) << ' ' << ((i & 2) != 0 ? most_m.y : least_m.y) << ' '
        << ((i & 4) != 0 ? most_m.z : least_m.z) << "\n";
  }
  out << "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n";
}

// A box of 0.2 m with voxels of 6 mm, 2 m away, that the hand could touch.
scene::Scenario TouchWithAFarCoarseBlock() {
  scene::Scenario scenario = Touch();
  const std::filesystem::path file = std::filesystem::path(::testing::TempDir()) / "far_block.obj";
  WriteBox(file, glm::dvec3(-0.1), glm::dvec3(0.1));
  scene::Object block;
  block.name = "far_block";
  block.owner = scene::Owner::kFixed;
  block.collision_mesh = file;
  block.voxel_size_m = 0.006;
  block.X_WO.translation = {2.0, 0.0, 0.0};
  scenario.objects.push_back(block);
  scene::Pair pair;
  pair.sampled = static_cast<std::uint16_t>(scenario.FindObject("ball"));
  pair.field = static_cast<std::uint16_t>(scenario.objects.size() - 1);
  scenario.pairs.push_back(pair);
  return scenario;
}

class Touching {
 public:
  explicit Touching(scene::Scenario its) : scenario(std::move(its)) {
    Options options;
    options.collision.cache = std::filesystem::path(::testing::TempDir()) / "haptic_node_cache";
    auto made = HapticNode::Create(scenario, serial_, options);
    EXPECT_TRUE(made) << made.error().detail;
    node_ = std::move(*made);
    node_->PrepareOutputs(&out);
    core::DeviceState device;
    device.is_engaged = true;
    device.X_WD = scenario.devices[0].X_WD_start;
    inputs_.devices.push_back(device);
    for (std::size_t i = 0; i < scenario.objects.size(); ++i) {
      if (scenario.objects[i].owner != scene::Owner::kPhysics) continue;
      core::BodyState body;
      body.object = static_cast<std::uint16_t>(i);
      body.X_WO = scenario.objects[i].X_WO;
      physics_.bodies.push_back(body);
    }
    inputs_.physics = &physics_;
    if (scenario.FindObject("ball") < 0) return;
    const auto ball =
        vps::LoadMesh(scenario.objects[static_cast<std::size_t>(scenario.FindObject("ball"))].collision_mesh);
    EXPECT_TRUE(ball);
    ball_ = ball->vertices;
  }

  void Tick() {
    inputs_.now_ns += core::kTick_ns;
    ++inputs_.devices[0].header.sequence;
    ++physics_.header.sequence;
    node_->Step(inputs_, &out);
  }
  void MoveTo(const glm::dvec3& to, double speed_m_per_s) {
    const glm::dvec3 from = X_WD().translation;
    const int ticks = static_cast<int>(std::ceil(glm::length(to - from) / (1e-3 * speed_m_per_s)));
    for (int i = 1; i <= ticks; ++i) {
      X_WD().translation = from + (static_cast<double>(i) / ticks) * (to - from);
      Tick();
    }
  }
  void Hold(int ticks) {
    for (int i = 0; i < ticks; ++i) Tick();
  }
  // Height of the ball's lowest vertex.
  [[nodiscard]] double Lowest_m(const core::Pose& X_W) const {
    double lowest_m = 1e9;
    for (const auto& vertex : ball_) lowest_m = std::min(lowest_m, (X_W * glm::dvec3(vertex)).z);
    return lowest_m;
  }
  // Where physics says that it is.
  core::Pose& X_WO(const std::string& name) {
    const int object = scenario.FindObject(name);
    return std::find_if(physics_.bodies.begin(), physics_.bodies.end(),
                        [object](const core::BodyState& body) { return body.object == object; })
        ->X_WO;
  }
  core::Pose& X_WD() { return inputs_.devices[0].X_WD; }
  double& opening_m() { return inputs_.devices[0].opening_m; }
  [[nodiscard]] const core::Wrench& force() const { return out.commands[0].F_Do_W; }
  [[nodiscard]] const core::Pose& X_WC() const { return out.proxies[0].X_WC; }

  scene::Scenario scenario;
  Outputs out;

 private:
  core::SerialFor serial_;
  std::unique_ptr<HapticNode> node_;
  core::PhysicsState physics_;
  Inputs inputs_;
  std::vector<glm::dvec3> ball_;
};

// Presses with 20 N on the plate, beside everything that stands on it.
void Press(Touching& touching) {
  const double depth_m = 20.0 / touching.scenario.coupling.stiffness_N_per_m;
  touching.MoveTo({-0.1, -0.02, 0.03}, 0.2);
  touching.MoveTo({-0.1, -0.02, 0.01 - depth_m}, 0.1);
  touching.Hold(200);
}

TEST(GodObjectInTheNode, RestsOnThePlateWithinTwentyMicrometresOfForceOverStiffness) {
  Touching touching(Touch());
  Press(touching);
  const double k = touching.scenario.coupling.stiffness_N_per_m;
  EXPECT_NEAR(touching.force().force_N.z, 20.0, 0.5);
  EXPECT_NEAR(touching.Lowest_m(touching.X_WC()), 0.0, 2e-5);
  EXPECT_NEAR(-touching.Lowest_m(touching.X_WD()), touching.force().force_N.z / k, 2e-5);
  EXPECT_TRUE(touching.out.proxies[0].is_in_contact);
}

// It rests on a surface, where collision may find it just outside.
TEST(GodObjectInTheNode, AForceIsAContact) {
  Touching touching(Touch());
  touching.MoveTo({-0.1, -0.02, 0.03}, 0.2);
  for (int i = 0; i < 500; ++i) {
    touching.X_WD().translation += glm::dvec3(4e-5, 0.0, i < 250 ? -1.4e-4 : 1e-4);
    touching.Tick();
    if (touching.out.proxies[0].is_in_contact) {
      EXPECT_TRUE(touching.out.is_in_contact) << i;
    }
  }
}

TEST(GodObjectInTheNode, AFarCoarsePartChangesNoBit) {
  Touching alone(Touch());
  Touching with_block(TouchWithAFarCoarseBlock());
  Press(alone);
  Press(with_block);
  EXPECT_EQ(alone.force().force_N, with_block.force().force_N);
  EXPECT_EQ(alone.force().torque_Nm, with_block.force().torque_Nm);
  EXPECT_EQ(alone.X_WC().translation, with_block.X_WC().translation);
  EXPECT_EQ(alone.X_WC().rotation, with_block.X_WC().rotation);
}

TEST(GodObjectInTheNode, FrictionIsFeltAsThePairsCone) {
  Touching touching(Touch());
  const auto ball = static_cast<std::uint16_t>(touching.scenario.FindObject("ball"));
  const auto plate = static_cast<std::uint16_t>(touching.scenario.FindObject("plate"));
  const auto pair = std::find_if(touching.scenario.pairs.begin(), touching.scenario.pairs.end(),
                                 [&](const scene::Pair& p) { return p.sampled == ball && p.field == plate; });
  ASSERT_NE(pair, touching.scenario.pairs.end());
  ASSERT_GT(pair->friction, 0.0);
  Press(touching);
  const glm::dvec3 from = touching.X_WD().translation;
  touching.MoveTo(from + glm::dvec3(0.02, 0.0, 0.0), 0.05);
  const glm::dvec3 F = touching.force().force_N;
  EXPECT_NEAR(-F.x / F.z, pair->friction, 0.03 * pair->friction);
  EXPECT_NEAR(F.y, 0.0, 0.03 * pair->friction * F.z);
}

// The block gets the opposite, as a wrench and as planes that physics_node evaluates at the device's pose.
TEST(GodObjectInTheNode, WhatTheHandFeelsIsWhatTheObjectGets) {
  Touching touching(Touch());
  const auto block = static_cast<std::size_t>(touching.scenario.FindObject("block"));
  const glm::dvec3 p = touching.scenario.objects[block].X_WO.translation;
  touching.MoveTo({p.x, p.y, 0.2}, 0.5);
  touching.MoveTo({p.x - 0.06, p.y, 0.2}, 0.5);
  touching.MoveTo({p.x - 0.06, p.y, p.z}, 0.5);
  touching.MoveTo({p.x - 0.025 - 0.006, p.y, p.z}, 0.1);
  touching.MoveTo({p.x - 0.025 - 0.006, p.y + 0.0005, p.z}, 0.1);  // it sticks
  touching.Hold(50);
  EXPECT_LT(touching.force().force_N.x, -5.0);
  EXPECT_LT(touching.force().force_N.y, -0.5);
  int num_sets = 0;
  for (std::size_t i = 0; i < touching.out.contacts.size(); ++i) {
    const core::ContactSet& set = touching.out.contacts[i];
    if (!set.is_in_contact || (set.sampled_body != block && set.field_body != block)) continue;
    ++num_sets;
    const bool is_hand_sampled = set.field_body == block;
    const double side = is_hand_sampled ? 1.0 : -1.0;
    EXPECT_LT(glm::length(side * set.F_So_W.force_N - touching.force().force_N), 0.02);
    glm::dvec3 sum_N(0.0);
    glm::dvec3 friction_N(0.0);
    const core::Pose& X_WBlock = touching.scenario.objects[block].X_WO;
    const core::Pose& X_WS = is_hand_sampled ? touching.X_WD() : X_WBlock;
    const core::Pose& X_WG = is_hand_sampled ? X_WBlock : touching.X_WD();
    for (const core::ContactPlane& plane : set.planes) {
      const glm::dvec3 n_W = X_WG.rotate(glm::dvec3(plane.n_G));
      const glm::dvec3 way_W = X_WS * glm::dvec3(plane.p_S) - X_WG * glm::dvec3(plane.q_G);
      const double gap_m = glm::dot(n_W, way_W);
      sum_N += plane.stiffness_N_per_m * std::max(-gap_m, 0.0) * n_W;
      if (gap_m < 0.0) friction_N -= static_cast<double>(plane.stiffness_N_per_m) * (way_W - gap_m * n_W);
    }
    EXPECT_NEAR(side * sum_N.x, touching.force().force_N.x, 0.02 * std::abs(touching.force().force_N.x));
    EXPECT_NEAR(side * friction_N.y, touching.force().force_N.y, 0.02 * std::abs(touching.force().force_N.y));
  }
  EXPECT_EQ(num_sets, 1);
}

// A gripper around a tab that is free to move: jaws left and right of the palm's origin, with their pads at x = 0.
scene::Scenario Gripper() {
  const std::filesystem::path folder = std::filesystem::path(::testing::TempDir()) / "gripper";
  std::filesystem::create_directories(folder);
  WriteBox(folder / "jaw_left.obj", {-0.01, -0.01, -0.006}, {0.0, 0.01, 0.006});
  WriteBox(folder / "jaw_right.obj", {0.0, -0.01, -0.006}, {0.01, 0.01, 0.006});
  WriteBox(folder / "palm.obj", {-0.02, -0.01, 0.03}, {0.02, 0.01, 0.04});
  WriteBox(folder / "tab.obj", {-0.0025, -0.02, -0.03}, {0.0025, 0.02, 0.003});
  scene::Scenario scenario;
  scenario.method = "fast";
  scenario.coupling.type = "god_object";
  scene::Device device;
  device.role = "right";
  const auto add = [&](const std::string& name, scene::Owner owner, scene::HandPart part) {
    scene::Object object;
    object.name = name;
    object.owner = owner;
    object.part = part;
    object.role = owner == scene::Owner::kHand ? 0 : -1;
    object.collision_mesh = folder / (name + ".obj");
    object.voxel_size_m = 0.0005;
    object.num_points = owner == scene::Owner::kHand ? 2000 : 0;
    scenario.objects.push_back(object);
    return static_cast<std::uint16_t>(scenario.objects.size() - 1);
  };
  const auto tab = add("tab", scene::Owner::kPhysics, scene::HandPart::kPalm);
  device.palm = add("palm", scene::Owner::kHand, scene::HandPart::kPalm);
  device.jaw_left = add("jaw_left", scene::Owner::kHand, scene::HandPart::kJawLeft);
  device.jaw_right = add("jaw_right", scene::Owner::kHand, scene::HandPart::kJawRight);
  scenario.devices.push_back(device);
  for (const int jaw : {device.jaw_left, device.jaw_right}) {
    scene::Pair pair;
    pair.sampled = static_cast<std::uint16_t>(jaw);
    pair.field = tab;
    pair.friction = 0.3;
    scenario.pairs.push_back(pair);
  }
  return scenario;
}

// Jaws that close on a part press on it with large forces against each other, at places that change from cycle to
// cycle. Were one of them kept from the part, the part would be flung away.
TEST(GodObjectInTheNode, APartBetweenJawsGetsTheOppositeOfWhatTheHandFeels) {
  Touching touching(Gripper());
  touching.X_WD().translation = {0.0003, 0.0, 0.0002};
  touching.X_WD().rotation = core::QuaternionFromRotationVector({0.001, 0.002, -0.001});
  double most_N = 0.0;
  double largest_N = 0.0;
  for (int i = 0; i < 120; ++i) {
    touching.opening_m() = std::max(0.012 - 1e-4 * i, 0.0048);
    touching.X_WO("tab").translation.x = 2e-5 * std::sin(0.7 * i);
    touching.Tick();
    glm::dvec3 sum_N = touching.out.proxies[0].F_Do_W.force_N;
    for (std::size_t k = 0; k < touching.out.contacts.size(); ++k) {
      sum_N -= touching.out.contacts[k].F_So_W.force_N;
      largest_N = std::max(largest_N, glm::length(touching.out.contacts[k].F_So_W.force_N));
    }
    most_N = std::max(most_N, glm::length(sum_N));
  }
  EXPECT_GT(largest_N, 0.1);
  EXPECT_LT(most_N, 1e-3);
}

}  // namespace
}  // namespace haptic_node
