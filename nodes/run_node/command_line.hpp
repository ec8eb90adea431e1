#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "bus/log/node_recording.hpp"
#include "bus/node.hpp"
#include "cli/arguments.hpp"
#include "scene/scenario.hpp"

namespace run_node {

// Exit status of a node.
constexpr int kDone = 0;
constexpr int kFailed = 1;
constexpr int kBadUsage = 2;  // or bad input

// Prints "PROGRAM: what" to stderr and returns `status`.
int Report(const std::string& program, const std::string& what, int status);

// Options of every node on the bus: scenario, session, keys, network, recording.
std::vector<cli::Option> BusOptions();
// The checks that concern several of them. Errors: kInvalidInput.
core::Result<void> CheckBusOptions(const cli::Arguments& arguments);

bus::NodeOptions MakeNodeOptions(const std::string& name, const cli::Arguments& arguments);
bus::log::RecordingOptions MakeRecordingOptions(const cli::Arguments& arguments);

// Nothing when the program has to end with `*status`: the help was printed, or what is wrong.
std::optional<cli::Arguments> ReadCommandLine(int argc, char** argv, const cli::Syntax& syntax, int* status);

// Nothing when the file is no good; its diagnostics were printed.
std::optional<scene::Scenario> ReadScenario(const std::string& program, const std::filesystem::path& file);

}  // namespace run_node
