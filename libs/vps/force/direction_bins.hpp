#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <glm/glm.hpp>

namespace vps {

// Directions in G sorted into 26 bins: faces, edges and corners of a cube.
constexpr std::size_t kNumDirectionBins = 27;  // 3 x 3 x 3; the middle one stays empty

// A component beyond sin(22.5 deg) = cos(67.5 deg) counts as pointing that way, so bins are about 45 deg wide and the
// normals of a box's face, of a chamfer and of a corner fall into the middle of one.
constexpr float kAcross = 0.3826834f;
inline std::size_t DirectionBin(const glm::vec3& n) {
  const auto third = [](float c) { return c > kAcross ? 2 : (c < -kAcross ? 0 : 1); };
  return static_cast<std::size_t>((third(n.x) * 3 + third(n.y)) * 3 + third(n.z));
}

struct Tangents {
  glm::vec3 u{0.0f}, v{0.0f};
};

// Of the bin's own direction, so that they do not turn with the contacts; turned by 45 deg: the far points of a
// rectangle along u and v are its corners.
inline const Tangents& BinTangents(std::size_t bin) {
  static const std::array<Tangents, kNumDirectionBins> table = [] {
    std::array<Tangents, kNumDirectionBins> all;
    for (int i = 0; i < static_cast<int>(kNumDirectionBins); ++i) {
      if (i == 13) continue;
      const glm::vec3 n = glm::normalize(glm::vec3(glm::ivec3(i / 9, i / 3 % 3, i % 3) - 1));
      const glm::vec3 helper = std::abs(n.x) < 0.7f ? glm::vec3(1, 0, 0) : glm::vec3(0, 1, 0);
      const glm::vec3 u = glm::normalize(glm::cross(n, helper));
      const glm::vec3 v = glm::cross(n, u);
      all[static_cast<std::size_t>(i)] = {glm::normalize(u + v), glm::normalize(u - v)};
    }
    return all;
  }();
  return table[bin];
}

}  // namespace vps
