#include "tools/transport/bench.hpp"

#include "tools/transport/studies.hpp"

namespace transport {

int BenchMain(const bench::BenchOptions& options, const std::vector<Peer>& peers, double effort) {
  const Setting setting{peers, effort};
  const auto with = [&setting](void (*study)(const Setting&, Report*)) {
    return [&setting, study](Report* report) { study(setting, report); };
  };
  return bench::RunStudies(options, {"bus", "Goals of the bus, measured", bench::ProcessorText()},
                           {{"hop", with(StudyHop)},
                            {"classes", with(StudyClasses)},
                            {"age", with(StudyAge)},
                            {"load", with(StudyLoad)},
                            {"bulk", with(StudyBulk)}},
                           peers.empty() ? "LCM" : "");
}

}  // namespace transport
