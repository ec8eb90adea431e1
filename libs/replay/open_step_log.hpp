#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "bus/log/step_log.hpp"
#include "core/result.hpp"
#include "scene/scenario.hpp"

namespace replay {

// Metadata of the run in a recording of steps: "scenario" (its file, relative to the working folder when it
// is below that), "scenario_digest", "method", "seed", and DescribePlatform().
bus::log::TextMap DescribeRun(const scene::Scenario& scenario);

// Digest of the bytes of a scenario's file, procedure, operator script and meshes.
std::uint64_t DigestOf(const scene::Scenario& scenario);

// `checkpoint`: the node's state at the start of the recording, attached as "<node>.checkpoint"; empty: the initial
// state. Errors: kIo.
core::Result<std::unique_ptr<bus::log::StepLog>> OpenStepLog(const std::filesystem::path& file, const std::string& node,
                                                             const std::string& fields, const bus::log::TextMap& about,
                                                             const std::vector<std::uint8_t>& checkpoint);

// "physics_node.checkpoint".
std::string CheckpointName(const std::string& node);

}  // namespace replay
