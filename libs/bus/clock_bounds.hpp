#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>
#include <map>
#include <string>
#include <vector>

#include "bus/roster.hpp"

namespace bus {

// For reports: by name of a peer, within how much this node knew its clock throughout [ns]; 0: the same machine. A peer
// whose clock was never compared for long enough is left out.
inline std::map<std::string, std::int64_t> ClockBounds(const std::vector<PeerStatus>& peers) {
  std::map<std::string, std::int64_t> bounds;
  for (const PeerStatus& peer : peers) {
    if (peer.is_observer || peer.largest_clock_bound_ns == std::numeric_limits<std::int64_t>::max()) continue;
    bounds[peer.name] = peer.largest_clock_bound_ns;
  }
  return bounds;
}

}  // namespace bus
