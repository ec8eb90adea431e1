#include "tools/oos/device/candidates.hpp"

#include <algorithm>
#include <filesystem>

namespace oos {

std::vector<std::string> FindCandidates(const std::string& serial_folder, const std::string& plugin_folder) {
  std::vector<std::string> candidates;
  const auto add = [&](const std::string& type, const std::string& folder, const std::string& ending) {
    std::error_code error;
    for (const auto& entry : std::filesystem::directory_iterator(folder, error)) {
      const std::string path = entry.path().string();
      if (path.ends_with(ending)) candidates.push_back(type + ":" + path);
    }
  };
  add("serial", serial_folder, "");
  add("plugin", plugin_folder, ".so");
  candidates.emplace_back("udp:7460");
  std::sort(candidates.begin(), candidates.end());
  return candidates;
}

}  // namespace oos
