#include "nodes/visual_node/latency_log.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <sstream>

namespace visual_node {
namespace {

core::Trace TraceOf(std::uint64_t sequence, std::int32_t applied_ns) {
  core::Trace trace;
  trace.id = core::MakeTraceId(0, sequence);
  trace.origin_ns = 1'000'000;
  trace.Add(core::Stage::kDeviceSample, 1'000'000);
  trace.Add(core::Stage::kVisualApply, 1'000'000 + applied_ns);
  return trace;
}

TEST(LatencyLog, ASampleInSeveralStatesCountsOnce) {
  LatencyLog log;
  log.AddState({}, TraceOf(1, 2'000'000));
  log.AddState({}, TraceOf(1, 3'000'000));
  log.AddState({}, TraceOf(2, 4'000'000));
  log.AddState({}, {});
  EXPECT_EQ(log.state().count(), 2u);
  EXPECT_DOUBLE_EQ(log.state().mean_ns(), 3e6);
  EXPECT_EQ(log.state_direct().count(), 0u);
}

TEST(LatencyLog, OnlyTheFirstFrameThatShowsASampleCounts) {
  LatencyLog log;
  log.AddFrame(TraceOf(1, 30'000'000));
  log.AddFrame(TraceOf(1, 60'000'000));
  EXPECT_EQ(log.image().count(), 1u);
  EXPECT_EQ(log.image().max_ns(), 30'000'000);
  EXPECT_DOUBLE_EQ(log.recent_image_ms(), 30.0);
}

TEST(LatencyLog, RowsContainEveryHop) {
  const std::filesystem::path file = std::filesystem::path(VR_OOS_BINARY_DIR) / "latency_log_test.csv";
  {
    LatencyLog log;
    ASSERT_TRUE(log.Open(file));
    log.AddState(TraceOf(3, 1'500'000), TraceOf(2, 2'500'000));
    log.Drain();
  }
  std::ifstream in(file);
  std::stringstream text;
  text << in.rdbuf();
  const std::string id2 = std::to_string(core::MakeTraceId(0, 2));
  const std::string id3 = std::to_string(core::MakeTraceId(0, 3));
  EXPECT_EQ(text.str(),
            "chain,trace_id,origin_ns,echo_ns,stages\n"
            "t2_state_direct," +
                id3 +
                ",1000000,-1,1,0,12,1500000\n"
                "t2_state," +
                id2 + ",1000000,-1,1,0,12,2500000\n");
  std::filesystem::remove(file);
}

}  // namespace
}  // namespace visual_node
