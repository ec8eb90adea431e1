#include "tools/oos/run/latency/latency_table.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <numeric>

#include "tools/oos/run/latency/hop_bounds.hpp"

namespace oos {
namespace {

LatencyRow Row(const std::string& chain, std::int32_t receive_ns, std::int32_t write_ns, std::int64_t echo_ns) {
  LatencyRow row;
  row.chain = chain;
  row.trace.id = 1;
  row.trace.stamps.push_back({core::Stage::kDeviceSample, 0});
  row.trace.stamps.push_back({core::Stage::kDeviceReceive, receive_ns});
  row.trace.stamps.push_back({core::Stage::kDeviceWrite, write_ns});
  row.echo_ns = echo_ns;
  return row;
}

TEST(LatencyTable, HopsAddUpToTheTotal) {
  std::vector<LatencyRow> rows;
  for (int i = 1; i <= 1000; ++i) rows.push_back(Row("t1", 1000 * i, 1500 * i, 1500 * i));
  const auto tables = Tabulate(rows);
  ASSERT_EQ(tables.size(), 1u);
  double sum_ms = 0.0;
  for (const Hop& hop : tables[0].hops) sum_ms += hop.ms.mean_ms;
  EXPECT_NEAR(sum_ms, tables[0].total.mean_ms, 1e-12);
  EXPECT_DOUBLE_EQ(tables[0].total.p50_ms, 0.75);
  EXPECT_DOUBLE_EQ(tables[0].total.p99_ms, 1.485);
  EXPECT_DOUBLE_EQ(tables[0].total.p999_ms, 1.4985);
  EXPECT_DOUBLE_EQ(tables[0].total.max_ms, 1.5);
  EXPECT_DOUBLE_EQ(tables[0].disagreement(), 0.0);
}

TEST(LatencyTable, TheEchoRevealsWrongStamps) {
  EXPECT_NEAR(Tabulate({Row("t1", 1'000'000, 1'100'000, 1'000'000)})[0].disagreement(), 0.1, 1e-12);
}

TEST(LatencyTable, DifferentRoutesAreNotMixed) {
  LatencyRow other = Row("t1", 1, 2, 2);
  other.trace.stamps.push_back({core::Stage::kVisualApply, 9});
  EXPECT_EQ(Tabulate({Row("t1", 1, 2, 2), Row("direct", 1, 2, 2), other}).size(), 3u);
}

// Physics elsewhere: haptic_node and device_bridge on one machine, physics_node and visual_node on two others.
TEST(HopBounds, AddUpOverHopsBetweenMachinesAndAreMissingWithoutAClockComparison) {
  const std::filesystem::path folder = std::filesystem::path(::testing::TempDir()) / "hop_bounds";
  std::filesystem::create_directories(folder);
  std::ofstream(folder / "clocks.csv") << "time_ns,host,offset_ns,bound_ns\n";
  std::ofstream(folder / "haptic_node.json") << R"({"clock_bounds_ns": {"device_bridge": 0, "physics_node": 300}})";
  std::ofstream(folder / "physics_node.json") << R"({"clock_bounds_ns": {"haptic_node": 50}})";
  const HopBounds bounds = HopBounds::Read(folder);
  core::Trace trace{1, 0, {}};
  for (const core::Stage stage : {core::Stage::kDeviceSend, core::Stage::kHapticReceive, core::Stage::kHapticSend,
                                  core::Stage::kPhysicsReceive, core::Stage::kPhysicsSend, core::Stage::kHapticReceive})
    trace.stamps.push_back({stage, 0});
  EXPECT_EQ(bounds.Along(trace), 350);
  trace.stamps.push_back({core::Stage::kVisualReceive, 0});
  EXPECT_EQ(bounds.Along(trace), std::nullopt);
  std::filesystem::remove(folder / "clocks.csv");
  EXPECT_EQ(HopBounds::Read(folder).Along(trace), 0);
}

TEST(LatencyTable, DamagedRowsAreNamed) {
  const std::filesystem::path file = std::filesystem::path(::testing::TempDir()) / "damaged_latency.csv";
  std::ofstream(file) << "chain,trace_id,origin_ns,echo_ns,stages\nt1,1,0,5,1,0,10,5\nt1,1,0,5,99,0\n";
  const auto rows = ReadLatencyRows(file);
  ASSERT_FALSE(rows);
  EXPECT_NE(rows.error().detail.find(":3:"), std::string::npos);
}

}  // namespace
}  // namespace oos
