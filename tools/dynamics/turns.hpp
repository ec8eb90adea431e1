#pragma once

#include <functional>
#include <vector>

namespace dynamics {

// Times of several pieces of work on one core, which take turns: a change of the machine's speed meets all of them.
// Processor time of the thread, so what other programs take does not count. Each piece runs `calls` times a turn, after
// a tenth as many that do not count; of every piece the median over the turns in us per call.
std::vector<double> TakeTurns(const std::vector<std::function<void()>>& pieces, int calls, int turns);

}  // namespace dynamics
