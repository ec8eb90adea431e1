#include "tools/contact/workload.hpp"

#include <cmath>
#include <random>

#include "vps/mesh/load_mesh.hpp"
#include "vps/mesh/shapes.hpp"
#include "vps/oracle/body_distance.hpp"

namespace contact {
namespace {

class Random {
 public:
  double Uniform(double low, double high) {
    return low + (high - low) * static_cast<double>(engine_() >> 11) * 0x1.0p-53;
  }
  glm::dvec3 Direction() {
    while (true) {
      const glm::dvec3 v(Uniform(-1, 1), Uniform(-1, 1), Uniform(-1, 1));
      if (glm::length(v) > 0.1 && glm::length(v) < 1.0) return glm::normalize(v);
    }
  }
  glm::dquat Rotation() { return core::QuaternionFromRotationVector(Uniform(0.0, 3.1) * Direction()); }

 private:
  std::mt19937_64 engine_{12345};
};

// Poses at which B, turned at random and pushed from a random side towards A's middle, has gone `depth_m` beyond the
// first touch.
std::vector<core::Pose> Approach(const vps::TriangleMesh& mesh_A, const vps::TriangleMesh& mesh_B, double depth_m,
                                 int count) {
  const vps::oracle::MeshDistance A(mesh_A);
  const vps::oracle::MeshDistance B(mesh_B);
  const vps::Box box_A = vps::BoundingBox(mesh_A);
  const vps::Box box_B = vps::BoundingBox(mesh_B);
  const glm::dvec3 centre_A = 0.5 * (box_A.lower + box_A.upper);
  const glm::dvec3 centre_B = 0.5 * (box_B.lower + box_B.upper);
  Random random;
  std::vector<core::Pose> poses;
  while (static_cast<int>(poses.size()) < count) {
    const glm::dvec3 from = random.Direction();
    core::Pose X;
    X.rotation = random.Rotation();
    // Sphere tracing: moving by the distance cannot pass through.
    double travel = glm::length(box_A.upper - box_A.lower) + glm::length(box_B.upper - box_B.lower);
    const auto place = [&](double t) { X.translation = centre_A + t * from - X.rotation * centre_B; };
    place(travel);
    double distance = vps::oracle::SurfaceDistance(A, B, X);
    while (distance > 1e-7 && travel > 0.0) {
      travel -= distance;
      place(travel);
      distance = vps::oracle::SurfaceDistance(A, B, X);
    }
    if (travel <= 0.0) continue;  // passed through a hole without a touch
    place(travel - depth_m);
    poses.push_back(X);
  }
  return poses;
}

vps::TriangleMesh Scaled(vps::TriangleMesh mesh, double largest_side_m) {
  const vps::Box box = vps::BoundingBox(mesh);
  const glm::dvec3 size = box.upper - box.lower;
  const glm::dvec3 centre = 0.5 * (box.lower + box.upper);
  const double scale = largest_side_m / std::max({size.x, size.y, size.z});
  for (glm::dvec3& v : mesh.vertices) v = scale * (v - centre);
  return mesh;
}

Workload SphereOnBox() {
  Workload w{"sphere_on_box",
             "a ball of 20 mm radius pressed 0.5 mm into a box",
             vps::MakeBox({0.1, 0.1, 0.05}),
             vps::MakeSphere(0.02, 128),
             {}};
  Random random;
  for (int i = 0; i < 8; ++i) {
    w.poses.push_back({random.Rotation(), {random.Uniform(-0.02, 0.02), random.Uniform(-0.02, 0.02), 0.025 + 0.0195}});
  }
  return w;
}

Workload TorusOnTorus() {
  Workload w{"torus_on_torus",
             "two rings pressed 0.5 mm into each other at random attitudes",
             vps::MakeTorus(0.05, 0.02, 128, 64),
             vps::MakeTorus(0.03, 0.012, 128, 64),
             {}};
  w.poses = Approach(w.A, w.B, 5e-4, 8);
  return w;
}

Workload PressedPeg() {
  Workload w{"pressed_peg",
             "a 20 mm peg in a hole 0.1 mm wider, pressed aside 0.05 to 0.1 mm beyond the clearance",
             vps::MakeBlockWithHole(0.04, 0.02, 0.01005, 128),
             vps::MakeCylinder(0.01, 0.03, 128),
             {}};
  w.voxel_size_m = 2.5e-4;
  w.oracle_accuracy = 1e-2;
  Random random;
  for (int i = 0; i < 4; ++i) {
    const double angle = random.Uniform(-3.1, 3.1);
    const double shift = 5e-5 + random.Uniform(5e-5, 1e-4);
    w.poses.push_back({core::QuaternionFromRotationVector({0, 0, random.Uniform(-3.1, 3.1)}),
                       {shift * std::cos(angle), shift * std::sin(angle), random.Uniform(-2e-3, 2e-3)}});
  }
  return w;
}

}  // namespace

Workloads MakeWorkloads(const std::filesystem::path& scenarios_folder, const std::filesystem::path& meshes_folder) {
  Workloads all;
  all.found = {SphereOnBox(), TorusOnTorus(), PressedPeg()};
  const auto add = [&](Workload w, const std::filesystem::path& file_A, const std::filesystem::path& file_B,
                       const auto& prepare) {
    auto A = vps::LoadMesh(file_A);
    auto B = vps::LoadMesh(file_B);
    if (!A || !B) {
      all.skipped.push_back(w.name + ": " + (!A ? A.error().detail : B.error().detail));
      return;
    }
    w.A = std::move(*A);
    w.B = std::move(*B);
    prepare(&w);
    all.found.push_back(std::move(w));
  };
  const std::filesystem::path scene = scenarios_folder / "module_replacement" / "meshes";
  add({"module_on_bracket", "two parts of the module replacement scene, 0.3 mm beyond the first touch", {}, {}, {}},
      scene / "bracket.obj", scene / "module.obj", [](Workload* w) { w->poses = Approach(w->A, w->B, 3e-4, 8); });
  add({"nut_on_bolt", "an M16 nut on its bolt, shifted aside until the threads press", {}, {}, {}},
      meshes_folder / "factory_bolt_m16_tight.obj", meshes_folder / "factory_nut_m16_tight_subdiv_3x.obj",
      [](Workload* w) {
        w->voxel_size_m = 2.5e-4;
        w->oracle_accuracy = 1e-2;
        Random random;
        for (int i = 0; i < 3; ++i) {
          const double angle = random.Uniform(-3.1, 3.1);
          w->poses.push_back({glm::dquat(1, 0, 0, 0), {2e-4 * std::cos(angle), 2e-4 * std::sin(angle), 0.01}});
        }
      });
  add({"fandisk_on_bunny",
       "a part with sharp edges on the Stanford bunny, both 100 mm, 0.5 mm beyond the first touch",
       {},
       {},
       {}},
      meshes_folder / "stanford_bunny.obj", meshes_folder / "fandisk.obj", [](Workload* w) {
        w->A = Scaled(std::move(w->A), 0.1);
        w->B = Scaled(std::move(w->B), 0.1);
        w->poses = Approach(w->A, w->B, 5e-4, 8);
      });
  return all;
}

}  // namespace contact
