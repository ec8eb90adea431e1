#include "tools/failures/row.hpp"

#include <algorithm>
#include <cstdio>
#include <map>

#include "tools/failures/peer_loop.hpp"
#include "tools/failures/variant.hpp"

namespace failures {
namespace {

constexpr const char* kTable = "rows";
constexpr int kNumFailures = 23;
constexpr int kWantedWithin = 21;

std::vector<std::string> Columns() {
  std::vector<std::string> columns{"id", "failure", "set-up", "observable", "bound"};
  for (const Variant& variant : Variants()) columns.push_back(variant.name);
  columns.insert(columns.end(), PeerNames().begin(), PeerNames().end());
  columns.insert(columns.end(), {"met", "why not"});
  return columns;
}

Table* FindTable(Report* report) {
  for (Table& table : report->tables) {
    if (table.name == kTable) return &table;
  }
  report->tables.push_back({kTable, Columns(), {}});
  return &report->tables.back();
}

std::string CellOf(const Row& row, const std::string& contender) {
  for (const Reading& reading : row.readings) {
    if (reading.contender == contender) return reading.measured + (reading.is_met ? "" : " (missed)");
  }
  return "";
}

const Reading* Deciding(const Row& row) {
  const auto found = std::find_if(row.readings.begin(), row.readings.end(),
                                  [](const Reading& r) { return r.contender == Variants().back().name; });
  return found == row.readings.end() ? nullptr : &*found;
}

}  // namespace

void AddRow(Report* report, const Row& row) {
  const Reading* deciding = Deciding(row);
  const bench::Verdict verdict = deciding == nullptr ? bench::Verdict::kNotMeasured
                                 : deciding->is_met  ? bench::Verdict::kMet
                                                     : bench::Verdict::kMissed;
  std::vector<std::string> cells{row.id, row.failure, row.set_up, row.observable, row.bound};
  for (const Variant& variant : Variants()) cells.push_back(CellOf(row, variant.name));
  const bool has_miss = deciding == nullptr || std::any_of(row.readings.begin(), row.readings.end(),
                                                           [](const Reading& r) { return !r.is_met; });
  for (const std::string& peer : PeerNames()) cells.push_back(CellOf(row, peer));
  cells.insert(cells.end(), {bench::ToText(verdict), has_miss ? row.why : ""});
  FindTable(report)->Add(cells);
  report->goals.push_back(
      {row.id + " " + row.observable, row.bound, deciding == nullptr ? "" : deciding->measured, verdict});
  std::printf("%-4s %-46s %-22s", row.id.c_str(), row.observable.c_str(), row.bound.c_str());
  for (const Reading& reading : row.readings) {
    std::printf("  %s: %s%s", reading.contender.c_str(), reading.measured.c_str(), reading.is_met ? "" : " (missed)");
  }
  std::printf("\n");
}

void AddSummary(Report* report) {
  const Table& table = *FindTable(report);
  const auto met =
      static_cast<std::size_t>(std::find(table.columns.begin(), table.columns.end(), "met") - table.columns.begin());
  std::map<std::string, bool> is_within;  // by failure
  for (const std::vector<std::string>& row : table.rows) {
    if (row[0].front() != 'F' || row[met] == bench::ToText(bench::Verdict::kNotMeasured)) continue;
    const bool is_met = row[met] == bench::ToText(bench::Verdict::kMet);
    const auto [at, is_new] = is_within.emplace(row[0], is_met);
    at->second = at->second && is_met;
  }
  const auto within = std::count_if(is_within.begin(), is_within.end(), [](const auto& one) { return one.second; });
  report->AddGoal("failures F1 to F23 with every measured row within its bound",
                  ">= " + std::to_string(kWantedWithin) + " of " + std::to_string(kNumFailures),
                  std::to_string(within) + " of " + std::to_string(is_within.size()) + " measured",
                  within >= kWantedWithin);
}

}  // namespace failures
