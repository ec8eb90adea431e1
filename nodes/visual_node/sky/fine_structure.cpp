#include "nodes/visual_node/sky/fine_structure.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/glm.hpp>

namespace visual_node {
namespace {

constexpr std::size_t kNumPoints = std::size_t{kFineSize} * kFineSize * kFineSize;

std::uint32_t Hash(const glm::ivec3& cell, std::uint32_t layer) {
  std::uint32_t h = static_cast<std::uint32_t>(cell.x) * 0x9E3779B1u ^
                    static_cast<std::uint32_t>(cell.y) * 0x85EBCA77u ^
                    static_cast<std::uint32_t>(cell.z) * 0xC2B2AE3Du ^ layer * 0x27D4EB2Fu;
  h = (h ^ h >> 15) * 0x2C1B3C6Du;
  h = (h ^ h >> 12) * 0x297A2D39u;
  return h ^ h >> 15;
}

// One seed in each of n x n x n cells [Worley 1996]: how near a point is to the nearest one, in cells.
class Cells {
 public:
  Cells(int n, std::uint32_t layer) : n_(n), seeds_(static_cast<std::size_t>(n * n * n)) {
    for (int z = 0; z < n; ++z) {
      for (int y = 0; y < n; ++y) {
        for (int x = 0; x < n; ++x) {
          const std::uint32_t h = Hash({x, y, z}, layer);
          seeds_[Index(x, y, z)] = glm::vec3(h & 1023u, h >> 10 & 1023u, h >> 20 & 1023u) / 1024.0f;
        }
      }
    }
  }
  [[nodiscard]] float NearnessAt(const glm::vec3& p) const {
    const glm::ivec3 cell(glm::floor(p));
    float nearest2 = 3.0f;
    for (int z = cell.z - 1; z <= cell.z + 1; ++z) {
      for (int y = cell.y - 1; y <= cell.y + 1; ++y) {
        for (int x = cell.x - 1; x <= cell.x + 1; ++x) {
          const glm::vec3 to = glm::vec3(x, y, z) + seeds_[Index((x + n_) % n_, (y + n_) % n_, (z + n_) % n_)] - p;
          nearest2 = std::min(nearest2, glm::dot(to, to));
        }
      }
    }
    return std::max(1.0f - std::sqrt(nearest2), 0.0f);
  }

 private:
  [[nodiscard]] std::size_t Index(int x, int y, int z) const { return static_cast<std::size_t>((z * n_ + y) * n_ + x); }

  int n_;
  std::vector<glm::vec3> seeds_;
};

// Smoothly between random values at n x n x n points.
float Waves(const glm::vec3& p, int n, std::uint32_t layer) {
  const glm::ivec3 cell(glm::floor(p));
  const glm::vec3 f = p - glm::vec3(cell), s = f * f * (3.0f - 2.0f * f);
  float sum = 0.0f;
  for (int corner = 0; corner < 8; ++corner) {
    const glm::ivec3 at(corner & 1, corner >> 1 & 1, corner >> 2);
    const glm::vec3 share = glm::mix(1.0f - s, s, glm::vec3(at));
    sum += share.x * share.y * share.z * static_cast<float>(Hash((cell + at) % n, layer) & 0xffffu) / 65535.0f;
  }
  return sum;
}

// So that its mean is in the middle and one in a hundred values is at an end.
void Spread(const std::vector<float>& values, std::size_t channel, std::vector<std::uint8_t>* bytes) {
  double sum = 0.0, squares = 0.0;
  for (const float value : values) {
    sum += value;
    squares += static_cast<double>(value) * value;
  }
  const double mean = sum / kNumPoints, deviation = std::sqrt(squares / kNumPoints - mean * mean);
  for (std::size_t i = 0; i < kNumPoints; ++i) {
    const double code = 127.5 + 127.5 / 2.6 * (values[i] - mean) / deviation;
    (*bytes)[2 * i + channel] = static_cast<std::uint8_t>(std::lround(std::clamp(code, 0.0, 255.0)));
  }
}

}  // namespace

std::vector<std::uint8_t> FineStructure() {
  const std::array<Cells, 3> cells = {Cells(5, 1), Cells(11, 2), Cells(23, 3)};
  constexpr std::array<int, 3> kCells = {5, 11, 23}, kWaves = {6, 13, 27};
  std::vector<float> puffs(kNumPoints), waves(kNumPoints);
  for (std::size_t i = 0; i < kNumPoints; ++i) {
    const glm::vec3 p =
        (glm::vec3(i % kFineSize, i / kFineSize % kFineSize, i / kFineSize / kFineSize) + 0.5f) / float{kFineSize};
    float weight = 1.0f;
    for (std::size_t k = 0; k < cells.size(); ++k, weight *= 0.5f) {
      puffs[i] += weight * cells[k].NearnessAt(static_cast<float>(kCells[k]) * p);
      waves[i] += weight * Waves(static_cast<float>(kWaves[k]) * p, kWaves[k], static_cast<std::uint32_t>(k));
    }
  }
  std::vector<std::uint8_t> bytes(2 * kNumPoints);
  Spread(puffs, 0, &bytes);
  Spread(waves, 1, &bytes);
  return bytes;
}

}  // namespace visual_node
