#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace cli {

// The whole text as a finite number, or nothing.
std::optional<double> ReadNumber(const std::string& text);

// The whole text as decimal digits, or nothing.
std::optional<std::uint64_t> ReadCount(const std::string& text);

}  // namespace cli
