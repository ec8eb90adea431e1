#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "core/messages/device.hpp"
#include "core/result.hpp"
#include "nodes/device_bridge/tactile/body_touch.hpp"
#include "scene/diagnostic.hpp"

namespace device_bridge {

// Interface of what a person wears: motors, or electrodes. Its driver has a thread of its own; these calls are the
// real-time thread's, and neither wait nor allocate.
class WornDevice {
 public:
  virtual ~WornDevice() = default;

  // `is_engaged`: the person holds the dead-man of the hand that the body is a part of.
  virtual void Feel(std::int64_t now_ns, const BodyTouch& touch, bool is_engaged) noexcept = 0;
  // Status, counts, levels and what else the device knows.
  virtual void Fill(core::TactileState* state) noexcept = 0;
  // In a word; the same pointer as long as it is the same. Good: it does what it is told.
  struct Condition {
    const char* text = "";
    bool is_good = false;
  };
  virtual Condition condition() noexcept = 0;

  [[nodiscard]] virtual const std::string& name() const = 0;
  [[nodiscard]] virtual bool is_simulated() const = 0;
  [[nodiscard]] virtual std::size_t num_channels() const = 0;
};

// By the device's file. Error: what is wrong with it.
core::Result<std::unique_ptr<WornDevice>> MakeWornDevice(const scene::Tactile& tactile);
// All that is wrong with it.
std::vector<scene::Diagnostic> CheckWornDevice(const scene::Tactile& tactile);

}  // namespace device_bridge
