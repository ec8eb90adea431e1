#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>

#include "core/fixed_vector.hpp"

namespace core {

// Where a stamp in the latency chain was taken. Values are on the wire: append, never renumber.
enum class Stage : std::uint8_t {
  kDeviceSample = 1,   // device state sampled (trace origin)
  kDeviceSend = 2,     // bridge hands the sample to the socket
  kHapticReceive = 3,  // haptic_node takes it off the socket
  kHapticStart = 4,    // haptic step begins
  kHapticSend = 5,     // haptic step done, results handed to the socket
  kPhysicsReceive = 6,
  kPhysicsStart = 7,
  kPhysicsSend = 8,
  kDeviceReceive = 9,  // bridge takes a command off the socket
  kDeviceWrite = 10,   // command passed the safety filter and was written to the device
  kVisualReceive = 11,
  kVisualApply = 12,  // visual node applied the state to its scene: t2_state ends here
  kFrameStart = 13,   // first frame that shows it begins to draw
  kFrameDone = 14,    // image finished (glFinish), vsync not waited for: t2_image ends here
};

struct Stamp {
  Stage stage{};
  std::int32_t offset_ns = 0;  // since Trace::origin_ns; 2.1 s stand for all that is later
};

constexpr std::size_t kMaxStamps = 16;

// One device sample on its way through the system. Id 0 means none.
// Stamps are appended at each hop, so differences of neighbours are the hops and they add up by construction.
struct Trace {
  std::uint64_t id = 0;        // role index in the top byte, the sample's sequence number below
  std::int64_t origin_ns = 0;  // CLOCK_MONOTONIC of the device's host when the sample was taken
  FixedVector<Stamp, kMaxStamps> stamps;

  [[nodiscard]] bool valid() const { return id != 0; }
  void Add(Stage stage, std::int64_t now_ns) {
    if (valid()) stamps.push_back({stage, Offset_ns(now_ns)});
  }

 private:
  // A wrapped offset would seem to lie before the stamps in front of it.
  [[nodiscard]] std::int32_t Offset_ns(std::int64_t now_ns) const {
    using Range = std::numeric_limits<std::int32_t>;
    return static_cast<std::int32_t>(std::clamp<std::int64_t>(now_ns - origin_ns, Range::min(), Range::max()));
  }
};

constexpr std::uint64_t MakeTraceId(unsigned role_index, std::uint64_t sequence) {
  return (static_cast<std::uint64_t>(role_index + 1) << 56) | (sequence & 0x00ff'ffff'ffff'ffffULL);
}

// What every message carries besides its payload (architecture section 1).
struct Header {
  std::uint64_t sequence = 0;   // per publisher and topic, starting at 1
  std::int64_t publish_ns = 0;  // publisher's CLOCK_MONOTONIC, or virtual time in lock-step
  Trace direct;                 // newest device sample that reached this message without a physics step
  Trace through_physics;        // newest device sample that reached it through a physics step in contact
};

}  // namespace core
