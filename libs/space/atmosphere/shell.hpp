#pragma once

#include <algorithm>
#include <cmath>

namespace space {

// The air as a shell between two spheres. A ray begins at the radius r [m] and has the cosine mu to the zenith there.
// Differences of squares are written as products, so that floats suffice.
template <typename Real>
struct Shell {
  Real bottom = 0;
  Real top = 0;

  // From the point where a ray leaves the top to where it touches the ground: half of the longest way through the air.
  [[nodiscard]] Real to_horizon() const { return std::sqrt((top - bottom) * (top + bottom)); }
  // The same for a radius.
  [[nodiscard]] Real to_horizon(Real r) const { return std::sqrt(std::max((r - bottom) * (r + bottom), Real(0))); }

  [[nodiscard]] Real DistanceToTop(Real r, Real mu) const {
    const Real b = r * mu;
    const Real c = std::max((top - r) * (top + r), Real(0));
    const Real root = std::sqrt(b * b + c);
    return b > 0 ? c / (root + b) : root - b;
  }

  // Only for a ray that meets the ground.
  [[nodiscard]] Real DistanceToBottom(Real r, Real mu) const {
    const Real b = r * mu;
    const Real c = std::max((r - bottom) * (r + bottom), Real(0));
    const Real sum = std::sqrt(std::max(b * b - c, Real(0))) - b;
    return sum > 0 ? c / sum : Real(0);
  }

  [[nodiscard]] bool MeetsGround(Real r, Real mu) const {
    const Real b = r * mu;
    return mu < 0 && b * b >= (r - bottom) * (r + bottom);
  }

  // The radius and the cosine after the distance d.
  [[nodiscard]] Real RadiusAfter(Real r, Real mu, Real d) const {
    return std::clamp(std::sqrt(std::max(d * d + Real(2) * r * mu * d + r * r, Real(0))), bottom, top);
  }
};

}  // namespace space
