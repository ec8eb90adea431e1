#include "vps/surface/field_bends.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "vps/field/nearest_facet.hpp"
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

// The cells of one level with the same z, with the edge 2^shift.
class Layer {
 public:
  Layer(const DistanceField& field, const glm::ivec3& n, int shift, int z)
      : field_(field), n_(n), shift_(shift), z_(z) {}

  void Fill() {
    numbers_.resize(static_cast<std::size_t>(n_.x) * n_.y);
    const float h = static_cast<float>(1 << shift_);
    ForPlaces([&](std::size_t i, const glm::vec3& p) {
      if (numbers_[i] == 0) {
        cells_.emplace_back();
        numbers_[i] = static_cast<std::uint32_t>(cells_.size());
      }
      Cell& cell = cells_[numbers_[i] - 1];
      places_.push_back({numbers_[i] - 1, SecondDifferences(field_, p, h)});
      for (std::size_t k = 0; k < 6; ++k) cell.mean[k] += places_.back().H[k];
      ++cell.count;
    });
    for (Cell& cell : cells_) {
      for (float& value : cell.mean) value /= static_cast<float>(cell.count);
    }
    for (Place& place : places_) {
      Cell& cell = cells_[place.cell];
      for (std::size_t k = 0; k < 6; ++k) place.H[k] -= (1.0f - kKept) * cell.mean[k];
      const auto [least, most] = ExtremeEigenvalues(place.H);
      cell.most = std::max(cell.most, most);
      cell.least = std::min(cell.least, least);
    }
    places_ = {};
  }

  void AppendTo(FieldBends* bends) const {
    const auto first = static_cast<std::uint32_t>(bends->words.size() / 4);
    for (const std::uint32_t number : numbers_) bends->numbers.push_back(number == 0 ? 0 : first + number);
    const float step = kBendStep / static_cast<float>(1 << shift_);
    for (const Cell& cell : cells_) {
      const Matrix& m = cell.mean;
      bends->words.push_back(Pack(m[0], m[1], step));
      bends->words.push_back(Pack(m[2], m[3], step));
      bends->words.push_back(Pack(m[4], m[5], step));
      bends->words.push_back(Pack(cell.most, -cell.least, 2.0f * step));
    }
  }

 private:
  struct Cell {
    Matrix mean = {};
    float most = 0.0f;
    float least = 0.0f;
    std::uint32_t count = 0;
  };
  struct Place {
    std::uint32_t cell;
    Matrix H;
  };

  static std::uint32_t Pack(float low, float high, float step) {
    const auto code = [&](float v) {
      return static_cast<std::uint32_t>(
                 static_cast<std::int32_t>(std::rint(std::clamp(v / step, -32767.0f, 32767.0f)))) &
             0xffffU;
    };
    return code(low) | code(high) << 16;
  }

  // Calls visit(cell's number, place) for places of a grid that are up to h from the surface, eight in a cell with the
  // edge h (one if that is the least).
  template <class Visit>
  void ForPlaces(const Visit& visit) const {
    const int spacing = std::max(2, 1 << shift_ >> 1);
    const float reach = static_cast<float>(1 << shift_) + 1.0f;
    const float half = 0.5f * static_cast<float>(spacing);
    const glm::ivec3 coarse(field_.nx >> field_.coarse_shift, field_.ny >> field_.coarse_shift,
                            field_.nz >> field_.coarse_shift);
    // No place of a coarse cell is farther from its middle than half a diagonal.
    const float far = reach + 0.87f * static_cast<float>(1 << field_.coarse_shift);
    const int end = std::min(field_.nz, (z_ + 1) << shift_);
    for (int z = z_ << shift_; z < end; z += spacing) {
      for (int y = 0; y < field_.ny; y += spacing) {
        for (int x = 0; x < field_.nx; x += spacing) {
          const glm::vec3 p(static_cast<float>(x) + half, static_cast<float>(y) + half, static_cast<float>(z) + half);
          const glm::ivec3 at = glm::min(glm::ivec3(p) >> field_.coarse_shift, coarse - 1);  // the last are outside
          const auto cell = static_cast<std::size_t>((at.z * coarse.y + at.y) * coarse.x + at.x);
          if (std::abs(field_.coarse[cell].distance) > far) continue;
          if (std::abs(SampleField(field_, p).distance) > reach) continue;
          visit(static_cast<std::size_t>(y >> shift_) * n_.x + (x >> shift_), p);
        }
      }
    }
  }

  const DistanceField& field_;
  glm::ivec3 n_;
  int shift_, z_;
  std::vector<std::uint32_t> numbers_;  // in cells_, from 1
  std::vector<Cell> cells_;
  std::vector<Place> places_;
};

void AddLevel(const DistanceField& field, int shift, core::ParallelFor* workers, FieldBends* bends) {
  const int edge = 1 << shift;
  const glm::ivec3 n = (glm::ivec3(field.nx, field.ny, field.nz) + (edge - 1)) / edge;
  bends->begin.push_back(static_cast<std::uint32_t>(bends->numbers.size()));
  std::vector<Layer> layers;
  for (int z = 0; z < n.z; ++z) layers.emplace_back(field, n, shift, z);
  core::ForEach(workers, layers.size(), [&](std::size_t i) { layers[i].Fill(); });
  for (const Layer& layer : layers) layer.AppendTo(bends);
}

// FieldBends::inner_errors of a brick: against the triangles, at four places of each coarse cell. With a distance of
// 1 / sqrt(12) of its edge from the middle along each axis these have the second moments of the cell. Where the band
// ends only a part of a cell is coarse: of a brick of the band every eighth voxel is tried, in all layers along each
// axis. To compare neighbouring cells would not do: where the depth bends smoothly both are off by the same at their
// common face. Without triangles, what the distance and the cell's plane may both change by in the r.m.s. way from its
// middle, half an edge.
float InnerError(const DistanceField& field, const glm::ivec3& brick) {
  constexpr float kFromMiddle = 0.2887f;
  constexpr glm::vec3 kPlaces[] = {{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}};
  const float coarse = static_cast<float>(1 << field.coarse_shift);
  if (field.triangles().num_levels == 0) return coarse;
  float sum = 0.0f;
  int count = 0;
  const auto measure = [&](const glm::vec3& p) {
    const FieldSample at = SampleField(field, p);
    if (at.distance > -kDeepestExact) return;
    const double reach = static_cast<double>(std::abs(at.distance) + 2.0f * coarse);
    const NearestFacet nearest = FindNearestFacet(field.triangles(), glm::dvec3(p), reach);
    if (!nearest.is_found) return;
    const float off = at.distance - static_cast<float>(nearest.height);
    sum += off * off;
    ++count;
  };
  const glm::ivec3 n(field.nx >> 3, field.ny >> 3, field.nz >> 3);
  const bool is_of_band = field.bricks[static_cast<std::size_t>((brick.z * n.y + brick.y) * n.x + brick.x)] != 0;
  const int step = is_of_band ? 2 : 1 << field.coarse_shift;
  for (int z = 0; z < 8; z += step) {
    for (int y = 0; y < 8; y += step) {
      for (int x = 0; x < 8; x += step) {
        const glm::vec3 corner(8 * brick + glm::ivec3(x, y, z));
        if (is_of_band) {
          measure(corner + ((x + y + z) % 4 == 0 ? 0.5f : 1.5f));
        } else {
          for (const glm::vec3& to : kPlaces) measure(corner + coarse * (0.5f + kFromMiddle * to));
        }
      }
    }
  }
  return count > 0 ? std::sqrt(sum / static_cast<float>(count)) : 0.0f;
}

}  // namespace

float InnerErrorAt(const FieldBends& bends, const DistanceField& field, const glm::vec3& p) {
  const glm::ivec3 n(field.nx >> 3, field.ny >> 3, field.nz >> 3);
  const glm::ivec3 brick = glm::clamp(glm::ivec3(p) >> 3, glm::ivec3(0), n - 1);
  return bends.inner_errors[static_cast<std::size_t>((brick.z * n.y + brick.y) * n.x + brick.x)];
}

FieldBends BuildFieldBends(const DistanceField& field, core::ParallelFor* workers) {
  FieldBends bends;
  const int longest = std::max({field.nx, field.ny, field.nz});
  for (int shift = 1; shift <= kMostBendLevels && (1 << shift) < longest; ++shift) {
    AddLevel(field, shift, workers, &bends);
  }
  const glm::ivec3 n(field.nx >> 3, field.ny >> 3, field.nz >> 3);
  const auto num_bricks = static_cast<std::size_t>(n.x) * static_cast<std::size_t>(n.y) * static_cast<std::size_t>(n.z);
  for (std::size_t i = 0; i < num_bricks; ++i) {
    bends.brick_errors.push_back(i < field.errors.size() ? static_cast<float>(field.errors[i]) * kErrorStep : 0.0f);
  }
  bends.inner_errors.resize(num_bricks);
  core::ForEach(workers, static_cast<std::size_t>(n.z) * static_cast<std::size_t>(n.y), [&](std::size_t row) {
    const auto z = static_cast<int>(row) / n.y;
    const auto y = static_cast<int>(row) % n.y;
    for (int x = 0; x < n.x; ++x) {
      bends.inner_errors[row * static_cast<std::size_t>(n.x) + static_cast<std::size_t>(x)] =
          InnerError(field, {x, y, z});
    }
  });
  return bends;
}

}  // namespace vps
