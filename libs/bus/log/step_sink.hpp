#pragma once

#include <cstdint>
#include <span>

namespace bus::log {

// Accepts the steps of one node, each encoded (replay/step_codec.hpp).
class StepSink {
 public:
  virtual ~StepSink() = default;
  // False: refused, and counted. Called by the step thread: no lock, no allocation.
  virtual bool Push(std::uint64_t tick, std::int64_t now_ns, std::span<const std::uint8_t> step) noexcept = 0;
};

}  // namespace bus::log
