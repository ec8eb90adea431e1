#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/result.hpp"
#include "scene/scenario.hpp"

namespace oos {

struct CheckOutcome {
  std::optional<scene::Scenario> scenario;  // when the scenario file itself could be read
  std::vector<std::string> problems;        // "file:line: what: why. Fix: ..."; empty: all good
  std::vector<std::string> notes;           // what is odd and was mended or may be meant so
};

// Everything that can be known to be wrong with a scenario before anything starts: the scenario file, the procedure,
// the operator's script, the content of the meshes.
CheckOutcome CheckScenario(const std::filesystem::path& path);

// Of --without. The error names the one that is no node.
core::Result<void> CheckNodeNames(const std::vector<std::string>& names);

// What `run` and `launch` take.
constexpr std::uint64_t kLargestSeed = std::uint64_t{1} << 53;
constexpr std::uint64_t kMostWorkers = 64;

}  // namespace oos
