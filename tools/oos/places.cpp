#include "tools/oos/places.hpp"

#include <unistd.h>

#include <cstdlib>
#include <string>

namespace oos {

std::filesystem::path SessionFolder() {
  if (const char* runtime = std::getenv("XDG_RUNTIME_DIR"); runtime != nullptr && *runtime != '\0') {
    return std::filesystem::path(runtime) / "vr_oos";
  }
  return "/tmp/vr_oos-" + std::to_string(getuid());
}

std::filesystem::path SessionFile() {
  return SessionFolder() / "session.json";
}

std::filesystem::path ProgramFolder() {
  if (const char* folder = std::getenv("VR_OOS_BIN_DIR"); folder != nullptr && *folder != '\0') return folder;
  std::error_code error;
  return std::filesystem::read_symlink("/proc/self/exe", error).parent_path();
}

}  // namespace oos
