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
  std::vector<std::string> notes;           // oddities that were repaired, or that may be intended
};

// Finds what is wrong with a scenario before anything starts: in the scenario file, the procedure, the operator's
// script and the meshes.
CheckOutcome CheckScenario(const std::filesystem::path& path);

// Checks the names given to --without. Errors: a name that is no node.
core::Result<void> CheckNodeNames(const std::vector<std::string>& names);

// Largest values that `run` and `launch` accept. A seed up to 2^53 is exact as a JSON number.
constexpr std::uint64_t kLargestSeed = std::uint64_t{1} << 53;
constexpr std::uint64_t kMostWorkers = 64;

}  // namespace oos
