#pragma once

#include <array>
#include <functional>
#include <vector>

#include "tools/contact/random.hpp"

namespace contact {

// Six coordinates of a body: three lengths [m], three angles [rad]. What they mean is the caller's.
using Coordinates = std::array<double, 6>;

// A hand's motion at 1 kHz: an Ornstein-Uhlenbeck process of the velocity (it forgets half of itself in about 14
// steps), so that consecutive poses are near each other and the path has no corners. `mean_step` is the mean length of
// a step of each coordinate. A step to where `is_allowed` says no is thrown back: the velocity turns round. Shorter
// than `count` when there is no way on.
std::vector<Coordinates> SmoothWalk(const Coordinates& start, const Coordinates& mean_step, int count,
                                    const std::function<bool(const Coordinates&)>& is_allowed, Random* random);

}  // namespace contact
