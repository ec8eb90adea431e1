#pragma once

#include "tools/bench/run_studies.hpp"

namespace failures {

// Runs every study of `oos bench stability`, see bench::RunStudies.
int BenchMain(const bench::BenchOptions& options);

}  // namespace failures
