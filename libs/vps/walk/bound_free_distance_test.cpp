#include "vps/walk/bound_free_distance.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "vps/field/build_field.hpp"
#include "vps/testing/shapes.hpp"
#include "vps/walk/field_walk.hpp"
#include "vps/walk/walk_input.hpp"

namespace vps {
namespace {

// At 300 m, beyond the range of bounds, all spheres are equally far: fillers of the tree must not be taken for one of
// them, since they have no children.
TEST(BoundFreeDistance, FillersAreFartherThanAnySphere) {
  const DistanceField field = *BuildField(MakeSphere(0.02, 16), 0.001);
  const SampleTree tree = *BuildSampleTree(MakeSphere(0.02, 16), 300);
  ASSERT_EQ(tree.num_levels, 2U);
  for (const double distance_m : {0.1, 300.0}) {
    WalkInput in = MakeFieldInput(field, {{1.0, 0.0, 0.0, 0.0}, {distance_m, 0.0, 0.0}});
    in.spheres = tree.spheres.data();
    in.level_begin = tree.level_begin.data();
    in.num_levels = tree.num_levels;
    for (const InstructionSet set : {InstructionSet::kPortable, InstructionSet::kAvx2, InstructionSet::kAvx512}) {
      if (!IsAvailable(set)) continue;
      const WalkKernels kernels = KernelsOf(set);
      std::int32_t keys[kBlock];
      kernels.bound(in, tree.level_begin[1], keys);
      for (std::uint32_t k = 0; k < kBlock; ++k) {
        const float bound = static_cast<float>(keys[k] >> 4) / static_cast<float>(kFreeDistanceSteps);
        if (tree.spheres[tree.level_begin[1]].x[k] < SampleTree::kFarAway_m) {
          EXPECT_LE(bound, std::min(kMaxFreeDistance, static_cast<float>(distance_m / field.voxel_size_m)));
        } else {
          EXPECT_GT(bound, kMaxFreeDistance) << k;
        }
      }
      double free_distance = 0.0;
      BoundFreeDistance(in, kernels, &free_distance);
      const double truth = (distance_m - 0.04) / field.voxel_size_m;
      EXPECT_GT(free_distance, std::min(static_cast<double>(kMaxFreeDistance) - 1.0, 0.7 * truth));
      EXPECT_LE(free_distance, truth + 0.1);
    }
  }
}

}  // namespace
}  // namespace vps
