#pragma once

#include <array>
#include <cstdint>

#include "device/frame.hpp"

namespace device {

// One side of a link by frames: the bridge's. It keeps the newest state and description of the device.
class FrameLink {
 public:
  // A link that was silent for longer may go on with any sequence: the device was started again.
  static constexpr std::int64_t kSilence_ns = 100'000'000;

  // Takes the bytes of one frame that came at now_ns. False: they are not a valid frame, or an old one.
  bool Take(std::span<const std::uint8_t> bytes, std::int64_t now_ns);
  // The frame for a command.
  Frame Command(const oos_device_command& command, std::int64_t now_ns);
  // Another device may be there: forgets the description and the sequence.
  void Forget();

  [[nodiscard]] bool is_silent(std::int64_t now_ns) const { return now_ns - last_ns_ > kSilence_ns; }
  [[nodiscard]] bool has_description() const { return has_description_; }
  [[nodiscard]] const oos_device_description& description() const { return description_; }
  [[nodiscard]] const oos_device_state& state() const { return state_; }  // sequence 0: none yet
  [[nodiscard]] std::uint64_t num_refused() const { return num_refused_; }

 private:
  void TakeState(const oos_device_state& state, std::int64_t now_ns);

  oos_device_description description_{};
  oos_device_state state_{};
  bool has_description_ = false;
  bool has_state_ = false;
  std::uint32_t sequence_ = 0;  // of the newest state, as sent
  std::uint32_t num_commands_ = 0;
  // Which command of ours went out under a sequence of the link, for `reflected`.
  std::array<std::uint64_t, 256> sent_{};
  std::int64_t last_ns_ = INT64_MIN / 2;
  std::uint64_t num_lost_ = 0;
  std::uint64_t num_samples_ = 0;
  std::uint64_t num_refused_ = 0;
};

}  // namespace device
