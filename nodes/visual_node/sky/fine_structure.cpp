#include "nodes/visual_node/sky/fine_structure.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/glm.hpp>
#include <span>

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

std::size_t PointIndex(int x, int y, int z) {
  return static_cast<std::size_t>((z * kFineSize + y) * kFineSize + x);
}

// Along one axis of n cells: how far the points around a seed at `seed` (in cells) are from it.
struct NoiseReach {
  NoiseReach(float seed, int n) {
    constexpr float kSize = kFineSize;
    const float per_point = static_cast<float>(n) / kSize;
    const int first = static_cast<int>(std::ceil((seed - 1.0f) / per_point - 0.5f));
    const int last = static_cast<int>(std::floor((seed + 1.0f) / per_point - 0.5f));
    for (int i = first; i <= last; ++i, ++num) {
      const float to = per_point * (static_cast<float>(i) + 0.5f) - seed;
      points[static_cast<std::size_t>(num)] = {(i + kFineSize) % kFineSize, to * to};
    }
  }
  struct Point {
    int at;
    float squared;
  };
  std::array<Point, kFineSize> points{};
  int num = 0;
  [[nodiscard]] std::span<const Point> all() const { return {points.data(), static_cast<std::size_t>(num)}; }
};

// One seed in each of n x n x n cells [Worley 1996]: how near a point is to the nearest one, in cells. A seed matters
// within a cell's width only, so each is taken to the points around it.
void AddNearness(int n, std::uint32_t layer, float weight, std::vector<float>* values) {
  std::vector<float> nearest2(kNumPoints, 1.0f);
  for (int cell = 0; cell < n * n * n; ++cell) {
    const glm::ivec3 at(cell % n, cell / n % n, cell / n / n);
    const std::uint32_t h = Hash(at, layer);
    const glm::vec3 seed = glm::vec3(at) + glm::vec3(h & 1023u, h >> 10 & 1023u, h >> 20 & 1023u) / 1024.0f;
    const NoiseReach xs(seed.x, n), ys(seed.y, n), zs(seed.z, n);
    for (const NoiseReach::Point& z : zs.all()) {
      for (const NoiseReach::Point& y : ys.all()) {
        const float row2 = y.squared + z.squared;
        if (row2 >= 1.0f) continue;
        float* const row = &nearest2[PointIndex(0, y.at, z.at)];
        for (const NoiseReach::Point& x : xs.all()) row[x.at] = std::min(row[x.at], x.squared + row2);
      }
    }
  }
  for (std::size_t i = 0; i < kNumPoints; ++i) (*values)[i] += weight * (1.0f - std::sqrt(nearest2[i]));
}

// Smoothly between random values at n x n x n points.
void AddWaves(int n, std::uint32_t layer, float weight, std::vector<float>* values) {
  std::vector<float> random(static_cast<std::size_t>(n * n * n));
  for (int i = 0; i < n * n * n; ++i) {
    const glm::ivec3 at(i % n, i / n % n, i / n / n);
    random[static_cast<std::size_t>(i)] = static_cast<float>(Hash(at, layer) & 0xffffu) / 65535.0f;
  }
  struct Step {
    int from, to;
    float share;
  };
  std::array<Step, kFineSize> steps{};
  for (std::size_t i = 0; i < steps.size(); ++i) {
    const float p = static_cast<float>(n) * (static_cast<float>(i) + 0.5f) / float{kFineSize}, f = p - std::floor(p);
    const int from = static_cast<int>(p);
    steps[i] = {from, (from + 1) % n, f * f * (3.0f - 2.0f * f)};
  }
  std::size_t i = 0;
  for (const Step& z : steps) {
    for (const Step& y : steps) {
      const auto row = [&](int row_y, int row_z) { return &random[static_cast<std::size_t>((row_z * n + row_y) * n)]; };
      const float *const a = row(y.from, z.from), *const b = row(y.to, z.from), *const c = row(y.from, z.to),
                         *const d = row(y.to, z.to);
      const auto at = [&](int x) {
        return glm::mix(glm::mix(a[x], b[x], y.share), glm::mix(c[x], d[x], y.share), z.share);
      };
      for (const Step& x : steps) (*values)[i++] += weight * glm::mix(at(x.from), at(x.to), x.share);
    }
  }
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
  constexpr std::array<int, 3> kCells = {5, 11, 23}, kWaves = {6, 13, 27};
  std::vector<float> puffs(kNumPoints), waves(kNumPoints);
  float weight = 1.0f;
  for (std::size_t k = 0; k < kCells.size(); ++k, weight *= 0.5f) {
    const auto layer = static_cast<std::uint32_t>(k);
    AddNearness(kCells[k], layer + 1, weight, &puffs);
    AddWaves(kWaves[k], layer, weight, &waves);
  }
  std::vector<std::uint8_t> bytes(2 * kNumPoints);
  Spread(puffs, 0, &bytes);
  Spread(waves, 1, &bytes);
  return bytes;
}

std::vector<std::uint8_t> HalveFine(const std::vector<std::uint8_t>& bytes, int size) {
  const int half = size / 2;
  std::vector<std::uint8_t> halved;
  for (int z = 0; z < half; ++z) {
    for (int y = 0; y < half; ++y) {
      for (int i = 0; i < 2 * half; ++i) {  // along x, two channels
        int sum = 4;
        for (int corner = 0; corner < 8; ++corner) {
          const int x = i / 2 * 2 + (corner & 1), row = 2 * y + (corner >> 1 & 1), layer = 2 * z + (corner >> 2);
          sum += bytes[static_cast<std::size_t>(((layer * size + row) * size + x) * 2 + i % 2)];
        }
        halved.push_back(static_cast<std::uint8_t>(sum / 8));
      }
    }
  }
  return halved;
}

}  // namespace visual_node
