#pragma once

#include <sched.h>

#include <vector>

namespace bench {

// While it lives the calling thread stays on one core, the last one that it may use.
class OneCore {
 public:
  OneCore();
  ~OneCore();
  OneCore(const OneCore&) = delete;
  OneCore& operator=(const OneCore&) = delete;

 private:
  cpu_set_t before_;
  bool is_pinned_ = false;
};

// The value below which the part `q` of the values lies; NaN if there are none.
double Quantile(std::vector<double> values, double q);

}  // namespace bench
