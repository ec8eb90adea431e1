#include "tracking/pinch.hpp"

#include <algorithm>

#include "tracking/bracketed_numbers.hpp"

namespace tracking {
namespace {

constexpr std::string_view kPinchLine = "pinch ";
constexpr std::size_t kNumPinchValues = 5;  // number of the hand, four fingers

}  // namespace

std::optional<double> ParsePinch(std::string_view datagram, int hand) {
  if (!datagram.starts_with(kPinchLine)) return std::nullopt;
  const auto values = FindNumbers<kNumPinchValues>(datagram, hand);
  if (!values) return std::nullopt;
  double most = 0.0;
  for (std::size_t i = 1; i < kNumPinchValues; ++i) {
    const double pinch = (*values)[i];
    if (!(pinch >= 0.0 && pinch <= 1.0)) return std::nullopt;
    most = std::max(most, pinch);
  }
  return most;
}

}  // namespace tracking
