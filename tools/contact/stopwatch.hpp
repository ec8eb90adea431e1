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

// One method in a race.
struct Racer {
  Method* method = nullptr;
  std::vector<core::Pose> poses;  // may be fewer for slow ones
  bool by_pose = true;            // false: too quick for the clock, all poses in one reading; no p99 or max
  Times times;
};

// Times all racers on one core. They take turns, `passes` times: a pass over all poses that does not count, since the
// others have cleared the caches, then a timed one; a racer that has used up `seconds_each` drops out (after one turn
// at the earliest; slow ones go without the pass that does not count). Of every pose the median over the passes is
// kept, so that an interrupt of the operating system is not taken for a property of the method; p50, p99 and max are
// over poses.
void Race(std::span<Racer> racers, int passes, double seconds_each);

}  // namespace contact
