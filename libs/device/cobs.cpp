#include "device/cobs.hpp"

namespace device {

std::size_t Stuff(std::span<const std::uint8_t> bytes, std::span<std::uint8_t, kMaxStuffed> out) {
  std::size_t size = 1, code_at = 0;
  std::uint8_t code = 1;
  for (const std::uint8_t byte : bytes) {
    if (byte != 0) {
      out[size++] = byte;
      ++code;
    }
    if (byte == 0 || code == 0xFF) {
      out[code_at] = code;
      code_at = size++;
      code = 1;
    }
  }
  out[code_at] = code;
  out[size++] = 0;
  return size;
}

bool Unstuffer::Take(std::uint8_t byte) {
  if (is_done_) {
    is_done_ = false;
    size_ = 0;
  }
  const auto add = [this](std::uint8_t value) {
    if (size_ == frame_.size()) {
      is_broken_ = true;
      return;
    }
    frame_[size_++] = value;
  };
  if (byte == 0) {
    is_done_ = !is_broken_ && left_ == 0 && size_ > 0;
    if (!is_done_) size_ = 0;
    code_ = left_ = 0;
    is_broken_ = false;
    return is_done_;
  }
  if (is_broken_) return false;
  if (left_ > 0) {
    add(byte);
    --left_;
    return false;
  }
  // A block begins; the one before ended with a zero, unless it was of the greatest length.
  if (code_ != 0 && code_ != 0xFF) add(0);
  code_ = byte;
  left_ = static_cast<std::uint8_t>(byte - 1);
  return false;
}

}  // namespace device
