#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "core/pose.hpp"
#include "tools/contact/structures.hpp"

namespace contact {

enum class Fit {
  kConforming,  // along whole faces
  kLight,       // a patch
  kDeep,        // far into each other, as no part should be
  kNear,        // within a millimetre, not touching
  kApart,       // 50 mm apart
};

// Poses X_AB of two parts. Consecutive ones are a hand's motion sampled at 1 kHz; independent ones have nothing to do
// with each other, so that what a method remembers of the last query is of no use.
struct Workload {
  std::string name;         // a file's name can be made of it
  std::string description;  // one sentence
  Fit fit = Fit::kLight;
  std::vector<core::Pose> independent;
  std::vector<std::vector<core::Pose>> walks;

  [[nodiscard]] std::vector<core::Pose> consecutive() const {
    std::vector<core::Pose> all;
    for (const auto& walk : walks) all.insert(all.end(), walk.begin(), walk.end());
    return all;
  }
};

// Workloads of the same parts.
struct PartsAndWorkloads {
  std::shared_ptr<const Parts> parts;
  std::vector<Workload> workloads;
};

struct Places {
  std::filesystem::path scenarios;
  std::filesystem::path meshes;  // public ones
};

// Names of all, in order, each made on request by MakeParts: poses are searched for, which takes seconds.
const std::vector<std::string>& PartsNames();

// Errors: a file that is missing. Always the same poses.
core::Result<PartsAndWorkloads> MakeParts(const std::string& name, const Places& places);

}  // namespace contact
