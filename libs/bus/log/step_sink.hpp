#pragma once

#include <cstdint>
#include <span>

namespace bus::log {

// Takes the steps of one node, each as bytes (replay/step_codec.hpp).
class StepSink {
 public:
  virtual ~StepSink() = default;
  // False: not taken, and counted. The step thread calls it: no lock, no allocation.
  virtual bool Push(std::uint64_t tick, std::int64_t now_ns, std::span<const std::uint8_t> step) noexcept = 0;
};

}  // namespace bus::log
