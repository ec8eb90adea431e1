// Figures without a chart, from the scenes of the tests.
#include <algorithm>
#include <cmath>

#include "physics/testing/closed_form/contact_laws.hpp"
#include "physics/testing/closed_form/snap_work.hpp"
#include "physics/testing/trials/build.hpp"
#include "physics/testing/trials/busy.hpp"
#include "physics/testing/trials/reference.hpp"
#include "physics/testing/trials/snaps.hpp"
#include "tools/dynamics/studies.hpp"

namespace dynamics {
namespace {

using physics::ContactKind;

void OfDrift(Report* report) {
  const double drift = physics::trials::DriftError();
  report->AddGoal("straight drift, 10 min", "<= 1e-10", Short(drift), drift <= 1e-10);
}

void OfMomentum(Report* report) {
  const auto residual = physics::trials::MixedContacts(60.0);
  const double worst = std::max(residual.linear, residual.angular);
  report->AddGoal("60 s of mixed contacts with friction and joints: linear and angular momentum", "<= 1e-9",
                  Short(residual.linear) + ", " + Short(residual.angular), worst <= 1e-9);
  const double joints = std::max(residual.joints.relative(), residual.joints.relative_angular());
  const double contacts = std::max(residual.contacts.relative(), residual.contacts.relative_angular());
  report->AddGoal("of these, joints alone; contacts alone", "<= 1e-9", Short(joints) + "; " + Short(contacts),
                  std::max(joints, contacts) <= 1e-9);
}

void OfSlope(Report* report) {
  constexpr double kFriction = 0.3;
  double creep_m_per_s = 0.0;
  double off = 0.0;
  const double exact = physics::closed_form::SlopeAcceleration_m_per_s2(std::atan(1.1 * kFriction), kFriction,
                                                                        physics::trials::kGravity);
  for (const ContactKind kind : {ContactKind::kCompliant, ContactKind::kHard}) {
    creep_m_per_s =
        std::max(creep_m_per_s, physics::trials::BlockOnSlope(0.95 * kFriction, kFriction, kind).creep_m_per_s);
    const double a = physics::trials::BlockOnSlope(1.1 * kFriction, kFriction, kind).acceleration_m_per_s2;
    off = std::max(off, std::abs(a / exact - 1.0));
  }
  report->AddGoal("slope at 0.95 of the friction angle's tangent: creep", "< 1 um/s",
                  Short(1e6 * creep_m_per_s) + " um/s", creep_m_per_s < 1e-6);
  report->AddGoal("slope at 1.1 of it: acceleration", "within 2 %", Short(100.0 * off) + " % off", off <= 0.02);
}

void OfSnap(Report* report) {
  double peak_off = 0.0;
  double work_off = 0.0;
  for (const double speed : {0.002, 0.01, 0.05}) {
    physics::trials::MovedPart scene;
    scene.Cycle(speed);
    peak_off = std::max({peak_off, std::abs(scene.peak_in_N / scene.params.engage_force_N - 1.0),
                         std::abs(scene.peak_out_N / scene.params.release_force_N - 1.0)});
    work_off = std::max(work_off, std::abs(scene.taken_J / physics::closed_form::SnapCycleWork_J(scene.params) - 1.0));
  }
  report->AddGoal("snap, 2 to 50 mm/s: peak forces", "within 1 %", Short(100.0 * peak_off) + " % off",
                  peak_off <= 0.01);
  report->AddGoal("snap, 2 to 50 mm/s: work of the loop", "within 1 %", Short(100.0 * work_off) + " % off",
                  work_off <= 0.01);
  physics::trials::MovedPart scene(0.1);
  const double exact_J = physics::closed_form::SnapCycleWork_J(scene.params);
  double least = 1e9;
  for (int i = 0; i < 1000; ++i) {
    const double before_J = scene.taken_J;
    scene.Cycle(0.25);
    least = std::min(least, (scene.taken_J - before_J) / exact_J);
  }
  report->AddGoal("snap, 1,000 cycles at 0.25 m/s: no energy gained", "> 0 taken in each",
                  Short(least) + " of the file's work in the least", least > 0.0);
}

void OfStiffness(Report* report) {
  physics::trials::StiffnessStepError worst;
  for (const double factor : {0.5, 1.5, 2.0, 2.9}) {
    const auto error = physics::trials::StepOfStiffness(factor);
    worst.reported = std::max(worst.reported, error.reported);
    worst.in_motion = std::max(worst.in_motion, error.in_motion);
  }
  report->AddGoal("stiffness step under load: energy reported; energy that the motion has", "within 1e-6",
                  Short(worst.reported) + "; " + Short(worst.in_motion),
                  std::max(worst.reported, worst.in_motion) <= 1e-6);
}

void OfFarParts(Report* report) {
  const physics::SolverWork alone = physics::trials::WorkOfAMover(0);
  const physics::SolverWork among = physics::trials::WorkOfAMover(50);
  const bool is_same = alone.num_islands == among.num_islands && alone.num_rows == among.num_rows &&
                       alone.num_sweeps == among.num_sweeps && alone.num_row_updates == among.num_row_updates &&
                       alone.num_direct_solves == among.num_direct_solves;
  report->AddGoal(
      "50 far parts added to a scene with one mover: the solver's counters", "unchanged",
      std::to_string(alone.num_row_updates) + " and " + std::to_string(among.num_row_updates) + " updates of rows",
      is_same);
}

void OfCheckpoint(Report* report) {
  constexpr int kSteps = 700;
  const int differing = physics::trials::StepsThatDifferAfterRestore(kSteps);
  report->AddGoal("restored from a checkpoint amid contacts and joints: steps that differ in any bit", "0",
                  std::to_string(differing) + " of " + std::to_string(kSteps), differing == 0);
}

}  // namespace

void StudyRows(const Peers& peers, Report* report) {
  OfDrift(report);
  OfMomentum(report);
  OfSlope(report);
  OfSnap(report);
  OfStiffness(report);
  OfFarParts(report);
  OfCheckpoint(report);
  const std::string arm = "7-joint arm, 1,000 random states: joint accelerations against MuJoCo";
  if (peers.arm_error) {
    const double error = peers.arm_error();
    report->AddGoal(arm, "within 1e-8", Short(error), error <= 1e-8);
  } else {
    report->goals.push_back({arm, "within 1e-8", "needs `./dev bench`", bench::Verdict::kNotMeasured});
  }
  report->goals.push_back({"world step of `module_replacement`, sheet included: p99", "<= 500 us",
                           "see `oos run scenarios/module_replacement --lockstep`", bench::Verdict::kNotMeasured});
}

}  // namespace dynamics
