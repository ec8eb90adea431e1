#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "device/frame.hpp"

namespace device {

// Consistent Overhead Byte Stuffing [Cheshire and Baker 1999]: a frame without zero bytes, ended by one, so that a
// reader of a serial line finds the next frame wherever it begins to listen. One byte more than the frame, and the
// zero.
constexpr std::size_t kMaxStuffed = kMaxFrameSize + kMaxFrameSize / 254 + 2;

// Writes `bytes`, at most kMaxFrameSize, with the zero at the end, to `out`. Returns the number of bytes.
std::size_t Stuff(std::span<const std::uint8_t> bytes, std::span<std::uint8_t, kMaxStuffed> out);

// Finds the frames in a stream of foreign bytes. Without allocation.
class Unstuffer {
 public:
  // Takes one byte. True when it ends a frame, which bytes() then gives until the next call.
  bool Take(std::uint8_t byte);
  [[nodiscard]] std::span<const std::uint8_t> bytes() const { return {frame_.data(), size_}; }

 private:
  std::array<std::uint8_t, kMaxFrameSize> frame_{};
  std::size_t size_ = 0;
  std::uint8_t code_ = 0;   // of the present block; 0: a frame begins
  std::uint8_t left_ = 0;   // bytes of it that are still to come
  bool is_broken_ = false;  // until the next zero
  bool is_done_ = false;
};

}  // namespace device
