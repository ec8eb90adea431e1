#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "vps/field/build_field.hpp"
#include "vps/field/nearest_facet.hpp"
#include "vps/testing/case_random.hpp"
#include "vps/testing/part_shapes.hpp"
#include "vps/testing/shapes.hpp"
#include "vps/walk/field_walk.hpp"

namespace vps {
namespace {

// Depths of sixteen places together are those of a search for each, in doubles, also where faces are cut into slivers
// of a millionth of their length, whose frames are lost in the rounding of floats.
TEST(FacetLanes, MeasureWhatASearchInDoublesMeasures) {
  TriangleMesh slivers = MakeBox({0.05, 0.04, 0.03});
  for (int i = 0; i < 3; ++i) slivers = SplitTriangles(slivers, 0.01);
  const glm::dquat turn = core::QuaternionFromRotationVector({0.4, -0.7, 0.3});
  for (glm::dvec3& p : slivers.vertices) p = turn * p;
  for (const TriangleMesh& mesh : {MakeTorus(0.02, 0.008, 48, 24), slivers}) {
    constexpr double kVoxel_m = 2e-4;
    const DistanceField field = *BuildField(mesh, kVoxel_m);
    const WalkInput in = MakeFieldInput(field, core::Pose{});
    const auto scratch = std::make_unique<FacetScratch>();
    CaseRandom random(3);
    int num_compared = 0;
    for (int i = 0; i < 4000; ++i) {
      const glm::dvec3 middle(random.Uniform(-0.03, 0.03), random.Uniform(-0.03, 0.03), random.Uniform(-0.02, 0.02));
      FacetPoints points{};
      std::array<glm::dvec3, kBlock> places;  // voxels
      bool is_near = true;
      for (std::size_t k = 0; k < kBlock; ++k) {
        const glm::vec3 p(middle + kVoxel_m * random.Direction());
        points.x[k] = p.x;
        points.y[k] = p.y;
        points.z[k] = p.z;
        places[k] = (glm::dvec3(p) - field.origin_m) / kVoxel_m;
        points.depth[k] = -SampleField(field, glm::vec3(places[k])).distance;
        is_near = is_near && std::abs(points.depth[k]) < 2.5f;
      }
      if (!is_near) continue;
      KernelsOf(BestInstructionSet()).measure(in, &points, 1, scratch.get());
      for (std::size_t k = 0; k < kBlock; ++k) {
        const NearestFacet nearest = FindNearestFacet(field.triangles(), places[k], 4.0);
        ASSERT_TRUE(nearest.is_found);
        if (std::abs(nearest.height) < 1e-3) continue;  // its side is rounding
        ++num_compared;
        ASSERT_NEAR(static_cast<double>(points.depth[k]), -nearest.height, 2e-4);
      }
    }
    EXPECT_GT(num_compared, 1000);
  }
}

}  // namespace
}  // namespace vps
