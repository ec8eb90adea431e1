#pragma once

#include <filesystem>
#include <tl/expected.hpp>
#include <vector>

#include "scene/diagnostic.hpp"
#include "scene/scenario.hpp"

namespace scene {

// A scenario beyond these limits is refused. They are plausibility limits, chosen without a study: they catch lengths
// in millimetres and misplaced digits.
constexpr std::size_t kMaxDevices = 4;
constexpr double kMinVoxelSize_m = 2.0e-5;
constexpr double kMaxVoxelSize_m = 0.1;
constexpr std::uint32_t kMinPoints = 16;
constexpr std::uint32_t kMaxPoints = 4'000'000;

// Reads and checks a scenario: `path` is the scenario.xml or its folder. Returns a valid Scenario, or all errors of the
// file in order of lines. Mesh files must exist; their content is not read:
// collision::LoadResolvedScenario chooses what follows from it.
tl::expected<Scenario, std::vector<Diagnostic>> LoadScenario(const std::filesystem::path& path);

}  // namespace scene
