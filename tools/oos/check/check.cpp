#include <cstdio>
#include <nlohmann/json.hpp>

#include "tools/oos/check/check_scenario.hpp"
#include "tools/oos/check/scene_json.hpp"
#include "tools/oos/check/verbs.hpp"
#include "tools/oos/verb/find_scenario.hpp"

namespace oos {
namespace {

int RunCheck(const Arguments& arguments) {
  int status = kHolds;
  for (const std::string& path : arguments.positional()) {
    const CheckOutcome outcome = CheckScenario(FindScenario(path));
    // With --json, standard output is for the program that reads it.
    std::FILE* out = arguments.has("--json") ? stderr : stdout;
    for (const std::string& problem : outcome.problems) std::fprintf(out, "%s\n", problem.c_str());
    for (const std::string& note : outcome.notes) std::fprintf(out, "note: %s\n", note.c_str());
    if (!outcome.problems.empty()) {
      status = kDoesNotHold;
      continue;
    }
    const scene::Scenario& scenario = *outcome.scenario;
    if (arguments.has("--json")) {
      const auto scene = SceneJson(scenario);
      if (!scene) return Complain("check", scene.error().detail, kDoesNotHold);
      std::printf("%s\n", scene->dump().c_str());
      continue;
    }
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
  return {"check",
          "finds what is wrong with a scenario: file, line, what, why, and the fix",
          "SCENARIO...",
          1,
          1000,
          {{"--json", "",
            "print each good scenario's objects, meshes, hands, cameras and steps, a line each, for other programs"}},
          RunCheck};
}

}  // namespace oos
