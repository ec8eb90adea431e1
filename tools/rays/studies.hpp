#pragma once

#include <filesystem>

#include "tools/bench/report.hpp"

namespace rays {

void StudyEfficiency(bench::Report* report);
void StudyRate(const std::filesystem::path& programs, const std::filesystem::path& scenarios, bench::Report* report);

}  // namespace rays
