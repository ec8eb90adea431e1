#pragma once

#include <glm/glm.hpp>

namespace physics {

// Surface of a body for the contacts of a cloth's nodes, as a signed distance.
class ClothShape {
 public:
  ClothShape(const glm::dvec3& centre_O, double radius_m) : centre_O_(centre_O), radius_m_(radius_m) {}
  virtual ~ClothShape() = default;
  ClothShape(const ClothShape&) = delete;
  ClothShape& operator=(const ClothShape&) = delete;

  // Distance [m] of a point of the mesh frame O, negative inside, and its gradient (unit, away from the body).
  virtual double Distance(const glm::dvec3& p_O, glm::dvec3* gradient_O) const = 0;

  // Bounding sphere of the surface.
  [[nodiscard]] const glm::dvec3& centre_O() const { return centre_O_; }
  [[nodiscard]] double radius_m() const { return radius_m_; }

 private:
  glm::dvec3 centre_O_;
  double radius_m_;
};

}  // namespace physics
