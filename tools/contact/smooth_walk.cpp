#include "tools/contact/smooth_walk.hpp"

#include <cmath>

namespace contact {

std::vector<Coordinates> SmoothWalk(const Coordinates& start, const Coordinates& mean_step, int count,
                                    const std::function<bool(const Coordinates&)>& is_allowed,
                                    vps::CaseRandom* random) {
  // v' = a v + sqrt(1 - a^2) s x, x normal of variance 1: v keeps the variance s^2, and its correlation after n steps
  // is a^n. The mean of |v| is s sqrt(2 / pi), which sets s.
  constexpr double kKeep = 0.95;  // a; halves in ln 0.5 / ln 0.95 = 13.5 steps; not derived
  constexpr int kMaxTries = 200;  // not derived
  const double renew = std::sqrt(1.0 - kKeep * kKeep);
  constexpr double kMeanOfNormal = 0.7979;  // sqrt(2 / pi)
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
