// haptic_node and physics_node in one process: the same as two, and the same as lock-step.

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>

#include "bus/log/mcap_reader.hpp"
#include "bus/log/step_log.hpp"
#include "core/parallel_for.hpp"
#include "nodes/haptic_node/haptic_node.hpp"
#include "nodes/haptic_node/step.hpp"
#include "nodes/haptic_physics_node/hand_over.hpp"
#include "nodes/lockstep/replay_steps.hpp"
#include "nodes/physics_node/physics_node.hpp"
#include "nodes/physics_node/step.hpp"
#include "replay/platform.hpp"
#include "replay/step_codec.hpp"
#include "tests/support.hpp"
#include "tools/oos/run/session/session.hpp"

namespace system_tests {
namespace {

const std::filesystem::path kOut = std::filesystem::path(VR_OOS_BINARY_DIR) / "colocate";

// One live run for all tests.
class Colocate : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    std::filesystem::remove_all(kOut);
    std::filesystem::create_directories(kOut / "steps");
    scenario_ = Load("touch");
    oos::SessionOptions options;
    options.out = kOut;
    options.steps = kOut / "steps";
    options.is_colocated = true;
    options.without = {"visual_node"};
    options.program_folder = std::filesystem::path(VR_OOS_BINARY_DIR) / "bin";
    const auto outcome = oos::RunSession(scenario_, options);
    ASSERT_TRUE(outcome) << outcome.error().detail;
    outcome_ = *outcome;
  }
  static scene::Scenario scenario_;
  static oos::SessionOutcome outcome_;
};
scene::Scenario Colocate::scenario_;
oos::SessionOutcome Colocate::outcome_;

// A recorded step, not decoded yet: each is encoded against the one before of its kind.
struct RawStep {
  std::int64_t now_ns = 0;
  bool is_of_physics = false;
  std::vector<std::uint8_t> bytes;
};

std::vector<RawStep> ReadSteps(const std::string& node) {
  std::vector<RawStep> steps;
  const auto read = bus::log::ReadMcap(
      kOut / "steps" / (node + ".mcap"), [&](const bus::log::Channel& channel, const bus::log::Message& message) {
        if (channel.topic != bus::log::StepTopic(node)) return;
        steps.push_back({0, node == "physics_node", {message.data.begin(), message.data.end()}});
      });
  EXPECT_TRUE(read) << read.error().detail;
  return steps;
}

template <class Step>
bool Decode(const RawStep& raw, replay::StepDecoder* decoder, Step* step) {
  if (!decoder->Begin(raw.bytes)) return false;
  decoder->includes_transport = true;
  VisitInputs(*decoder, *step);
  decoder->includes_transport = false;
  VisitOutputs(*decoder, *step);
  return decoder->Finish();
}

template <class Step>
std::uint64_t DigestOf(Step& step) {
  replay::Digest digest;
  digest.includes_transport = false;
  VisitOutputs(digest, step);
  return digest.value();
}

TEST_F(Colocate, ARunCompletesTouchAndBothNodesReport) {
  EXPECT_TRUE(outcome_.is_final) << outcome_.why;
  EXPECT_TRUE(outcome_.dead.empty());
  EXPECT_TRUE(outcome_.killed.empty());
  for (const char* file : {"haptic_node.json", "physics_node.json", "haptic_physics_node.log"}) {
    EXPECT_TRUE(std::filesystem::exists(kOut / file)) << file;
  }
}

TEST_F(Colocate, TheRecordedStepsOfBothNodesReplayBitForBit) {
  for (const std::string node : {"physics_node", "haptic_node"}) {
    const std::filesystem::path file = kOut / "steps" / (node + ".mcap");
    const auto recorded = lockstep::ReadRecordedNodes(file);
    ASSERT_TRUE(recorded) << recorded.error().detail;
    const auto outcome = lockstep::ReplaySteps(file, recorded->front(), scenario_, {});
    if (!outcome && outcome.error().detail.find("time ran short") != std::string::npos) {
      std::printf("%s: %s\n", node.c_str(), outcome.error().detail.c_str());  // a busy machine: reported, no failure
      continue;
    }
    ASSERT_TRUE(outcome) << outcome.error().detail;
    EXPECT_GT(outcome->num_steps, 1000U);
    EXPECT_EQ(outcome->num_inexact, 0U) << lockstep::Describe(recorded->front(), *outcome);
  }
}

// The two nodes again as lock-step joins them. Of the recording, the steps get only what came from other processes:
// device samples, times and parameters. What one of the two gets of the other comes from the other's step.
class AsLockstep {
 public:
  explicit AsLockstep(const scene::Scenario& scenario) {
    haptic_ = std::move(*haptic_node::HapticNode::Create(scenario, workers_, {}));
    physics_ = std::move(*physics_node::PhysicsNode::Create(scenario));
    for (haptic_node::Step* step : {&haptic_step_, &got_haptic_}) haptic_->PrepareOutputs(&step->outputs);
    hand_over_.cycle.contacts.resize(scenario.pairs.size());
  }

  // Whether the step's outputs are the recorded ones.
  bool Repeat(const RawStep& raw) {
    if (raw.is_of_physics) return RepeatPhysics(raw);
    const std::uint8_t kind = replay::StepKind(raw.bytes);
    replay::StepDecoder& decoder = haptic_decoders_[kind];
    EXPECT_TRUE(Decode(raw, &decoder, &haptic_step_));
    haptic_node::Inputs& inputs = haptic_step_.inputs;
    inputs.physics = hand_over_.answer.state.header.sequence != 0 ? &hand_over_.answer.state : nullptr;
    inputs.reactions = hand_over_.answer.reactions;
    if (kind == haptic_node::kReevaluation) {
      haptic_->Reevaluate(inputs, &got_haptic_.outputs);
      ++num_reevaluations;
    } else {
      haptic_->Step(inputs, &got_haptic_.outputs);
      hand_over_.TakeContacts(haptic_->cycle(), inputs.now_ns, &got_haptic_.outputs);
      hand_over_.TakeProxies(haptic_->cycle(), inputs.now_ns, &got_haptic_.outputs);
    }
    return DigestOf(got_haptic_) == decoder.digest();
  }

  // Whether the last cycle ran short of time, as on a busy machine: what follows cannot be repeated.
  [[nodiscard]] bool was_late() const { return haptic_step_.pairs_late > 0; }
  std::size_t num_reevaluations = 0;

 private:
  bool RepeatPhysics(const RawStep& raw) {
    EXPECT_TRUE(Decode(raw, &physics_decoder_, &physics_step_));
    physics_node::Inputs& inputs = physics_step_.inputs;
    inputs.proxies = hand_over_.cycle.proxies;
    inputs.contacts = hand_over_.cycle.contacts.data();
    inputs.num_contacts = hand_over_.cycle.contacts.size();
    physics_->Step(inputs, &got_physics_.outputs);
    hand_over_.TakeAnswer(physics_->tick(), inputs.now_ns, &got_physics_.outputs);
    return DigestOf(got_physics_) == physics_decoder_.digest();
  }

  core::SerialFor workers_;
  std::unique_ptr<haptic_node::HapticNode> haptic_;
  std::unique_ptr<physics_node::PhysicsNode> physics_;
  haptic_physics_node::HandOver hand_over_;
  std::array<replay::StepDecoder, 2> haptic_decoders_;
  replay::StepDecoder physics_decoder_;
  haptic_node::Step haptic_step_, got_haptic_;
  physics_node::Step physics_step_, got_physics_;
};

// All steps in the order in which the one thread made them.
std::vector<RawStep> ReadStepsInOrder() {
  std::vector<RawStep> steps;
  std::array<replay::StepDecoder, 2> decoders;
  haptic_node::Step haptic;
  for (RawStep& raw : ReadSteps("haptic_node")) {
    EXPECT_TRUE(Decode(raw, &decoders[replay::StepKind(raw.bytes)], &haptic));
    raw.now_ns = haptic.inputs.now_ns;
    steps.push_back(std::move(raw));
  }
  replay::StepDecoder decoder;
  physics_node::Step physics;
  for (RawStep& raw : ReadSteps("physics_node")) {
    EXPECT_TRUE(Decode(raw, &decoder, &physics));
    raw.now_ns = physics.inputs.now_ns;
    steps.push_back(std::move(raw));
  }
  std::stable_sort(steps.begin(), steps.end(), [](const RawStep& a, const RawStep& b) { return a.now_ns < b.now_ns; });
  return steps;
}

TEST_F(Colocate, ThePairHasTheBitsOfLockstepForTheSameInputs) {
  const std::vector<RawStep> steps = ReadStepsInOrder();
  ASSERT_GT(steps.size(), 2000U);
  replay::SetDenormals("flushed");
  AsLockstep pair(scenario_);
  std::size_t num_different = 0;
  for (const RawStep& step : steps) {
    const bool is_same = pair.Repeat(step);
    if (pair.was_late()) {
      std::printf("compared up to a cycle in which time ran short\n");  // reported, no failure
      break;
    }
    num_different += is_same ? 0 : 1;
  }
  EXPECT_EQ(num_different, 0U) << "of " << steps.size();
  if (!pair.was_late()) {
    EXPECT_GT(pair.num_reevaluations, 100U);
  }
}

}  // namespace
}  // namespace system_tests
