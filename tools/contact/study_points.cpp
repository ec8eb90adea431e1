#include <cmath>
#include <cstdio>

#include "tools/contact/studies.hpp"

namespace contact {
namespace {

// Not derived: length of a run against scatter of the medians.
constexpr int kPasses = 3;
constexpr double kSecondsEach = 0.5;

std::string CountText(std::uint32_t n) {
  return n >= 1'000'000 ? std::to_string(n / 1'000'000) + " M" : std::to_string(n / 1000) + " k";
}

}  // namespace

std::vector<PointScaling> StudyPoints(const Workload& workload, const Parts& parts, Structures* structures) {
  const std::vector<std::uint32_t> counts = {1024, 4096, 16384, 65536, 262144, 1048576, 2097152};
  std::vector<Structures::Key> keys;
  for (const std::uint32_t n : counts) {
    keys.push_back({true, vps::Method::kFast, 0.0, n, true});
    if (n <= 1048576) keys.push_back({true, vps::Method::kPaper, 0.0, n, true});
  }
  structures->Prepare(keys);
  std::vector<std::unique_ptr<Method>> methods;
  std::vector<Racer> racers;
  std::vector<PointScaling> rows;
  for (const Structures::Key& key : keys) {
    const auto A = structures->Get({false, key.method, parts.voxel_size_m, 0});
    const auto B = structures->Get(key);
    if (!A || !B) continue;
    const bool is_fast = key.method == vps::Method::kFast;
    methods.push_back(is_fast ? MakeFastMethod(*A, *B, AsInScenarios(kAccuracy))
                              : MakePaperMethod(*A, *B, vps::SurfaceArea_m2(parts.B), true));
    std::vector<core::Pose> poses;
    // Fewer poses of every walk for the slower method and for many points.
    const std::size_t steps = is_fast ? 50 : key.num_points > 100'000 ? 3 : 12;
    for (const auto& walk : workload.walks) {
      poses.insert(poses.end(), walk.begin(), walk.begin() + static_cast<std::ptrdiff_t>(std::min(steps, walk.size())));
    }
    racers.push_back({methods.back().get(), std::move(poses), true, {}});
    rows.push_back({workload.name, is_fast ? "fast" : "paper", key.num_points, {}});
  }
  Race(racers, kPasses, kSecondsEach);
  for (std::size_t i = 0; i < rows.size(); ++i) rows[i].times = racers[i].times;
  std::printf("\n%s, points: ", workload.name.c_str());
  for (const PointScaling& row : rows) {
    std::printf(" %s %s %s us;", row.method.c_str(), CountText(row.num_points).c_str(),
                Short(row.times.p50_us).c_str());
  }
  std::printf("\n");
  return rows;
}

void ReportPoints(const std::vector<PointScaling>& rows, Report* report) {
  if (rows.empty()) return;
  Table table{"points", {"workload", "method", "points", "p50_us", "p99_us", "max_us"}, {}};
  Chart chart{"Time of a query against the number of points",
              "median over consecutive poses, even points (no blue noise), both methods at the same voxel size",
              {}};
  const auto find = [&](const std::string& workload, const std::string& method, std::uint32_t n) -> const Times* {
    for (const PointScaling& row : rows) {
      if (row.workload == workload && row.method == method && row.num_points == n) return &row.times;
    }
    return nullptr;
  };
  for (const PointScaling& row : rows) {
    table.Add({row.workload, row.method, std::to_string(row.num_points), Cell(row.times.p50_us), Cell(row.times.p99_us),
               Cell(row.times.max_us)});
    if (chart.panels.empty() || chart.panels.back().title != row.workload) {
      Panel panel;
      panel.title = row.workload;
      panel.x_title = "points on B's surface";
      panel.y_title = "time per query [us]";
      panel.series = {{"paper", {}, true}, {"fast", {}, true}};
      chart.panels.push_back(panel);
    }
    chart.panels.back().series[row.method == "fast"].points.push_back(
        {static_cast<double>(row.num_points), row.times.p50_us, ""});
  }
  report->tables.push_back(table);
  report->charts.emplace_back("points", chart);
  const Times* paper = find("bunny_light", "paper", 1048576);
  const Times* fast = find("bunny_light", "fast", 1048576);
  if (paper != nullptr && fast != nullptr) {
    const double ratio = paper->p50_us / fast->p50_us;
    report->AddGoal("light contact (bunny_light), 1 M points, s = 0.8 mm: faster than paper", ">= 15 x",
                    Short(ratio) + " x consecutive (" + Short(fast->p50_us) + " us)", ratio >= 15.0);
  }
  for (const char* workload : {"peg_pressed", "nut_pressed"}) {
    const Times* two = find(workload, "fast", 2097152);
    if (two == nullptr) continue;
    report->AddGoal(std::string("conforming contact (") + workload + "), 2 M points", "<= 1000 us",
                    Short(two->p50_us) + " us", two->p50_us <= 1000.0);
    const double tail = two->p99_us / two->p50_us;
    report->AddGoal(std::string("conforming contact (") + workload + "), 2 M points: p99 over median", "<= 1.6",
                    Short(tail), tail <= 1.6);
  }
}

}  // namespace contact
