#pragma once

#include <filesystem>

#include "tools/bench/run_studies.hpp"

namespace rays {

// Everything that `oos bench rays` measures (see bench::RunStudies). `programs`: the folder with rt_worker;
// `scenarios`: the one with module_replacement.
int BenchMain(const bench::BenchOptions& options, const std::filesystem::path& programs,
              const std::filesystem::path& scenarios);

}  // namespace rays
