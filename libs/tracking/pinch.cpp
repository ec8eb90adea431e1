#include "tracking/pinch.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstddef>

namespace tracking {
namespace {

constexpr std::string_view kPinchLine = "pinch ";
constexpr std::size_t kNumPinchValues = 5;  // number of the hand, four fingers

// "id f1 f2 f3 f4", whole.
std::optional<std::array<double, kNumPinchValues>> ParsePinchValues(std::string_view text) {
  std::array<double, kNumPinchValues> values{};
  const char* at = text.data();
  const char* const end = text.data() + text.size();
  for (double& value : values) {
    while (at != end && *at == ' ') ++at;
    const auto [next, error] = std::from_chars(at, end, value);
    if (error != std::errc()) return std::nullopt;
    at = next;
  }
  if (at != end) return std::nullopt;
  return values;
}

}  // namespace

std::optional<double> ParsePinch(std::string_view datagram, int hand) {
  if (!datagram.starts_with(kPinchLine)) return std::nullopt;
  for (std::size_t open = 0; (open = datagram.find('[', open)) != std::string_view::npos; ++open) {
    const std::size_t close = datagram.find(']', open);
    if (close == std::string_view::npos) return std::nullopt;
    const auto values = ParsePinchValues(datagram.substr(open + 1, close - open - 1));
    if (!values || (*values)[0] != static_cast<double>(hand)) continue;
    double most = 0.0;
    for (std::size_t i = 1; i < kNumPinchValues; ++i) {
      const double pinch = (*values)[i];
      if (!(pinch >= 0.0 && pinch <= 1.0)) return std::nullopt;
      most = std::max(most, pinch);
    }
    return most;
  }
  return std::nullopt;
}

}  // namespace tracking
