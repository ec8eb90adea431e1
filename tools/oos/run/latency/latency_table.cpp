#include "tools/oos/run/latency/latency_table.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <map>
#include <numeric>
#include <sstream>

namespace oos {
namespace {

constexpr const char* kHeader = "chain,trace_id,origin_ns,echo_ns,stage,offset_ns,...";

double Percentile(const std::vector<double>& sorted, double q) {
  const auto rank = static_cast<std::size_t>(std::ceil(q * static_cast<double>(sorted.size())));
  return sorted[std::min(std::max<std::size_t>(rank, 1), sorted.size()) - 1];
}

// visual_node's rows name their stages ("frame_done:123") and have no echo; the bridge's give number and offset.
bool AddNamedStamp(const std::string& cell, core::Trace* trace) {
  const std::size_t colon = cell.find(':');
  for (int stage = 1; stage <= static_cast<int>(core::Stage::kFrameDone); ++stage) {
    if (cell.compare(0, colon, StageName(static_cast<core::Stage>(stage))) != 0) continue;
    trace->stamps.push_back({static_cast<core::Stage>(stage),
                             static_cast<std::int32_t>(std::strtol(cell.c_str() + colon + 1, nullptr, 10))});
    return true;
  }
  return false;
}

bool AddNumberedStamp(const std::string& stage_cell, const std::string& offset_cell, core::Trace* trace) {
  const long stage = std::strtol(stage_cell.c_str(), nullptr, 10);
  if (stage < 1 || stage > static_cast<long>(core::Stage::kFrameDone)) return false;
  trace->stamps.push_back(
      {static_cast<core::Stage>(stage), static_cast<std::int32_t>(std::strtol(offset_cell.c_str(), nullptr, 10))});
  return true;
}

bool ParseRow(const std::string& line, LatencyRow* row) {
  std::istringstream in(line);
  std::string cell;
  std::vector<std::string> cells;
  while (std::getline(in, cell, ',')) cells.push_back(cell);
  if (cells.size() < 4) return false;
  row->chain = cells[0];
  row->trace.id = std::strtoull(cells[1].c_str(), nullptr, 10);
  row->trace.origin_ns = std::strtoll(cells[2].c_str(), nullptr, 10);
  if (cells[3].find(':') != std::string::npos) {
    for (std::size_t i = 3; i < cells.size(); ++i) {
      if (cells[i].find(':') == std::string::npos || !AddNamedStamp(cells[i], &row->trace)) return false;
    }
    return true;
  }
  if (cells.size() % 2 != 0) return false;
  row->echo_ns = std::strtoll(cells[3].c_str(), nullptr, 10);
  for (std::size_t i = 4; i + 1 < cells.size(); i += 2) {
    if (!AddNumberedStamp(cells[i], cells[i + 1], &row->trace)) return false;
  }
  return !row->trace.stamps.empty();
}

void WriteRow(const LatencyRow& row, std::ostream& out) {
  out << row.chain << ',' << row.trace.id << ',' << row.trace.origin_ns << ',' << row.echo_ns;
  for (const core::Stamp& stamp : row.trace.stamps)
    out << ',' << static_cast<int>(stamp.stage) << ',' << stamp.offset_ns;
  out << '\n';
}

// Chain and stages in order: only traces with the same stages are averaged together.
std::string RouteOf(const LatencyRow& row) {
  std::string route = row.chain;
  for (const core::Stamp& stamp : row.trace.stamps) route += "," + std::to_string(static_cast<int>(stamp.stage));
  return route;
}

}  // namespace

Distribution Describe(std::vector<double> values_ms) {
  Distribution d;
  d.n = values_ms.size();
  if (values_ms.empty()) return d;
  std::sort(values_ms.begin(), values_ms.end());
  d.mean_ms = std::accumulate(values_ms.begin(), values_ms.end(), 0.0) / static_cast<double>(d.n);
  d.p50_ms = Percentile(values_ms, 0.5);
  d.p90_ms = Percentile(values_ms, 0.9);
  d.p99_ms = Percentile(values_ms, 0.99);
  d.p999_ms = Percentile(values_ms, 0.999);
  d.max_ms = values_ms.back();
  return d;
}

double ChainTable::disagreement() const {
  return echo.n == 0 || echo.mean_ms <= 0.0 ? 0.0 : std::abs(total.mean_ms - echo.mean_ms) / echo.mean_ms;
}

const char* StageName(core::Stage stage) {
  switch (stage) {
    case core::Stage::kDeviceSample:
      return "device_sample";
    case core::Stage::kDeviceSend:
      return "device_send";
    case core::Stage::kHapticReceive:
      return "haptic_receive";
    case core::Stage::kHapticStart:
      return "haptic_start";
    case core::Stage::kHapticSend:
      return "haptic_send";
    case core::Stage::kPhysicsReceive:
      return "physics_receive";
    case core::Stage::kPhysicsStart:
      return "physics_start";
    case core::Stage::kPhysicsSend:
      return "physics_send";
    case core::Stage::kDeviceReceive:
      return "device_receive";
    case core::Stage::kDeviceWrite:
      return "device_write";
    case core::Stage::kVisualReceive:
      return "visual_receive";
    case core::Stage::kVisualApply:
      return "visual_apply";
    case core::Stage::kFrameStart:
      return "frame_start";
    case core::Stage::kFrameDone:
      return "frame_done";
  }
  return "?";
}

core::Result<void> MergeLatencyTables(const std::filesystem::path& folder) {
  std::ofstream out(folder / "latency.csv");
  out << kHeader << "\n";
  for (const char* name : {"device_bridge_latency.csv", "visual_node_latency.csv", "latency_visual.csv"}) {
    if (!std::filesystem::exists(folder / name)) continue;
    const auto rows = ReadLatencyRows(folder / name);
    if (!rows) return core::Fail(rows.error().code, rows.error().detail);
    for (const LatencyRow& row : *rows) WriteRow(row, out);
  }
  if (!out) return core::Fail(core::ErrorCode::kIo, "cannot write " + (folder / "latency.csv").string());
  return {};
}

core::Result<std::vector<LatencyRow>> ReadLatencyRows(const std::filesystem::path& file) {
  std::ifstream in(file);
  if (!in)
    return core::Fail(core::ErrorCode::kNotFound, "no " + file.string() + ": name the folder of a run of processes");
  std::vector<LatencyRow> rows;
  std::string line;
  for (int number = 1; std::getline(in, line); ++number) {
    if (number == 1 || line.empty()) continue;
    LatencyRow row;
    if (!ParseRow(line, &row)) {
      return core::Fail(core::ErrorCode::kDamaged,
                        file.string() + ":" + std::to_string(number) + ": not a row of '" + kHeader + "'");
    }
    rows.push_back(row);
  }
  return rows;
}

std::vector<ChainTable> Tabulate(const std::vector<LatencyRow>& rows) {
  std::map<std::string, std::vector<const LatencyRow*>> routes;
  for (const LatencyRow& row : rows) routes[RouteOf(row)].push_back(&row);
  std::vector<ChainTable> tables;
  for (const auto& [route, members] : routes) {
    ChainTable table;
    table.chain = members.front()->chain;
    table.route = members.front()->trace;
    std::vector<double> total, echo;
    const std::size_t num_stamps = members.front()->trace.stamps.size();
    std::vector<std::vector<double>> hops(num_stamps - 1);
    for (const LatencyRow* row : members) {
      const auto& stamps = row->trace.stamps;
      total.push_back(1e-6 * stamps.back().offset_ns);
      if (row->echo_ns >= 0) echo.push_back(1e-6 * static_cast<double>(row->echo_ns));
      for (std::size_t i = 0; i + 1 < num_stamps; ++i) {
        hops[i].push_back(1e-6 * (stamps[i + 1].offset_ns - stamps[i].offset_ns));
      }
    }
    table.total = Describe(total);
    table.echo = Describe(echo);
    for (std::size_t i = 0; i + 1 < num_stamps; ++i) {
      const auto& stamps = members.front()->trace.stamps;
      const core::Stage from = stamps[i].stage, to = stamps[i + 1].stage;
      table.hops.push_back({std::string(StageName(from)) + " -> " + StageName(to), from, to, Describe(hops[i])});
    }
    tables.push_back(table);
  }
  // The most frequent route comes first.
  std::stable_sort(tables.begin(), tables.end(),
                   [](const ChainTable& a, const ChainTable& b) { return a.total.n > b.total.n; });
  return tables;
}

}  // namespace oos
