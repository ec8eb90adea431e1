#pragma once

#include <filesystem>
#include <string>

#include "core/result.hpp"

namespace oos {

// A launched session as the lab's hosts describe it over ssh. Any machine that may log in there can read it.
struct LabSession {
  std::string registry, session;
  std::filesystem::path scenario;  // as the launcher's machine names it
  std::filesystem::path
      keys;  // of observers and viewers, copied from the registry's host; only this user can read them
};

core::Result<LabSession> FindLabSession(const std::string& lab_file);

}  // namespace oos
