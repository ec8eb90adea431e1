#include "tools/oos/verb/find_scenario.hpp"

#include <system_error>

namespace oos {

std::filesystem::path FindScenario(const std::string& given, const std::filesystem::path& program_folder) {
  std::error_code error;
  if (given.empty() || std::filesystem::exists(given, error) || given.find('/') != std::string::npos) return given;
  // <prefix>/libexec/vr-oos/oos and <source>/build/<preset>/bin/oos.
  for (const char* scenarios : {"../../share/vr-oos/scenarios", "../../../scenarios"}) {
    const std::filesystem::path folder = (program_folder / scenarios / given).lexically_normal();
    if (std::filesystem::exists(folder / "scenario.xml", error)) return folder;
  }
  return given;
}

std::filesystem::path FindScenario(const std::string& given) {
  std::error_code error;
  return FindScenario(given, std::filesystem::read_symlink("/proc/self/exe", error).parent_path());
}

}  // namespace oos
