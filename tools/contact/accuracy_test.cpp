#include <gtest/gtest.h>

#include <fstream>
#include <map>
#include <sstream>

#include "tools/contact/studies.hpp"
#include "tools/contact/testing/published_wrenches.hpp"

namespace contact {
namespace {

// Rows of docs/performance/vps/field_accuracy.csv by parts and method.
std::map<std::string, std::vector<double>> PublishedRows() {
  std::ifstream stream(VR_OOS_SOURCE_DIR "/docs/performance/vps/field_accuracy.csv");
  std::map<std::string, std::vector<double>> rows;
  std::string line;
  std::getline(stream, line);
  EXPECT_EQ(line,
            "parts,method,voxel_m,depth_error_mean_voxels,depth_error_p95_voxels,depth_error_max_voxels,"
            "direction_p50_deg,direction_p95_deg,wrong_contacts");
  while (std::getline(stream, line)) {
    std::istringstream cells(line);
    std::string parts, method, cell;
    std::getline(cells, parts, ',');
    std::getline(cells, method, ',');
    std::vector<double>& row = rows[parts + " " + method];
    while (std::getline(cells, cell, ',')) row.push_back(cell.empty() ? -1.0 : std::stod(cell));
  }
  return rows;
}

// The published errors are upper bounds of those measured now, within 20 % and a small absolute margin.
TEST(PublishedAccuracy, HoldsForTheRings) {
  const auto published = PublishedRows();
  const auto made = MakeParts("rings", {});
  ASSERT_TRUE(made);
  Structures structures(*made->parts);
  for (const FieldFigures& now : StudyField(*made, &structures)) {
    const auto row = published.find("rings " + now.method);
    ASSERT_NE(row, published.end()) << now.method;
    const std::vector<double>& was = row->second;
    ASSERT_GE(was.size(), 6U);
    EXPECT_DOUBLE_EQ(now.voxel_size_m, was[0]);
    EXPECT_LE(now.depth_voxels.p50, 1.2 * was[1] + 5e-4) << now.method;
    EXPECT_LE(now.depth_voxels.p95, 1.2 * was[2] + 2e-3) << now.method;
    EXPECT_LE(now.depth_voxels.max, 1.2 * was[3] + 2e-2) << now.method;
    EXPECT_LE(now.direction_deg.p50, 1.2 * was[4] + 1e-2) << now.method;
    EXPECT_LE(now.direction_deg.p95, 1.2 * was[5] + 5e-2) << now.method;
  }
}

// The same for whole wrenches, sampling included.
TEST(PublishedAccuracy, HoldsForWholeWrenches) {
  const auto published = PublishedWrenches();
  for (const char* name : {"ball_and_box", "rings"}) {
    const auto made = MakeParts(name, {});
    ASSERT_TRUE(made);
    const Workload& workload = made->workloads.front();
    const Measurement now = MeasureFast(*made->parts, workload, 4096);
    const auto row = published.find(workload.name + " s; 4096 points");
    ASSERT_NE(row, published.end()) << name;
    const std::vector<double>& was = row->second;
    ASSERT_EQ(was.size(), 9U);
    EXPECT_LE(now.magnitude.p50, 1.2 * was[0] + 1e-3) << name;
    EXPECT_LE(now.magnitude.max, 1.2 * was[2] + 2e-3) << name;
    EXPECT_LE(now.direction_deg.p95, 1.2 * was[4] + 1e-2) << name;
    EXPECT_LE(now.torque.max, 1.2 * was[6] + 1e-3) << name;
    EXPECT_EQ(now.missed, 0.0) << name;
  }
}

TEST(PublishedAccuracy, HoldsForTheModuleOnItsBracket) {
  ExpectPublishedWrenches("module", "module_on_bracket");
}

TEST(PublishedAccuracy, HoldsForTheFandiskOnTheBunny) {
  ExpectPublishedWrenches("fandisk", "fandisk_on_bunny");
}

TEST(Workload, HasTheSamePosesAtEveryCall) {
  const auto first = MakeParts("peg", {});
  const auto second = MakeParts("peg", {});
  ASSERT_TRUE(first && second);
  const std::vector<core::Pose> a = first->workloads[0].consecutive();
  const std::vector<core::Pose> b = second->workloads[0].consecutive();
  ASSERT_EQ(a.size(), 800U);
  ASSERT_EQ(a.size(), b.size());
  double longest_m = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].translation, b[i].translation);
    if (i % 100 != 0) longest_m = std::max(longest_m, glm::distance(a[i].translation, a[i - 1].translation));
  }
  EXPECT_LT(longest_m, 5e-4);  // a hand at 1 kHz
}

}  // namespace
}  // namespace contact
