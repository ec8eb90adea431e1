#include "vps/mesh/check_mesh.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include "core/testing/backward_threads.hpp"
#include "vps/mesh/self_intersection.hpp"
#include "vps/mesh/winding_number.hpp"
#include "vps/testing/shapes.hpp"

namespace vps {
namespace {

using testing::HasSubstr;

TriangleMesh Moved(TriangleMesh mesh, const glm::dvec3& by) {
  for (auto& p : mesh.vertices) p += by;
  return mesh;
}

TriangleMesh TurnedOver(TriangleMesh mesh) {
  for (auto& t : mesh.triangles) std::swap(t[1], t[2]);
  return mesh;
}

// Two triangles in z = 0.
TriangleMesh Plate(double side_m) {
  const double h = 0.5 * side_m;
  return {{{-h, -h, 0}, {h, -h, 0}, {h, h, 0}, {-h, h, 0}}, {{0, 1, 2}, {0, 2, 3}}};
}

TEST(CheckMesh, FindsNothingInCleanSolids) {
  for (const auto& mesh : {MakeBox({1, 2, 3}), MakeSphere(1, 24), MakeTorus(1, 0.3, 24, 12), MakeCylinder(1, 2, 24),
                           MakeBlockWithHole(3, 1, 1, 24)}) {
    const auto checked = CheckMesh(mesh);
    ASSERT_TRUE(checked) << checked.error().detail;
    EXPECT_TRUE(checked->report.is_simple_solid);
    EXPECT_TRUE(DescribeDefects(checked->report).empty()) << DescribeDefects(checked->report)[0];
    EXPECT_EQ(checked->mesh.triangles.size(), mesh.triangles.size());
    EXPECT_EQ(checked->report.num_parts, 1U);
  }
}

TEST(CheckMesh, WorksAtTenMetresAndAtATenthOfAMillimetre) {
  for (const double size_m : {1e-4, 10.0}) {
    const auto checked = CheckMesh(MakeTorus(size_m, 0.3 * size_m, 48, 24));
    ASSERT_TRUE(checked) << checked.error().detail;
    EXPECT_TRUE(checked->report.is_simple_solid) << size_m;
    EXPECT_NEAR(checked->report.volume_m3 / std::pow(size_m, 3), 2 * std::numbers::pi * std::numbers::pi * 0.09, 0.05);
  }
}

TEST(CheckMesh, RefusesAMeshWithoutTriangles) {
  EXPECT_THAT(CheckMesh({}).error().detail, HasSubstr("no triangles"));
}

TEST(CheckMesh, RefusesCornersThatAreNoNumbers) {
  for (const double bad : {std::nan(""), std::numeric_limits<double>::infinity()}) {
    auto mesh = MakeBox({1, 1, 1});
    mesh.vertices[mesh.triangles[5][1]].y = bad;
    EXPECT_THAT(CheckMesh(mesh).error().detail, HasSubstr("not a finite number"));
  }
}

TEST(CheckMesh, RefusesIndicesOutOfRange) {
  auto mesh = MakeBox({1, 1, 1});
  mesh.triangles[7][2] = 99;
  EXPECT_THAT(CheckMesh(mesh).error().detail, HasSubstr("triangle 7 names vertex 99 of 8"));
}

TEST(CheckMesh, RefusesAMeshOfNothingButNeedles) {
  TriangleMesh mesh{{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}, {{0, 1, 2}, {0, 0, 1}}};
  EXPECT_THAT(CheckMesh(mesh).error().detail, HasSubstr("no triangle with an area: all 2"));
}

TEST(CheckMesh, DropsAndCountsTrianglesWithoutArea) {
  auto mesh = MakeBox({1, 1, 1});
  mesh.triangles.push_back({0, 0, 1});
  mesh.triangles.push_back({2, 2, 2});
  const auto checked = CheckMesh(mesh);
  ASSERT_TRUE(checked);
  EXPECT_EQ(checked->report.num_zero_area, 2U);
  EXPECT_EQ(checked->mesh.triangles.size(), 12U);
}

TEST(CheckMesh, KeepsANeedleThatHoldsTheSurfaceTogether) {
  // A tetrahedron with the middle of edge 0-1 used on one side only, and a needle between.
  TriangleMesh mesh{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0.5, 0, 0}},
                    {{0, 2, 4}, {4, 2, 1}, {0, 4, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}}};
  ASSERT_EQ(CountOpenEdges(mesh), 0U);
  const auto checked = CheckMesh(mesh);
  ASSERT_TRUE(checked) << checked.error().detail;
  EXPECT_EQ(checked->report.num_zero_area, 1U);
  EXPECT_EQ(CountOpenEdges(checked->mesh), 0U);
}

TEST(CheckMesh, WeldsRepeatedCornersAndCracks) {
  const auto box = MakeBox({1, 1, 1});
  TriangleMesh soup;  // every triangle with corners of its own, as in STL, some a hair off
  for (std::size_t i = 0; i < box.triangles.size(); ++i) {
    for (const auto& p : box.corners(i)) soup.vertices.push_back(p + glm::dvec3(i % 3 == 0 ? 2e-7 : 0.0));
    const auto n = static_cast<std::uint32_t>(soup.vertices.size());
    soup.triangles.push_back({n - 3, n - 2, n - 1});
  }
  const auto checked = CheckMesh(soup);
  ASSERT_TRUE(checked) << checked.error().detail;
  EXPECT_EQ(checked->report.num_vertices, 8U + checked->report.num_welded_near);
  EXPECT_EQ(checked->report.num_open_edges, 0U);
  EXPECT_GT(checked->report.num_welded_near, 0U);
}

TEST(CheckMesh, StitchesEdgesThatMeetSeveralShorterOnes) {
  // The top of a box on walls whose upper edges have corners of their own.
  TriangleMesh mesh = MakeBox({1, 1, 1});
  TriangleMesh split;
  split.vertices = mesh.vertices;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const auto [a, b, c] = mesh.corners(i);
    const auto& t = mesh.triangles[i];
    const bool is_wall = std::abs(glm::cross(b - a, c - a).z) < 0.5;
    int edge = -1;
    for (int k = 0; k < 3; ++k) {
      const glm::dvec3 middle = 0.5 * (mesh.vertices[t[k]] + mesh.vertices[t[(k + 1) % 3]]);
      if (is_wall && middle.z == 0.5) edge = k;
    }
    if (edge < 0) {
      split.triangles.push_back(t);
      continue;
    }
    const std::uint32_t p = t[edge], q = t[(edge + 1) % 3], r = t[(edge + 2) % 3];
    std::uint32_t last = p;
    for (const double s : {0.25, 0.5, 0.75}) {
      split.vertices.push_back((1 - s) * mesh.vertices[p] + s * mesh.vertices[q]);
      const auto v = static_cast<std::uint32_t>(split.vertices.size() - 1);
      split.triangles.push_back({last, v, r});
      last = v;
    }
    split.triangles.push_back({last, q, r});
  }
  ASSERT_GT(CountOpenEdges(split), 0U);
  const auto checked = CheckMesh(split);
  ASSERT_TRUE(checked) << checked.error().detail;
  EXPECT_EQ(checked->report.num_splits, 12U);
  EXPECT_TRUE(checked->report.is_simple_solid);
  EXPECT_NEAR(checked->report.volume_m3, 1.0, 1e-12);
}

TEST(CheckMesh, DropsALooseTriangle) {
  auto mesh = MakeSphere(0.5, 32);
  mesh.vertices.insert(mesh.vertices.end(), {{0.6, 0, 0}, {0.6, 0.1, 0}, {0.6, 0, 0.1}});
  const auto n = static_cast<std::uint32_t>(mesh.vertices.size());
  mesh.triangles.push_back({n - 3, n - 2, n - 1});
  const auto checked = CheckMesh(mesh);
  ASSERT_TRUE(checked) << checked.error().detail;
  EXPECT_EQ(checked->report.num_loose, 1U);
  EXPECT_EQ(checked->mesh.triangles.size(), mesh.triangles.size() - 1);
  EXPECT_TRUE(checked->report.is_simple_solid);
}

TEST(CheckMesh, RefusesAMissingRing) {
  // A long tube without its upper end face: lids over both loops would block the bore.
  auto mesh = MakeBlockWithHole(1, 30, 0.3, 24);
  std::erase_if(mesh.triangles, [&](const auto& t) {
    return mesh.vertices[t[0]].z > 14 && mesh.vertices[t[1]].z > 14 && mesh.vertices[t[2]].z > 14;
  });
  EXPECT_THAT(CheckMesh(mesh).error().detail, HasSubstr("ring-shaped face is missing around (0, 0, 15) m"));
}

TEST(CheckMesh, DropsDoubledTriangles) {
  auto mesh = MakeBox({1, 1, 1});
  mesh.triangles.push_back(mesh.triangles[3]);
  const auto checked = CheckMesh(mesh);
  ASSERT_TRUE(checked) << checked.error().detail;
  EXPECT_EQ(checked->report.num_doubled, 1U);
  EXPECT_TRUE(checked->report.is_simple_solid);
}

TEST(CheckMesh, RemovesTheWallBetweenTwoSolidsThatShareAFace) {
  const auto pair = Joined(MakeBox({1, 1, 1}), Moved(MakeBox({1, 1, 1}), {1, 0, 0}));
  const auto checked = CheckMesh(pair);
  ASSERT_TRUE(checked) << checked.error().detail;
  EXPECT_NEAR(checked->report.volume_m3, 2.0, 1e-12);
  if (checked->report.num_doubled > 0) {  // where both faces have the same diagonal
    EXPECT_EQ(checked->report.num_doubled, 4U);
    EXPECT_NEAR(checked->report.area_m2, 10.0, 1e-12);
  }
}

TEST(CheckMesh, TurnsAnInsideOutSolid) {
  const auto checked = CheckMesh(TurnedOver(MakeTorus(1, 0.3, 24, 12)));
  ASSERT_TRUE(checked);
  EXPECT_EQ(checked->report.num_triangles_turned, 576U);
  EXPECT_EQ(checked->report.num_parts_turned, 1U);
  EXPECT_GT(checked->report.volume_m3, 0.0);
}

TEST(CheckMesh, TurnsSingleTrianglesAndNamesThem) {
  auto mesh = MakeSphere(0.5, 32);
  for (const std::size_t i : {17U, 18U, 400U}) std::swap(mesh.triangles[i][0], mesh.triangles[i][1]);
  const auto checked = CheckMesh(mesh);
  ASSERT_TRUE(checked);
  EXPECT_EQ(checked->report.num_triangles_turned, 3U);
  EXPECT_EQ(checked->report.turned[2].triangle, 400U);
  EXPECT_TRUE(checked->report.is_simple_solid);
  EXPECT_THAT(DescribeDefects(checked->report)[0], HasSubstr("triangle 400"));
}

TEST(CheckMesh, KeepsCavitiesWhicheverWayTheFileFaces) {
  const auto hollow = Joined(MakeBox({1, 1, 1}), TurnedOver(MakeBox({0.5, 0.5, 0.5})));
  for (const auto& mesh : {hollow, TurnedOver(hollow)}) {
    const auto checked = CheckMesh(mesh);
    ASSERT_TRUE(checked);
    EXPECT_NEAR(checked->report.volume_m3, 1.0 - 0.125, 1e-12);
  }
}

TEST(CheckMesh, TurnsOneOfTwoPartsSideBySide) {
  const auto checked = CheckMesh(Joined(MakeBox({1, 1, 1}), TurnedOver(Moved(MakeBox({1, 1, 1}), {3, 0, 0}))));
  ASSERT_TRUE(checked);
  EXPECT_EQ(checked->report.num_parts, 2U);
  EXPECT_EQ(checked->report.num_parts_turned, 1U);
  EXPECT_NEAR(checked->report.volume_m3, 2.0, 1e-12);
}

TEST(CheckMesh, ClosesSmallHolesAndNamesThem) {
  auto mesh = MakeSphere(0.5, 64);
  const glm::dvec3 removed = mesh.corners(900)[0];
  mesh.triangles.erase(mesh.triangles.begin() + 900);
  mesh.triangles.erase(mesh.triangles.begin() + 200, mesh.triangles.begin() + 203);
  const auto checked = CheckMesh(mesh);
  ASSERT_TRUE(checked) << checked.error().detail;
  EXPECT_EQ(CountOpenEdges(checked->mesh), 0U);
  EXPECT_GE(checked->report.num_holes, 2U);
  EXPECT_NEAR(checked->report.volume_m3, CheckMesh(MakeSphere(0.5, 64))->report.volume_m3, 2e-4);
  double nearest = 1.0;
  for (const MeshHole& hole : checked->report.holes) {
    nearest = std::min(nearest, glm::length(hole.place.p_m - removed));
  }
  EXPECT_LT(nearest, 0.05);
}

TEST(CheckMesh, RefusesAnOpenSurfaceUnlessItIsASheet) {
  const auto refused = CheckMesh(Plate(0.1));
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().detail, HasSubstr("4 open edges"));
  EXPECT_THAT(refused.error().detail, HasSubstr("(0, 0, 0) m"));
  EXPECT_THAT(refused.error().detail, HasSubstr("sheet_thickness_m"));
  const auto sheet = CheckMesh(Plate(0.1), true);
  ASSERT_TRUE(sheet);
  EXPECT_EQ(sheet->report.num_open_edges, 4U);
  EXPECT_EQ(sheet->mesh.triangles.size(), 2U);
  auto lidless = MakeBox({1, 1, 1});
  lidless.triangles.resize(10);
  EXPECT_FALSE(CheckMesh(lidless));
}

TEST(CheckMesh, RefusesPolygonSoupUnlessItIsASheet) {
  std::mt19937_64 engine(1);
  TriangleMesh soup;
  for (std::uint32_t i = 0; i < 300; ++i) {
    soup.vertices.push_back(1e-19 * glm::dvec3(engine(), engine(), engine()));
    if (i % 3 == 2) soup.triangles.push_back({i - 2, i - 1, i});
  }
  EXPECT_THAT(CheckMesh(soup).error().detail, HasSubstr("is open: 300 open edges"));
  EXPECT_TRUE(CheckMesh(soup, true));
}

TEST(CheckMesh, RefusesTwoCoincidentLayers) {
  const auto both = Joined(Plate(0.1), TurnedOver(Plate(0.1)));
  EXPECT_THAT(CheckMesh(both).error().detail, HasSubstr("encloses no volume"));
  const auto sheet = CheckMesh(both, true);
  ASSERT_TRUE(sheet);
  EXPECT_EQ(sheet->mesh.triangles.size(), 2U);
}

TEST(CheckMesh, NamesAMoebiusStripsConflict) {
  TriangleMesh strip;
  constexpr std::uint32_t kSteps = 24;
  for (std::uint32_t i = 0; i < kSteps; ++i) {
    const double a = 2 * std::numbers::pi * i / kSteps;
    const glm::dvec3 radial(std::cos(a), std::sin(a), 0);
    const glm::dvec3 across = std::cos(0.5 * a) * radial + glm::dvec3(0, 0, std::sin(0.5 * a));
    strip.vertices.push_back(radial - 0.2 * across);
    strip.vertices.push_back(radial + 0.2 * across);
  }
  for (std::uint32_t i = 0; i < kSteps; ++i) {
    const bool is_last = i + 1 == kSteps;
    const std::uint32_t a = 2 * i, b = 2 * i + 1, c = is_last ? 1 : a + 2, d = is_last ? 0 : a + 3;
    strip.triangles.push_back({a, c, b});
    strip.triangles.push_back({b, c, d});
  }
  EXPECT_FALSE(CheckMesh(strip));
  const auto sheet = CheckMesh(strip, true);
  ASSERT_TRUE(sheet);
  EXPECT_GT(sheet->report.num_conflicts, 0U);
}

TEST(CheckMesh, CountsEdgesOfMoreThanTwoTriangles) {
  const auto pair = Joined(MakeBox({1, 1, 1}), Moved(MakeBox({1, 1, 1}), {1, 1, 0}));  // share one edge
  const auto checked = CheckMesh(pair);
  ASSERT_TRUE(checked) << checked.error().detail;
  EXPECT_EQ(checked->report.num_many_sided_edges, 1U);
  EXPECT_LT(glm::length(checked->report.many_sided_edges[0].p_m - glm::dvec3(0.5, 0.5, 0)), 1e-12);
  EXPECT_NEAR(checked->report.volume_m3, 2.0, 1e-12);
}

TEST(CheckMesh, NamesWhereSolidsPassThroughEachOther) {
  const auto checked = CheckMesh(Joined(MakeBox({1, 1, 1}), Moved(MakeBox({1, 1, 1}), {0.7, 0.6, 0.4})));
  ASSERT_TRUE(checked);
  EXPECT_GT(checked->report.num_crossings, 0U);
  EXPECT_FALSE(checked->report.is_simple_solid);
  for (const MeshPlace& place : checked->report.crossings) {  // on both boxes
    const glm::dvec3 p = place.p_m;
    EXPECT_NEAR(std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)}), 0.5, 1e-12);
  }
  const WindingNumber winding(checked->mesh);
  EXPECT_NEAR(winding.At({0.35, 0.3, 0.2}), 2.0, 0.05);
  EXPECT_NEAR(winding.At({-0.4, 0, 0}), 1.0, 0.05);
}

TEST(FindCrossings, FindsTheCircleWhereTwoBallsMeetAndStopsAtItsBound) {
  EXPECT_TRUE(FindCrossings(MakeSphere(1, 48), 1000).empty());
  const auto two = Joined(MakeSphere(1, 48), Moved(MakeSphere(1, 48), {0.77, 0.13, 0.31}));
  const auto crossings = FindCrossings(two, 100000);
  EXPECT_GT(crossings.size(), 100U);
  // The circle where two unit spheres meet lies in the plane halfway between their centres.
  const glm::dvec3 half = 0.5 * glm::dvec3(0.77, 0.13, 0.31);
  for (const Crossing& crossing : crossings) {
    EXPECT_NEAR(glm::dot(crossing.p_m - half, glm::normalize(half)), 0.0, 0.02);
  }
  EXPECT_EQ(FindCrossings(two, 10).size(), 10U);
  // In the same order with several workers, which begin with the last.
  core::test::BackwardThreads workers(3);
  for (const std::size_t most : {std::size_t{10}, std::size_t{100000}}) {
    const auto alone = FindCrossings(two, most);
    const auto shared = FindCrossings(two, most, &workers);
    ASSERT_EQ(shared.size(), alone.size());
    for (std::size_t i = 0; i < alone.size(); ++i) {
      EXPECT_EQ(shared[i].a, alone[i].a);
      EXPECT_EQ(shared[i].b, alone[i].b);
    }
  }
}

TEST(FindIntersectingTriangles, MarksCrossingsAndCoplanarOverlaps) {
  const TriangleMesh plate = MakeBox({1, 1, 0.2});
  EXPECT_FALSE(HasSelfIntersection(plate));
  EXPECT_FALSE(HasSelfIntersection(MakeTorus(0.1, 0.03, 48, 24)));
  // Beside each other in one plane, with a gap, and touching along an edge.
  EXPECT_FALSE(HasSelfIntersection(Joined(plate, Moved(plate, {1.5, 0, 0}))));
  EXPECT_FALSE(HasSelfIntersection(Joined(plate, Moved(plate, {1.0, 1.0, 0}))));
  // A small block upon it: its two lower triangles, and those of the plate's face that they cover.
  const auto standing = Joined(plate, Moved(MakeBox({0.1, 0.1, 0.5}), {0.3, -0.2, 0.35}));
  EXPECT_TRUE(HasSelfIntersection(standing));
  EXPECT_TRUE(FindCrossings(standing, 10).empty());
  const auto is_intersecting = FindIntersectingTriangles(standing);
  for (std::uint32_t t = 0; t < standing.triangles.size(); ++t) {
    const auto corners = standing.corners(t);
    const bool is_in_the_plane =
        std::all_of(corners.begin(), corners.end(), [](const glm::dvec3& p) { return std::abs(p.z - 0.1) < 1e-12; });
    const bool is_of_the_block = t >= plate.triangles.size();
    if (!is_in_the_plane || is_of_the_block) {
      EXPECT_EQ(is_intersecting[t] != 0, is_in_the_plane) << t;
    }
  }
  EXPECT_EQ(std::count(is_intersecting.begin(), is_intersecting.end(), 1), 3);  // the face's other half is free
}

TEST(WindingNumber, IsOneInsideAndZeroOutside) {
  const auto mesh = MakeTorus(0.1, 0.03, 96, 48);
  const WindingNumber winding(mesh);
  std::mt19937_64 engine(5);
  for (int i = 0; i < 20000; ++i) {
    const auto random = [&] { return static_cast<double>(engine() >> 11) * 0x1p-53 * 2.0 - 1.0; };
    const glm::dvec3 p = 0.15 * glm::dvec3(random(), random(), random());
    const double d = std::hypot(std::hypot(p.x, p.y) - 0.1, p.z) - 0.03;
    if (std::abs(d) < 1e-4) continue;
    ASSERT_NEAR(winding.At(p), d < 0 ? 1.0 : 0.0, 0.05) << p.x << " " << p.y << " " << p.z;
  }
}

}  // namespace
}  // namespace vps
