#pragma once

#include <filesystem>
#include <string>

#include "core/result.hpp"
#include "lab/plan.hpp"

namespace oos {

// The keys of one launch (bus/security/keys.hpp), in a folder that only this user can read; removed with this object.
class LaunchKeys {
 public:
  LaunchKeys() = default;
  LaunchKeys(const LaunchKeys&) = delete;
  LaunchKeys& operator=(const LaunchKeys&) = delete;
  ~LaunchKeys();

  // Makes keys for the nodes, for the tools ("oos") and for clients that users attach.
  core::Result<void> Make(const std::filesystem::path& directory);
  [[nodiscard]] const std::filesystem::path& directory() const { return directory_; }

  // A script that writes the keys that the members on the host of `plan` need, and no other secrets. It is sent on
  // stdin.
  [[nodiscard]] core::Result<std::string> ScriptFor(const lab::HostPlan& plan) const;

 private:
  std::filesystem::path directory_;
};

}  // namespace oos
