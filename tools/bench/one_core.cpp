#include "tools/bench/one_core.hpp"

#include <algorithm>
#include <cstddef>
#include <limits>

namespace bench {

OneCore::OneCore() {
  if (sched_getaffinity(0, sizeof(before_), &before_) != 0) return;
  int last = -1;
  for (int i = 0; i < CPU_SETSIZE; ++i) {
    if (CPU_ISSET(i, &before_)) last = i;
  }
  if (last < 0) return;
  cpu_set_t one;
  CPU_ZERO(&one);
  CPU_SET(last, &one);
  is_pinned_ = sched_setaffinity(0, sizeof(one), &one) == 0;
}

OneCore::~OneCore() {
  if (is_pinned_) sched_setaffinity(0, sizeof(before_), &before_);
}

double Quantile(std::vector<double> values, double q) {
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(q * static_cast<double>(values.size() - 1) + 0.5);
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

}  // namespace bench
