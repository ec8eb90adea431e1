#pragma once

#include <algorithm>
#include <cmath>

#include "space/atmosphere/air.hpp"
#include "space/atmosphere/shell.hpp"

namespace space {

// How the tables sample what they depend on, after section 4 of [Bruneton and Neyret 2008] with the changes of
// [Bruneton 2017]. H is the distance to the horizon from the top, rho that from the radius r:
//   radius     rho / H,
//   view       its distance to the ground or to the top, between the least and the largest of that radius; rays that
//              meet the ground and those that do not have half of the rows each, because the horizon is an edge,
//   sun        max(1 - a / A, 0) / (1 + a), where a is the distance to the top at the ground in the sun's direction,
//              from its least (0) to its largest (1), and A the same for the lowest sun,
//   nu         linear.
// Each is a number in [0, 1]; a table of n samples has its first at 0 and its last at 1.

// A place between two samples of a table.
template <typename Real>
struct Between {
  int first = 0;
  int second = 0;
  Real share = 0;  // of the second
};

template <typename Real>
Between<Real> PlaceAmong(int num, Real x) {
  const Real at = std::clamp(x, Real(0), Real(1)) * Real(num - 1);
  const int first = std::min(static_cast<int>(at), std::max(num - 2, 0));
  return {first, std::min(first + 1, num - 1), at - Real(first)};
}

template <typename Real>
class AirMapping {
 public:
  explicit AirMapping(const Air& air)
      : shell_{Real(air.bottom_m), Real(air.top_m)},
        least_mu_s_(Real(air.least_mu_s)),
        horizon_(shell_.to_horizon()),
        least_(shell_.top - shell_.bottom),
        lowest_(SunDistance(least_mu_s_)) {}

  [[nodiscard]] const Shell<Real>& shell() const { return shell_; }

  [[nodiscard]] Real lowest() const { return lowest_; }  // A

  [[nodiscard]] Real FromRadius(Real r) const { return shell_.to_horizon(r) / horizon_; }
  [[nodiscard]] Real ToRadius(Real x) const {
    const Real rho = horizon_ * x;
    return std::clamp(std::sqrt(rho * rho + shell_.bottom * shell_.bottom), shell_.bottom, shell_.top);
  }

  // Up to the top: for the transmittance, and for rays that do not meet the ground.
  [[nodiscard]] Real FromUpward(Real r, Real mu) const {
    const Real least = shell_.top - r, most = shell_.to_horizon(r) + horizon_;
    return (shell_.DistanceToTop(r, mu) - least) / (most - least);
  }
  [[nodiscard]] Real ToUpward(Real r, Real x) const {
    const Real least = shell_.top - r, rho = shell_.to_horizon(r), most = rho + horizon_;
    const Real d = least + x * (most - least);
    if (d == 0) return Real(1);
    return std::clamp(((horizon_ - rho) * (horizon_ + rho) - d * d) / (Real(2) * r * d), Real(-1), Real(1));
  }

  // Down to the ground.
  [[nodiscard]] Real FromDownward(Real r, Real mu) const {
    const Real least = r - shell_.bottom, most = shell_.to_horizon(r);
    return most > least ? (shell_.DistanceToBottom(r, mu) - least) / (most - least) : Real(0);
  }
  [[nodiscard]] Real ToDownward(Real r, Real x) const {
    const Real least = r - shell_.bottom, rho = shell_.to_horizon(r);
    const Real d = least + x * (rho - least);
    if (d == 0) return Real(-1);
    return std::clamp(-(rho * rho + d * d) / (Real(2) * r * d), Real(-1), Real(1));
  }

  [[nodiscard]] Real FromSun(Real mu_s) const {
    const Real a = SunDistance(mu_s);
    return std::max(Real(1) - a / lowest_, Real(0)) / (Real(1) + a);
  }
  [[nodiscard]] Real ToSun(Real x) const {
    const Real a = (lowest_ - x * lowest_) / (Real(1) + x * lowest_);
    const Real d = least_ + std::min(a, lowest_) * (horizon_ - least_);
    return std::clamp((horizon_ * horizon_ - d * d) / (Real(2) * shell_.bottom * d), Real(-1), Real(1));
  }

 private:
  [[nodiscard]] Real SunDistance(Real mu_s) const {
    return (shell_.DistanceToTop(shell_.bottom, mu_s) - least_) / (horizon_ - least_);
  }

  Shell<Real> shell_;
  Real least_mu_s_;
  Real horizon_;
  Real least_;
  Real lowest_;
};

}  // namespace space
