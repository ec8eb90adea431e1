#pragma once

#include <span>
#include <vector>

#include "tools/bench/one_core.hpp"
#include "tools/contact/methods/method.hpp"

namespace contact {

using bench::OneCore;
using bench::Quantile;

struct Times {
  double p50_us = 0.0, p99_us = 0.0, max_us = 0.0;
};

// One method in Race.
struct Racer {
  Method* method = nullptr;
  std::vector<core::Pose> poses;  // a slow method may have fewer than the others
  bool by_pose = true;  // false: a query is too short for the clock, so a pass is timed as a whole; no p99 or max
  Times times;
  std::vector<double> by_pose_us{};  // what the times are quantiles of
};

// Times all racers on one core, turn about, `passes` turns each. A turn is an untimed pass over all poses (four in the
// first turn), because the other racers have displaced this one's data from the caches, then a timed pass. A racer that
// has used `seconds_each` has no further turn; one that has used 0.3 of it has no untimed pass. A pose's time is the
// median over its passes, which leaves out interrupts of the operating system; p50, p99 and max are over poses.
void Race(std::span<Racer> racers, int passes, double seconds_each);

}  // namespace contact
