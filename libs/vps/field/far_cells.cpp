#include "vps/field/far_cells.hpp"

#include <cmath>
#include <utility>

namespace vps {
namespace {

constexpr int kSteps[3] = {1, 8, 64};
// Error of a coarse cell's plane, voxels, from which a voxel gets its own. Not derived: less costs memory and build
// time, more leaves errors that DistanceField.FarPoints* allows for 5 of 20 000 points.
constexpr float kTolerance = 0.5f;

glm::ivec3 PlaceOf(int cell) {
  return {cell & 7, cell >> 3 & 7, cell >> 6};
}

}  // namespace

template <class Visit>
void FarCells::ForNeighbours(int cell, const Visit& visit) {
  const glm::ivec3 place = PlaceOf(cell);
  for (int axis = 0; axis < 3; ++axis) {
    if (place[axis] > 0) visit(cell - kSteps[axis]);
    if (place[axis] < 7) visit(cell + kSteps[axis]);
  }
}

FarCells::FarCells(const DistanceField& field, std::span<const std::uint32_t> creases, const glm::ivec3& corner,
                   std::uint32_t* words)
    : words_(words) {
  const int shift = field.coarse_shift;
  const auto half = 0.5f * static_cast<float>(1 << shift);
  for (int i = 0; i < kNumCells; ++i) {
    const std::uint32_t word = words[i];
    switch (KindOf(word)) {
      case CellKind::kPlane:
        distance_[i] = DistanceOf(word);
        break;
      case CellKind::kCrease:  // nearer than the band: only the sign matters
        distance_[i] = DistanceOf(creases[std::size_t{RecordOf(word)} * kPlanesPerCrease]);
        break;
      case CellKind::kCoarse: {
        const glm::ivec3 voxel = corner + PlaceOf(i);
        const glm::ivec3 c(voxel.x >> shift, voxel.y >> shift, voxel.z >> shift);
        const CoarseCell& cell =
            field.coarse[(static_cast<std::size_t>(c.z) * (field.ny >> shift) + c.y) * (field.nx >> shift) + c.x];
        const glm::vec3 e = glm::vec3(voxel - (c << shift)) + (0.5f - half);
        distance_[i] = cell.distance + glm::dot(CoarseGradientOf(cell.gradient), e);
        is_open_.set(static_cast<std::size_t>(i));
        break;
      }
    }
  }
  for (int i = 0; i < kNumCells; ++i) {
    if (!is_open_[static_cast<std::size_t>(i)]) continue;
    if (std::abs(distance_[i]) < DistanceField::kBandVoxels || IsContradicted(i)) doubtful_.push_back(i);
  }
}

bool FarCells::IsContradicted(int cell) const {
  bool is_contradicted = false;
  ForNeighbours(cell, [&](int other) {
    is_contradicted = is_contradicted || std::abs(distance_[other] - distance_[cell]) > 1.0f + kTolerance;
  });
  return is_contradicted;
}

std::optional<glm::ivec3> FarCells::NextDoubtful() {
  while (!doubtful_.empty()) {
    const int cell = doubtful_.back();
    doubtful_.pop_back();
    if (!is_open_[static_cast<std::size_t>(cell)]) continue;
    if (std::abs(distance_[cell]) < DistanceField::kBandVoxels || IsContradicted(cell)) return PlaceOf(cell);
  }
  return std::nullopt;
}

void FarCells::Put(const glm::ivec3& cell, float distance, const glm::vec3& gradient) {
  const int at = (cell.z * 8 + cell.y) * 8 + cell.x;
  is_open_.reset(static_cast<std::size_t>(at));
  const float coarse = std::exchange(distance_[at], distance);
  const bool is_off = std::abs(coarse - distance) > kTolerance && std::abs(distance) < kLargestWordDistance;
  // A distance beyond a word's range is stored too near, with the right sign.
  const bool is_wrong = is_off || std::abs(coarse) < DistanceField::kBandVoxels || (coarse < 0.0f) != (distance < 0.0f);
  if (is_wrong) words_[at] = EncodePlane(distance, gradient);
  ForNeighbours(at, [&](int other) { doubtful_.push_back(other); });
}

}  // namespace vps
