#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "core/result.hpp"
#include "nodes/device_bridge/head/head_tracker.hpp"
#include "scene/scenario.hpp"

namespace device_bridge {

// The tracker of each user's head, by its kind. `seed`: of simulated ones.
core::Result<std::vector<std::unique_ptr<HeadTracker>>> MakeHeads(const std::vector<scene::User>& users,
                                                                  std::uint64_t seed);

}  // namespace device_bridge
