#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <tl/expected.hpp>
#include <vector>

#include "scene/diagnostic.hpp"

namespace tactile {

// A tactile USB device as a table: which one it is, what it is told once, and what its frames look like. Everything
// that differs from one laboratory's device to another's is here, in a file (README.md).

struct ControlRequest {  // vendor request to the device, without data
  std::uint8_t request = 0;
  std::uint16_t value = 0;
  std::uint16_t index = 0;
};

struct FrameField {
  enum class Kind { kConstant, kLevel, kXor };
  Kind kind = Kind::kConstant;
  std::size_t num_bytes = 1;  // little endian
  std::uint16_t value = 0;    // of a constant; of a level: what stands for all
  std::size_t channel = 0;    // of a level
};

struct UsbTable {
  std::string name;
  std::uint16_t vendor = 0;
  std::uint16_t product = 0;
  std::uint8_t interface = 0;
  std::uint8_t endpoint = 0;
  std::int64_t period_ns = 20'000'000;  // a frame is repeated after it while a motor runs
  std::size_t num_channels = 0;
  std::vector<ControlRequest> setup;  // after the device was opened
  std::vector<FrameField> frame;

  [[nodiscard]] std::size_t num_bytes() const;
};

constexpr std::size_t kMaxFrameBytes = 64;  // of an interrupt endpoint at full speed

// The table of a <usb_tactile> file, or all that is wrong with it.
tl::expected<UsbTable, std::vector<scene::Diagnostic>> ReadUsbTable(const std::filesystem::path& file);

// The bytes for these levels, 0 to 1, one for each channel. Another level counts as off.
void EncodeFrame(const UsbTable& table, std::span<const float> levels, std::vector<std::uint8_t>* bytes);
// The levels of such bytes; false: they are none.
bool DecodeFrame(const UsbTable& table, std::span<const std::uint8_t> bytes, std::vector<float>* levels);

}  // namespace tactile
