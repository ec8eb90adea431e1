#include <cstdio>

#include "tools/oos/check_scenario.hpp"
#include "tools/oos/verb.hpp"

namespace oos {
namespace {

int Run(const Arguments& arguments) {
  int status = kHolds;
  for (const std::string& path : arguments.positional()) {
    const CheckOutcome outcome = CheckScenario(path);
    for (const std::string& problem : outcome.problems) std::printf("%s\n", problem.c_str());
    for (const std::string& note : outcome.notes) std::printf("note: %s\n", note.c_str());
    if (!outcome.problems.empty()) {
      status = kDoesNotHold;
      continue;
    }
    const scene::Scenario& scenario = *outcome.scenario;
    std::size_t num_active = 0;
    for (const scene::Pair& pair : scenario.pairs) num_active += pair.is_active ? 1 : 0;
    std::printf("%s: good. %zu objects, %zu pairs (%zu active), %zu mechanisms, %zu hands\n", scenario.name.c_str(),
                scenario.objects.size(), scenario.pairs.size(), num_active, scenario.mechanisms.size(),
                scenario.devices.size());
  }
  return status;
}

}  // namespace

Verb CheckVerb() {
  return {
      "check", "finds what is wrong with a scenario: file, line, what, why, and the fix", "SCENARIO...", 1, 1000, {},
      Run};
}

}  // namespace oos
