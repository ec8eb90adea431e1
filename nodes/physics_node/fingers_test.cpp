// A hand with five fingers and a block of 0.5 kg, through the node's own steps: what holds it is friction.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numeric>
#include <vector>

#include "core/clock.hpp"
#include "nodes/physics_node/physics_node.hpp"
#include "scene/load_scenario.hpp"
#include "tracking/finger_angles.hpp"

namespace physics_node {
namespace {

constexpr double kBlock_m = 0.05;
constexpr double kWeight_N = 0.5 * 9.81;

// The palm goes where the test says; the person's fingers are those of GraspAngles.
class Hand {
 public:
  // Accuracy of its pairs; 0: the scenario's.
  explicit Hand(const char* file, double accuracy = 0.0) {
    const auto loaded = scene::LoadScenario(std::filesystem::path(VR_OOS_SOURCE_DIR) / "scenarios/five_fingers" / file);
    EXPECT_TRUE(loaded) << scene::Format(loaded.error().front());
    scenario_ = *loaded;
    for (scene::Pair& pair : scenario_.pairs) pair.accuracy = accuracy > 0.0 ? accuracy : pair.accuracy;
    node_ = Make();
    block_ = scenario_.FindObject("block");
    const scene::Object& block = scenario_.objects[static_cast<std::size_t>(block_)];
    X_WGrip_ = block.X_WO * block.frames.at(0).X_OF;
    X_WD_ = scenario_.devices.at(0).X_WD_start;
    inputs_.proxies.resize(1);
  }

  [[nodiscard]] std::unique_ptr<PhysicsNode> Make() const {
    auto made = PhysicsNode::Create(scenario_);
    EXPECT_TRUE(made.has_value()) << (made ? "" : made.error().detail);
    return std::move(*made);
  }

  void Tick() {
    Prepare();
    node_->Step(inputs_, &outputs_);
    for (const core::Event& event : outputs_.events) {
      if (event.name == "grasp_attached") is_held_ = true;
      if (event.name == "grasp_detached") is_held_ = false;
    }
  }
  void Prepare() {
    ++cycle_;
    inputs_.now_ns += core::kTick_ns;
    core::HapticProxy& proxy = inputs_.proxies[0];
    proxy.header.sequence = proxy.cycle = cycle_;
    proxy.X_WD = X_WD_;
    proxy.V_WD = V_WD_;
    proxy.finger_rad.clear();
    for (const double angle_rad : tracking::GraspAngles(opening_m_)) proxy.finger_rad.push_back(angle_rad);
  }

  void Wait(double seconds) {
    for (int i = 0; i < static_cast<int>(std::lround(1e3 * seconds)); ++i) Tick();
  }
  // At that speed of the opening.
  void Close(double opening_m, double m_per_s) {
    while (std::abs(opening_m_ - opening_m) > 1e-9) {
      opening_m_ += std::clamp(opening_m - opening_m_, -m_per_s * core::kTick_s, m_per_s * core::kTick_s);
      Tick();
    }
  }
  // On a straight way, as fast as that.
  void Go(const glm::dvec3& way_W, double m_per_s) {
    const auto num_ticks = static_cast<int>(std::ceil(glm::length(way_W) / (m_per_s * core::kTick_s)));
    V_WD_.linear_m_per_s = way_W / (num_ticks * core::kTick_s);
    for (int i = 0; i < num_ticks; ++i) {
      X_WD_.translation += way_W / static_cast<double>(num_ticks);
      Tick();
    }
    V_WD_ = {};
  }
  // Above the block, then down to where it is taken.
  void Reach() {
    const glm::dvec3 above_W(0.0, 0.0, 0.08);
    Go(X_WGrip_.translation + above_W - X_WD_.translation, 0.5);
    Go(-above_W, 0.3);
    Wait(0.1);
  }
  void TakeAndLift(double opening_m) {
    Reach();
    Close(opening_m, 0.05);
    Wait(0.3);
    Go({0.0, 0.0, 0.1}, 0.1);
    Wait(0.5);
  }

  // Of the thumb on the block, along the line from thumb to fingers.
  [[nodiscard]] double Press_N() const {
    double sum_N = 0.0;
    int slot = 0;
    for (const scene::Pair& pair : scenario_.pairs) {
      const scene::Object& sampled = scenario_.objects[pair.sampled];
      const bool is_contact =
          sampled.owner == scene::Owner::kPhysics || scenario_.objects[pair.field].owner == scene::Owner::kPhysics;
      if (is_contact && pair.field == block_ && sampled.finger_link && sampled.finger_link->finger == 0) {
        sum_N -= node_->world().contact(slot).F_So_W.force_N.x;  // the palm has the axes of W
      }
      slot += is_contact ? 1 : 0;
    }
    return sum_N;
  }
  [[nodiscard]] core::Pose X_WBlock() const {
    for (const core::BodyState& body : outputs_.state.bodies) {
      if (body.object == block_) return body.X_WO;
    }
    return {};
  }
  [[nodiscard]] core::Pose X_DBlock() const { return X_WD_.inverse() * X_WBlock(); }
  [[nodiscard]] bool is_held() const { return is_held_; }
  [[nodiscard]] const scene::Scenario& scenario() const { return scenario_; }
  [[nodiscard]] const Outputs& outputs() const { return outputs_; }
  [[nodiscard]] const Inputs& inputs() const { return inputs_; }
  PhysicsNode& node() { return *node_; }

 private:
  scene::Scenario scenario_;
  std::unique_ptr<PhysicsNode> node_;
  int block_ = -1;
  Inputs inputs_;
  Outputs outputs_;
  core::Pose X_WGrip_;
  core::Pose X_WD_;
  core::Twist V_WD_;
  double opening_m_ = 0.08;
  std::uint64_t cycle_ = 0;
  bool is_held_ = false;
};

class Fingers : public testing::TestWithParam<const char*> {};

TEST_P(Fingers, HoldABlockForTenSecondsByFriction) {
  Hand hand(GetParam());
  hand.TakeAndLift(0.044);
  ASSERT_TRUE(hand.is_held());
  EXPECT_GT(hand.X_WBlock().translation.z, 0.12);
  const core::Pose X_before = hand.X_DBlock();
  hand.Wait(10.0);
  EXPECT_TRUE(hand.is_held());
  EXPECT_LT(glm::distance(hand.X_DBlock().translation, X_before.translation), 1e-4);
  EXPECT_LT(glm::length(core::RotationVector(hand.X_DBlock().rotation * glm::conjugate(X_before.rotation))), 2e-3);
  // What it weighs is felt: the reaction on the hand is the block's and the fingers' weight.
  double fingers_kg = 0.0;
  for (const scene::Object& object : hand.scenario().objects) fingers_kg += object.finger_link ? object.mass_kg : 0.0;
  EXPECT_NEAR(hand.outputs().reactions[0].F_Do_W.force_N.z, -(kWeight_N + 9.81 * fingers_kg), 0.02);
}

// Coulomb: thumb and fingers press with N each and hold 2 mu N, the weight m g. So it slips where N = m g / (2 mu).
TEST_P(Fingers, LetGoWhereFrictionNoLongerHolds) {
  Hand hand(GetParam(), 0.02);
  const double limit_N = kWeight_N / (2.0 * 0.8);
  hand.TakeAndLift(0.044);
  ASSERT_GT(hand.Press_N(), limit_N);
  const double height_m = hand.X_DBlock().translation.z;
  double opening_m = 0.044;
  std::vector<double> presses_N;
  while (hand.X_DBlock().translation.z > height_m - 5e-4 && opening_m < kBlock_m) {
    presses_N.push_back(hand.Press_N());
    opening_m += 1e-6;
    hand.Close(opening_m, 1e-3);
  }
  // The mean while it slips.
  constexpr std::size_t kSlip_ms = 50;
  ASSERT_GT(presses_N.size(), kSlip_ms);
  const double press_N = std::accumulate(presses_N.end() - kSlip_ms, presses_N.end(), 0.0) / kSlip_ms;
  // Which contact lets go first is chance: of ten grips, closed a little more or less, the mean is 0.987, with a
  // standard deviation of 0.011.
  EXPECT_NEAR(press_N / limit_N, 1.0, 0.05);
}

TEST_P(Fingers, DropTheBlockAtHalfTheGrip) {
  Hand hand(GetParam());
  hand.TakeAndLift(0.046);
  ASSERT_TRUE(hand.is_held());
  const double press_N = hand.Press_N();
  EXPECT_LT(0.5 * press_N, kWeight_N / (2.0 * 0.8));  // so half of it cannot hold the block
  double opening_m = 0.046;
  double before_drop_N = press_N;
  while (hand.is_held() && hand.Press_N() > 0.5 * press_N && opening_m < kBlock_m) {
    opening_m += 1e-5;
    before_drop_N = hand.Press_N();
    hand.Close(opening_m, 1e-2);
  }
  EXPECT_GT(before_drop_N, 0.4 * press_N);  // dropped, not let go
  hand.Wait(1.0);
  EXPECT_LT(hand.X_WBlock().translation.z, 0.04);
}

// Servos with a largest torque: however far a person closes the hand, no joint presses harder.
TEST_P(Fingers, PressNoHarderThanTheirServos) {
  Hand hand(GetParam());
  hand.Reach();
  hand.Close(0.0, 0.1);
  hand.Wait(0.5);
  bool is_any_at_its_limit = false;
  for (const core::MechanismState& state : hand.outputs().state.mechanisms) {
    const scene::Mechanism& m = hand.scenario().mechanisms[state.mechanism];
    const bool is_at_stop = state.position < m.lower + 1e-3 || state.position > m.upper - 1e-3;
    if (!is_at_stop) {
      EXPECT_LE(std::abs(state.force), m.motor_limit + 1e-6) << m.name;
    }
    is_any_at_its_limit = is_any_at_its_limit || std::abs(state.force) > 0.99 * m.motor_limit;
  }
  EXPECT_TRUE(is_any_at_its_limit);
}

TEST_P(Fingers, GoOnBitForBitFromACheckpointInAGrasp) {
  Hand hand(GetParam());
  hand.TakeAndLift(0.044);
  Snapshot snapshot;
  hand.node().Save(&snapshot);
  const auto other = hand.Make();
  ASSERT_TRUE(other->Restore(&snapshot));
  Outputs outputs;
  for (int i = 0; i < 200; ++i) {
    hand.Tick();
    other->Step(hand.inputs(), &outputs);
    ASSERT_EQ(outputs.state.state_hash, hand.outputs().state.state_hash) << i;
    ASSERT_EQ(outputs.reactions[0].grasped_object, hand.outputs().reactions[0].grasped_object);
  }
}

INSTANTIATE_TEST_SUITE_P(Sides, Fingers, testing::Values("scenario.xml", "left.xml"));

}  // namespace
}  // namespace physics_node
