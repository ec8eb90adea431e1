#include "vps/surface/field_bends.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "vps/surface/patch_block.hpp"

namespace vps {
namespace {

constexpr float kKept = 0.25f;  // of the mean, in `most`

using Matrix = std::array<float, 6>;

Matrix SecondDifferences(const DistanceField& field, const glm::vec3& p, float h) {
  const auto at = [&](float x, float y, float z) { return SampleField(field, p + h * glm::vec3(x, y, z)).distance; };
  const float twice = 2.0f * at(0, 0, 0);
  const float per = 1.0f / (h * h);
  return {per * (at(1, 0, 0) + at(-1, 0, 0) - twice),
          per * (at(0, 1, 0) + at(0, -1, 0) - twice),
          per * (at(0, 0, 1) + at(0, 0, -1) - twice),
          0.25f * per * (at(1, 1, 0) + at(-1, -1, 0) - at(1, -1, 0) - at(-1, 1, 0)),
          0.25f * per * (at(1, 0, 1) + at(-1, 0, -1) - at(1, 0, -1) - at(-1, 0, 1)),
          0.25f * per * (at(0, 1, 1) + at(0, -1, -1) - at(0, 1, -1) - at(0, -1, 1))};
}

// The least and the greatest eigenvalue: with the mean q of all three and p^2 = |H - q 1|^2 / 6 they are
// q + 2 p cos(phi + 2 pi k / 3), cos(3 phi) = det((H - q 1) / p) / 2 (Smith 1961).
std::pair<float, float> ExtremeEigenvalues(const Matrix& H) {
  const float q = (H[0] + H[1] + H[2]) / 3.0f;
  const float x = H[0] - q;
  const float y = H[1] - q;
  const float z = H[2] - q;
  const float p = std::sqrt((x * x + y * y + z * z + 2.0f * (H[3] * H[3] + H[4] * H[4] + H[5] * H[5])) / 6.0f);
  if (!(p > 0.0f)) return {q, q};
  const float det = x * (y * z - H[5] * H[5]) - H[3] * (H[3] * z - H[5] * H[4]) + H[4] * (H[3] * H[5] - y * H[4]);
  const float phi = std::acos(std::clamp(0.5f * det / (p * p * p), -1.0f, 1.0f)) / 3.0f;
  constexpr float kThird = 2.0943951f;  // of a turn
  return {q + 2.0f * p * std::cos(phi + kThird), q + 2.0f * p * std::cos(phi)};
}

// Calls visit(cell's number, place) for places of a grid that are up to h from the surface, eight in a cell with the
// edge h (one if that is the least).
template <class Visit>
void ForPlaces(const DistanceField& field, const glm::ivec3& n, int shift, const Visit& visit) {
  const int spacing = std::max(2, 1 << shift >> 1);
  const float reach = static_cast<float>(1 << shift) + 1.0f;
  const float half = 0.5f * static_cast<float>(spacing);
  const glm::ivec3 coarse(field.nx >> field.coarse_shift, field.ny >> field.coarse_shift,
                          field.nz >> field.coarse_shift);
  // No place of a coarse cell is farther from its middle than half a diagonal.
  const float far = reach + 0.87f * static_cast<float>(1 << field.coarse_shift);
  for (int z = 0; z < field.nz; z += spacing) {
    for (int y = 0; y < field.ny; y += spacing) {
      for (int x = 0; x < field.nx; x += spacing) {
        const glm::vec3 p(static_cast<float>(x) + half, static_cast<float>(y) + half, static_cast<float>(z) + half);
        const glm::ivec3 at = glm::min(glm::ivec3(p) >> field.coarse_shift, coarse - 1);  // the last places are outside
        const auto cell = static_cast<std::size_t>((at.z * coarse.y + at.y) * coarse.x + at.x);
        if (std::abs(field.coarse[cell].distance) > far) continue;
        if (std::abs(SampleField(field, p).distance) > reach) continue;
        const glm::ivec3 c(x >> shift, y >> shift, z >> shift);
        visit((static_cast<std::size_t>(c.z) * n.y + c.y) * n.x + c.x, p);
      }
    }
  }
}

std::uint32_t Pack(float low, float high, float step) {
  const auto code = [&](float v) {
    return static_cast<std::uint32_t>(static_cast<std::int32_t>(std::rint(std::clamp(v / step, -32767.0f, 32767.0f)))) &
           0xffffU;
  };
  return code(low) | code(high) << 16;
}

}  // namespace

FieldBends::FieldBends(const DistanceField& field) {
  const int longest = std::max({field.nx, field.ny, field.nz});
  for (int shift = 1; shift <= kMostBendLevels && (1 << shift) < longest; ++shift) Fill(field, shift);
  const auto num_bricks = static_cast<std::size_t>(field.nx >> 3) * (field.ny >> 3) * (field.nz >> 3);
  for (std::size_t i = 0; i < num_bricks; ++i) {
    brick_errors_.push_back(i < field.errors.size() ? static_cast<float>(field.errors[i]) * kErrorStep : 0.0f);
  }
}

void FieldBends::Fill(const DistanceField& field, int shift) {
  const int edge = 1 << shift;
  const glm::ivec3 n = (glm::ivec3(field.nx, field.ny, field.nz) + (edge - 1)) / edge;
  begin_.push_back(static_cast<std::uint32_t>(numbers_.size()));
  numbers_.resize(numbers_.size() + static_cast<std::size_t>(n.x) * n.y * n.z);
  std::uint32_t* const numbers = &numbers_[begin_.back()];
  const std::size_t first = words_.size() / 4;
  struct Cell {
    Matrix mean = {};
    float most = 0.0f;
    float least = 0.0f;
    std::uint32_t count = 0;
  };
  std::vector<Cell> cells;
  const float h = static_cast<float>(edge);
  ForPlaces(field, n, shift, [&](std::size_t i, const glm::vec3& p) {
    if (numbers[i] == 0) {
      cells.emplace_back();
      numbers[i] = static_cast<std::uint32_t>(first + cells.size());
    }
    Cell& cell = cells[numbers[i] - first - 1];
    const Matrix H = SecondDifferences(field, p, h);
    for (std::size_t k = 0; k < 6; ++k) cell.mean[k] += H[k];
    ++cell.count;
  });
  for (Cell& cell : cells) {
    for (float& value : cell.mean) value /= static_cast<float>(cell.count);
  }
  ForPlaces(field, n, shift, [&](std::size_t i, const glm::vec3& p) {
    Cell& cell = cells[numbers[i] - first - 1];
    Matrix H = SecondDifferences(field, p, h);
    for (std::size_t k = 0; k < 6; ++k) H[k] -= (1.0f - kKept) * cell.mean[k];
    const auto [least, most] = ExtremeEigenvalues(H);
    cell.most = std::max(cell.most, most);
    cell.least = std::min(cell.least, least);
  });
  const float step = kBendStep / h;
  for (const Cell& cell : cells) {
    const Matrix& m = cell.mean;
    words_.push_back(Pack(m[0], m[1], step));
    words_.push_back(Pack(m[2], m[3], step));
    words_.push_back(Pack(m[4], m[5], step));
    words_.push_back(Pack(cell.most, -cell.least, 2.0f * step));
  }
}

}  // namespace vps
