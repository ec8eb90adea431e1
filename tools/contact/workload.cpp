#include "tools/contact/workload.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "tools/contact/approach.hpp"
#include "tools/contact/smooth_walk.hpp"
#include "vps/mesh/load_mesh.hpp"
#include "vps/testing/shapes.hpp"

namespace contact {
namespace {

// Not derived: more poses take longer and scatter less. Published tables hold for these poses only.
constexpr std::uint64_t kSeed = 12345;
constexpr int kWalks = 8;
constexpr int kSteps = 100;
constexpr int kIndependent = 16;
constexpr double kPi = 3.14159265358979323846;

vps::TriangleMesh Scaled(vps::TriangleMesh mesh, double largest_side_m) {
  const vps::Box box = vps::BoundingBox(mesh);
  const glm::dvec3 size = box.upper - box.lower;
  const glm::dvec3 centre = 0.5 * (box.lower + box.upper);
  const double scale = largest_side_m / std::max({size.x, size.y, size.z});
  for (glm::dvec3& v : mesh.vertices) v = scale * (v - centre);
  return mesh;
}

// Fills every hole with a fan around the middle of its rim.
vps::TriangleMesh Closed(vps::TriangleMesh mesh) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
  for (const auto& t : mesh.triangles) {
    for (int k = 0; k < 3; ++k) ++edges[{t[k], t[(k + 1) % 3]}];
  }
  std::map<std::uint32_t, std::uint32_t> next;  // along the rim, against the triangles' direction
  for (const auto& [edge, count] : edges) {
    if (!edges.contains({edge.second, edge.first})) next[edge.second] = edge.first;
  }
  while (!next.empty()) {
    std::vector<std::uint32_t> rim = {next.begin()->first};
    while (next.contains(rim.back())) {
      const std::uint32_t to = next[rim.back()];
      next.erase(rim.back());
      if (to == rim.front()) break;
      rim.push_back(to);
    }
    if (rim.size() < 3) continue;
    glm::dvec3 middle(0.0);
    for (const std::uint32_t v : rim) middle += mesh.vertices[v];
    const auto hub = static_cast<std::uint32_t>(mesh.vertices.size());
    mesh.vertices.push_back(middle / static_cast<double>(rim.size()));
    for (std::size_t i = 0; i < rim.size(); ++i) mesh.triangles.push_back({rim[i], rim[(i + 1) % rim.size()], hub});
  }
  return mesh;
}

// Workload of independent poses by Approach and of walks by WanderInBand that start there, `slack_m` beyond the band.
Workload FreeWorkload(const Parts& parts, std::string name, std::string description, Fit fit, double step_m,
                      double least_m, double greatest_m, double slack_m) {
  vps::CaseRandom random(kSeed);
  Workload w{std::move(name), std::move(description), fit, {}, {}};
  w.independent = Approach(parts, least_m, greatest_m, kIndependent, &random);
  const std::vector<core::Pose> starts(w.independent.begin(), w.independent.begin() + kWalks);
  w.walks = WanderInBand(parts, starts, step_m, least_m - slack_m, greatest_m + slack_m, kSteps, &random);
  return w;
}

// Workload of parts that fit into each other: X_AB = pose_of(c) for coordinates with |c_k| <= bound_k that `is_allowed`
// accepts.
Workload FittedWorkload(std::string name, std::string description, Fit fit, const Coordinates& bound,
                        const Coordinates& mean_step, const std::function<bool(const Coordinates&)>& is_allowed,
                        const std::function<core::Pose(const Coordinates&)>& pose_of) {
  vps::CaseRandom random(kSeed);
  Workload w{std::move(name), std::move(description), fit, {}, {}};
  const auto is_within = [&](const Coordinates& c) {
    for (std::size_t k = 0; k < c.size(); ++k) {
      if (std::abs(c[k]) > bound[k]) return false;
    }
    return is_allowed(c);
  };
  while (w.independent.size() < kIndependent) {
    Coordinates c{};
    for (std::size_t k = 0; k < c.size(); ++k) c[k] = random.Uniform(-bound[k], bound[k]);
    if (!is_within(c)) continue;
    w.independent.push_back(pose_of(c));
    if (w.walks.size() >= kWalks) continue;
    std::vector<core::Pose> walk;
    for (const Coordinates& at : SmoothWalk(c, mean_step, kSteps, is_within, &random)) walk.push_back(pose_of(at));
    w.walks.push_back(std::move(walk));
  }
  return w;
}

core::Result<PartsAndWorkloads> Load(const std::string& name, const std::filesystem::path& A,
                                     const std::filesystem::path& B, double voxel_size_m,
                                     const std::function<void(Parts*)>& prepare,
                                     const std::function<std::vector<Workload>(const Parts&)>& workloads) {
  auto mesh_A = vps::LoadMesh(A);
  if (!mesh_A) return tl::unexpected(mesh_A.error());
  auto mesh_B = vps::LoadMesh(B);
  if (!mesh_B) return tl::unexpected(mesh_B.error());
  Parts parts{name, std::move(*mesh_A), std::move(*mesh_B), voxel_size_m};
  if (prepare) prepare(&parts);
  return PartsAndWorkloads{std::make_shared<const Parts>(parts), workloads(parts)};
}

core::Result<PartsAndWorkloads> BallAndBox() {
  const Parts parts{"ball_and_box", vps::MakeBox({0.1, 0.1, 0.05}), vps::MakeSphere(0.02, 128), 1e-3};
  // The ball's centre is above the box's upper face, away from its edges.
  Workload w = FittedWorkload(
      "ball_on_box", "a ball of 20 mm radius pressed 0.2 to 0.8 mm into a box", Fit::kLight,
      {0.02, 0.02, 3e-4, 3.0, 3.0, 3.0}, {1e-4, 1e-4, 2e-5, 5e-3, 5e-3, 5e-3}, [](const Coordinates&) { return true; },
      [](const Coordinates& c) {
        return core::Pose{core::QuaternionFromRotationVector({c[3], c[4], c[5]}), {c[0], c[1], 0.0445 + c[2]}};
      });
  return PartsAndWorkloads{std::make_shared<const Parts>(parts), {w}};
}

core::Result<PartsAndWorkloads> Rings() {
  const Parts parts{"rings", vps::MakeTorus(0.05, 0.02, 128, 64), vps::MakeTorus(0.03, 0.012, 128, 64), 1e-3};
  return PartsAndWorkloads{
      std::make_shared<const Parts>(parts),
      {FreeWorkload(parts, "ring_on_ring", "two rings pressed 0.2 to 0.8 mm into each other at random attitudes",
                    Fit::kLight, 4e-4, 2e-4, 8e-4, 3e-4)}};
}

// A peg of 20 mm in a hole 0.1 mm wider, 40 mm long. With the axis shifted by e [m] and tilted by t [rad], the greatest
// depth is e + t 20 mm - 0.05 mm: half the hole's length times the tilt, less the radial clearance.
core::Result<PartsAndWorkloads> PegInHole() {
  const Parts parts{"peg", vps::MakeBlockWithHole(0.06, 0.04, 0.01005, 256), vps::MakeCylinder(0.01, 0.06, 256),
                    2.5e-4};
  const auto pose_of = [](const Coordinates& c) {
    return core::Pose{
        core::QuaternionFromRotationVector({c[3], c[4], 0.0}) * core::QuaternionFromRotationVector({0.0, 0.0, c[5]}),
        {c[0], c[1], c[2]}};
  };
  const auto reach_m = [](const Coordinates& c) { return std::hypot(c[0], c[1]) + 0.02 * std::hypot(c[3], c[4]); };
  Workload pressed = FittedWorkload(
      "peg_pressed", "a 20 mm peg in a hole 0.1 mm wider, pressed aside until it is up to 0.2 mm deep",
      Fit::kConforming, {2e-4, 2e-4, 9e-3, 2e-3, 2e-3, 3.0}, {1e-5, 1e-5, 2.5e-5, 2e-4, 2e-4, 3e-3},
      [&](const Coordinates& c) { return std::hypot(c[0], c[1]) > 7e-5 && reach_m(c) < 2.5e-4; }, pose_of);
  Workload free = FittedWorkload(
      "peg_free", "the same peg within its clearance, touching nothing", Fit::kNear,
      {4e-5, 4e-5, 9e-3, 2e-3, 2e-3, 3.0}, {5e-6, 5e-6, 2.5e-5, 1e-4, 1e-4, 3e-3},
      [&](const Coordinates& c) { return reach_m(c) < 4.5e-5; }, pose_of);
  return PartsAndWorkloads{std::make_shared<const Parts>(parts), {pressed, free}};
}

// Both files have the thread's axis on z. With the nut 10 mm up (five turns of the M16's 2 mm pitch) the thread's
// clearance of 8 um is the same above and below: found by exact distances over angles and heights. A turn by phi rises
// by 2 mm phi / (2 pi).
core::Result<PartsAndWorkloads> NutOnBolt(const Places& places) {
  return Load("nut", places.meshes / "factory_bolt_m16_tight.obj",
              places.meshes / "factory_nut_m16_tight_subdiv_3x.obj", 2.5e-4, {}, [](const Parts&) {
                Workload w = FittedWorkload(
                    "nut_pressed",
                    "an M16 nut on its bolt, pressed against the flanks by 0.05 to 0.3 mm along the axis",
                    Fit::kConforming, {1e-4, 1e-4, 3e-4, 1e-3, 1e-3, 3.0}, {8e-6, 8e-6, 8e-6, 5e-5, 5e-5, 4e-3},
                    [](const Coordinates& c) { return std::abs(c[2]) > 5e-5 && std::hypot(c[0], c[1]) < 1e-4; },
                    [](const Coordinates& c) {
                      return core::Pose{core::QuaternionFromRotationVector({c[3], c[4], 0.0}) *
                                            core::QuaternionFromRotationVector({0.0, 0.0, c[5]}),
                                        // Tilted about the nut's centre, 22.5 mm up its axis.
                                        glm::dvec3(c[0], c[1], 0.01 + 0.002 * c[5] / (2.0 * kPi) + c[2]) +
                                            glm::dvec3(-0.0225 * c[4], 0.0225 * c[3], 0.0)};
                    });
                return std::vector<Workload>{w};
              });
}

core::Result<PartsAndWorkloads> Bunnies(const Places& places) {
  return Load(
      "bunnies", places.meshes / "stanford_bunny.obj", places.meshes / "stanford_bunny.obj", 8e-4,
      [](Parts* parts) {
        parts->A = Scaled(Closed(std::move(parts->A)), 0.1);
        parts->B = Scaled(Closed(std::move(parts->B)), 0.2);
      },
      [](const Parts& parts) {
        return std::vector<Workload>{
            FreeWorkload(parts, "bunny_light",
                         "two Stanford bunnies of 100 and 200 mm, holes closed, pressed 0.2 to 0.8 mm into each other",
                         Fit::kLight, 4e-4, 2e-4, 8e-4, 2e-4),
            FreeWorkload(parts, "bunny_near", "the same bunnies 0.3 to 1 mm apart", Fit::kNear, 4e-4, -1e-3, -3e-4,
                         2e-4),
            FreeWorkload(parts, "bunny_deep", "the same bunnies 5 to 15 mm in each other", Fit::kDeep, 4e-4, 5e-3,
                         15e-3, 2e-3),
            FreeWorkload(parts, "bunny_apart", "the same bunnies 50 mm apart", Fit::kApart, 6e-4, -0.052, -0.048,
                         1e-3)};
      });
}

core::Result<PartsAndWorkloads> FandiskOnBunny(const Places& places) {
  return Load(
      "fandisk", places.meshes / "stanford_bunny.obj", places.meshes / "fandisk.obj", 1e-3,
      [](Parts* parts) {
        parts->A = Scaled(Closed(std::move(parts->A)), 0.1);
        parts->B = Scaled(std::move(parts->B), 0.1);
      },
      [](const Parts& parts) {
        return std::vector<Workload>{FreeWorkload(
            parts, "fandisk_on_bunny", "a part with sharp edges on the bunny, both 100 mm, 0.2 to 0.8 mm deep",
            Fit::kLight, 4e-4, 2e-4, 8e-4, 2e-4)};
      });
}

core::Result<PartsAndWorkloads> ModuleOnBracket(const Places& places) {
  const auto folder = places.scenarios / "module_replacement" / "meshes";
  return Load("module", folder / "bracket.obj", folder / "module.obj", 1e-3, {}, [](const Parts& parts) {
    return std::vector<Workload>{FreeWorkload(parts, "module_on_bracket",
                                              "two parts of the module replacement scene, 0.2 to 0.8 mm deep",
                                              Fit::kLight, 4e-4, 2e-4, 8e-4, 2e-4)};
  });
}

// Both files are in the assembly's frame: at X_AB = identity the gear is on its pin, which has 0.5 mm of clearance.
core::Result<PartsAndWorkloads> GearOnPin(const Places& places) {
  return Load("gear", places.meshes / "factory_gear_base_loose_space_5e-4_subdiv_4x.obj",
              places.meshes / "factory_gear_small_space_5e-4.obj", 2.5e-4, {}, [](const Parts& parts) {
                const vps::Box box = vps::BoundingBox(parts.B);
                const glm::dvec3 centre = 0.5 * (box.lower + box.upper);
                Workload w = FittedWorkload(
                    "gear_on_pin", "a gear on its pin, pressed 0.05 to 0.2 mm into the plate below", Fit::kConforming,
                    {1e-4, 1e-4, 7.5e-5, 5e-4, 5e-4, 3.0}, {8e-6, 8e-6, 8e-6, 5e-5, 5e-5, 3e-3},
                    [](const Coordinates&) { return true; },
                    [centre](const Coordinates& c) {
                      core::Pose X;
                      X.rotation = core::QuaternionFromRotationVector({c[3], c[4], 0.0}) *
                                   core::QuaternionFromRotationVector({0.0, 0.0, c[5]});
                      X.translation = centre + glm::dvec3(c[0], c[1], c[2] - 1.25e-4) - X.rotation * centre;
                      return X;
                    });
                return std::vector<Workload>{w};
              });
}

}  // namespace

const std::vector<std::string>& PartsNames() {
  static const std::vector<std::string> names = {"ball_and_box", "rings",   "peg",    "nut",
                                                 "bunnies",      "fandisk", "module", "gear"};
  return names;
}

core::Result<PartsAndWorkloads> MakeParts(const std::string& name, const Places& places) {
  if (name == "ball_and_box") return BallAndBox();
  if (name == "rings") return Rings();
  if (name == "peg") return PegInHole();
  if (name == "nut") return NutOnBolt(places);
  if (name == "bunnies") return Bunnies(places);
  if (name == "fandisk") return FandiskOnBunny(places);
  if (name == "module") return ModuleOnBracket(places);
  if (name == "gear") return GearOnPin(places);
  return core::Fail(core::ErrorCode::kInvalidInput, "no parts '" + name + "'");
}

}  // namespace contact
