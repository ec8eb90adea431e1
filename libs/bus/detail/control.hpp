#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "bus/detail/latest_io.hpp"
#include "bus/envelope.hpp"

namespace oos {
class Control;
}

namespace bus::detail {

constexpr std::size_t kMaxMessageBytes = std::size_t{8} << 20;

// The bus's own messages: an envelope with one oos.Control. Not real-time.
std::vector<std::uint8_t> EncodeControl(const Identity& identity, TopicClass topic_class, const oos::Control& control);

// False when the bytes are too many, damaged, of another session, or no oos.Control.
bool DecodeControl(std::span<const std::uint8_t> bytes, std::uint64_t session, oos::Control* control);

// Class of the message that is inside.
TopicClass ClassOf(const oos::Control& control);

}  // namespace bus::detail
