#pragma once

#include <string>

#include "core/result.hpp"

namespace space {

// A moment in UTC, as ERFA's quasi Julian date in two parts: a day with a leap second is 86401 s long.
struct Instant {
  double utc1 = 0.0;
  double utc2 = 0.0;
};

// From "2016-03-05T12:00:00Z". Only years from 1972 (the first leap second) to 2099.
core::Result<Instant> ParseInstant(const std::string& text);

// "2016-03-05 12:00:00 UTC".
std::string FormatInstant(const Instant& instant);

// The moment that many SI seconds later.
Instant After(const Instant& instant, double seconds);

}  // namespace space
