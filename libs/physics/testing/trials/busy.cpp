#include "physics/testing/trials/busy.hpp"

#include "physics/hinge.hpp"
#include "physics/hook_and_loop.hpp"
#include "physics/snap.hpp"
#include "physics/spring_coupling.hpp"
#include "physics/testing/trials/build.hpp"

namespace physics::trials {

Busy::Busy() {
  low = AddDynamic(&world, {{1, 0, 0, 0}, {0, 0, 0.05}}, BoxMass(0.2, {0.1, 0.1, 0.1}), {{0, 0.1, 0.2}, {}});
  const int high = AddDynamic(&world, {{1, 0, 0, 0}, {0, 0, 0.151}}, BoxMass(20.0, {0.1, 0.1, 0.1}));
  pair = world.AddContactPair(low, world.world_body()).value();
  const int upper = world.AddContactPair(high, low).value();
  push = world.AddContactPair(high, world.world_body()).value();
  world.SetContactPlanes(pair, Feet(0.0));
  world.SetContactPlanes(upper, Feet(0.05));
  world.SetContactWrench(push, {{3, 0, -100}, {}});
  HingeParams hinge;
  hinge.has_detents = true;
  hinge.detents_rad[0] = -0.3;
  hinge.detents_rad[1] = 0.3;
  hinge.detent_torque_Nm = 0.1;
  const int lever = AddDynamic(&world, HingePose(hinge, -0.2), BoxMass(0.05, {0.01, 0.05, 0.01}));
  AddMechanism<Hinge>(&world, world.world_body(), lever, hinge);
  HookAndLoopParams patches;
  patches.p_PPatch_m = {{0, 0, 0}, {0.1, 0, 0}};
  patches.X_PC = world.X_WO(lever);
  patches.stiffness_N_per_m = 500.0;
  patches.release_force_N = 0.5;
  AddMechanism<HookAndLoop>(&world, world.world_body(), lever, patches);
  SnapParams snap;
  snap.engage_force_N = 5.0;
  snap.release_force_N = 8.0;
  const int plug =
      AddDynamic(&world, {{1, 0, 0, 0}, {0, 0, 0.005}}, BoxMass(0.3, {0.03, 0.03, 0.1}), {{}, {0, 0, -0.3}});
  AddMechanism<Snap>(&world, world.world_body(), plug, snap);
  const int held = AddDynamic(&world, {}, BoxMass(0.3, {0.03, 0.03, 0.1}), {{0, 1, 0}, {}});
  auto* grasp = AddMechanism<SpringCoupling>(&world, plug, held, SpringCouplingParams{});
  grasp->Attach(world.X_WO(plug), world.X_WO(held), {0, 0, 0});
}

core::ContactSet Busy::Feet(double top_m) {
  core::ContactSet set;
  set.friction = 0.2f;
  set.damping_N_s_per_m = 10.0f;
  std::uint32_t id = 0;
  for (const double x : {-0.05, 0.05}) {
    for (const double y : {-0.05, 0.05}) AddPlane(&set, ++id, {x, y, -0.05}, {x, y, top_m}, {0, 0, 1}, 1e5);
  }
  return set;
}

void Busy::Run(int steps) {
  for (int i = 0; i < steps; ++i) world.Step(kDt);
}

int StepsThatDifferAfterRestore(int steps) {
  Busy whole;
  whole.Run(333);
  Checkpoint checkpoint;
  whole.world.Save(&checkpoint);
  Busy restored;
  restored.Run(50);
  if (!restored.world.Restore(&checkpoint)) return steps;
  int differing = restored.world.StateHash() == whole.world.StateHash() ? 0 : 1;
  for (int i = 0; i < steps; ++i) {
    whole.Run(1);
    restored.Run(1);
    if (restored.world.StateHash() != whole.world.StateHash()) ++differing;
  }
  return differing;
}

}  // namespace physics::trials
