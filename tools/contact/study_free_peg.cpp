#include <cmath>
#include <cstdio>
#include <string>

#include "bus/rt/worker_pool.hpp"
#include "tools/contact/methods/setup.hpp"
#include "tools/contact/studies.hpp"
#include "vps/oracle/body_distance.hpp"
#include "vps/testing/case_random.hpp"
#include "vps/testing/shapes.hpp"

namespace contact {
namespace {

constexpr double kClearance_m = 5e-5;
constexpr std::size_t kNumPoses = 1000;
constexpr int kSegments = 512;   // facets take 12 mm (1 - cos(pi / n)) = 0.2 um of the widest hole
constexpr double kTravel = 0.2;  // along the axis, of the hole's height; the peg's ends stay outside

// Sizes as family pegs of vps/testing/wrench_cases draws them: middle and largest.
struct PegAndHole {
  double radius_m, length_m;  // of the peg
  double height_m, block_m;   // of the block
  std::size_t num_poses;
};
constexpr PegAndHole kPegs[] = {{8e-3, 0.032, 0.018, 0.032, kNumPoses / 2}, {0.012, 0.048, 0.03, 0.048, kNumPoses / 2}};

// The peg is convex and reaches beyond the hole at both ends. So it is free if its edges along the axis are in the hole
// where they pass the planes of the hole's rims: what is between is in their convex hull, and the hole is convex. A
// place is in the hole if it is within the circle inside its facets.
bool IsFree(const PegAndHole& peg, const core::Pose& X_AB) {
  constexpr double kPi = 3.141592653589793;
  const double inside_facets_m = (peg.radius_m + kClearance_m) * std::cos(kPi / kSegments);
  const glm::dvec3 axis = X_AB.rotate({0.0, 0.0, 1.0});
  for (int i = 0; i < kSegments; ++i) {
    const double angle = 2.0 * kPi * i / kSegments;
    const glm::dvec3 on_edge = X_AB * (peg.radius_m * glm::dvec3(std::cos(angle), std::sin(angle), 0.0));
    for (const double z : {-0.5 * peg.height_m, 0.5 * peg.height_m}) {
      const double along_m = (z - on_edge.z) / axis.z;
      const glm::dvec3 at = on_edge + along_m * axis;
      if (std::abs(along_m) > 0.5 * peg.length_m || std::hypot(at.x, at.y) >= inside_facets_m) return false;
    }
  }
  return true;
}

// Shifted and tilted as far as the clearance allows. Of every fiftieth the exact distance says so, too: it takes a
// tenth of a second.
std::vector<core::Pose> FreePoses(const vps::TriangleMesh& A, const vps::TriangleMesh& B, const PegAndHole& peg) {
  constexpr std::size_t kChecked = 50;
  vps::CaseRandom random(7);
  const vps::oracle::MeshDistance exact_A(A);
  const vps::oracle::MeshDistance exact_B(B);
  std::vector<core::Pose> poses;
  while (poses.size() < peg.num_poses) {
    const double tilt = random.Uniform(0.0, 2.0 * kClearance_m / peg.height_m);
    const double about = random.Uniform(-3.14, 3.14);
    const double aside_m = random.Uniform(0.0, kClearance_m);
    const double to = random.Uniform(-3.14, 3.14);
    const core::Pose X_AB = {
        core::QuaternionFromRotationVector(tilt * glm::dvec3(std::cos(about), std::sin(about), 0.0)) *
            core::QuaternionFromRotationVector({0.0, 0.0, random.Uniform(-3.1, 3.1)}),
        {aside_m * std::cos(to), aside_m * std::sin(to), random.Uniform(-kTravel, kTravel) * peg.height_m}};
    if (!IsFree(peg, X_AB)) continue;
    poses.push_back(X_AB);
    if (poses.size() % kChecked == 0 && !(vps::oracle::SurfaceDistance(exact_A, exact_B, X_AB) > 0.0)) return {};
  }
  return poses;
}

struct Counted {
  double voxel_size_m = 0.0;
  std::uint32_t num_points = 0;
  std::size_t num_poses = 0, num_contacts = 0;
  double deepest_m = 0.0;  // that was reported
};

Counted CountContacts(const PegAndHole& peg) {
  const vps::TriangleMesh A = vps::MakeBlockWithHole(peg.block_m, peg.height_m, peg.radius_m + kClearance_m, kSegments);
  const vps::TriangleMesh B = vps::MakeCylinder(peg.radius_m, peg.length_m, kSegments);
  Counted counted;
  const Setup setup = ChooseSetup(A, B, {});
  counted.voxel_size_m = setup.resolution.voxel_size_m;
  counted.num_points = setup.resolution.num_points;
  auto method = setup.is_A_sampled ? MakeFastMethod(B, A, setup.resolution) : MakeFastMethod(A, B, setup.resolution);
  if (!method) return counted;
  if (setup.is_A_sampled) method = Turned(std::move(*method));
  for (const core::Pose& X_AB : FreePoses(A, B, peg)) {
    const Answer answer = (*method)->Query(X_AB);
    ++counted.num_poses;
    if (answer.contacts == 0) continue;
    ++counted.num_contacts;
    counted.deepest_m = std::max(counted.deepest_m, -answer.signed_distance_m);
  }
  return counted;
}

}  // namespace

void StudyFreePeg(Report* report) {
  std::vector<Counted> counted(std::size(kPegs));
  bus::WorkerPool workers(2, "pegs");
  workers.Run(
      counted.size(),
      [](void* context, std::size_t i) { (*static_cast<std::vector<Counted>*>(context))[i] = CountContacts(kPegs[i]); },
      &counted);
  Table table{
      "free_peg", {"peg_radius_m", "clearance_m", "voxel_size_m", "points", "poses", "contacts", "deepest_m"}, {}};
  std::size_t poses = 0;
  std::size_t contacts = 0;
  for (std::size_t i = 0; i < counted.size(); ++i) {
    const Counted& c = counted[i];
    poses += c.num_poses;
    contacts += c.num_contacts;
    table.Add({Cell(kPegs[i].radius_m), Cell(kClearance_m), Cell(c.voxel_size_m), std::to_string(c.num_points),
               std::to_string(c.num_poses), std::to_string(c.num_contacts), Cell(c.deepest_m)});
    std::printf("free peg, radius %s mm, voxels of %s mm, %u points: %zu of %zu free poses report contact\n",
                Short(1e3 * kPegs[i].radius_m).c_str(), Short(1e3 * c.voxel_size_m).c_str(), c.num_points,
                c.num_contacts, c.num_poses);
  }
  report->tables.push_back(table);
  report->AddGoal("free peg, 0.05 mm clearance, resolution as `oos query` chooses it: false contacts",
                  "0 of 1000 poses", std::to_string(contacts) + " of " + std::to_string(poses),
                  contacts == 0 && poses == kNumPoses);
}

}  // namespace contact
