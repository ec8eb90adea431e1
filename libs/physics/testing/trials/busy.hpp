#pragma once

#include "core/messages/haptic.hpp"
#include "physics/world.hpp"

namespace physics::trials {

// A world with every kind of state: stacked blocks in frictional contact under load, a lever, a snap, hook-and-loop
// patches, a grasp.
struct Busy {
  World world;
  int low = -1, pair = -1, push = -1;

  Busy();
  static core::ContactSet Feet(double top_m);  // contact planes of a block that stands on a face at this height
  void Run(int steps);
};

// Counts the steps, of `steps`, after which the state differs in any bit between a run and a second one that was
// restored from the first one's checkpoint; the second had run on its own before.
int StepsThatDifferAfterRestore(int steps);

}  // namespace physics::trials
