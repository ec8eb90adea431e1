#pragma once

#include <vector>

#include "tools/contact/methods/method.hpp"

namespace contact {

// What planes are for: between two queries a body is held by those of the last one. They are made where a hand has come
// to a pose, and the body moves on by as far as in some cycles, to six sides.
struct PlaneFigures {
  // Of planes against a query there: force over its force, moment over force times radius.
  std::vector<double> force, moment;
  // Of a tool's planes: the least gap against that of a query there, over the way.
  std::vector<double> gap;
  std::vector<double> num_planes, num_gap_planes;
};

// Adds those of `fast` as in scenarios. `ways`: of each pose the way to it, which it ends.
void MeasurePlanes(const Cooked& A, const Cooked& B, double radius_B_m,
                   const std::vector<std::vector<core::Pose>>& ways, PlaneFigures* figures);

}  // namespace contact
