#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <vector>

#include "vps/field/build_field.hpp"
#include "vps/testing/shapes.hpp"
#include "vps/walk/evaluate_points.hpp"
#include "vps/walk/walk_input.hpp"

namespace vps {
namespace {

constexpr NearRange kNear{0.12f, 1.0f / 0.12f};

// A torus pressed into a plate: samples outside, at the rim and inside.
struct TorusInPlate {
  DistanceField field = *BuildField(MakeBox({0.2, 0.2, 0.04}), 1e-3);
  SampleTree tree = BuildSampleTree(*SampleSurface(MakeTorus(0.03, 0.012, 64, 32), 2048));
  core::Pose X_GS{core::QuaternionFromRotationVector({0.3, 0.2, 0.1}), {0.001, 0.002, 0.02 + 0.014}};
  FieldWalkScratch scratch{tree};
  FieldWalkResult walk = WalkField(tree, field, X_GS, 2e-3, &scratch);
  WalkInput input = MakeFieldInput(field, X_GS);
  std::vector<FineSource> sources;

  TorusInPlate() {
    for (std::uint32_t i = 0; i < walk.num_near_blocks; ++i) {
      const std::uint32_t at = scratch.near_blocks[i];
      for (std::uint32_t k = 0; k < kBlock; ++k) {
        if (at * kBlock + k >= tree.num_points) continue;
        sources.push_back({&tree.fine[at * kBlock + k], &tree.points[at], k, 0.25f + 0.05f * static_cast<float>(k)});
      }
    }
  }
  std::vector<FinePoints> Refine(InstructionSet set) const {
    std::vector<FinePoints> found(sources.size());
    const auto count = static_cast<std::uint32_t>(sources.size());
    KernelsOf(set).refine(input, {sources.data(), count, input.m_per_voxel, kNear}, found.data());
    return found;
  }
  std::vector<NearBlock> Weigh(InstructionSet set) const {
    WeighInput weigh{};
    weigh.points = tree.points.data();
    weigh.spheres = tree.spheres.data();
    weigh.near_blocks = scratch.near_blocks.data();
    weigh.near_slots = scratch.near_slots.data();
    weigh.near_depths = reinterpret_cast<const float(*)[kBlock]>(scratch.near_depths.data());
    weigh.m_per_voxel = input.m_per_voxel;
    weigh.most_m2 = static_cast<float>(tree.refined_m * tree.refined_m);
    weigh.inside_per_m = 1e4f;
    weigh.steeper = 3.0f;
    weigh.least_slope = 0.02f;
    weigh.unrefined = kNear;
    std::vector<NearBlock> near(walk.num_near_blocks);
    KernelsOf(set).weigh(weigh, 0, walk.num_near_blocks, near.data());
    return near;
  }
};

template <class T>
bool IsSame(const std::vector<T>& a, const std::vector<T>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0;
}

TEST(WalkSamples, EveryInstructionSetGivesTheSameBits) {
  if (!IsAvailable(InstructionSet::kAvx2)) GTEST_SKIP() << "this processor has no AVX2";
  const TorusInPlate pair;
  ASSERT_GT(pair.sources.size(), 100U);
  for (const InstructionSet set : {InstructionSet::kAvx2, InstructionSet::kAvx512}) {
    if (!IsAvailable(set)) continue;
    EXPECT_TRUE(IsSame(pair.Refine(set), pair.Refine(InstructionSet::kPortable)));
    EXPECT_TRUE(IsSame(pair.Weigh(set), pair.Weigh(InstructionSet::kPortable)));
  }
}

// Every finer point by itself, in double.
TEST(WalkSamples, FinerPointsAddUp) {
  const TorusInPlate pair;
  const std::vector<FinePoints> found = pair.Refine(BestInstructionSet());
  int num_at_rim = 0;
  int num_inside = 0;
  for (std::size_t i = 0; i < found.size(); ++i) {
    const FineSource& source = pair.sources[i];
    PointBlock points;
    Unpack(*source.fine, *source.block, source.lane, source.weight, &points);
    SphereBlock sphere{};
    sphere.x[0] = source.block->x[source.lane];
    sphere.y[0] = source.block->y[source.lane];
    sphere.z[0] = source.block->z[source.lane];
    sphere.r[0] = source.fine->reach_m;
    BlockDepths depths;
    FindDepths(&points, &sphere, 1, pair.field, pair.X_GS, &depths);
    double near = 0.0, volume = 0.0, mean = 0.0, square = 0.0, rim = 0.0, deepest = -1e9;
    glm::dvec3 force(0.0), moment(0.0);
    for (std::uint32_t k = 0; k < kBlock; ++k) {
      const double d = depths.of[k];
      const double inside = std::max(d, 0.0) * points.area_m2[k];
      if (points.area_m2[k] > 0.0f) near += std::clamp((d + 0.12) / 0.12, 0.0, 1.0);
      volume += inside;
      const glm::dvec3 f = inside * 1e-3 * glm::dvec3(points.nx[k], points.ny[k], points.nz[k]);
      force += f;
      moment += glm::cross(glm::dvec3(points.x[k], points.y[k], points.z[k]), f);
      mean += d / kBlock;
      square += d * d / kBlock;
      deepest = std::max(deepest, d);
    }
    const double h = 0.433 * std::sqrt(std::max(square - mean * mean, 0.0));
    for (std::uint32_t k = 0; k < kBlock && h > 1e-3; ++k) {
      const double part = std::max(h - std::abs(static_cast<double>(depths.of[k])), 0.0);
      rim += part * part * points.area_m2[k] / (4.0 * h);
    }
    const double area = source.block->area_m2[source.lane];
    EXPECT_NEAR(found[i].num_near, near, 1e-3);
    EXPECT_NEAR(found[i].volume_m2, volume, 1e-4 * area);
    EXPECT_NEAR(found[i].rim_m2, volume > 0.0 ? rim : 0.0, 1e-3 * area);
    EXPECT_EQ(found[i].depth, static_cast<float>(deepest));
    EXPECT_NEAR(found[i].sums.volume_m3, 1e-3 * volume, 1e-7 * area);
    for (int axis = 0; axis < 3; ++axis) {
      EXPECT_NEAR(found[i].sums.force_m3[axis], force[axis], 1e-7 * area);
      EXPECT_NEAR(found[i].sums.moment_m4[axis], moment[axis], 1e-8 * area);
    }
    num_at_rim += rim > 1e-3 * area ? 1 : 0;
    num_inside += volume > 0.5 * area ? 1 : 0;
  }
  EXPECT_GT(num_at_rim, 5);
  EXPECT_GT(num_inside, 20);
}

}  // namespace
}  // namespace vps
