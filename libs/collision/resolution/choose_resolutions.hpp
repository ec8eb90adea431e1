#pragma once

#include <filesystem>
#include <string>
#include <tl/expected.hpp>
#include <vector>

#include "scene/diagnostic.hpp"
#include "scene/scenario.hpp"

namespace collision {

// Why an object has its resolution, or its side of a pair: a line for the person who wrote the scenario.
struct ResolutionNote {
  std::size_t object = 0;
  std::string text;
};

// Fills in voxel_size_m and num_points of the objects whose resolution is chosen (scene::Object), for the scenario's
// method: the finest voxels and the most points that any of their pairs wants (vps::ChooseVoxel, ChoosePoints). Of a
// pair in which both are chosen, the one with the smaller feature becomes the sampled one (vps::IsFirstSampled), else
// it keeps its sides; so its name may change. Reads the meshes of these objects and of those that they meet, and
// nothing when there are none. The same files give the same choice everywhere. Call it again when the method changes.
// Errors, with the object's file and line: a mesh that cannot be read or mended.
tl::expected<std::vector<ResolutionNote>, std::vector<scene::Diagnostic>> ChooseResolutions(scene::Scenario* scenario);

// scene::LoadScenario, then ChooseResolutions: for all who use a scenario's pairs or collision data.
tl::expected<scene::Scenario, std::vector<scene::Diagnostic>> LoadResolvedScenario(const std::filesystem::path& path);

}  // namespace collision
