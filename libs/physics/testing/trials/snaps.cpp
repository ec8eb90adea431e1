#include "physics/testing/trials/snaps.hpp"

#include <algorithm>
#include <cmath>

#include "physics/testing/trials/build.hpp"

namespace physics::trials {

MovedPart::MovedPart(double mass_kg, SpringCouplingParams spring) {
  params.engage_force_N = 15.0;
  params.release_force_N = 20.0;
  params.damping_N_s_per_m = 0.0;
  const core::Pose X{{1, 0, 0, 0}, {0, 0, z_m}};
  part = AddDynamic(&world, X, BoxMass(mass_kg, {0.03, 0.03, 0.1}));
  hand = AddKinematic(&world, X);
  snap = AddMechanism<Snap>(&world, world.world_body(), part, params);
  auto* grip = AddMechanism<SpringCoupling>(&world, hand, part, spring);
  grip->Attach(X, X, X.translation);
}

void MovedPart::Step(double hand_speed_m_per_s) {
  z_m += hand_speed_m_per_s * kDt;
  world.SetKinematic(hand, {{1, 0, 0, 0}, {0, 0, z_m}}, {{}, {0, 0, hand_speed_m_per_s}});
  const double before = world.V_WO(part).linear_m_per_s.z;
  world.Step(kDt);
  taken_J -= snap->force() * 0.5 * (before + world.V_WO(part).linear_m_per_s.z) * kDt;
  if (snap->state() == 0) largest_free_N = std::max(largest_free_N, snap->force());
  if (snap->state() == 0 && hand_speed_m_per_s < 0.0) peak_in_N = std::max(peak_in_N, snap->force());
  if (snap->state() == 1 && hand_speed_m_per_s > 0.0) peak_out_N = std::max(peak_out_N, -snap->force());
}

void MovedPart::Move(double to_m, double speed_m_per_s) {
  const double direction = to_m > z_m ? 1.0 : -1.0;
  const int steps = static_cast<int>(std::lround(std::abs(to_m - z_m) / (speed_m_per_s * kDt)));
  for (int i = 0; i < steps; ++i) Step(direction * speed_m_per_s);
  for (int i = 0; i < 50; ++i) Step(0.0);
}

bool MovedPart::Cycle(double speed_m_per_s) {
  Move(-0.012, speed_m_per_s);
  const bool has_engaged = snap->state() == 1;
  Move(0.02, speed_m_per_s);
  return has_engaged && snap->state() == 0;
}

LoadedSnap::LoadedSnap(double force_N, double speed_m_per_s) : pull_N(force_N) {
  params.engage_force_N = 15.0;
  params.release_force_N = 60.0;
  params.damping_N_s_per_m = 0.0;
  params.is_initially_engaged = true;
  const double z_m = force_N / params.stiffness_N_per_m;
  part = AddDynamic(&world, {{1, 0, 0, 0}, {0, 0, z_m}}, BoxMass(kMass_kg, {0.05, 0.05, 0.05}),
                    {{}, {0, 0, speed_m_per_s}});
  AddMechanism<Snap>(&world, world.world_body(), part, params);
  world.SetLoad(part, {{0, 0, force_N}, {}});
  stiffness = world.FindTunable(0, "stiffness_N_per_m");
}

double LoadedSnap::Energy_J(double stiffness_N_per_m) const {
  const double p = world.momentum_Ns(part).z;
  const double z = world.center_of_mass_W(part).z - 0.5 * kDt * p / kMass_kg;
  return 0.5 * p * p / kMass_kg + 0.5 * stiffness_N_per_m * z * z - pull_N * z;
}

void LoadedSnap::Run(int steps) {
  for (int i = 0; i < steps; ++i) world.Step(kDt);
}

StiffnessStepError StepOfStiffness(double factor) {
  LoadedSnap scene(20.0);
  scene.Run(50);
  const double k = scene.params.stiffness_N_per_m;
  const double x = scene.world.center_of_mass_W(scene.part).z;
  const double before_J = scene.Energy_J(k);
  const double exact_J = 0.5 * (factor - 1.0) * k * x * x;
  StiffnessStepError error;
  error.reported = std::abs(scene.world.BeginChange(0, scene.stiffness, {factor * k}).injected_J / exact_J - 1.0);
  for (int i = 0; i < 300; ++i) {
    scene.Run(1);
    error.in_motion = std::max(error.in_motion, std::abs((scene.Energy_J(factor * k) - before_J) / exact_J - 1.0));
  }
  return error;
}

}  // namespace physics::trials
