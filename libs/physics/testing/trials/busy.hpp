#pragma once

#include "core/messages/haptic.hpp"
#include "physics/world.hpp"

namespace physics::trials {

// Everything at once: stacked blocks in frictional contact under load, a lever, a snap, patches, a grasp.
struct Busy {
  World world;
  int low = -1, pair = -1, push = -1;

  Busy();
  static core::ContactSet Feet(double top_m);  // of a block on a face at this height
  void Run(int steps);
};

// How many of `steps` steps differ in any bit of the state between a run and another that was restored from it, in a
// world that had been elsewhere.
int StepsThatDifferAfterRestore(int steps);

}  // namespace physics::trials
