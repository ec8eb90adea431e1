#pragma once

#include <cstdint>
#include <optional>

#include "core/pose.hpp"

namespace device_bridge {

// Interface of trackers of a person's head, real and simulated. R is the room, H the head (view/room.hpp). Times are
// CLOCK_MONOTONIC of this host and do not decrease. Read is called by the real-time thread: it neither blocks,
// allocates nor throws.
class HeadTracker {
 public:
  virtual ~HeadTracker() = default;

  // X_RH, newer than that of the last call; none: nothing new has been seen.
  virtual std::optional<core::Pose> Read(std::int64_t now_ns) noexcept = 0;

  [[nodiscard]] virtual bool is_simulated() const = 0;
  [[nodiscard]] virtual const char* description() const = 0;
};

}  // namespace device_bridge
