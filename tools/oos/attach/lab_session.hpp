#pragma once

#include <filesystem>
#include <string>

#include "core/result.hpp"

namespace oos {

// A session that somebody launched, as the hosts of the lab describe it over ssh: from any machine that may log in
// there.
struct LabSession {
  std::string registry, session;
  std::filesystem::path scenario;  // as the launcher's machine names it
  std::filesystem::path keys;      // of lookers-on and viewers, brought from the registry's host; ours alone
};

core::Result<LabSession> FindLabSession(const std::string& lab_file);

}  // namespace oos
