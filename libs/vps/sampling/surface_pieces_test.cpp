#include "vps/sampling/surface_pieces.hpp"

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
      const SurfacePieces pieces = CutIntoPieces(mesh, longest_m);
      ASSERT_FALSE(pieces.pieces.empty());
      EXPECT_EQ(pieces.pieces.size(), CountPieces(mesh, longest_m));
      double area_m2 = 0.0;
      for (const SurfacePiece& piece : pieces.pieces) {
        area_m2 += Area_m2(piece);
        EXPECT_LE(Longest_m(piece), longest_m * (1.0 + 1e-5));
      }
      EXPECT_NEAR(area_m2, SurfaceArea_m2(mesh), 1e-5 * area_m2);
    }
  }
}

// A cylinder of 512 strips 0.25 mm wide: four triangles for each 3 mm of a strip, where halving makes so many that none
// are kept.
TEST(SurfacePieces, OfThinTrianglesAreFew) {
  const TriangleMesh cylinder = MakeCylinder(0.02, 0.1, 512);
  const std::size_t slices = 36;
  const std::size_t count = CountPieces(cylinder, 3e-3);
  EXPECT_GT(count, 512 * 4 * slices);
  EXPECT_LT(count, 512 * (4 * slices + 32));
}

TEST(SurfacePieces, LieInTheSpheresOfTheirTree) {
  const SurfacePieces pieces = CutIntoPieces(MakeTorus(0.05, 0.02, 48, 24), 3e-3);
  ASSERT_TRUE(IsConsistent(pieces, pieces.pieces.size()));
  std::size_t run = 1;  // pieces under a sphere
  for (std::uint32_t level = 0; level < pieces.num_levels; ++level) {
    for (std::size_t i = 0; i < pieces.pieces.size(); ++i) {
      const std::size_t at = i / run;
      const SphereBlock& block = pieces.spheres[pieces.level_begin[level] + at / kBlock];
      const std::size_t lane = at % kBlock;
      const glm::dvec3 centre(block.x[lane], block.y[lane], block.z[lane]);
      const glm::dvec3 n(block.nx[lane], block.ny[lane], block.nz[lane]);
      for (const glm::vec3& p : pieces.pieces[i].corners) {
        EXPECT_LE(glm::length(glm::dvec3(p) - centre), block.r[lane]);
        if (level == 0) {
          EXPECT_LE(std::abs(glm::dot(glm::dvec3(p) - centre, n)), block.h[lane]);
        }
      }
    }
    run *= kBlock;
  }
}

TEST(SurfacePieces, AreEmptyAboveTheLimit) {
  const TriangleMesh box = MakeBox({1.0, 1.0, 1.0});
  EXPECT_EQ(CountPieces(box, 1e-3), 0U);
  EXPECT_TRUE(CutIntoPieces(box, 1e-3).pieces.empty());
  EXPECT_EQ(CutIntoPieces(box, 1e-3).num_levels, 0U);
}

}  // namespace
}  // namespace vps
