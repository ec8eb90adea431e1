#pragma once

#include <cstdint>
#include <span>

#include "core/messages/device.hpp"
#include "core/messages/haptic.hpp"
#include "core/messages/physics.hpp"

namespace bus::detail {

// The messages of fixed size that travel a thousand times a second, in protobuf's wire format [Protocol Buffers
// encoding] without protobuf's code: at that rate the library's code and tables are out of the processor's caches each
// time they are needed. Byte for byte what the library writes; what it reads, but for groups, which no .proto here has.

// Returns the size, or kDoesNotFit (bus/codec.hpp).
std::size_t EncodeFlat(const core::DeviceState& m, std::span<std::uint8_t> out) noexcept;
std::size_t EncodeFlat(const core::DeviceCommand& m, std::span<std::uint8_t> out) noexcept;
std::size_t EncodeFlat(const core::HapticProxy& m, std::span<std::uint8_t> out) noexcept;
std::size_t EncodeFlat(const core::Reaction& m, std::span<std::uint8_t> out) noexcept;

// False, with `m` as it was, when the bytes are not such a payload. Leaves the header alone.
bool DecodeFlat(std::span<const std::uint8_t> in, core::DeviceState* m) noexcept;
bool DecodeFlat(std::span<const std::uint8_t> in, core::DeviceCommand* m) noexcept;
bool DecodeFlat(std::span<const std::uint8_t> in, core::HapticProxy* m) noexcept;
bool DecodeFlat(std::span<const std::uint8_t> in, core::Reaction* m) noexcept;

}  // namespace bus::detail
