#include "tools/dynamics/turns.hpp"

#include <ctime>

#include "tools/bench/one_core.hpp"

namespace dynamics {
namespace {

double ThreadTime_us() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e6 * static_cast<double>(now.tv_sec) + 1e-3 * static_cast<double>(now.tv_nsec);
}

}  // namespace

std::vector<double> TakeTurns(const std::vector<std::function<void()>>& pieces, int calls, int turns) {
  const bench::OneCore pinned;
  std::vector<std::vector<double>> us(pieces.size());
  for (int turn = 0; turn < turns; ++turn) {
    for (std::size_t i = 0; i < pieces.size(); ++i) {
      for (int n = 0; n < calls / 10; ++n) pieces[i]();
      const double begin_us = ThreadTime_us();
      for (int n = 0; n < calls; ++n) pieces[i]();
      us[i].push_back((ThreadTime_us() - begin_us) / calls);
    }
  }
  std::vector<double> medians;
  for (const auto& of_piece : us) medians.push_back(bench::Quantile(of_piece, 0.5));
  return medians;
}

}  // namespace dynamics
