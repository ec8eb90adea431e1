#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "bus/latest/latest_io.hpp"
#include "bus/wire/envelope.hpp"

namespace oos {
class Control;
}

namespace bus::detail {

// A snapshot of some 120 STATE values of the largest size fits; more would hold the bus thread up.
constexpr std::size_t kMaxMessageBytes = std::size_t{8} << 20;

// Messages of the bus protocol itself: an envelope with one oos.Control. Not real-time.
std::vector<std::uint8_t> EncodeControl(const Identity& identity, TopicClass topic_class, const oos::Control& control);

// False: too long, damaged, of another session, or not an oos.Control.
bool DecodeControl(std::span<const std::uint8_t> bytes, std::uint64_t session, oos::Control* control);

// The class by which such a message travels.
TopicClass ClassOf(const oos::Control& control);

}  // namespace bus::detail
