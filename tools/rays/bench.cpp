#include "tools/rays/bench.hpp"

#include "tools/rays/studies.hpp"

namespace rays {

int BenchMain(const bench::BenchOptions& options, const std::filesystem::path& programs,
              const std::filesystem::path& scenarios) {
  return bench::RunStudies(options, {"rays", "Goals of the ray tracer, measured", bench::ProcessorText()},
                           {{"efficiency", StudyEfficiency},
                            {"rate", [&](bench::Report* report) { StudyRate(programs, scenarios, report); }}},
                           "");
}

}  // namespace rays
