#include "scene/load_scenario.hpp"

#include <algorithm>

#include "scene/read_scenario.hpp"
#include "scene/schema.hpp"
#include "scene/xml.hpp"

namespace scene {

tl::expected<Scenario, std::vector<Diagnostic>> LoadScenario(const std::filesystem::path& path) {
  std::error_code error;
  const bool is_folder = std::filesystem::is_directory(path, error);
  const std::filesystem::path file = is_folder ? path / "scenario.xml" : path;
  auto root = ReadXml(file);
  if (!root) return tl::unexpected(root.error());

  std::vector<Diagnostic> diagnostics;
  CheckAgainstRules(*root, file, &diagnostics);
  if (root->name != "scenario") return tl::unexpected(diagnostics);
  ExpandArms(file, &*root, &diagnostics);
  ExpandFingers(file, &*root, &diagnostics);
  std::vector<PairElement> pair_elements;
  Scenario scenario = ReadScenario(*root, file, &pair_elements, &diagnostics);
  CheckScenario(scenario, &diagnostics);
  GeneratePairs(pair_elements, &scenario, &diagnostics);
  if (diagnostics.empty()) return scenario;

  std::stable_sort(diagnostics.begin(), diagnostics.end(),
                   [](const Diagnostic& a, const Diagnostic& b) { return a.where.line < b.where.line; });
  return tl::unexpected(std::move(diagnostics));
}

}  // namespace scene
