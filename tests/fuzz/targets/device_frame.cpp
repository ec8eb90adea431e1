#include <zlib.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <vector>

#include "device/cobs.hpp"
#include "device/frame.hpp"
#include "device/frame_link.hpp"
#include "tests/fuzz/claim.hpp"
#include "tests/fuzz/reader.hpp"

namespace fuzz {
namespace {

void CheckNumbers(const double* numbers, int count) {
  for (int i = 0; i < count; ++i) Claim(std::isfinite(numbers[i]), "numbers of a frame that is taken are finite");
}

void CheckTaken(const device::ReadFrame& frame) {
  using device::FrameKind;
  if (frame.header.kind == FrameKind::kState) {
    CheckNumbers(frame.state.X_BD, 7);
    CheckNumbers(frame.state.V_BD, 6);
    CheckNumbers(frame.state.applied, 7);
    double square = 0.0;
    for (int i = 0; i < 4; ++i) square += frame.state.X_BD[i] * frame.state.X_BD[i];
    Claim(std::abs(square - 1.0) < 1e-9, "the quaternion is a unit");
  }
  if (frame.header.kind == FrameKind::kCommand) CheckNumbers(frame.command.F_Do_B, 6);
  if (frame.header.kind == FrameKind::kDescription) {
    Claim(std::memchr(frame.description.name, 0, sizeof frame.description.name) != nullptr, "a name ends");
    Claim(std::memchr(frame.description.serial, 0, sizeof frame.description.serial) != nullptr, "a serial number ends");
  }
}

}  // namespace

// A datagram of a device: as it is, and with its head and its CRC made right, which no mutation would.
void FuzzDeviceFrame(Input input) {
  device::ReadFrame frame;
  if (device::DecodeFrame(input, &frame) == device::FrameFault::kNone) CheckTaken(frame);
  std::vector<std::uint8_t> bytes(input.begin(), input.end());
  if (bytes.size() < device::kHeaderSize + device::kCrcSize) return;
  constexpr std::array<std::size_t, 4> kSizes = {device::kStateSize, device::kDescriptionSize, device::kStateSize,
                                                 device::kCommandSize};
  const std::uint8_t kind = bytes[5] % 4;
  bytes.resize(kSizes[kind]);
  std::memcpy(bytes.data(), "OOSD\x01", 5);
  bytes[5] = kind;
  const auto length = static_cast<std::uint16_t>(bytes.size());
  std::memcpy(bytes.data() + 6, &length, sizeof length);
  const auto crc =
      static_cast<std::uint32_t>(crc32(0, bytes.data(), static_cast<uInt>(bytes.size() - device::kCrcSize)));
  std::memcpy(bytes.data() + bytes.size() - device::kCrcSize, &crc, sizeof crc);
  const device::FrameFault fault = device::DecodeFrame(bytes, &frame);
  Claim(fault == device::FrameFault::kNone || fault == device::FrameFault::kNotFinite ||
            fault == device::FrameFault::kKind,
        "nothing else can be wrong with it");
  if (fault == device::FrameFault::kNone) CheckTaken(frame);
}

// Bytes of a serial line, in their order, into the link that stands for the device.
void FuzzSerialLine(Input input) {
  device::Unstuffer unstuffer;
  device::FrameLink link;
  std::int64_t now_ns = 0;
  std::uint64_t samples = 0;
  for (const std::uint8_t byte : input) {
    if (!unstuffer.Take(byte)) continue;
    const auto frame = unstuffer.bytes();
    Claim(!frame.empty() && frame.size() <= device::kMaxFrameSize, "a frame has a frame's size");
    now_ns += 1'000'000;
    link.Take(frame, now_ns);
    Claim(link.state().sequence >= samples, "samples are counted upwards");
    samples = link.state().sequence;
    // What comes out of the line is stuffed back into the same bytes, which are found again.
    std::array<std::uint8_t, device::kMaxStuffed> stuffed{};
    const std::size_t size = device::Stuff(frame, stuffed);
    device::Unstuffer again;
    bool is_found = false;
    for (std::size_t i = 0; i < size; ++i) is_found = again.Take(stuffed[i]);
    Claim(is_found && std::equal(frame.begin(), frame.end(), again.bytes().begin(), again.bytes().end()),
          "stuffing is reversible");
  }
}

}  // namespace fuzz
