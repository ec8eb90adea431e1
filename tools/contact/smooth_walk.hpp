#pragma once

#include <array>
#include <functional>
#include <vector>

#include "vps/testing/case_random.hpp"

namespace contact {

// Six coordinates of a body: three lengths [m], three angles [rad]. The caller turns them into a pose.
using Coordinates = std::array<double, 6>;

// A hand's motion at 1 kHz: each coordinate's velocity is an Ornstein-Uhlenbeck process whose correlation halves in
// about 14 steps, so that consecutive poses are near each other and the path has no corners. `mean_step`: mean length
// of a step of each coordinate. Where `is_allowed` refuses a step, the velocity is reversed. The path is shorter than
// `count` when 200 steps in a row are refused.
std::vector<Coordinates> SmoothWalk(const Coordinates& start, const Coordinates& mean_step, int count,
                                    const std::function<bool(const Coordinates&)>& is_allowed, vps::CaseRandom* random);

}  // namespace contact
