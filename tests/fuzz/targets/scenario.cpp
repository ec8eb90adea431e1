#include "scene/load_scenario.hpp"
#include "tests/fuzz/claim.hpp"
#include "tests/fuzz/scratch_folder.hpp"
#include "tests/fuzz/targets.hpp"

namespace fuzz {

// The input as a scenario.xml, beside files of the names that the corpus uses. It is also the arm's file, so that a
// scenario can include itself.
void FuzzScenario(Input input) {
  static const ScratchFolder folder;
  [[maybe_unused]] static const bool is_ready = [] {
    for (const char* name : {"a.obj", "b.obj", "procedure.scxml", "operator.txt"}) folder.Write(name, {});
    return true;
  }();
  const auto scenario = scene::LoadScenario(folder.Write("scenario.xml", input));
  if (!scenario) {
    Claim(!scenario.error().empty(), "a refusal says why");
    for (const scene::Diagnostic& diagnostic : scenario.error()) Claim(!diagnostic.what.empty(), "each says what");
    return;
  }
  for (std::size_t pair = 0; pair < scenario->pairs.size(); ++pair) (void)scenario->PairName(pair);
}

}  // namespace fuzz
