#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/messages/logic.hpp"
#include "nodes/lockstep/replay_node.hpp"
#include "replay/difference.hpp"

namespace lockstep {

struct StepsOptions {
  double speed = 0.0;                            // times real time; 0: as fast as it goes
  replay::Tolerance tolerance;                   // default: bit for bit
  std::vector<core::ParameterChange> mutations;  // made at the first step, to see what they change
  ReplayOptions node;
};

// The largest difference of a number within a stretch of ticks, after the first one.
struct GrowthRow {
  std::uint64_t first_tick = 0, last_tick = 0;
  double distance = 0.0;
  std::string name;                // of the field
  double distance_of_first = 0.0;  // of the field that differed first
};

struct StepsOutcome {
  std::uint64_t num_steps = 0;
  std::uint64_t num_different = 0;  // steps in which anything was beyond the tolerance
  std::uint64_t num_inexact = 0;    // steps that were not the same bits
  std::uint64_t digest = 0;         // of all outputs of the replay
  double recorded_s = 0.0;          // from the first to the last step
  double cpu_s = 0.0;               // of the steps alone, without reading and comparing

  // The first difference.
  std::uint64_t tick = 0;
  double time_s = 0.0;
  replay::FieldDifference first;
  std::string name;        // topic and field
  std::string thing;       // object or mechanism
  std::size_t others = 0;  // fields that differ in the same step
  std::vector<GrowthRow> growth;
};

// Feeds a new node with the recorded inputs of every step and compares what it makes. Errors: a file that cannot be
// read, steps that are missing or cannot be repeated.
core::Result<StepsOutcome> ReplaySteps(const std::filesystem::path& file, const RecordedNode& recorded,
                                       const scene::Scenario& scenario, const StepsOptions& options);

// A few lines for people.
std::string Describe(const RecordedNode& recorded, const StepsOutcome& outcome);

}  // namespace lockstep
