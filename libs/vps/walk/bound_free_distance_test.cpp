#include "vps/walk/bound_free_distance.hpp"

#include <gtest/gtest.h>

#include "vps/field/build_field.hpp"
#include "vps/testing/shapes.hpp"
#include "vps/walk/field_walk.hpp"

namespace vps {
namespace {

// Fillers of the tree must not be taken for spheres, since they have no children.
TEST(BoundFreeDistance, IsBelowTheDistanceNearAndFar) {
  const DistanceField field = *BuildField(MakeSphere(0.02, 16), 0.001);
  const SampleTree tree = BuildSampleTree(*SampleSurface(MakeSphere(0.02, 16), 300));
  ASSERT_EQ(tree.num_levels, 2U);
  for (const double distance_m : {0.1, 300.0, 2e6}) {
    WalkInput in = MakeFieldInput(field, {{1.0, 0.0, 0.0, 0.0}, {distance_m, 0.0, 0.0}});
    in.spheres = tree.spheres.data();
    in.level_begin = tree.level_begin.data();
    in.num_levels = tree.num_levels;
    for (const InstructionSet set : {InstructionSet::kPortable, InstructionSet::kAvx2, InstructionSet::kAvx512}) {
      if (!IsAvailable(set)) continue;
      std::uint32_t spheres_tested = 0;
      const double free_distance = BoundFreeDistance(in, KernelsOf(set), &spheres_tested);
      const double truth = (distance_m - 0.04) / field.voxel_size_m;
      EXPECT_GT(free_distance, 0.7 * truth);
      EXPECT_LE(free_distance, 1.000001 * truth + 0.1);
      EXPECT_GT(spheres_tested, kBlock);
    }
  }
}

}  // namespace
}  // namespace vps
