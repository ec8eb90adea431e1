#pragma once

#include <bitset>
#include <glm/glm.hpp>
#include <optional>
#include <span>
#include <vector>

#include "vps/field/distance_field.hpp"

namespace vps {

// Finds the voxels of one brick whose coarse cell has a wrong plane there: off by more than the tolerance, in the band,
// or on the other side of the surface. Distances in voxels.
//
// Distances at two centres one voxel apart differ by at most 1. A voxel that differs by more from a neighbour is
// doubtful, and so is one in the band; the caller supplies its exact distance. A region of wrong distances is so
// consumed from its rim, and hardly any right voxel is measured.
class FarCells {
 public:
  // `words`: of the brick whose first voxel is `corner`, [z * 64 + y * 8 + x]; `creases`: the records that they name.
  // Only the coarse grid of `field` is read.
  FarCells(const DistanceField& field, std::span<const std::uint32_t> creases, const glm::ivec3& corner,
           std::uint32_t* words);

  // Next doubtful voxel, as place in the brick; nullopt when there is none.
  std::optional<glm::ivec3> NextDoubtful();
  // Takes the exact distance and gradient at the centre of the last one.
  void Put(const glm::ivec3& cell, float distance, const glm::vec3& gradient);

 private:
  static constexpr int kNumCells = static_cast<int>(DistanceField::kBrickWords);
  template <class Visit>
  static void ForNeighbours(int cell, const Visit& visit);
  [[nodiscard]] bool IsContradicted(int cell) const;

  std::uint32_t* words_;
  float distance_[kNumCells];       // at the centre, by the field
  std::bitset<kNumCells> is_open_;  // far, exact distance not known yet
  std::vector<int> doubtful_;       // may hold settled ones
};

}  // namespace vps
