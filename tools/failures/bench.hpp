#pragma once

#include "tools/bench/run_studies.hpp"
#include "tools/failures/peer_loop.hpp"

namespace failures {

// Runs every study of `oos bench stability`, see bench::RunStudies. `others`: peers beside Bullet.
int BenchMain(const bench::BenchOptions& options, const Peers& others);

}  // namespace failures
