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

// What a recording of a node's steps says about the run: "scenario" (its file, relative to the working folder when it
// is below that), "scenario_digest", "method", "seed", and DescribePlatform().
bus::log::TextMap DescribeRun(const scene::Scenario& scenario);

// Of the bytes of everything that a scenario is made of: its file, procedure, operator script and meshes.
std::uint64_t DigestOf(const scene::Scenario& scenario);

// `checkpoint`: where the node stands as the recording begins, attached as "<node>.checkpoint"; empty: at its
// beginning. Errors: kIo.
core::Result<std::unique_ptr<bus::log::StepLog>> OpenStepLog(const std::filesystem::path& file, const std::string& node,
                                                             const std::string& fields, const bus::log::TextMap& about,
                                                             const std::vector<std::uint8_t>& checkpoint);

// "physics_node.checkpoint".
std::string CheckpointName(const std::string& node);

}  // namespace replay
