#include "replay/step_recorder.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#if !defined(__SANITIZE_THREAD__) && !defined(__SANITIZE_ADDRESS__)
#include "bus/testing/step_guard.hpp"
#define VR_OOS_HAS_GUARD
#endif

#include "bus/log/mcap_reader.hpp"
#include "bus/log/step_log.hpp"
#include "core/clock.hpp"

namespace replay {
namespace {

struct LoggedStep {
  std::vector<core::Event> events;
  core::PhysicsState state;
};
template <class V>
void VisitInputs(V& v, LoggedStep& step) {
  Items(v, "events", step.events);
}
template <class V>
void VisitOutputs(V& v, LoggedStep& step) {
  Field(v, "state", step.state);
}

void Fill(std::uint64_t tick, LoggedStep* step) {
  step->state.tick = tick;
  step->state.bodies.resize(core::kMaxBodies);
  for (core::BodyState& body : step->state.bodies) body.X_WO.translation.x = 1.0 / static_cast<double>(tick);
}

class StepLogTest : public ::testing::Test {
 protected:
  StepLogTest() { std::filesystem::remove(path_); }
  ~StepLogTest() override { std::filesystem::remove(path_); }
  std::unique_ptr<bus::log::StepLog> Open() {
    auto file = std::move(*bus::log::StepFile::Create(path_));
    const std::uint16_t channel = file->AddNode("physics_node", "fields", {{"seed", "3"}});
    EXPECT_TRUE(file->Attach("physics_node.checkpoint", {1, 2, 3}));
    return std::make_unique<bus::log::StepLog>(std::move(file), "physics_node", channel);
  }
  std::filesystem::path path_ =
      std::filesystem::path(::testing::TempDir()) / ("steps" + std::to_string(::getpid()) + ".mcap");
};

TEST_F(StepLogTest, EveryStepIsInTheFileWithoutAnAllocationOrLockOfTheStepThread) {
  auto log = Open();
  StepRecorder<LoggedStep> recorder(log.get());
  LoggedStep step;
  step.events = {{7, "physics_node", "a name that is too long to be kept in place", "and a detail that is, too"}};
  constexpr std::uint64_t kSteps = 500;
  std::uint64_t allocations = 0, locks = 0;
  for (std::uint64_t tick = 1; tick <= kSteps; ++tick) {
    Fill(tick, &step);
#ifdef VR_OOS_HAS_GUARD
    bus::step_guard::Arm();
#endif
    recorder.Record(tick, static_cast<std::int64_t>(tick) * core::kTick_ns, step);
#ifdef VR_OOS_HAS_GUARD
    const bus::step_guard::Counts counts = bus::step_guard::Disarm();
    allocations += counts.allocations;
    locks += counts.locks;
#endif
  }
  EXPECT_EQ(allocations, 0U);
  EXPECT_EQ(locks, 0U);
  EXPECT_EQ(log->num_lost(), 0U);
  ASSERT_TRUE(log->Close());

  StepDecoder decoder;
  std::uint64_t tick = 0;
  const auto contents = bus::log::ReadMcap(path_, [&](const bus::log::Channel& channel, const bus::log::Message& m) {
    EXPECT_EQ(channel.topic, "replay/physics_node/step");
    ++tick;
    LoggedStep got, expected;
    Fill(tick, &expected);
    ASSERT_TRUE(decoder.Begin(m.data)) << tick;
    VisitInputs(decoder, got);
    decoder.includes_transport = false;
    VisitOutputs(decoder, got);
    decoder.includes_transport = true;
    ASSERT_TRUE(decoder.Finish()) << tick;
    EXPECT_EQ(decoder.tick(), tick);
    EXPECT_EQ(got.events.at(0).name, step.events[0].name);
    Digest left, right;
    left.includes_transport = right.includes_transport = false;
    VisitOutputs(left, got);
    VisitOutputs(right, expected);
    EXPECT_EQ(left.value(), right.value());
    EXPECT_EQ(decoder.digest(), right.value());
  });
  ASSERT_TRUE(contents) << contents.error().detail;
  EXPECT_EQ(tick, kSteps);
  EXPECT_EQ(contents->attachments.at(0).data, (bus::log::Bytes{1, 2, 3}));
  EXPECT_EQ(contents->metadata.at(0).entries.at("seed"), "3");
}

// A sink that takes every third step only.
class LossySink final : public bus::log::StepSink {
 public:
  bool Push(std::uint64_t tick, std::int64_t, std::span<const std::uint8_t> step) noexcept override {
    if (tick % 3 != 0) return false;
    steps.emplace_back(step.begin(), step.end());
    return true;
  }
  std::vector<std::vector<std::uint8_t>> steps;
};

TEST(StepRecorder, StepsAfterALossAreReadable) {
  LossySink sink;
  StepRecorder<LoggedStep> recorder(&sink);
  LoggedStep step;
  for (std::uint64_t tick = 1; tick <= 12; ++tick) {
    Fill(tick, &step);
    recorder.Record(tick, 0, step);
  }
  StepDecoder decoder;
  ASSERT_EQ(sink.steps.size(), 4U);
  for (std::size_t i = 0; i < sink.steps.size(); ++i) {
    LoggedStep got;
    ASSERT_TRUE(decoder.Begin(sink.steps[i]));
    VisitInputs(decoder, got);
    decoder.includes_transport = false;
    VisitOutputs(decoder, got);
    ASSERT_TRUE(decoder.Finish());
    EXPECT_EQ(got.state.tick, 3 * (i + 1));
    EXPECT_EQ(got.state.bodies[5].X_WO.translation.x, 1.0 / static_cast<double>(3 * (i + 1)));
  }
}

}  // namespace
}  // namespace replay
