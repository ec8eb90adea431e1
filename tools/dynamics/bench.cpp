#include "tools/dynamics/bench.hpp"

#include "tools/dynamics/studies.hpp"

namespace dynamics {

int BenchMain(const bench::BenchOptions& options, const Peers& peers) {
  const auto with = [&peers](void (*study)(const Peers&, Report*)) {
    return [&peers, study](Report* report) { study(peers, report); };
  };
  return bench::RunStudies(options, {"physics", "Goals of the dynamics, measured", bench::ProcessorText()},
                           {{"rotation", with(StudyRotation)},
                            {"rebound", with(StudyRebound)},
                            {"reduction", with(StudyReduction)},
                            {"mass_ratio", with(StudyMassRatio)},
                            {"peg", with(StudyPeg)},
                            {"cloth", with(StudyCloth)},
                            {"rows", with(StudyRows)}},
                           peers.spinners.empty() ? "MuJoCo" : "");
}

}  // namespace dynamics
