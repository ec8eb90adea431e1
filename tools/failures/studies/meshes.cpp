// F23: meshes as they come. Is the inside of the field that haptic_node cooks from them the inside of the solid?
#include <algorithm>
#include <cmath>
#include <random>

#include "tools/failures/field_pair.hpp"
#include "tools/failures/for_all.hpp"
#include "tools/failures/studies/studies.hpp"
#include "vps/oracle/mesh_distance.hpp"
#include "vps/testing/shapes.hpp"

namespace failures {
namespace {

constexpr int kSamples = 50000;
constexpr double kNear_voxels = 3.0;
constexpr double kUndecided_voxels = 0.01;  // on the surface no sign is wrong

struct BadMesh {
  std::string name;
  vps::TriangleMesh mesh;
  vps::TriangleMesh sound;
  double voxel_m;
};

class Random {
 public:
  double Unit() { return static_cast<double>(engine_() >> 11) * 0x1.0p-53; }
  std::size_t Below(std::size_t n) { return static_cast<std::size_t>(engine_() % n); }

 private:
  std::mt19937_64 engine_{23};
};

vps::TriangleMesh Scaled(vps::TriangleMesh mesh, double scale) {
  for (glm::dvec3& v : mesh.vertices) v *= scale;
  return mesh;
}

vps::TriangleMesh WithHoles(vps::TriangleMesh mesh, double share) {
  Random random;
  std::erase_if(mesh.triangles, [&](const auto&) { return random.Unit() < share; });
  return mesh;
}

vps::TriangleMesh WithTurnedFaces(vps::TriangleMesh mesh, double share) {
  Random random;
  for (auto& t : mesh.triangles) {
    if (random.Unit() < share) std::swap(t[0], t[1]);
  }
  return mesh;
}

vps::TriangleMesh Crossing() {
  vps::TriangleMesh mesh = vps::MakeBox({0.06, 0.04, 0.03});
  const vps::TriangleMesh other = vps::MakeSphere(0.025, 48);
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  for (const glm::dvec3& v : other.vertices) mesh.vertices.push_back(v + glm::dvec3(0.021, 0.007, 0.011));
  for (const auto& t : other.triangles) mesh.triangles.push_back({first + t[0], first + t[1], first + t[2]});
  return mesh;
}

std::vector<BadMesh> BadMeshes() {
  const vps::TriangleMesh torus = vps::MakeTorus(0.05, 0.02, 96, 48);
  return {{"1 % of the faces missing", WithHoles(torus, 0.01), torus, 1e-3},
          {"10 % of the faces turned", WithTurnedFaces(torus, 0.1), torus, 1e-3},
          {"a box and a ball that cross", Crossing(), Crossing(), 1e-3},
          {"a torus of 4 mm", Scaled(torus, 0.03), Scaled(torus, 0.03), 3e-5},
          {"a torus of 10 m", Scaled(torus, 70.0), Scaled(torus, 70.0), 0.07}};
}

// -1, 1, or 0 where the structure does not decide: a layer of voxels on the surface.
int SignOf(const vps::CookedObject& object, const glm::dvec3& p_m) {
  if (object.field) {
    const vps::DistanceField& field = *object.field;
    return vps::SampleField(field, glm::vec3((p_m - field.origin_m) / field.voxel_size_m)).distance < 0.0F ? -1 : 1;
  }
  const vps::Voxmap& map = *object.voxmap;
  const glm::ivec3 at(glm::floor((p_m - map.origin_m) / map.voxel_size_m));
  if (!map.contains(at.x, at.y, at.z)) return 1;
  const int layer = map.at(at.x, at.y, at.z);
  return layer > 0 ? -1 : layer < 0 ? 1 : 0;
}

// Share of samples with the wrong sign; above 1: the mesh is refused.
double WrongSigns(const Variant& variant, const BadMesh& bad) {
  try {
    const FieldPair pair(variant, bad.mesh, bad.voxel_m, vps::MakeSphere(10.0 * bad.voxel_m, 16), 64);
    const vps::oracle::MeshDistance exact(bad.sound);
    Random random;
    int samples = 0;
    int wrong = 0;
    while (samples < kSamples) {
      const auto [a, b, c] = bad.sound.corners(random.Below(bad.sound.triangles.size()));
      const double u = std::sqrt(random.Unit());
      const double v = random.Unit();
      const glm::dvec3 on = (1.0 - u) * a + u * (1.0 - v) * b + u * v * c;
      const glm::dvec3 aside(random.Unit() - 0.5, random.Unit() - 0.5, random.Unit() - 0.5);
      const glm::dvec3 p = on + 2.0 * kNear_voxels * bad.voxel_m * aside;
      const double distance = exact.SignedDistance(p) / bad.voxel_m;
      if (std::abs(distance) > kNear_voxels || std::abs(distance) < kUndecided_voxels) continue;
      ++samples;
      const int sign = SignOf(pair.field(), p);
      if (sign != 0 && sign != (distance < 0.0 ? -1 : 1)) ++wrong;
    }
    return static_cast<double>(wrong) / samples;
  } catch (const std::runtime_error& refusal) {
    std::printf("%s: %s\n", bad.name.c_str(), refusal.what());
    return 2.0;
  }
}

}  // namespace

void StudyMeshes(Report* report) {
  const std::vector<BadMesh> meshes = BadMeshes();
  // Fields do not depend on the coupling.
  std::vector<double> shares(meshes.size() * Variants().size());
  ForAll(shares.size(), [&](std::size_t i) {
    shares[i] = WrongSigns(Variants()[i % Variants().size()], meshes[i / Variants().size()]);
  });
  for (std::size_t m = 0; m < meshes.size(); ++m) {
    Row row{"F23",
            "bad meshes",
            meshes[m].name + ", 50,000 places within 3 voxels of the surface",
            "signs wrong",
            "< 1e-4",
            {},
            "the field's surface is off by some hundredths of a voxel; 7 of the 11 places of box and ball are at faces "
            "inside the solid, which count as its surface, or within half a voxel of where the two cross"};
    for (std::size_t v = 0; v < Variants().size(); ++v) {
      const double share = shares[m * Variants().size() + v];
      row.readings.push_back({Variants()[v].name, share > 1.0 ? "refused" : bench::Cell(share), share < 1e-4});
    }
    AddRow(report, row);
  }
}

}  // namespace failures
