#pragma once

#include <array>

#include "vps/field/distance_field.hpp"

namespace vps {

// Reorders a brick's words from rows (x fastest, then y) to WordInBrick.
inline void TileBrick(std::array<std::uint32_t, DistanceField::kBrickWords>* words) {
  const std::array<std::uint32_t, DistanceField::kBrickWords> rows = *words;
  for (std::int32_t k = 0; k < static_cast<std::int32_t>(DistanceField::kBrickWords); ++k) {
    (*words)[WordInBrick(k, k >> 3, k >> 6)] = rows[static_cast<std::size_t>(k)];
  }
}

}  // namespace vps
