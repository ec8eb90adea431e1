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
  kLight,       // in a patch, below 1 mm deep
  kDeep,        // 5 to 15 mm deep
  kNear,        // within a millimetre, not touching
  kApart,       // 50 mm apart
};

// Poses X_AB of two parts. Consecutive ones are a hand's motion sampled at 1 kHz. Independent ones are drawn
// separately, so that a method gains nothing from coherence with its last query.
struct Workload {
  std::string name;         // used in file names
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

// Names that MakeParts takes, in the order of the bench.
const std::vector<std::string>& PartsNames();

// Loads or makes the meshes and searches for the poses, which takes seconds. The same poses at every call. Errors: an
// unknown name, a mesh file that is missing or refused.
core::Result<PartsAndWorkloads> MakeParts(const std::string& name, const Places& places);

}  // namespace contact
