#pragma once

#include <filesystem>
#include <vector>

#include "tools/contact/reference_poses.hpp"

namespace contact {

// A case of the training set, and those of its poses at which the parts touch, with their exact wrenches.
struct TrainingCase {
  vps::WrenchCase parts;  // without poses
  std::vector<ReferencePose> posed;
};

// One case of each generated family, about a hundred poses in all: never of the held-out set. The poses and their
// references are kept in a file in `folder` (empty: they are not), which takes minutes once; its name is that of the
// source that they follow from, so that no other source reads it.
std::vector<TrainingCase> TrainingCases(const std::filesystem::path& folder);

}  // namespace contact
