#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

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

}  // namespace oos
