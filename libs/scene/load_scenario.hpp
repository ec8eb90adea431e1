#pragma once

#include <filesystem>
#include <tl/expected.hpp>
#include <vector>

#include "scene/diagnostic.hpp"
#include "scene/scenario.hpp"

namespace scene {

// Limits of the bus and of what a person can have meant; beyond them a scenario is refused.
constexpr std::size_t kMaxDevices = 4;
constexpr double kMinVoxelSize_m = 2.0e-5;
// Edge of a voxel over the largest depth error near the surface that `accuracy_m` asks for: a field of method `fast` is
// off by at most 0.3 voxel, at edges (docs/decisions/0006).
constexpr double kVoxelsPerAccuracy = 3.0;
constexpr double kMaxVoxelSize_m = 0.1;
constexpr std::uint32_t kMinPoints = 16;
constexpr std::uint32_t kMaxPoints = 4'000'000;

// Reads and checks a scenario: `path` is the scenario.xml or its folder. Either a Scenario that every process can rely
// on, or all that is wrong with the file, in order of lines. Mesh files must exist; their content is not read.
tl::expected<Scenario, std::vector<Diagnostic>> LoadScenario(const std::filesystem::path& path);

}  // namespace scene
