#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>
#include <map>
#include <string>
#include <vector>

#include "bus/membership/roster.hpp"

namespace bus {

// For reports: the largest bound of each peer's clock offset during the run [ns], by name; 0: the same machine. Peers
// whose clock was not compared for 1 s are left out.
inline std::map<std::string, std::int64_t> ClockBounds(const std::vector<PeerStatus>& peers) {
  std::map<std::string, std::int64_t> bounds;
  for (const PeerStatus& peer : peers) {
    if (peer.is_observer || peer.largest_clock_bound_ns == std::numeric_limits<std::int64_t>::max()) continue;
    bounds[peer.name] = peer.largest_clock_bound_ns;
  }
  return bounds;
}

}  // namespace bus
