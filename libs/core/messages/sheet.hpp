#pragma once

#include <cstdint>
#include <glm/glm.hpp>

#include "core/fixed_vector.hpp"
#include "core/messages/trace.hpp"

namespace core {

constexpr std::size_t kMaxSheetNodes = 1024;

// physics/sheet/<object>: where the nodes of an object's sheet are, to be looked at. Row by row, num_columns in each.
struct SheetState {
  Header header;
  std::uint16_t object = 0xffff;  // object index in the scenario
  std::uint64_t tick = 0;
  std::uint16_t num_columns = 0;
  FixedVector<glm::vec3, kMaxSheetNodes> p_W;
};

}  // namespace core
