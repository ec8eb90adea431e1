#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "device/plugin.h"

namespace device {

// The frames that a device and the bridge exchange over UDP or a serial line (docs/reference/device_protocol.md). All
// numbers are little-endian:
//
//    0  4  "OOSD"
//    4  1  version, 1
//    5  1  kind
//    6  2  length of the frame with its CRC
//    8  4  sequence: the sender's frames of this kind, from 1
//   12  4  reflected: sequence of the newest frame from the other side (of commands, of states); 0: none
//   16  8  sender's clock [ns]
//   24  .  payload, by kind
//    .  4  CRC-32 (zlib) of all bytes before
enum class FrameKind : std::uint8_t { kDescription = 1, kState = 2, kCommand = 3 };

struct FrameHeader {
  FrameKind kind = FrameKind::kState;
  std::uint32_t sequence = 0;
  std::uint32_t reflected = 0;
  std::int64_t time_ns = 0;
};

constexpr std::size_t kHeaderSize = 24;
constexpr std::size_t kCrcSize = 4;
constexpr std::size_t kDescriptionSize = kHeaderSize + 48 + 32 + 4 * 4 + 10 * 8 + kCrcSize;
constexpr std::size_t kStateSize = kHeaderSize + 2 * 4 + 22 * 8 + kCrcSize;
constexpr std::size_t kCommandSize = kHeaderSize + 2 * 4 + 9 * 8 + kCrcSize;
constexpr std::size_t kMaxFrameSize = 256;
static_assert(kDescriptionSize <= kMaxFrameSize && kStateSize <= kMaxFrameSize && kCommandSize <= kMaxFrameSize);

// Flags of a command.
constexpr std::uint32_t kDescribeYourself = 1;  // send a description

// A frame that is being written.
struct Frame {
  std::array<std::uint8_t, kMaxFrameSize> bytes{};
  std::size_t size = 0;
  [[nodiscard]] std::span<const std::uint8_t> span() const { return {bytes.data(), size}; }
};

Frame EncodeDescription(const FrameHeader& header, const oos_device_description& description);
Frame EncodeState(const FrameHeader& header, const oos_device_state& state);
Frame EncodeCommand(const FrameHeader& header, const oos_device_command& command, std::uint32_t flags);

enum class FrameFault { kNone, kShort, kNoMagic, kVersion, kKind, kLength, kCrc, kNotFinite };

// A frame that was read. Of description, state and command only the one of header.kind is filled; texts end with 0, all
// numbers are finite, and the quaternion of a state is a unit.
struct ReadFrame {
  FrameHeader header;
  oos_device_description description{};
  oos_device_state state{};
  oos_device_command command{};
  std::uint32_t command_flags = 0;
};

// Reads foreign bytes: any are allowed. The fault says why *frame is not to be used.
FrameFault DecodeFrame(std::span<const std::uint8_t> bytes, ReadFrame* frame);

const char* Describe(FrameFault fault);

}  // namespace device
