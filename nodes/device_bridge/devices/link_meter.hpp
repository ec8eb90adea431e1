#pragma once

#include <array>
#include <cstdint>

#include "device/plugin.h"
#include "nodes/device_bridge/device_health.hpp"

namespace device_bridge {

// Measures the link to a device over windows of half a second.
class LinkMeter {
 public:
  static constexpr std::int64_t kWindow_ns = 500'000'000;

  void Forget() { *this = LinkMeter(); }
  // A command went out under this number.
  void Sent(std::uint64_t command, std::int64_t now_ns) { sent_ns_[command % sent_ns_.size()] = now_ns; }
  // A new sample came.
  void Received(const oos_device_state& state, std::int64_t now_ns);
  // True when a window has ended at now_ns: figures() are new.
  bool Update(std::int64_t now_ns);
  [[nodiscard]] const LinkFigures& figures() const { return figures_; }

 private:
  std::array<std::int64_t, 256> sent_ns_{};
  std::int64_t begin_ns_ = 0;  // of the window
  std::int64_t last_ns_ = 0;   // newest sample; 0: none
  std::int64_t longest_ns_ = 0;
  std::uint64_t num_samples_ = 0;
  std::uint64_t lost_before_ = 0, lost_now_ = 0;
  std::uint64_t reflected_ = 0;
  std::int64_t round_trips_ns_ = 0;
  std::int64_t num_round_trips_ = 0;
  LinkFigures figures_;
};

}  // namespace device_bridge
