#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "vps/mesh/load_mesh.hpp"
#include "vps/oracle/exact_distance.hpp"
#include "vps/pointshell/pointshell.hpp"
#include "vps/testing/brute_force.hpp"
#include "vps/testing/case_random.hpp"
#include "vps/testing/shapes.hpp"
#include "vps/voxmap/build_voxmap.hpp"
#include "vps/voxmap/distance_transform.hpp"

namespace vps {
namespace {

struct ErrorStatistics {
  double mean_voxels = 0.0;
  double rms_voxels = 0.0;
  double max_voxels = 0.0;
  int count = 0;
};

// V(P) of Eq. 1 against the exact signed distance of the mesh. Points are put around the surface, each with the normal
// of the exact distance (its gradient by differences, so a flat contact is assumed, as Eq. 1 does).
ErrorStatistics CompareWithOracle(const TriangleMesh& mesh, double voxel_size_m, double band_voxels, int count) {
  const Voxmap field = *BuildVoxmap(mesh, voxel_size_m);
  const oracle::ExactDistance exact(mesh);
  const auto shell = *BuildPointshell(mesh, 500);
  CaseRandom random(23);
  ErrorStatistics errors;
  while (errors.count < count) {
    const std::size_t i = static_cast<std::size_t>((random.Signed() + 1.0) * 0.5 * 500.0);
    const glm::dvec3 p = shell.points_m[i] + band_voxels * voxel_size_m * random.InCube();
    const double d = exact.SignedDistance(p);
    if (std::abs(d) > band_voxels * voxel_size_m) continue;
    const double h = 1e-3 * voxel_size_m;
    const glm::dvec3 gradient(
        exact.SignedDistance(p + glm::dvec3(h, 0, 0)) - exact.SignedDistance(p - glm::dvec3(h, 0, 0)),
        exact.SignedDistance(p + glm::dvec3(0, h, 0)) - exact.SignedDistance(p - glm::dvec3(0, h, 0)),
        exact.SignedDistance(p + glm::dvec3(0, 0, h)) - exact.SignedDistance(p - glm::dvec3(0, 0, h)));
    if (glm::length(gradient) < 1.9 * h) continue;  // on the medial axis there is no one normal
    PointTree point;
    point.num_points = 1;
    const glm::dvec3 n = glm::normalize(gradient);  // out of the field: the inward normal of a sampled object there
    point.x = {static_cast<float>(p.x)};
    point.y = {static_cast<float>(p.y)};
    point.z = {static_cast<float>(p.z)};
    point.nx = {static_cast<float>(n.x)};
    point.ny = {static_cast<float>(n.y)};
    point.nz = {static_cast<float>(n.z)};
    const auto hits = QueryBruteForce(point, field, core::Pose{}, 1.0);
    if (hits.empty()) continue;  // beyond the grid
    const double error = (static_cast<double>(hits[0].penetration_m) + d) / voxel_size_m;
    errors.mean_voxels += error;
    errors.rms_voxels += error * error;
    errors.max_voxels = std::max(errors.max_voxels, std::abs(error));
    ++errors.count;
  }
  errors.mean_voxels /= errors.count;
  errors.rms_voxels = std::sqrt(errors.rms_voxels / errors.count);
  return errors;
}

void ExpectWithinLayerError(const TriangleMesh& mesh, double voxel_size_m, const char* name) {
  const ErrorStatistics e = CompareWithOracle(mesh, voxel_size_m, 4.0, 600);
  testing::Test::RecordProperty(std::string(name) + "_rms_voxels", std::to_string(e.rms_voxels));
  std::printf("%-10s error of V in voxels: mean %+.3f, rms %.3f, max %.3f\n", name, e.mean_voxels, e.rms_voxels,
              e.max_voxels);
  // The error of integer layers: half a voxel of rounding, up to sqrt(3)/2 of surface thickness.
  EXPECT_LT(e.rms_voxels, 0.75) << name;
  EXPECT_LT(e.max_voxels, 1.75) << name;
}

TEST(Voxmap, PenetrationFollowsTheExactDistanceOfASphere) {
  ExpectWithinLayerError(MakeSphere(0.05, 48), 0.002, "sphere");
}
TEST(Voxmap, PenetrationFollowsTheExactDistanceOfABox) {
  ExpectWithinLayerError(MakeBox({0.08, 0.05, 0.031}), 0.002, "box");
}
TEST(Voxmap, PenetrationFollowsTheExactDistanceOfATorus) {
  ExpectWithinLayerError(MakeTorus(0.05, 0.02, 48, 24), 0.002, "torus");
}

TEST(Voxmap, PenetrationFollowsTheExactDistanceOfSceneParts) {
  const std::filesystem::path folder = std::filesystem::path(VR_OOS_SOURCE_DIR) / "scenarios/module_replacement/meshes";
  int num_parts = 0;
  for (const auto& [name, voxel_m] : {std::pair{"handle", 0.001}, std::pair{"module", 0.001}}) {
    for (const char* extension : {".obj", ".glb", ".gltf"}) {
      const auto file = folder / (std::string(name) + extension);
      if (!std::filesystem::exists(file)) continue;
      const auto mesh = LoadMesh(file);
      ASSERT_TRUE(mesh.has_value()) << mesh.error().detail;
      ExpectWithinLayerError(*mesh, voxel_m, name);
      ++num_parts;
      break;
    }
  }
  EXPECT_EQ(num_parts, 2) << "parts are missing in " << folder;
}

TEST(Voxmap, IsExactOnAPlaneThroughVoxelCentres) {
  // A box with its faces on voxel centres: V is the depth to rounding, at any place in the voxel.
  const Voxmap field = *BuildVoxmap(MakeBox({0.04, 0.04, 0.02}), 0.001);
  CaseRandom random(3);
  for (int i = 0; i < 1000; ++i) {
    const double depth = 0.004 * random.Signed();
    PointTree point;
    point.num_points = 1;
    point.x = {static_cast<float>(0.01 * random.Signed())};
    point.y = {static_cast<float>(0.01 * random.Signed())};
    point.z = {static_cast<float>(0.01 - depth)};
    point.nx = {0.0f};
    point.ny = {0.0f};
    point.nz = {1.0f};
    const auto hits = QueryBruteForce(point, field, core::Pose{}, 1.0);
    ASSERT_EQ(hits.size(), 1U);
    EXPECT_NEAR(hits[0].penetration_m, depth, 1e-6);
  }
}

TEST(Voxmap, SignIsThatOfTheWindingNumberBeyondTheSurfaceVoxels) {
  const TriangleMesh mesh = MakeTorus(0.05, 0.02, 48, 24);
  const Voxmap field = *BuildVoxmap(mesh, 0.002);
  const oracle::ExactDistance exact(mesh);
  CaseRandom random(9);
  for (int i = 0; i < 2000; ++i) {
    const auto x = static_cast<int>((random.Signed() + 1.0) * 0.5 * field.nx);
    const auto y = static_cast<int>((random.Signed() + 1.0) * 0.5 * field.ny);
    const auto z = static_cast<int>((random.Signed() + 1.0) * 0.5 * field.nz);
    const int layer{field.at(x, y, z)};
    const glm::dvec3 centre = field.origin_m + field.voxel_size_m * (glm::dvec3(x, y, z) + 0.5);
    if (layer == 0) {
      EXPECT_LE(exact.UnsignedDistance(centre), 0.8661 * field.voxel_size_m);
    } else {
      EXPECT_EQ(layer > 0, exact.WindingNumber(centre) > 0.5);
    }
  }
}

TEST(Voxmap, EuclideanLayersBeatTwentySixNeighbourLayersBehindATiltedPlane) {
  // Three voxels deep behind a surface of normal (1,1,1): steps of length sqrt(3) make 26-neighbour layers too few.
  TriangleMesh box = MakeBox({0.06, 0.06, 0.06});
  const glm::dquat tilt =
      core::QuaternionFromRotationVector(std::acos(std::sqrt(1.0 / 3.0)) * glm::normalize(glm::dvec3(-1, 1, 0)));
  for (auto& p : box.vertices) p = tilt * p;
  const double s = 0.001;
  const Voxmap field = *BuildVoxmap(box, s);
  const oracle::ExactDistance exact(box);
  double euclidean = 0.0;
  double chessboard = 0.0;
  int count = 0;
  for (int z = 0; z < field.nz; ++z) {
    for (int y = 0; y < field.ny; ++y) {
      for (int x = 0; x < field.nx; ++x) {
        const glm::dvec3 centre = field.origin_m + s * (glm::dvec3(x, y, z) + 0.5);
        const glm::dvec3 q = glm::conjugate(tilt) * centre;
        if (std::abs(q.x) > 0.015 || std::abs(q.y) > 0.015 || std::abs(q.z - (0.03 - 3.0 * s)) > 0.3 * s) continue;
        int nearest = 100;
        for (int dz = -5; dz <= 5; ++dz) {
          for (int dy = -5; dy <= 5; ++dy) {
            for (int dx = -5; dx <= 5; ++dx) {
              if (field.at(x + dx, y + dy, z + dz) == 0)
                nearest = std::min(nearest, std::max({std::abs(dx), std::abs(dy), std::abs(dz)}));
            }
          }
        }
        euclidean += field.at(x, y, z);
        chessboard += nearest;
        ++count;
      }
    }
  }
  ASSERT_GT(count, 50);
  std::printf("3 voxels deep: Euclidean layers %.2f, 26-neighbour layers %.2f\n", euclidean / count,
              chessboard / count);
  EXPECT_GT(euclidean / count, chessboard / count + 0.3);
  EXPECT_NEAR(euclidean / count, 3.0, 1.0);
}

TEST(Voxmap, OpenMeshHasNoInside) {
  TriangleMesh box = MakeBox({0.02, 0.02, 0.02});
  box.triangles.resize(box.triangles.size() - 2);
  const Voxmap field = *BuildVoxmap(box, 0.001);
  for (const std::int8_t layer : field.layers) EXPECT_LE(layer, 0);
}

TEST(Voxmap, RefusesWhatCannotBeBuilt) {
  EXPECT_FALSE(BuildVoxmap(MakeBox({1, 1, 1}), 0.0).has_value());
  EXPECT_FALSE(BuildVoxmap({}, 0.001).has_value());
  EXPECT_EQ(BuildVoxmap(MakeBox({1, 1, 1}), 1e-5).error().code, core::ErrorCode::kResource);
}

TEST(SquaredDistances, EqualBruteForceOnRandomSeeds) {
  const int nx = 23, ny = 31, nz = 17;
  CaseRandom random(1);
  std::vector<std::uint8_t> state(nx * ny * nz, 0);
  for (int i = 0; i < 12; ++i)
    state[static_cast<std::size_t>((random.Signed() + 1.0) * 0.5 * double(state.size()))] = 1;
  const auto squared = SquaredDistances(state, 1, nx, ny, nz, [](double) {});
  for (int z = 0; z < nz; ++z) {
    for (int y = 0; y < ny; ++y) {
      for (int x = 0; x < nx; ++x) {
        int best = kDistanceLimit * kDistanceLimit;
        for (std::size_t k = 0; k < state.size(); ++k) {
          if (state[k] == 0) continue;
          const int dx = static_cast<int>(k % nx) - x;
          const int dy = static_cast<int>(k / nx % ny) - y;
          const int dz = static_cast<int>(k / (nx * ny)) - z;
          best = std::min(best, dx * dx + dy * dy + dz * dz);
        }
        ASSERT_EQ(squared[(static_cast<std::size_t>(z) * ny + y) * nx + x], best);
      }
    }
  }
}

}  // namespace
}  // namespace vps
