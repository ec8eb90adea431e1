#include "nodes/device_bridge/operator/operator_script.hpp"

#include "scene/load_scenario.hpp"
#include "tests/fuzz/claim.hpp"
#include "tests/fuzz/reader.hpp"

namespace fuzz {

// An operator.txt for the scenario module_replacement.
void FuzzOperatorScript(Input input) {
  static const auto scenario = scene::LoadScenario(VR_OOS_SOURCE_DIR "/scenarios/module_replacement");
  Claim(scenario.has_value(), "the scenario can be read");
  const std::string text = TextOf(input);
  const auto parsed = device_bridge::ParseOperatorScript(text, "operator.txt", *scenario, {"cover", "grasp"});
  for (const scene::Diagnostic& diagnostic : parsed.diagnostics) Claim(!diagnostic.what.empty(), "each says what");
}

}  // namespace fuzz
