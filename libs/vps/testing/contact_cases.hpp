#pragma once

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "vps/mesh/load_mesh.hpp"
#include "vps/oracle/first_touch.hpp"
#include "vps/testing/case_random.hpp"
#include "vps/testing/shapes.hpp"

// Pairs and poses at which the accuracy of method `fast` is measured. For tests.
namespace vps {

struct ContactCase {
  std::string name;
  TriangleMesh A, B;  // field, samples
  double voxel_size_m = 1e-3;
  std::vector<core::Pose> poses;  // X_AB
};

// `count` poses X_AB. B, at a random attitude, moves from a random side towards A's middle and stops at a random depth
// within the bounds past the first touch (negative: before it).
inline std::vector<core::Pose> ApproachPoses(const TriangleMesh& mesh_A, const TriangleMesh& mesh_B, double least_m,
                                             double greatest_m, int count, CaseRandom* random) {
  const oracle::MeshDistance A(mesh_A);
  const oracle::MeshDistance B(mesh_B);
  const Box box_A = BoundingBox(mesh_A);
  const Box box_B = BoundingBox(mesh_B);
  std::vector<core::Pose> poses;
  while (static_cast<int>(poses.size()) < count) {
    const glm::dvec3 from = random->Direction();
    const auto touch = oracle::FindFirstTouch(A, box_A, B, box_B, random->Rotation(), from);
    const double depth = random->Uniform(least_m, greatest_m);
    if (touch) poses.push_back(touch->Beyond(depth));
  }
  return poses;
}

inline ContactCase BallCase(int count) {
  ContactCase c{"ball on plate", MakeBox({0.1, 0.1, 0.05}), MakeSphere(0.02, 128), 1e-3, {}};
  CaseRandom random(1);
  for (int i = 0; i < count; ++i) {
    c.poses.push_back({random.Rotation(),
                       {random.Uniform(-0.02, 0.02), random.Uniform(-0.02, 0.02), 0.045 - random.Uniform(2e-4, 8e-4)}});
  }
  return c;
}

inline ContactCase ToriCase(int count) {
  ContactCase c{"two tori", MakeTorus(0.05, 0.02, 128, 64), MakeTorus(0.03, 0.012, 128, 64), 1e-3, {}};
  CaseRandom random(2);
  c.poses = ApproachPoses(c.A, c.B, 2e-4, 8e-4, count, &random);
  return c;
}

// A peg of 20 mm in a hole 0.1 mm wider.
inline ContactCase PegCase(int count) {
  ContactCase c{"pressed peg", MakeBlockWithHole(0.06, 0.04, 0.01005, 256), MakeCylinder(0.01, 0.06, 256), 2.5e-4, {}};
  CaseRandom random(3);
  for (int i = 0; i < count; ++i) {
    const double side = random.Uniform(0.0, 6.28);
    const double shift = random.Uniform(7e-5, 2e-4);
    const glm::dquat tilt =
        core::QuaternionFromRotationVector({random.Uniform(-2e-3, 2e-3), random.Uniform(-2e-3, 2e-3), 0.0});
    const glm::dquat turn = core::QuaternionFromRotationVector({0.0, 0.0, random.Uniform(-3.0, 3.0)});
    c.poses.push_back({tilt * turn, {shift * std::cos(side), shift * std::sin(side), random.Uniform(-9e-3, 9e-3)}});
  }
  return c;
}

inline core::Result<ContactCase> ModuleCase(const std::filesystem::path& source, int count) {
  const auto folder = source / "scenarios/module_replacement/meshes";
  auto A = LoadMesh(folder / "bracket.obj");
  if (!A) return tl::unexpected(A.error());
  auto B = LoadMesh(folder / "module.obj");
  if (!B) return tl::unexpected(B.error());
  ContactCase c{"module on bracket", *A, *B, 1e-3, {}};
  CaseRandom random(4);
  c.poses = ApproachPoses(c.A, c.B, 2e-4, 8e-4, count, &random);
  return c;
}

// Both files have the thread's axis on z. With the nut 10 mm up (five turns of 2 mm) both flanks are 8 um away. A turn
// by phi rises by 2 mm phi / (2 pi).
inline core::Result<ContactCase> NutCase(const std::filesystem::path& meshes, int count) {
  auto A = LoadMesh(meshes / "factory_bolt_m16_tight.obj");
  if (!A) return tl::unexpected(A.error());
  auto B = LoadMesh(meshes / "factory_nut_m16_tight_subdiv_3x.obj");
  if (!B) return tl::unexpected(B.error());
  ContactCase c{"M16 nut on bolt", *A, *B, 2.5e-4, {}};
  CaseRandom random(5);
  for (int i = 0; i < count; ++i) {
    const double press = random.Uniform(5e-5, 3e-4) * (random.Uniform(-1, 1) < 0.0 ? -1.0 : 1.0);
    const double angle = random.Uniform(-3.0, 3.0);
    c.poses.push_back({core::QuaternionFromRotationVector({0.0, 0.0, angle}),
                       {random.Uniform(-7e-5, 7e-5), random.Uniform(-7e-5, 7e-5),
                        0.010 + press + 0.002 * angle / (2.0 * 3.14159265358979)}});
  }
  return c;
}

}  // namespace vps
