#pragma once

#include <algorithm>
#include <array>

#include "vps/field/distance_field.hpp"

namespace vps {

// Reorders every brick's words from rows (x fastest, then y) to WordInBrick.
inline void TileBricks(DistanceField* field) {
  std::array<std::uint32_t, DistanceField::kBrickWords> rows;
  for (std::size_t first = 0; first < field->words.size(); first += DistanceField::kBrickWords) {
    std::uint32_t* const brick = &field->words[first];
    std::copy(brick, brick + DistanceField::kBrickWords, rows.begin());
    for (std::int32_t k = 0; k < static_cast<std::int32_t>(DistanceField::kBrickWords); ++k) {
      brick[WordInBrick(k, k >> 3, k >> 6)] = rows[static_cast<std::size_t>(k)];
    }
  }
}

}  // namespace vps
