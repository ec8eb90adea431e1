#include "nodes/haptic_physics_node/pair_loop.hpp"

#include "core/clock.hpp"

namespace haptic_physics_node {

void PairLoop::Run(const std::atomic<bool>& stop) {
  haptic_.Start();
  physics_.Start();
  while (!stop.load(std::memory_order_relaxed)) MakeTick(haptic_.WaitForTick(stop));
}

// What closes the force loop comes first: the direct command, the tick, the command that contains it. Then what others
// read.
void PairLoop::MakeTick(const haptic_node::NodeLoop::Tick& tick) {
  haptic_.BeginCycle(tick);
  const std::int64_t cycle_ns = core::MonotonicNow_ns();
  hand_over_.TakeContacts(++num_cycles_, cycle_ns, haptic_.mutable_outputs());
  hand_over_.TakeProxies(num_cycles_, cycle_ns, haptic_.mutable_outputs());
  const bool has_stepped = physics_.StepAfterCycle();
  if (has_stepped) {
    physics_node::Outputs* answer = physics_.mutable_outputs();
    hand_over_.TakeAnswer(answer->state.tick, core::MonotonicNow_ns(), answer);
    haptic_.ReevaluateIfAnswered();
  }
  haptic_.EndCycle();
  if (has_stepped) physics_.EndTicks();
}

}  // namespace haptic_physics_node
