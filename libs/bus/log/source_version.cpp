#include "bus/log/source_version.hpp"

#include <filesystem>
#include <fstream>

namespace bus::log {

std::string SourceVersion() {
  std::error_code error;
  const std::filesystem::path self = std::filesystem::read_symlink("/proc/self/exe", error);
  std::ifstream file(self.parent_path() / "version.txt");
  std::string version;
  std::getline(file, version);
  return version.empty() ? "unknown" : version;
}

}  // namespace bus::log
