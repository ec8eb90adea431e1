#include "tracking/glove.hpp"

#include "tracking/bracketed_numbers.hpp"

namespace tracking {
namespace {

constexpr std::string_view kGloveLine = "glove ";
constexpr double kHalfTurn_rad = 3.15;  // a little more, for what was rounded

}  // namespace

std::optional<FingerAngles> ParseGlove(std::string_view datagram, int hand) {
  if (!datagram.starts_with(kGloveLine)) return std::nullopt;
  const auto values = FindNumbers<1 + kNumFingerAngles>(datagram, hand);
  if (!values) return std::nullopt;
  FingerAngles angles_rad{};
  for (std::size_t i = 0; i < kNumFingerAngles; ++i) {
    angles_rad[i] = (*values)[1 + i];
    if (!(angles_rad[i] >= -kHalfTurn_rad && angles_rad[i] <= kHalfTurn_rad)) return std::nullopt;
  }
  return angles_rad;
}

}  // namespace tracking
