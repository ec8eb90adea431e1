#include "tools/oos/verb/find_scenario.hpp"

#include <algorithm>
#include <system_error>

namespace oos {
namespace {

// Below <prefix>/libexec/vr-oos/oos and <source>/build/<preset>/bin/oos.
constexpr const char* kScenarioFolders[] = {"../../share/vr-oos/scenarios", "../../../scenarios"};

std::filesystem::path FolderOfThisProgram() {
  std::error_code error;
  return std::filesystem::read_symlink("/proc/self/exe", error).parent_path();
}

}  // namespace

std::filesystem::path FindScenario(const std::string& given, const std::filesystem::path& program_folder) {
  std::error_code error;
  if (given.empty() || std::filesystem::exists(given, error) || given.find('/') != std::string::npos) return given;
  for (const char* scenarios : kScenarioFolders) {
    const std::filesystem::path folder = (program_folder / scenarios / given).lexically_normal();
    if (std::filesystem::exists(folder / "scenario.xml", error)) return folder;
  }
  return given;
}

std::filesystem::path FindScenario(const std::string& given) {
  return FindScenario(given, FolderOfThisProgram());
}

std::vector<std::string> KnownScenarios(const std::filesystem::path& program_folder) {
  std::vector<std::string> names;
  std::error_code error;
  for (const char* scenarios : kScenarioFolders) {
    for (const auto& entry : std::filesystem::directory_iterator(program_folder / scenarios, error)) {
      if (std::filesystem::exists(entry.path() / "scenario.xml", error)) names.push_back(entry.path().filename());
    }
  }
  std::sort(names.begin(), names.end());
  return names;
}

std::vector<std::string> KnownScenarios() {
  return KnownScenarios(FolderOfThisProgram());
}

}  // namespace oos
