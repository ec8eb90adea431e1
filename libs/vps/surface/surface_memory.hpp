#pragma once

#include <cstdint>

namespace vps {

// Of a pair from one query to the next: the threshold that sufficed. Starting with it, one pass suffices while the
// contact changes little. The result then depends on the queries before, within the accuracy.
struct SurfaceMemory {
  double threshold_m3 = 0.0;  // 0: none
  double wanted_m3 = 0.0;
  double carrying_m2 = 0.0;  // the area that carries
  // Where a smaller threshold takes more than the budget: the most places that this one has read.
  std::uint64_t affordable_places = 0;
};

}  // namespace vps
