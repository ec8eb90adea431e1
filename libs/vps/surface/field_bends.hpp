#pragma once

#include <array>
#include <vector>

#include "vps/field/distance_field.hpp"

namespace vps {

// How a distance field bends at the scale of a node: for each length h = 1, 2, 4, ... voxels a grid of cells of that
// edge. From H, the matrix of second differences at spacing h divided by h^2, at places of the cell up to h from the
// surface:
//
//   mean  the mean of H [1/voxel]: what the depth of a node differs by from the depth at its centre, in the mean,
//   most  a positive semidefinite matrix above |H - 3/4 mean| at each of the places: how far it may be from that.
//
// A quarter of the mean stays in `most`, since the mean of a cell is not that of every node in it (not derived).
struct Bend {
  std::array<float, 6> mean = {};  // xx, yy, zz, xy, xz, yz, in the field's axes
  std::array<float, 6> most = {};
};

class FieldBends {
 public:
  explicit FieldBends(const DistanceField& field);

  // At p [voxels], with h of at least `reach` voxels. Null: nothing is known there of a scale that large.
  [[nodiscard]] const Bend* At(const glm::vec3& p, float reach) const;

 private:
  struct Level {
    glm::ivec3 n{0};
    std::vector<std::uint32_t> numbers;  // of each cell, in `cells`, from 1; 0: the surface is farther than h
    std::vector<Bend> cells;
  };
  void Fill(const DistanceField& field, int shift, Level* level) const;

  std::vector<Level> levels_;
};

}  // namespace vps
