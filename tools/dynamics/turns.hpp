#pragma once

#include <functional>
#include <vector>

namespace dynamics {

// Measures several pieces of work on one core, which take turns so that a change of the machine's speed affects all of
// them alike. The clock is the thread's processor time, so other programs do not count. In a turn each piece runs
// `calls` times, after a warm-up of a tenth as many. Returns for every piece the median over the turns in us per call.
std::vector<double> TakeTurns(const std::vector<std::function<void()>>& pieces, int calls, int turns);

}  // namespace dynamics
