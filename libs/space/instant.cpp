#include "space/instant.hpp"

#include <erfa.h>
#include <erfam.h>

#include <cmath>
#include <cstdio>

namespace space {
namespace {

constexpr int kFirstYear = 1972;
constexpr int kLastYear = 2099;

}  // namespace

core::Result<Instant> ParseInstant(const std::string& text) {
  int year = 0, month = 0, day = 0, hour = 0, minute = 0, second = 0, num_read = 0;
  const int num_fields =
      std::sscanf(text.c_str(), "%4d-%2d-%2dT%2d:%2d:%2dZ%n", &year, &month, &day, &hour, &minute, &second, &num_read);
  Instant instant;
  const bool is_complete = num_fields == 6 && text.size() == 20 && num_read == 20 && text.find(' ') == text.npos;
  if (!is_complete || year < kFirstYear || year > kLastYear || second > 59 ||
      eraDtf2d("UTC", year, month, day, hour, minute, second, &instant.utc1, &instant.utc2) < 0) {
    return core::Fail(core::ErrorCode::kInvalidInput,
                      "'" + text + "' is no moment in UTC from 1972 to 2099 such as 2016-03-05T12:00:00Z");
  }
  return instant;
}

std::string FormatInstant(const Instant& instant) {
  int year = 0, month = 0, day = 0;
  int fields[4] = {};
  eraD2dtf("UTC", 0, instant.utc1, instant.utc2, &year, &month, &day, fields);
  char text[64];
  std::snprintf(text, sizeof text, "%04d-%02d-%02d %02d:%02d:%02d UTC", year, month, day, fields[0], fields[1],
                fields[2]);
  return text;
}

Instant After(const Instant& instant, double seconds) {
  double tai1 = 0.0, tai2 = 0.0;
  eraUtctai(instant.utc1, instant.utc2, &tai1, &tai2);
  Instant later;
  eraTaiutc(tai1, tai2 + seconds / ERFA_DAYSEC, &later.utc1, &later.utc2);
  return later;
}

}  // namespace space
