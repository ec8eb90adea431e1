#include "nodes/visual_node/gl/detail_levels.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

namespace visual_node {
namespace {

std::size_t NumTriangles(const Piece::Level& level) {
  std::size_t num = 0;
  for (const auto& indices : level.indices) num += indices.size() / 3;
  return num;
}

// A square of n by n cells whose height is `height(x, y)`; each half of it in a primitive of its own.
template <typename Height>
vps::VisualMesh Field(std::uint32_t n, Height height, bool has_two_materials = false) {
  vps::VisualMesh mesh;
  mesh.primitives.resize(has_two_materials ? 2 : 1);
  for (vps::VisualPrimitive& primitive : mesh.primitives) {
    for (std::uint32_t k = 0; k < (n + 1) * (n + 1); ++k) {
      const float x = 0.01f * static_cast<float>(k % (n + 1)), y = 0.01f * static_cast<float>(k / (n + 1));
      primitive.positions.emplace_back(x, y, height(x, y));
      primitive.normals.emplace_back(0, 0, 1);
    }
  }
  for (std::uint32_t j = 0; j < n; ++j) {
    for (std::uint32_t i = 0; i < n; ++i) {
      const std::uint32_t a = j * (n + 1) + i, b = a + 1, c = a + n + 1, d = c + 1;
      auto& indices = mesh.primitives[has_two_materials && 2 * i >= n ? 1 : 0].indices;
      indices.insert(indices.end(), {a, b, d, a, d, c});
    }
  }
  return mesh;
}

// Twice the area that a primitive's triangles cover, seen from above.
double Area(const vps::VisualMesh& mesh, std::size_t primitive, const std::vector<std::uint32_t>& indices) {
  double area = 0.0;
  for (std::size_t i = 0; i + 2 < indices.size(); i += 3) {
    const auto& p = mesh.primitives[primitive].positions;
    const glm::vec3 a = p[indices[i]], b = p[indices[i + 1]], c = p[indices[i + 2]];
    area += std::abs(static_cast<double>(glm::cross(b - a, c - a).z));
  }
  return area;
}

TEST(DetailLevels, AFlatSquareNeedsTwoTriangles) {
  auto mesh = Field(10, [](float, float) { return 0.0f; });
  const std::vector<Piece> pieces = MakePieces(&mesh);
  ASSERT_EQ(pieces.size(), 1u);
  std::size_t fewest = 200;
  for (const Piece::Level& level : pieces[0].levels) {
    if (level.error_m > 1e-6f) continue;
    fewest = std::min(fewest, NumTriangles(level));
    EXPECT_NEAR(Area(mesh, 0, level.indices[0]), 2.0 * 0.01, 1e-8);
  }
  EXPECT_EQ(fewest, 2u);
}

// A window that is closed while they are made does not wait for them.
TEST(DetailLevels, EndEarlyWhenAStopIsWanted) {
  auto mesh = Field(10, [](float, float) { return 0.0f; });
  const std::atomic<bool> is_stop_wanted{true};
  EXPECT_TRUE(MakePieces(&mesh, &is_stop_wanted).empty());
}

TEST(DetailLevels, NoVertexIsFartherFromALevelThanItsError) {
  auto mesh = Field(24, [](float x, float y) { return 0.01f * std::sin(40.0f * x) * std::cos(30.0f * y); });
  for (const Piece& piece : MakePieces(&mesh)) {
    EXPECT_GE(piece.levels.size(), 5u);
    for (const Piece::Level& level : piece.levels) {
      const auto& indices = level.indices[0];
      if (indices.empty()) continue;
      const auto& p = mesh.primitives[0].positions;
      // Seen from above the levels have no folds, so a vertex is at most its height over the triangle below away.
      double worst = 0.0;
      for (const glm::vec3& v : p) {
        double nearest = 1.0;
        for (std::size_t i = 0; i + 2 < indices.size(); i += 3) {
          const glm::dvec3 a(p[indices[i]]), b(p[indices[i + 1]]), c(p[indices[i + 2]]);
          constexpr int kSteps = 12;
          for (int s = 0; s <= kSteps; ++s) {
            for (int t = 0; s + t <= kSteps; ++t) {
              const glm::dvec3 q = a + (b - a) * (s / double{kSteps}) + (c - a) * (t / double{kSteps});
              nearest = std::min(nearest, glm::distance(q, glm::dvec3(v)));
            }
          }
        }
        worst = std::max(worst, nearest);
      }
      // The samples of a triangle are a twelfth of its sides apart.
      EXPECT_LE(worst, level.error_m + 0.01);
    }
  }
}

TEST(DetailLevels, ErrorsGrowAndTrianglesBecomeFewer) {
  auto mesh = Field(16, [](float x, float y) { return 0.02f * std::sin(40.0f * x) * std::cos(30.0f * y); });
  const std::vector<Piece> pieces = MakePieces(&mesh);
  ASSERT_EQ(pieces.size(), 1u);
  const auto& levels = pieces[0].levels;
  EXPECT_EQ(NumTriangles(levels.front()), 512u);
  EXPECT_EQ(levels.front().error_m, 0.0f);
  EXPECT_EQ(NumTriangles(levels.back()), 0u);
  for (std::size_t i = 1; i < levels.size(); ++i) {
    EXPECT_GE(levels[i].error_m, levels[i - 1].error_m);
    EXPECT_LE(4 * NumTriangles(levels[i]), 3 * NumTriangles(levels[i - 1]));
  }
}

TEST(DetailLevels, TheLineBetweenTwoMaterialsStaysWhereItIs) {
  auto mesh = Field(
      10, [](float, float) { return 0.0f; }, true);
  const std::vector<Piece> pieces = MakePieces(&mesh);
  ASSERT_EQ(pieces.size(), 1u);
  for (const Piece::Level& level : pieces[0].levels) {
    if (level.error_m > 1e-6f) continue;
    for (const std::size_t k : {0u, 1u}) EXPECT_NEAR(Area(mesh, k, level.indices[k]), 0.01, 1e-8);
  }
}

TEST(DetailLevels, PartsThatDoNotTouchArePiecesAndThreeTrianglesAtAnEdgeStayWhole) {
  vps::VisualMesh mesh = Field(2, [](float, float) { return 0.0f; });
  vps::VisualPrimitive& primitive = mesh.primitives[0];
  const auto first = static_cast<std::uint32_t>(primitive.positions.size());
  for (const glm::vec3 p :
       {glm::vec3(1, 0, 0), glm::vec3(1, 1, 0), glm::vec3(2, 0, 0), glm::vec3(1, 0, 1), glm::vec3(1, 0, -1)}) {
    primitive.positions.push_back(p);
    primitive.normals.emplace_back(0, 0, 1);
  }
  for (const std::uint32_t k : {2u, 3u, 4u}) {
    for (const std::uint32_t i : {0u, 1u, k}) primitive.indices.push_back(first + i);
  }
  const std::vector<Piece> pieces = MakePieces(&mesh);
  ASSERT_EQ(pieces.size(), 2u);
  std::multiset<std::size_t> sizes;
  for (const Piece& piece : pieces) sizes.insert(piece.levels.size());
  EXPECT_EQ(*sizes.begin(), 2u) << "whole, and nothing";
  EXPECT_GT(*sizes.rbegin(), 3u);
}

}  // namespace
}  // namespace visual_node
