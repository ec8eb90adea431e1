#include "vps/field/settled_signs.hpp"

#include <algorithm>
#include <cmath>

namespace vps {

void SampleSigns::Spread(std::size_t first) {
  // By how much two balls must reach, for steps to one, two and three sides.
  static const float kReach[4] = {0.0f, 1.0f + static_cast<float>(kSettledMargin),
                                  std::sqrt(2.0f) + static_cast<float>(kSettledMargin),
                                  std::sqrt(3.0f) + static_cast<float>(kSettledMargin)};
  std::array<std::uint16_t, 512> stack;
  std::size_t size = 0;
  stack[size++] = static_cast<std::uint16_t>(first);
  while (size > 0) {
    const int at = stack[--size];
    const glm::ivec3 p(at & 7, at >> 3 & 7, at >> 6);
    const glm::ivec3 lower = glm::max(p - 1, 0);
    const glm::ivec3 upper = glm::min(p + 1, 7);
    for (int z = lower.z; z <= upper.z; ++z) {
      for (int y = lower.y; y <= upper.y; ++y) {
        for (int x = lower.x; x <= upper.x; ++x) {
          const auto to = static_cast<std::size_t>((z * 8 + y) * 8 + x);
          if (sign[to] != 0.0f || radius[to] < 0.0f) continue;
          const int sides = std::abs(x - p.x) + std::abs(y - p.y) + std::abs(z - p.z);
          if (radius[static_cast<std::size_t>(at)] + radius[to] <= kReach[sides]) continue;
          sign[to] = sign[first];
          stack[size++] = static_cast<std::uint16_t>(to);
        }
      }
    }
  }
}

}  // namespace vps
