#include "tools/failures/bench.hpp"

#include <cstdio>
#include <filesystem>

#include "tools/failures/bullet_loop.hpp"
#include "tools/failures/studies/studies.hpp"

namespace failures {

int BenchMain(const bench::BenchOptions& options, const Peers& others) {
  // Said before the work: after twenty minutes the study `energy` reads the scenes that are shipped.
  const bool reads_scenes = options.only.empty() || options.only.find("energy") != std::string::npos;
  if (reads_scenes && !std::filesystem::exists("scenarios")) {
    std::fprintf(stderr, "oos bench stability: no folder scenarios in %s; run it in the source tree\n",
                 std::filesystem::current_path().c_str());
    return 2;
  }
  Peers peers{BulletPeer()};
  peers.insert(peers.end(), others.begin(), others.end());
  const auto with = [&peers](void (*study)(const Peers&, Report*)) {
    return [&peers, study](Report* report) { study(peers, report); };
  };
  std::vector<bench::Study> studies{
      {"thin", with(StudyThin)},   {"steps", StudySteps},           {"peg", StudyPeg},
      {"edges", StudyEdges},       {"boundary", StudyBoundary},     {"field", StudyField},
      {"energy", StudyEnergy},     {"impact", with(StudyImpact)},   {"bodies", with(StudyBodies)},
      {"light", StudyLightBodies}, {"penalty", StudyPenalty},       {"friction", with(StudyFriction)},
      {"pairs", StudyPairs},       {"lateness", StudyLateness},     {"deep", with(StudyDeepStart)},
      {"rest", StudyRest},         {"threads", StudyThreads},       {"long", StudyLongRun},
      {"overload", StudyOverload}, {"meshes", StudyMeshes},         {"held", StudyHeld},
      {"held_peg", StudyHeldPeg},  {"held_bodies", StudyHeldBodies}};
  if (options.only.empty()) studies.push_back({"summary", AddSummary});
  return bench::RunStudies(options, {"stability", "Failure tests F1 to F23, measured", bench::ProcessorText()}, studies,
                           others.empty() ? "MuJoCo" : "");
}

}  // namespace failures
