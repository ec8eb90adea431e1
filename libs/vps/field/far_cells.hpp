#pragma once

#include <bitset>
#include <glm/glm.hpp>
#include <optional>
#include <span>
#include <vector>

#include "vps/field/distance_field.hpp"

namespace vps {

// The voxels of one brick that leave their answer to the coarse grid, and which of them must not: the plane of their
// coarse cell is off, says that they are in the band or that they are on the other side of the surface. Distances in
// voxels.
//
// Distances at two centres one voxel apart differ by 1 at most. Neighbours that are told to differ by more are
// doubtful, those in the band apart; who asks tells the exact distance. Each region of wrong answers is so consumed
// from its rim, and hardly any voxel is asked for that is right.
class FarCells {
 public:
  // `words`: of the brick whose first voxel is `corner`, [z * 64 + y * 8 + x]; `creases`: the records that they name.
  // Of the field only its coarse grid is asked.
  FarCells(const DistanceField& field, std::span<const std::uint32_t> creases, const glm::ivec3& corner,
           std::uint32_t* words);

  // Place in the brick; nothing: no more doubt.
  std::optional<glm::ivec3> NextDoubtful();
  // The exact answer at the centre of the last one.
  void Put(const glm::ivec3& cell, float distance, const glm::vec3& gradient);

 private:
  static constexpr int kNumCells = static_cast<int>(DistanceField::kBrickWords);
  template <class Visit>
  static void ForNeighbours(int cell, const Visit& visit);
  [[nodiscard]] bool IsContradicted(int cell) const;

  std::uint32_t* words_;
  float distance_[kNumCells];       // at the centre, as the field tells it
  std::bitset<kNumCells> is_open_;  // far, and not asked for yet
  std::vector<int> doubtful_;       // some are settled since
};

}  // namespace vps
