#include "tools/failures/bench.hpp"

#include "tools/failures/studies/studies.hpp"

namespace failures {

int BenchMain(const bench::BenchOptions& options) {
  std::vector<bench::Study> studies{
      {"thin", StudyThin},         {"steps", StudySteps},       {"peg", StudyPeg},
      {"edges", StudyEdges},       {"boundary", StudyBoundary}, {"field", StudyField},
      {"energy", StudyEnergy},     {"impact", StudyImpact},     {"bodies", StudyBodies},
      {"light", StudyLightBodies}, {"penalty", StudyPenalty},   {"friction", StudyFriction},
      {"pairs", StudyPairs},       {"lateness", StudyLateness}, {"deep", StudyDeepStart},
      {"rest", StudyRest},         {"threads", StudyThreads},   {"long", StudyLongRun},
      {"overload", StudyOverload}, {"meshes", StudyMeshes}};
  if (options.only.empty()) studies.push_back({"summary", AddSummary});
  return bench::RunStudies(options, {"stability", "Failure tests F1 to F23, measured", bench::ProcessorText()}, studies,
                           "");
}

}  // namespace failures
