#include "vps/sampling/touch_points.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "vps/testing/shapes.hpp"

namespace vps {
namespace {

using Kind = TouchPlace::Kind;

// Kinds, places and turns stay when the tree is gone.
TouchPoints TouchPointsOf(const TriangleMesh& mesh, std::uint32_t num_points) {
  const SampleTree samples = BuildSampleTree(*SampleSurface(mesh, num_points));
  const SurfaceTree surface = BuildSurfaceTree(mesh, 4.0 * std::sqrt(samples.area_m2 / num_points));
  return FindTouchPoints(samples, surface);
}

std::map<Kind, int> CountKinds(const TouchPoints& touch) {
  std::map<Kind, int> count;
  for (const TouchPlace& place : touch.places) ++count[place.kind];
  return count;
}

// Every corner of the box is a place, twelve edges are covered without a gap, and faces have the samples.
TEST(TouchPoints, HoldCornersAndCoverEdges) {
  const TouchPoints touch = TouchPointsOf(MakeBox({0.06, 0.02, 0.04}), 2048);
  double length_m = 0.0;
  int num_corners = 0;
  for (std::size_t i = 0; i < touch.places.size(); ++i) {
    const PointBlock& block = touch.tree.points[i / kBlock];
    const glm::vec3 p(block.x[i % kBlock], block.y[i % kBlock], block.z[i % kBlock]);
    const glm::vec3 from_corner = glm::abs(p) - glm::vec3(0.03f, 0.01f, 0.02f);
    EXPECT_LT(std::max({from_corner.x, from_corner.y, from_corner.z}), 1e-6f);
    num_corners += glm::length(from_corner) < 1e-6f ? 1 : 0;
    if (touch.places[i].kind == Kind::kEdge) length_m += 2.0 * static_cast<double>(touch.places[i].reach_m);
  }
  EXPECT_EQ(num_corners, 8);
  EXPECT_NEAR(length_m, 4 * (0.06 + 0.02 + 0.04), 1e-5);
  EXPECT_GT(CountKinds(touch)[Kind::kFace], 1500);
}

// Its rims, and the blunt edges between its facets once each, although thin triangles are cut each for itself.
TEST(TouchPoints, CoverTheEdgesOfThinTriangles) {
  const TouchPoints touch = TouchPointsOf(MakeCylinder(0.01, 0.06, 128), 16384);
  double rims_m = 0.0;
  double lines_m = 0.0;
  for (const TouchPlace& place : touch.places) {
    if (place.kind == Kind::kEdge)
      (std::abs(place.along.z) < 0.5f ? rims_m : lines_m) += 2.0 * static_cast<double>(place.reach_m);
  }
  EXPECT_NEAR(rims_m, 2 * 128 * 2 * 0.01 * std::sin(std::acos(-1.0) / 128), 1e-4);
  EXPECT_NEAR(lines_m, 128 * 0.06, 0.08);
}

// A polygon of 128 sides turns by 1/128 of a turn from one to the next; a box has only sharp edges.
TEST(TouchPoints, TurnFromFaceToFaceAsRoundPartsDo) {
  const TouchPoints cylinder = TouchPointsOf(MakeCylinder(0.01, 0.06, 128), 16384);
  EXPECT_NEAR(cylinder.turn_rad, 2.0 * std::acos(-1.0) / 128, 1e-4);
  const TouchPoints box = TouchPointsOf(MakeBox({0.06, 0.02, 0.04}), 2048);
  EXPECT_NEAR(box.turn_rad, 0.0, 1e-4);
}

}  // namespace
}  // namespace vps
