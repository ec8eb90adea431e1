#include "vps/surface/field_bends.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "vps/field/build_field.hpp"
#include "vps/surface/patch_block.hpp"
#include "vps/testing/shapes.hpp"

namespace vps {
namespace {

// Per brick of the field of a box: the r.m.s. of field minus exact depth over places deeper than kDeepestExact. Inside
// a box the depth is the least of those below its sides.
std::vector<float> ErrorsInBox(const DistanceField& field, const glm::dvec3& half_m) {
  const glm::ivec3 n(field.nx >> 3, field.ny >> 3, field.nz >> 3);
  std::vector<float> errors;
  for (int brick = 0; brick < n.x * n.y * n.z; ++brick) {
    const glm::ivec3 first = 8 * glm::ivec3(brick % n.x, brick / n.x % n.y, brick / (n.x * n.y));
    float sum = 0.0f;
    int count = 0;
    for (int place = 0; place < 512; ++place) {
      const glm::vec3 p = glm::vec3(first + glm::ivec3(place & 7, place >> 3 & 7, place >> 6)) + 0.5f;
      const FieldSample at = SampleField(field, p);
      if (at.distance > -kDeepestExact) continue;
      const glm::dvec3 from_sides = half_m - glm::abs(glm::dvec3(p) * field.voxel_size_m + field.origin_m);
      const double depth = std::min({from_sides.x, from_sides.y, from_sides.z}) / field.voxel_size_m;
      const float off = -at.distance - static_cast<float>(depth);
      sum += off * off;
      ++count;
    }
    errors.push_back(count > 0 ? std::sqrt(sum / static_cast<float>(count)) : 0.0f);
  }
  return errors;
}

// The plate is little thicker than the band on both sides: its coarse cells are coarse in part only, and their middles
// need not be.
TEST(FieldBends, KnowTheErrorOfDeepPlacesWhereverTheBandEnds) {
  constexpr double kVoxel_m = 1e-3;
  int num_wrong = 0;
  for (const double thickness : {6.6, 7.0, 7.4, 7.8, 8.2, 9.0, 10.0}) {
    const glm::dvec3 sides_m(0.06, 0.06, thickness * kVoxel_m);
    const auto field = BuildField(MakeBox(sides_m), kVoxel_m);
    ASSERT_TRUE(field);
    const FieldBends bends = BuildFieldBends(*field);
    const std::vector<float> errors = ErrorsInBox(*field, 0.5 * sides_m);
    for (std::size_t i = 0; i < errors.size(); ++i) {
      if (errors[i] < 0.05f) continue;
      ++num_wrong;
      EXPECT_GT(bends.inner_errors[i], 0.3f * errors[i]) << thickness << " voxels thick, brick " << i;
    }
  }
  EXPECT_GT(num_wrong, 50) << "there was no error to know";
}

}  // namespace
}  // namespace vps
