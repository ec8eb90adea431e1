#include "nodes/device_bridge/head/make_heads.hpp"

#include "nodes/device_bridge/head/dtrack_head.hpp"
#include "nodes/device_bridge/head/simulated_head.hpp"

namespace device_bridge {

core::Result<std::vector<std::unique_ptr<HeadTracker>>> MakeHeads(const std::vector<scene::User>& users,
                                                                  std::uint64_t seed) {
  std::vector<std::unique_ptr<HeadTracker>> heads;
  for (const scene::User& user : users) {
    if (user.head == "dtrack") {
      auto head = DtrackHead::Create(user);
      if (!head) return tl::unexpected(head.error());
      heads.push_back(std::move(*head));
    } else {
      heads.push_back(std::make_unique<SimulatedHead>(seed + heads.size()));
    }
  }
  return heads;
}

}  // namespace device_bridge
