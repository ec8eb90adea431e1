#pragma once

#include <initializer_list>

#include "nodes/visual_node/walls/kept_ticks.hpp"

namespace visual_node {

inline KeptTicks KeptOf(std::initializer_list<std::uint64_t> ticks) {
  KeptTicks kept;
  for (const std::uint64_t tick : ticks) kept.Add(tick);
  return kept;
}

}  // namespace visual_node
