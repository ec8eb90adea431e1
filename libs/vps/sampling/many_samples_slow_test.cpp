#include <gtest/gtest.h>

#include "vps/pointshell/pointshell.hpp"
#include "vps/sampling/sample_tree.hpp"
#include "vps/testing/shapes.hpp"

namespace vps {
namespace {

TEST(SlowSurfaceSamples, MoreMemoryThanAllowedIsRefusedBeforeItIsTaken) {
  const auto samples = SampleSurface(MakeCylinder(0.01, 0.04, 65536), kMaxPoints);
  ASSERT_FALSE(samples);
  EXPECT_NE(samples.error().detail.find("MB allowed: take fewer"), std::string::npos) << samples.error().detail;
}

TEST(SlowSampleTree, EstimatesItsMemoryFromAbove) {
  const TriangleMesh mesh = MakeTorus(0.05, 0.02, 48, 24);
  const auto estimate = EstimateSampleTree(mesh, 140'000);
  ASSERT_TRUE(estimate);
  const auto stored = static_cast<double>(BuildSampleTree(*SampleSurface(mesh, 140'000)).num_bytes());
  EXPECT_GE(estimate->stored_bytes, stored);
  EXPECT_LE(estimate->stored_bytes, 1.05 * stored + 4000.0);
  EXPECT_GT(estimate->peak_bytes, estimate->stored_bytes);
}

}  // namespace
}  // namespace vps
