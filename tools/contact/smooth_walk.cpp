#include "tools/contact/smooth_walk.hpp"

#include <cmath>

namespace contact {

std::vector<Coordinates> SmoothWalk(const Coordinates& start, const Coordinates& mean_step, int count,
                                    const std::function<bool(const Coordinates&)>& is_allowed, Random* random) {
  constexpr double kKeep = 0.95;
  constexpr int kMaxTries = 200;
  const double renew = std::sqrt(1.0 - kKeep * kKeep);  // keeps the variance
  constexpr double kMeanOfNormal = 0.7979;              // mean of |x| of a normal x of variance 1
  Coordinates velocity{};
  for (std::size_t k = 0; k < velocity.size(); ++k) velocity[k] = mean_step[k] / kMeanOfNormal * random->Normal();
  std::vector<Coordinates> path = {start};
  int tries = 0;
  while (static_cast<int>(path.size()) < count && tries < kMaxTries) {
    Coordinates next = path.back();
    for (std::size_t k = 0; k < next.size(); ++k) {
      velocity[k] = kKeep * velocity[k] + renew * mean_step[k] / kMeanOfNormal * random->Normal();
      next[k] += velocity[k];
    }
    if (is_allowed(next)) {
      path.push_back(next);
      tries = 0;
      continue;
    }
    for (double& v : velocity) v *= -random->Uniform(0.3, 1.0);
    ++tries;
  }
  return path;
}

}  // namespace contact
