#pragma once

#include "physics/live_change.hpp"
#include "physics/snap.hpp"
#include "physics/spring_coupling.hpp"
#include "physics/world.hpp"

namespace physics::trials {

// A part on a snap without damping, moved in and out by a hand through a spring. What the snap does to the part is read
// from the part: the work of a force is what it changes of the kinetic energy, F dt (v + v') / 2.
struct MovedPart {
  World world;
  SnapParams params;
  int part = -1, hand = -1;
  Snap* snap = nullptr;
  double z_m = 0.02;
  double taken_J = 0.0;     // by the snap
  double peak_in_N = 0.0;   // while it is free and pushed in
  double peak_out_N = 0.0;  // while it is engaged and pulled out
  double largest_free_N = 0.0;

  explicit MovedPart(double mass_kg = 0.3, SpringCouplingParams spring = {});
  void Step(double hand_speed_m_per_s);
  void Move(double to_m, double speed_m_per_s);
  // In and out again; whether it engaged and released.
  bool Cycle(double speed_m_per_s);
};

// A part that is held to W by a snap without damping and pulled by a constant force.
struct LoadedSnap {
  static constexpr double kMass_kg = 0.3;
  World world;
  SnapParams params;
  int part = -1, stiffness = -1;  // the latter for World::BeginChange
  double pull_N = 0.0;

  explicit LoadedSnap(double force_N, double speed_m_per_s = 0.0);
  // Kinetic energy, the spring's and the load's, from momentum and pose alone; the place half a step back goes with the
  // speed.
  [[nodiscard]] double Energy_J(double stiffness_N_per_m) const;
  void Run(int steps);
};

// A step of the stiffness to `factor` times what it was, under 20 N: relative error of the energy reported against
// dk x^2 / 2, and the worst of what the motion has over the next 0.3 s.
struct StiffnessStepError {
  double reported = 0.0;
  double in_motion = 0.0;
};
StiffnessStepError StepOfStiffness(double factor);

}  // namespace physics::trials
