#pragma once

#include <string>

#include "tools/oos/run/report/run_history.hpp"

namespace oos {

// Force, latency and late cycles over a run's time as SVG. Empty when the history holds none of them.
std::string DrawHistory(const RunHistory& history);

}  // namespace oos
