#include "device/frame_link.hpp"

namespace device {
namespace {

// A device in another process can neither be moved by a simulated operator nor run in virtual time.
constexpr std::uint32_t kForeignFlags = OOS_DEVICE_IS_SIMULATED | OOS_DEVICE_TELLS_APPLIED | OOS_DEVICE_TELLS_VELOCITY;

}  // namespace

bool FrameLink::Take(std::span<const std::uint8_t> bytes, std::int64_t now_ns) {
  ReadFrame frame;
  if (DecodeFrame(bytes, &frame) != FrameFault::kNone || frame.header.kind == FrameKind::kCommand) {
    ++num_refused_;
    return false;
  }
  if (frame.header.kind == FrameKind::kDescription) {
    description_ = frame.description;
    description_.flags &= kForeignFlags;
    has_description_ = true;
    last_ns_ = now_ns;
    return true;
  }
  // A difference of sequences is read as signed, so that they may begin again after 2^32.
  const auto ahead = static_cast<std::int32_t>(frame.header.sequence - sequence_);
  const bool is_first = !has_state_ || is_silent(now_ns);
  if (!is_first && ahead <= 0) {
    ++num_refused_;
    return false;
  }
  if (!is_first) num_lost_ += static_cast<std::uint64_t>(ahead - 1);
  sequence_ = frame.header.sequence;
  TakeState(frame.state, now_ns);
  return true;
}

void FrameLink::TakeState(const oos_device_state& state, std::int64_t now_ns) {
  has_state_ = true;
  last_ns_ = now_ns;
  const std::uint32_t reflected = static_cast<std::uint32_t>(state.reflected);
  state_ = state;
  state_.sequence = ++num_samples_;
  state_.lost = num_lost_;
  const bool is_known = reflected != 0 && num_commands_ - reflected < sent_.size();
  state_.reflected = is_known ? sent_[reflected % sent_.size()] : 0;
}

Frame FrameLink::Command(const oos_device_command& command, std::int64_t now_ns) {
  FrameHeader header;
  header.kind = FrameKind::kCommand;
  header.sequence = ++num_commands_;
  header.reflected = sequence_;
  header.time_ns = now_ns;
  sent_[num_commands_ % sent_.size()] = command.sequence;
  return EncodeCommand(header, command, has_description_ ? 0 : kDescribeYourself);
}

void FrameLink::Forget() {
  has_description_ = false;
  has_state_ = false;
  sequence_ = 0;
}

}  // namespace device
