#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <set>
#include <string>
#include <vector>

#include "core/pose.hpp"
#include "core/testing/backward_threads.hpp"
#include "vps/field/build_field.hpp"
#include "vps/mesh/load_mesh.hpp"
#include "vps/oracle/exact_distance.hpp"
#include "vps/oracle/mesh_distance.hpp"
#include "vps/testing/case_random.hpp"
#include "vps/testing/shapes.hpp"

namespace vps {
namespace {

glm::vec3 InVoxels(const DistanceField& field, const glm::dvec3& p) {
  return glm::vec3((p - field.origin_m) / field.voxel_size_m);
}

struct Errors {
  double mean = 0.0, p95 = 0.0, max = 0.0;
  glm::dvec3 worst{0.0};
};

// Field against the exact distance at random places within 1.5 voxels of the surface, in voxels.
Errors Measure(const TriangleMesh& mesh, const DistanceField& field, int count) {
  const oracle::ExactDistance exact(mesh);
  CaseRandom random(7);
  std::vector<double> errors;
  Errors e;
  while (static_cast<int>(errors.size()) < count) {
    const auto corners =
        mesh.corners(static_cast<std::size_t>(random.Unit() * static_cast<double>(mesh.triangles.size())));
    double u = random.Unit();
    double v = random.Unit();
    if (u + v > 1.0) u = 1.0 - u, v = 1.0 - v;
    const glm::dvec3 p = corners[0] + u * (corners[1] - corners[0]) + v * (corners[2] - corners[0]) +
                         1.5 * field.voxel_size_m * random.InCube();
    const double d = exact.SignedDistance(p) / field.voxel_size_m;
    if (std::abs(d) > 1.5) continue;
    errors.push_back(std::abs(SampleField(field, InVoxels(field, p)).distance - d));
    e.mean += errors.back() / count;
    if (errors.back() > e.max) e.max = errors.back(), e.worst = p;
  }
  std::sort(errors.begin(), errors.end());
  e.p95 = errors[errors.size() * 95 / 100];
  return e;
}

void ExpectAccurate(const char* name, const TriangleMesh& mesh, double voxel_size_m) {
  const auto field = BuildField(mesh, voxel_size_m);
  ASSERT_TRUE(field);
  const Errors e = Measure(mesh, *field, 2000);
  std::printf("%-28s s = %.3g mm: error mean %.4f, p95 %.4f, max %.3f voxels; %zu creases, %.1f MB\n", name,
              1e3 * voxel_size_m, e.mean, e.p95, e.max, field->creases.size() / kPlanesPerCrease,
              static_cast<double>(field->num_bytes()) * 1e-6);
  EXPECT_LE(e.mean, 0.02) << name;
  EXPECT_LE(e.p95, 0.1) << name;
  EXPECT_LE(e.max, 0.3) << name << " at " << e.worst.x << " " << e.worst.y << " " << e.worst.z;
}

TEST(DistanceField, NearTheSurfaceTheErrorIsAFewHundredthsOfAVoxel) {
  ExpectAccurate("box", MakeBox({0.03, 0.021, 0.0417}), 0.001);
  ExpectAccurate("torus", MakeTorus(0.03, 0.01, 64, 32), 0.0005);
  ExpectAccurate("sphere", MakeSphere(0.02, 48), 0.001);
  ExpectAccurate("cylinder", MakeCylinder(0.01, 0.03, 64), 0.0005);
  ExpectAccurate("block with hole", MakeBlockWithHole(0.03, 0.02, 0.01005, 128), 0.00025);
}

TEST(DistanceField, PartsOfTheScenesAreAsAccurateAsShapes) {
  for (const char* file : {"peg_in_hole/meshes/hole.obj", "peg_in_hole/meshes/peg.obj",
                           "module_replacement/meshes/module.obj", "module_replacement/meshes/jaw_left.obj"}) {
    const auto mesh = LoadMesh(std::string(VR_OOS_SOURCE_DIR "/scenarios/") + file);
    if (!mesh) continue;
    ExpectAccurate(file, *mesh, 0.0005);
  }
}

TEST(DistanceField, ATurnedBoxHasSharpEdgesInsideAndOut) {
  TriangleMesh box = MakeBox({0.03, 0.02, 0.04});
  const glm::dmat3 R = glm::mat3_cast(core::QuaternionFromRotationVector({0.3, 0.5, 0.7}));
  for (glm::dvec3& v : box.vertices) v = R * v;
  ExpectAccurate("turned box", box, 0.001);
}

// Scanned parts: several facets in every cell, none of which represents the cell.
TEST(DistanceField, RoughFacetsSmallerThanAVoxelKeepTheBoundsAndCauseNoBias) {
  constexpr double kVoxel = 0.001;
  TriangleMesh rough = MakeSphere(0.012, 96);  // facets of 0.8 voxel
  CaseRandom random(5);
  for (glm::dvec3& v : rough.vertices) v *= 1.0 + 0.1 * kVoxel / 0.012 * random.Signed();
  ExpectAccurate("rough sphere", rough, kVoxel);
  const auto field = BuildField(rough, kVoxel);
  ASSERT_TRUE(field);
  const oracle::MeshDistance exact(rough);
  double bias = 0.0;
  constexpr int kCount = 2000;
  for (int i = 0; i < kCount; ++i) {
    const glm::dvec3 p = (0.012 + 0.0003 * random.Signed()) * glm::normalize(random.InCube() + glm::dvec3(1e-9));
    bias += (SampleField(*field, InVoxels(*field, p)).distance - exact.SignedDistance(p) / kVoxel) / kCount;
  }
  EXPECT_LE(std::abs(bias), 0.004);
}

// A tangent plane differs from the mean over its voxel by the curvature / 24, here a third of the step in which words
// hold distances: 1/1200 voxel, one percent of the depth of a peg that touches its hole by a tenth of a voxel.
TEST(DistanceField, ReconstructsAGentlyCurvedWallWithoutBias) {
  const TriangleMesh block = MakeBlockWithHole(0.03, 0.02, 0.01, 512);
  const double s = 3e-4;
  const DistanceField field = *BuildField(block, s);
  const oracle::MeshDistance exact(block);
  CaseRandom random(3);
  double sum = 0.0;
  constexpr int kCount = 20000;
  for (int i = 0; i < kCount; ++i) {
    const double phi = M_PI * random.Signed();
    const double r = 0.01 + 0.5 * s * random.Signed();
    const glm::dvec3 p(r * std::cos(phi), r * std::sin(phi), 0.005 * random.Signed());
    sum += static_cast<double>(SampleField(field, InVoxels(field, p)).distance) - exact.SignedDistance(p) / s;
  }
  EXPECT_LT(std::abs(sum / kCount), 2e-4);  // a tenth of the planes' rounding
}

TEST(DistanceField, DeepInsideAndFarOutsideDepthAndDirectionAreRight) {
  const TriangleMesh sphere = MakeSphere(0.05, 96);
  const auto field = BuildField(sphere, 0.0005);
  ASSERT_TRUE(field);
  CaseRandom random(3);
  for (int i = 0; i < 2000; ++i) {
    const glm::dvec3 n = glm::normalize(random.InCube() + glm::dvec3(1e-9));
    const double r = 0.01 + 0.042 * random.Unit();
    const FieldSample sample = SampleField(*field, InVoxels(*field, r * n));
    // A cell's plane is off by e^2 / 2r, e at most half its diagonal.
    const double e_m = std::max(0.5 * 1.74 * static_cast<double>(sample.cell), 1.0) * field->voxel_size_m;
    ASSERT_NEAR(sample.distance * 0.0005, r - 0.05, e_m * e_m / (2.0 * (r - e_m)) + 8e-5) << r;
    ASSERT_GT(glm::dot(glm::normalize(glm::dvec3(sample.gradient)), n),
              1.0 - 0.5 * e_m * e_m / ((r - e_m) * (r - e_m)) - 2e-3)
        << r;
  }
}

// The bound of culling: the exact distance differs from that at the cell's centre by no more than the distance between.
TEST(DistanceField, CentreDistanceIsAConservativeBound) {
  const TriangleMesh mesh = MakeBlockWithHole(0.03, 0.02, 0.01, 64);
  const auto field = BuildField(mesh, 0.0005);
  ASSERT_TRUE(field);
  const oracle::ExactDistance exact(mesh);
  CaseRandom random(5);
  for (int i = 0; i < 4000; ++i) {
    const glm::dvec3 p = 0.03 * random.InCube();
    const glm::vec3 q = InVoxels(*field, p);
    const FieldSample sample = SampleField(*field, q);
    const double d = exact.SignedDistance(p) / field->voxel_size_m;
    ASSERT_LE(sample.centre_distance - sample.centre_offset, d + 0.31) << i;
  }
}

// Beyond the band, too: beside edges, in notches and behind thin walls, where the tangent at a coarse cell's centre
// passes through the surface in one of its far voxels: contact in free space, or too much depth.
TEST(DistanceField, FarPointsHaveTheRightSignAndAreFar) {
  TriangleMesh turned = MakeBox({0.06, 0.05, 0.003});  // walls of 3 to 12 voxels
  const glm::dmat3 R = glm::mat3_cast(core::QuaternionFromRotationVector({0.3, 0.5, 0.7}));
  for (glm::dvec3& v : turned.vertices) v = R * v;
  const std::pair<TriangleMesh, double> cases[] = {{MakeBlockWithHole(0.05, 0.05, 0.01025, 128), 0.00025},
                                                   {MakeBlockWithHole(0.03, 0.02, 0.01, 64), 0.001},
                                                   {turned, 0.00025},
                                                   {turned, 0.001},
                                                   {MakeTorus(0.03, 0.004, 96, 48), 0.00025}};
  CaseRandom random(11);
  for (const auto& [mesh, voxel_size_m] : cases) {
    const auto field = BuildField(mesh, voxel_size_m);
    ASSERT_TRUE(field);
    const oracle::MeshDistance exact(mesh);
    int num_far = 0;
    int num_off = 0;  // nearer than that, and off by more than 1.5 voxels
    for (int i = 0; i < 20000; ++i) {
      const auto corners = mesh.corners(i % mesh.triangles.size());
      const double u = random.Unit();
      const glm::dvec3 p = corners[0] + u * (corners[1] - corners[0]) +
                           random.Unit() * (1.0 - u) * (corners[2] - corners[0]) + 9.0 * voxel_size_m * random.InCube();
      const double d = exact.SignedDistance(p) / voxel_size_m;
      const float sampled = SampleField(*field, InVoxels(*field, p)).distance;
      num_off += std::abs(d) < 3.5 && std::abs(sampled - d) > 1.5 ? 1 : 0;
      if (std::abs(d) < 4.0) continue;
      ++num_far;
      ASSERT_GT(d < 0.0 ? -sampled : sampled, 1.0f)
          << "exact " << d << ", voxels of " << voxel_size_m << " m, shift " << field->coarse_shift;
    }
    EXPECT_GT(num_far, 1000);
    EXPECT_LE(num_off, 5) << "shift " << field->coarse_shift;
  }
}

// Deep inside, in coarse cells: tangent planes overestimate the depth, which is the least of several distances. Without
// ComputeMeanDepths the mean is off by 0.04 to 0.09 voxel.
TEST(DistanceField, DepthsBeyondTheBandAreRightInTheMean) {
  TriangleMesh turned = MakeBox({0.05, 0.04, 0.03});
  const glm::dmat3 R = glm::mat3_cast(core::QuaternionFromRotationVector({0.3, 0.5, 0.7}));
  for (glm::dvec3& v : turned.vertices) v = R * v;
  const double voxel_size_m = 0.0005;
  CaseRandom random(17);
  for (const TriangleMesh& mesh : {MakeSphere(0.025, 64), turned, MakeBlockWithHole(0.05, 0.05, 0.01, 64)}) {
    const auto field = BuildField(mesh, voxel_size_m);
    ASSERT_TRUE(field);
    const oracle::MeshDistance exact(mesh);
    double sum = 0.0;
    int count = 0;
    for (int i = 0; i < 40000; ++i) {
      const glm::dvec3 p = 0.03 * random.InCube();
      const double d = exact.SignedDistance(p) / voxel_size_m;
      if (d > -4.0) continue;
      sum += static_cast<double>(SampleField(*field, InVoxels(*field, p)).distance) - d;
      ++count;
    }
    ASSERT_GT(count, 1000);
    EXPECT_NEAR(sum / count, 0.0, 0.033);
  }
}

// The bounds of a coarse cell hold for every point around it, creases and the edge of the band included.
TEST(DistanceField, CellBoundsHoldAtEveryPoint) {
  for (const bool is_block : {true, false}) {
    const auto field = is_block ? BuildField(MakeBlockWithHole(0.03, 0.02, 0.01, 64), 0.0005)
                                : BuildField(MakeTorus(0.03, 0.01, 64, 32), 0.0005);
    ASSERT_TRUE(field);
    CaseRandom random(8);
    const int side = 1 << field->coarse_shift;
    const glm::ivec3 n(field->nx / side, field->ny / side, field->nz / side);
    const glm::vec3 last = glm::vec3(field->nx, field->ny, field->nz) - 0.5f;
    int num_wide = 0;
    int num_close = 0;
    for (int i = 0; i < 300000; ++i) {
      const glm::ivec3 c(glm::dvec3(n) * glm::dvec3(random.Unit(), random.Unit(), random.Unit()));
      const CoarseCell& cell = field->coarse[static_cast<std::size_t>((c.z * n.y + c.y) * n.x + c.x)];
      const glm::vec3 centre = (glm::vec3(c) + 0.5f) * static_cast<float>(side);
      const std::uint32_t wide = std::bit_cast<std::uint32_t>(cell.distance) & 0xffU;
      const glm::vec3 p = centre + (0.5f * static_cast<float>(side) + kWideMargin) * glm::vec3(random.InCube());
      if (wide != 0 && glm::all(glm::greaterThan(p, glm::vec3(0.0f))) && glm::all(glm::lessThan(p, last))) {
        ++num_wide;
        const float plane = cell.distance + glm::dot(CoarseGradientOf(cell.gradient), p - centre);
        ASSERT_GE(SampleField(*field, p).distance, plane - static_cast<float>(wide - 1) / kFallSteps);
      }
      // From a voxel of the cell that is a plane near the surface.
      const std::uint32_t close = cell.gradient >> 24;
      const glm::ivec3 v =
          c * side + glm::ivec3(glm::dvec3(side) * glm::dvec3(random.Unit(), random.Unit(), random.Unit()));
      const std::uint32_t word =
          field->words[field->bricks[static_cast<std::size_t>(
                           ((v.z >> 3) * (field->ny >> 3) + (v.y >> 3)) * (field->nx >> 3) + (v.x >> 3))] +
                       WordInBrick(v.x, v.y, v.z)];
      if (close == 0 || KindOf(word) != CellKind::kPlane || std::abs(DistanceOf(word)) > kMostAnchorDistance) continue;
      ++num_close;
      const glm::vec3 e = (0.5f + kCloseRadius) * glm::vec3(random.InCube());
      const float plane = DistanceOf(word) + glm::dot(GradientOf(word), e);
      ASSERT_GE(SampleField(*field, glm::vec3(v) + 0.5f + e).distance,
                plane - static_cast<float>(close - 1) / kFallSteps);
    }
    EXPECT_GT(num_wide, 15000);
    EXPECT_GT(num_close, 2000);
  }
}

TEST(DistanceField, WordsKeepDistanceAndDirection) {
  CaseRandom random(1);
  for (int i = 0; i < 100000; ++i) {
    const glm::vec3 n(glm::normalize(random.InCube() + glm::dvec3(0, 0, 1e-9)));
    const auto d = static_cast<float>(3.9 * random.Signed());
    const std::uint32_t word = EncodePlane(d, n);
    ASSERT_EQ(KindOf(word), CellKind::kPlane);
    ASSERT_NEAR(DistanceOf(word), d, 0.5f / kDistanceSteps + 1e-6f);
    ASSERT_LT(glm::length(GradientOf(word) - n), 0.014f);
    ASSERT_LT(glm::length(CoarseGradientOf(EncodeCoarseGradient(n)) - n), 0.007f);
  }
}

TEST(DistanceField, IsTheSameBitForBitOnAnyNumberOfThreads) {
  const TriangleMesh mesh = MakeBlockWithHole(0.03, 0.02, 0.01005, 96);
  const auto serial = BuildField(mesh, 0.0004);
  ASSERT_TRUE(serial);
  for (const std::size_t threads : {1, 2, 5}) {
    core::test::BackwardThreads workers(threads);
    const auto field = BuildField(mesh, 0.0004, {.workers = &workers});
    ASSERT_TRUE(field);
    EXPECT_EQ(field->bricks, serial->bricks) << threads;
    EXPECT_EQ(field->words, serial->words) << threads;
    EXPECT_EQ(field->creases, serial->creases) << threads;
    ASSERT_EQ(field->coarse.size(), serial->coarse.size());
    EXPECT_EQ(std::memcmp(field->coarse.data(), serial->coarse.data(), field->coarse.size() * sizeof(CoarseCell)), 0);
  }
}

std::size_t CountUsedPlaces(const DistanceField& field) {
  return field.bricks.size() - static_cast<std::size_t>(std::count(field.bricks.begin(), field.bricks.end(), 0U));
}

TEST(DistanceField, KeepsEqualBricksOnce) {
  // Edges, corners and what faces share: each of a box's face is one brick again and again.
  const auto field = BuildField(MakeBox({0.03, 0.02, 0.04}), 0.0002);
  ASSERT_TRUE(field);
  std::set<std::vector<std::uint32_t>> bricks;
  for (auto at = field->words.begin(); at != field->words.end(); at += DistanceField::kBrickWords) {
    EXPECT_TRUE(bricks.emplace(at, at + DistanceField::kBrickWords).second);
  }
  EXPECT_GT(CountUsedPlaces(*field), 4 * bricks.size());
}

// The estimate is enough, and at most 2.5 times as much as needed unless bricks are alike, from a part of a few bricks
// to one of thousands.
TEST(DistanceField, EstimatesItsMemoryFromAbove) {
  struct Case {
    const char* name;
    TriangleMesh mesh;
    double voxel_size_m;
  };
  for (const Case& c :
       {Case{"box of 5 voxels", MakeBox({0.005, 0.005, 0.005}), 0.001},
        Case{"box", MakeBox({0.03, 0.02, 0.04}), 0.0002}, Case{"fine torus", MakeTorus(0.03, 0.01, 128, 64), 0.0004},
        Case{"block with hole", MakeBlockWithHole(0.05, 0.05, 0.01, 64), 0.00025},
        Case{"rod", MakeCylinder(0.001, 0.2, 32), 0.0005}}) {
    const auto estimate = EstimateField(c.mesh, c.voxel_size_m);
    const auto field = BuildField(c.mesh, c.voxel_size_m);
    ASSERT_TRUE(estimate && field) << c.name;
    const auto stored = static_cast<double>(field->num_bytes());
    EXPECT_GE(estimate->stored_bytes, stored) << c.name;
    const double if_all_differ = stored - 4.0 * static_cast<double>(field->words.size()) +
                                 4.0 * static_cast<double>(CountUsedPlaces(*field) * DistanceField::kBrickWords);
    EXPECT_LE(estimate->stored_bytes, 2.5 * if_all_differ + 1e5) << c.name;
    EXPECT_GE(estimate->peak_bytes, estimate->stored_bytes) << c.name;
    EXPECT_LE(estimate->peak_bytes, 3.0 * estimate->stored_bytes + 1e7) << c.name;
  }
}

TEST(DistanceField, RefusesMoreMemoryThanAllowed) {
  const TriangleMesh box = MakeBox({0.1, 0.1, 0.1});
  const auto estimate = EstimateField(box, 0.0005);
  ASSERT_TRUE(estimate);
  EXPECT_TRUE(BuildField(box, 0.0005, {.max_peak_bytes = 1.01 * estimate->peak_bytes}));
  const auto refused = BuildField(box, 0.0005, {.max_peak_bytes = 0.99 * estimate->peak_bytes});
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, core::ErrorCode::kResource);
  EXPECT_NE(refused.error().detail.find("MB"), std::string::npos) << refused.error().detail;
}

TEST(DistanceField, ProgressRunsFromNothingToAll) {
  std::vector<double> reported;
  ASSERT_TRUE(BuildField(MakeSphere(0.02, 32), 0.0005,
                         {.progress = [&](std::string_view, double fraction) { reported.push_back(fraction); }}));
  ASSERT_GT(reported.size(), 4U);
  EXPECT_TRUE(std::is_sorted(reported.begin(), reported.end()));
  EXPECT_EQ(reported.front(), 0.0);
  EXPECT_EQ(reported.back(), 1.0);
}

TEST(DistanceField, RefusesWhatCannotBeBuilt) {
  EXPECT_FALSE(BuildField({}, 0.001));
  EXPECT_FALSE(BuildField(MakeBox({1, 1, 1}), 0.0));
  EXPECT_FALSE(BuildField(MakeBox({1, 1, 1}), std::nan("")));
  const auto huge = BuildField(MakeBox({1000, 1000, 1000}), 1e-4);  // millimetres taken for metres
  ASSERT_FALSE(huge);
  EXPECT_EQ(huge.error().code, core::ErrorCode::kResource);
}

}  // namespace
}  // namespace vps
