#include "vps/field/nearest_facet.hpp"

#include <gtest/gtest.h>

#include "vps/field/build_field.hpp"
#include "vps/field/closest_triangle.hpp"
#include "vps/testing/contact_cases.hpp"

namespace vps {
namespace {

// Within the rounding of the corners, half a step along each axis.
TEST(NearestFacet, IsTheNearestPlaceOfTheMeshWithItsSide) {
  for (const TriangleMesh& mesh : {MakeTorus(0.05, 0.02, 48, 24), MakeBlockWithHole(0.06, 0.04, 0.01, 64)}) {
    const DistanceField field = *BuildField(mesh, 1e-3);
    ASSERT_FALSE(field.triangles().blocks.empty());
    const TriangleField exact(mesh);
    CaseRandom random(3);
    int num_found = 0;
    for (int i = 0; i < 2000; ++i) {
      const glm::dvec3 p(random.Uniform(-0.07, 0.07), random.Uniform(-0.07, 0.07), random.Uniform(-0.03, 0.03));
      std::uint32_t triangle = 0;
      const double distance = std::sqrt(exact.ClosestOfAll(p, &triangle).squared_distance) / 1e-3;
      const NearestFacet facet = FindNearestFacet(field.triangles(), (p - field.origin_m) / 1e-3, 5.0);
      EXPECT_EQ(facet.is_found, distance < 5.0);
      if (!facet.is_found) continue;
      ++num_found;
      EXPECT_NEAR(std::abs(facet.height), distance, static_cast<double>(kFacetStep));
      EXPECT_NEAR(glm::length((p - field.origin_m) / 1e-3 - facet.place), distance, static_cast<double>(kFacetStep));
      const double by_field = static_cast<double>(SampleField(field, glm::vec3((p - field.origin_m) / 1e-3)).distance);
      if (std::abs(by_field) > 0.5) {
        EXPECT_EQ(facet.height > 0.0, by_field > 0.0);
      }
    }
    EXPECT_GT(num_found, 200);
  }
}

// Long thin triangles beside small ones: boxes that overlap, so that the order in which blocks are met matters.
// Gathered once around a ball, also one with more triangles than there is room for, the answer is that of the whole
// mesh.
TEST(NearestFacet, OfWhatIsGatheredIsThatOfTheWholeMesh) {
  int num_full = 0;
  for (const TriangleMesh& mesh : {MakeBlockWithHole(0.06, 0.04, 0.01, 128), MakeSphere(0.02, 96)}) {
    const DistanceField field = *BuildField(mesh, 1e-3);
    const Facets& facets = field.triangles();
    CaseRandom random(5);
    int num_found = 0;
    for (int i = 0; i < 300; ++i) {
      const double radius = random.Uniform(0.5, 9.0);
      const glm::dvec3 out = random.Direction();
      const glm::dvec3 from(0.03 * out.x, 0.03 * out.y, 0.02 * out.z);
      const glm::dvec3 middle = (from - field.origin_m) / 1e-3;
      FacetsAround around;
      around.Gather(facets, middle, radius);
      num_full += around.is_full() ? 1 : 0;
      for (int k = 0; k < 10; ++k) {
        const double share = random.Uniform(0.0, 0.5);
        const glm::dvec3 p = middle + share * radius * random.Direction();
        const double reach = (1.0 - share) * radius;
        const NearestFacet one = around.FindNearest(p, reach);
        const NearestFacet all = FindNearestFacet(facets, p, reach);
        ASSERT_EQ(one.is_found, all.is_found);
        if (!all.is_found) continue;
        ++num_found;
        EXPECT_NEAR(one.height, all.height, 1e-9);
        EXPECT_NEAR(glm::distance(one.place, all.place), 0.0, 1e-6);
      }
    }
    EXPECT_GT(num_found, 100);
  }
  EXPECT_GT(num_full, 20);
}

// Over the groove between two faces: without the nearer one the other is nearest, and without that nothing so near.
TEST(NearestFacet, OfWhatIsGatheredIsThatOfTheRestOnceAFaceIsLeftOut) {
  const DistanceField field = *BuildField(MakeBlockWithHole(0.06, 0.04, 0.01, 16), 1e-3);
  const glm::dvec3 p = (glm::dvec3(0.0095, 0.0001, 0.0) - field.origin_m) / 1e-3;
  FacetsAround around;
  around.Gather(field.triangles(), p, 3.0);
  const NearestFacet first = around.FindNearest(p, 1.0);
  around.LeaveOut(first);
  const NearestFacet second = around.FindNearest(p, 1.0);
  ASSERT_TRUE(first.is_found && second.is_found);
  EXPECT_GE(second.height, first.height);
  EXPECT_LT(first.normal.y * second.normal.y, 0.0);
  around.LeaveOut(second);
  EXPECT_FALSE(around.FindNearest(p, 1.0).is_found);
}

}  // namespace
}  // namespace vps
