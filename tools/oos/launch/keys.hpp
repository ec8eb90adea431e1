#pragma once

#include <filesystem>
#include <string>

#include "core/result.hpp"
#include "lab/plan.hpp"

namespace oos {

// The keys of one launch (bus/keys.hpp): made here, in a folder that only we can read, and gone with this object.
class LaunchKeys {
 public:
  LaunchKeys() = default;
  LaunchKeys(const LaunchKeys&) = delete;
  LaunchKeys& operator=(const LaunchKeys&) = delete;
  ~LaunchKeys();

  // For the nodes, for the tools ("oos") and for clients that somebody attaches.
  core::Result<void> Make(const std::filesystem::path& directory);
  [[nodiscard]] const std::filesystem::path& directory() const { return directory_; }

  // A script that writes on the host of `plan` what its members need, and no other's secret. It travels on stdin.
  [[nodiscard]] core::Result<std::string> ScriptFor(const lab::HostPlan& plan) const;

 private:
  std::filesystem::path directory_;
};

}  // namespace oos
