// F10, F14, F18: mass ratio, redundant contacts, one-sided sampling.
#include <algorithm>
#include <cmath>

#include "core/clock.hpp"
#include "physics/testing/trials/heavy_on_light.hpp"
#include "physics/testing/trials/reference.hpp"
#include "tools/dynamics/stack.hpp"
#include "tools/failures/field_pair.hpp"
#include "tools/failures/studies/studies.hpp"
#include "tools/failures/tool_on_plate.hpp"
#include "vps/testing/shapes.hpp"

namespace failures {
namespace {

constexpr double kRatio = 1000.0;
constexpr int kSteps = 1000;

struct Stacked {
  double overlap_m = 0.0;
  double step_us = 0.0;  // of the thread's processor, mean
};

Stacked Stand(const dynamics::StackMaker& maker) {
  const auto stack = maker.make(kRatio);
  const std::int64_t begin_ns = core::ThreadCpuNow_ns();
  for (int i = 0; i < kSteps; ++i) stack->Step();
  return {stack->deepest_m(), 1e-3 * static_cast<double>(core::ThreadCpuNow_ns() - begin_ns) / kSteps};
}

void StudyMassRatio(const Peers& peers, Report* report) {
  Row row{
      "F10",
      "mass ratio",
      "block of 200 kg on one of 0.2 kg, 1 g, input `manifold`; Bullet: 10 sweeps; MuJoCo: stiffest contacts",
      "overlap; time of a step",
      "<= 50 um; <= 0.2 ms",
      {},
      "Bullet's sequential impulses do not converge; MuJoCo's contacts are soft, at the stiffest that its step allows"};
  const auto reading = [](const std::string& contender, const Stacked& stacked) {
    return Reading{contender, Short(1e6 * stacked.overlap_m) + " um; " + Short(stacked.step_us) + " us",
                   stacked.overlap_m <= 5e-5 && stacked.step_us <= 200.0};
  };
  const Stacked ours =
      Stand(dynamics::OwnStacks().at(0));  // contacts are given in closed form: one figure for all variants
  for (const Variant& variant : Variants()) row.readings.push_back(reading(variant.name, ours));
  for (const Peer& peer : peers) row.readings.push_back(reading(peer.name, Stand(peer.stack)));
  AddRow(report, row);
}

constexpr glm::dvec3 kBlock_m{0.1, 0.1, 0.02};

// Of the planes' wrench from that of all points, over force and over force times the block's radius, as in vps.md.
struct Reduction {
  double force = 0.0;
  double torque = 0.0;
};

Reduction Reduce(FieldPair* pair, const core::Pose& X_GS) {
  const vps::PairResult& result = pair->Query(X_GS);
  core::Wrench sum;
  for (const core::ContactPlane& plane : result.planes) {
    const glm::dvec3 n(plane.n_G);
    const glm::dvec3 p = X_GS * glm::dvec3(plane.p_S);
    const double gap = glm::dot(n, p - glm::dvec3(plane.q_G));
    const glm::dvec3 F = plane.stiffness_N_per_m * std::max(0.0, -gap) * n;
    sum += {F, glm::cross(p - X_GS.translation, F)};
  }
  const double force = glm::length(result.F_So_W.force_N);
  return {glm::length(sum.force_N - result.F_So_W.force_N) / force,
          glm::length(sum.torque_Nm - result.F_So_W.torque_Nm) / (0.5 * glm::length(kBlock_m) * force)};
}

void StudyReducedContacts(Report* report) {
  Row row{"F14",
          "redundant contacts",
          "block of 100 mm with 16k points pressed flat, and with a tilt of 2 mrad, into a plate",
          "planes' force and torque / radius off all points'",
          "<= 1 %; <= 1 %",
          {},
          "`paper`: planes stand for depths, the sum is scaled by Eq. 2; `fast`: 20 planes at most stand for a tilted "
          "press"};
  for (const Variant& variant : Variants()) {
    FieldPair pair(variant, vps::MakeBox({0.2, 0.2, 0.04}), kVoxel_m, vps::MakeBox(kBlock_m), 16384);
    Reduction worst;
    for (const double tilt : {0.0, 0.002}) {
      const Reduction one = Reduce(
          &pair, {core::QuaternionFromRotationVector({tilt, 0.5 * tilt, 0.1}), {1.3e-4, 2.1e-4, 0.02 + 0.01 - 5e-4}});
      worst = {std::max(worst.force, one.force), std::max(worst.torque, one.torque)};
    }
    row.readings.push_back({variant.name, Short(100.0 * worst.force) + " %; " + Short(100.0 * worst.torque) + " %",
                            worst.force <= 0.01 && worst.torque <= 0.01});
  }
  AddRow(report, row);
  Row rocking{"F14",
              "redundant contacts",
              "plate of 2 kg pressed with 60 N off its centre, pulled to and fro, 10,000 contacts",
              "rocking",
              "<= 5 um",
              {},
              ""};
  const double rocking_m = physics::trials::RockingOfAPress_m(2.0);
  for (const Variant& variant : Variants())
    rocking.readings.push_back({variant.name, Short(1e6 * rocking_m) + " um", rocking_m <= 5e-6});
  AddRow(report, rocking);
}

// A needle of 0.2 mm, the tool, stands 0.3 mm deep in the middle of a plate's face; each of the two is sampled in turn.
void StudyNeedle(Report* report) {
  constexpr double kDepth_m = 3e-4;
  const vps::TriangleMesh needle = vps::MakeCylinder(1e-4, 0.02, 16);
  const vps::TriangleMesh plate = vps::MakeBox({0.1, 0.1, 0.02});
  const core::Pose X_PN{{1, 0, 0, 0}, {3.7e-4, 2.3e-4, 0.01 + 0.01 - kDepth_m}};
  Row row{"F18",
          "one-sided sampling",
          "needle of 0.2 mm as the tool, 0.3 mm deep in a plate with 4k points, voxels of 1 mm; either one sampled",
          "depth off, needle sampled; plate sampled, in voxels",
          "<= 0.1; <= 0.1",
          {},
          "a needle thinner than a voxel has no inside in its field, and passes between the plate's points"};
  for (const Variant& variant : Variants()) {
    const auto error = [&](const vps::TriangleMesh& field, const vps::TriangleMesh& sampled, FieldPair::Palm palm,
                           const core::Pose& X_GS) {
      try {
        FieldPair pair(variant, field, kVoxel_m, sampled, kToolPoints, palm);
        const vps::PairResult& result = pair.Query(X_GS);
        const double depth_m = result.is_in_contact ? -result.signed_distance_m : 0.0;
        return std::abs(depth_m - kDepth_m) / kVoxel_m;
      } catch (const std::runtime_error&) {
        return 1e9;
      }
    };
    const double of_needle = error(plate, needle, FieldPair::Palm::kSampled, X_PN);
    const double of_plate = error(needle, plate, FieldPair::Palm::kField, X_PN.inverse());
    row.readings.push_back({variant.name, Short(of_needle) + "; " + (of_plate < 1e9 ? Short(of_plate) : "refused"),
                            of_needle <= 0.1 && of_plate <= 0.1});
  }
  AddRow(report, row);
}

}  // namespace

void StudyBodies(const Peers& peers, Report* report) {
  StudyMassRatio(peers, report);
  StudyReducedContacts(report);
  StudyNeedle(report);
}

}  // namespace failures
