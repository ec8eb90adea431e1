#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/messages/logic.hpp"
#include "core/messages/physics.hpp"
#include "core/result.hpp"
#include "nodes/haptic_node/ports.hpp"
#include "scene/scenario.hpp"

namespace lockstep {

struct Options {
  std::optional<std::uint64_t> seed;              // default: the scenario's
  std::optional<double> duration_s;               // default: the scenario's limit
  unsigned workers = 1;                           // of the haptic node and of physics_node
  std::filesystem::path cache;                    // cooked structures
  std::filesystem::path trace;                    // CSV, a row every 10 ms; empty: none
  std::vector<core::ParameterChange> parameters;  // set before the first tick
  bool loses_physics_wrench = false;              // fault: contacts never reach physics_node
  std::uint64_t restart_physics_tick = 0;         // fault: after it physics_node ends and goes on from its checkpoint
  std::filesystem::path checkpoint;               // the file for that
  std::filesystem::path steps;                    // every step of the nodes, for `oos replay`; empty: none
  double steps_from_s = 0.0;                      // the recording begins there, with checkpoints and a new haptic_node
  std::function<void(const core::PhysicsState&)> follow;  // sees every tick's state
  // Called right before and right after each node's Step, on its thread.
  std::function<void(std::string_view node, bool is_beginning)> watch_steps;
  const std::atomic<int>* interrupted = nullptr;
  std::function<void(const std::string&)> say;  // progress for people
};

struct StepOutcome {
  std::string name;
  bool is_completed = false;
  double seconds = 0.0;
  std::string why;
};

// Of a distribution.
struct Times {
  double p50_us = 0.0, p99_us = 0.0, p9999_us = 0.0, max_us = 0.0;
};

struct Outcome {
  bool is_completed = false;
  std::string why;
  std::vector<StepOutcome> steps;
  std::uint64_t seed = 0;
  std::uint64_t hash = 0;  // over all states and commands, see StateHash
  std::uint64_t ticks = 0;
  double simulated_s = 0.0;
  double wall_s = 0.0;        // without setup
  double peak_force_N = 0.0;  // on the hand, after the safety filter
  double peak_command_N = 0.0;
  double impulse_balance = 0.0;
  // Of the hand for which it is smallest, and largest: device_bridge/passivity.hpp.
  double least_energy_J = 0.0;
  double share_made_passive = 0.0;     // of the writes to the device
  double used_stiffness_share = 1.0;   // smallest that haptic_node had
  double least_stiffness_share = 0.0;  // of allowed over wanted, see device_bridge/allowed_coupling.hpp
  std::uint64_t contact_cycles = 0;
  Times haptic, haptic_cpu;    // wall time of the haptic step, and processor time, without other workers'
  Times contact, contact_cpu;  // of those in contact
  double physics_p50_us = 0.0, physics_p99_us = 0.0, physics_max_us = 0.0;  // of one core, sheets included
  haptic_node::Counters work;                                               // summed over the run
};

// All nodes but the visual one in this process on a virtual clock: deterministic and as fast as the CPU allows. One
// tick of 1 ms: the bridge samples (and applies the command of the tick before), the haptic node answers it, physics
// steps with its proxies and contacts, the haptic node reevaluates its force, every tenth tick logic looks. What goes
// back (physics state to the haptic node and the bridge, logic's parameters to their owners) arrives one tick later, as
// it does over the bus.
core::Result<Outcome> Run(const scene::Scenario& scenario, const Options& options);

}  // namespace lockstep
