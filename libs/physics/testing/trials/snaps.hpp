#pragma once

#include "physics/live_change.hpp"
#include "physics/snap.hpp"
#include "physics/spring_coupling.hpp"
#include "physics/world.hpp"

namespace physics::trials {

// A part on a snap without damping, moved in and out by a hand through a spring. The work of the snap's force F on the
// part over a step, with the part's velocities v before and v' after it, is the change of kinetic energy
// F dt (v + v') / 2.
struct MovedPart {
  World world;
  SnapParams params;
  int part = -1, hand = -1;
  Snap* snap = nullptr;
  double z_m = 0.02;
  double taken_J = 0.0;     // energy taken by the snap
  double peak_in_N = 0.0;   // while it is free and pushed in
  double peak_out_N = 0.0;  // while it is engaged and pulled out
  double largest_free_N = 0.0;

  explicit MovedPart(double mass_kg = 0.3, SpringCouplingParams spring = {3000.0, 40.0, 40.0, 0.6});
  void Step(double hand_speed_m_per_s);
  void Move(double to_m, double speed_m_per_s);
  // Moves in and out again; returns whether it engaged and released.
  bool Cycle(double speed_m_per_s);
};

// A part that a snap without damping holds to W, pulled by a constant force.
struct LoadedSnap {
  static constexpr double kMass_kg = 0.3;
  World world;
  SnapParams params;
  int part = -1, stiffness = -1;  // the latter for World::BeginChange
  double pull_N = 0.0;

  explicit LoadedSnap(double force_N, double speed_m_per_s = 0.0);
  // p^2 / 2m + k z^2 / 2 - F z from momentum and pose, in J. z is taken half a step back, at the time at which
  // semi-implicit integration has the momentum p.
  [[nodiscard]] double Energy_J(double stiffness_N_per_m) const;
  void Run(int steps);
};

// The stiffness changes at once to `factor` times its value, under 20 N: relative errors against dk x^2 / 2 of the
// energy reported, and of the energy of the motion (largest over the next 0.3 s).
struct StiffnessStepError {
  double reported = 0.0;
  double in_motion = 0.0;
};
StiffnessStepError StepOfStiffness(double factor);

}  // namespace physics::trials
