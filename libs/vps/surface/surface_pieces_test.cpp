#include "vps/surface/surface_pieces.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "vps/testing/shapes.hpp"

namespace vps {
namespace {

double Area_m2(const SurfacePiece& piece) {
  const glm::dvec3 a(piece.corners[0]);
  return 0.5 * glm::length(glm::cross(glm::dvec3(piece.corners[1]) - a, glm::dvec3(piece.corners[2]) - a));
}

double Longest_m(const SurfacePiece& piece) {
  double longest = 0.0;
  for (int k = 0; k < 3; ++k) {
    longest = std::max(longest, glm::length(glm::dvec3(piece.corners[(k + 1) % 3]) - glm::dvec3(piece.corners[k])));
  }
  return longest;
}

TEST(SurfacePieces, CoverTheSurfaceWithSidesWithinTheLimit) {
  for (const TriangleMesh& mesh :
       {MakeBox({0.04, 0.03, 0.02}), MakeTorus(0.05, 0.02, 48, 24), MakeBlockWithHole(0.05, 0.05, 0.01, 512)}) {
    for (const double longest_m : {2.2e-3, 3e-3}) {
      const std::vector<SurfacePiece> pieces = CutIntoPieces(mesh, longest_m);
      double area_m2 = 0.0;
      for (const SurfacePiece& piece : pieces) {
        area_m2 += Area_m2(piece);
        EXPECT_LE(Longest_m(piece), longest_m * (1.0 + 1e-5));
      }
      EXPECT_NEAR(area_m2, SurfaceArea_m2(mesh), 1e-5 * area_m2);
    }
  }
}

// A cylinder of 512 strips 0.25 mm wide: four triangles for each 3 mm of a strip, where halving would make too many.
TEST(SurfacePieces, OfThinTrianglesAreFew) {
  const std::size_t slices = 36;
  const std::size_t count = CutIntoPieces(MakeCylinder(0.02, 0.1, 512), 3e-3).size();
  EXPECT_GT(count, 512 * 4 * slices);
  EXPECT_LT(count, 512 * (4 * slices + 32));
}

TEST(SurfacePieces, AreTheTrianglesThemselvesWhereThereWouldBeTooMany) {
  EXPECT_EQ(CutIntoPieces(MakeBox({1.0, 1.0, 1.0}), 1e-3).size(), 12U);
}

}  // namespace
}  // namespace vps
