#pragma once

#include <cstddef>
#include <cstdint>

#include "core/messages/trace.hpp"
#include "core/pose.hpp"
#include "core/wrench.hpp"

// Types of message fields that are more than a number. The messages are made of proto/ (proto/generate.py).
namespace core {

// In place of an object index of the scenario.
constexpr std::uint16_t kNoObject = 0xffff;

// Angles of a hand's fingers that a message has room for: three for each of five.
constexpr std::size_t kMaxFingerJoints = 15;

// When a figure takes its new value: in the owner's next tick; linearly over ramp_s from there; or held until the
// change gives the scene no energy. Values are on the wire: append, never renumber.
enum class ChangeManner : std::uint8_t { kAtOnce = 0, kRamped = 1, kWhenSeparated = 2 };

}  // namespace core
