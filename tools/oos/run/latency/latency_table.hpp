#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/messages/trace.hpp"
#include "core/result.hpp"

namespace oos {

// One complete stamped trace, as a row of latency.csv: chain,trace_id,origin_ns,echo_ns, then pairs of stage number and
// offset [ns since the origin] in the order of the stamps.
struct LatencyRow {
  std::string chain;  // "direct", "t1", "t2"
  core::Trace trace;
  std::int64_t echo_ns = -1;  // the same time measured by device_bridge's log, without stamps; -1: not measured
};

struct Distribution {
  std::size_t n = 0;
  double mean_ms = 0.0, p50_ms = 0.0, p90_ms = 0.0, p99_ms = 0.0, p999_ms = 0.0, max_ms = 0.0;
};
Distribution Describe(std::vector<double> values_ms);

struct Hop {
  std::string name;  // "device sample -> device send"
  core::Stage from{}, to{};
  Distribution ms;
};

// All rows of one chain that passed the same stages: hops between neighbouring stamps, which add up to the total.
struct ChainTable {
  std::string chain;
  core::Trace route;  // one of them
  Distribution total;
  std::vector<Hop> hops;
  Distribution echo;  // n = 0: no independent measurement
  // |mean of stamps - mean of echo| / mean of echo over the same traces; 0 without an echo.
  [[nodiscard]] double disagreement() const;
};

const char* StageName(core::Stage stage);

// Merges the latency files that nodes left in a run's folder to latency.csv.
core::Result<void> MergeLatencyTables(const std::filesystem::path& folder);
core::Result<std::vector<LatencyRow>> ReadLatencyRows(const std::filesystem::path& file);
std::vector<ChainTable> Tabulate(const std::vector<LatencyRow>& rows);

}  // namespace oos
