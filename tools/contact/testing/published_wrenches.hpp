#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "tools/contact/studies.hpp"
#include "tools/contact/truth.hpp"

// The published accuracy of whole wrenches, and the same measured now.
namespace contact {

// Rows of docs/performance/vps/wrench_accuracy.csv by workload and setting.
inline std::map<std::string, std::vector<double>> PublishedWrenches() {
  std::ifstream stream(VR_OOS_SOURCE_DIR "/docs/performance/vps/wrench_accuracy.csv");
  std::map<std::string, std::vector<double>> rows;
  std::string line;
  std::getline(stream, line);
  EXPECT_EQ(line,
            "workload,setting,magnitude_p50,magnitude_p95,magnitude_max,direction_p50_deg,direction_p95_deg,torque_p50,"
            "torque_max,depth_error_m_p50,missed");
  while (std::getline(stream, line)) {
    std::istringstream cells(line);
    std::string workload, setting, cell;
    std::getline(cells, workload, ',');
    std::getline(cells, setting, ',');
    std::vector<double>& row = rows[workload + " " + setting];
    while (std::getline(cells, cell, ',')) row.push_back(cell.empty() ? -1.0 : std::stod(cell));
  }
  return rows;
}

// Method `fast` with so many points on B against the exact answers.
inline Measurement MeasureFast(const Parts& parts, const Workload& workload, std::uint32_t num_points) {
  Structures structures(parts);
  const auto A = structures.Get({false, vps::Method::kFast, parts.voxel_size_m, 0});
  const auto B = structures.Get({true, vps::Method::kFast, 0.0, num_points});
  Measurement measured;
  if (A && B) {
    Compare(parts, workload, ExactAnswers(parts, workload), true, MakeFastMethod(*A, *B, InContests(kAccuracy)).get(),
            &measured);
  } else {
    ADD_FAILURE() << parts.name << " cannot be cooked";
  }
  return measured;
}

// The rows behind the README, the changelog and docs/performance/vps/goals.md: real parts at the benchmark's own poses,
// 64 k points. Poses and answers are the same on every machine, so nothing is added but the table's rounding.
inline void ExpectPublishedWrenches(const std::string& parts, const std::string& workload_name) {
#if defined(__SANITIZE_THREAD__) || defined(__SANITIZE_ADDRESS__)
  GTEST_SKIP() << "an hour for figures that are the same";
#endif
  const std::filesystem::path source = VR_OOS_SOURCE_DIR;
  const Places places{source / "scenarios", source.parent_path() / "shared/data/meshes"};
  if (parts != "module" && !exists(places.meshes)) GTEST_SKIP() << "no public meshes in " << places.meshes;
  const auto published = PublishedWrenches();
  const auto made = MakeParts(parts, places);
  ASSERT_TRUE(made) << made.error().detail;
  for (const Workload& workload : made->workloads) {
    if (workload.name != workload_name) continue;
    const auto row = published.find(workload_name + " " + kMiddle);
    ASSERT_NE(row, published.end());
    const std::vector<double>& was = row->second;
    ASSERT_EQ(was.size(), 9U);
    const Measurement now = MeasureFast(*made->parts, workload, kMiddlePoints);
    constexpr double kRounding = 1.0 + 1e-5;
    EXPECT_LE(now.magnitude.p50, kRounding * was[0]);
    EXPECT_LE(now.magnitude.max, kRounding * was[2]);
    EXPECT_LE(now.direction_deg.p50, kRounding * was[3]);
    EXPECT_LE(now.direction_deg.p95, kRounding * was[4]);
    EXPECT_LE(now.torque.max, kRounding * was[6]);
    EXPECT_EQ(now.missed, 0.0);
    return;
  }
  FAIL() << "no workload " << workload_name;
}

}  // namespace contact
