#pragma once

#include "physics/cloth/cloth_shape.hpp"

namespace physics {

// The half-space z < 0 of frame O, reported within a sphere of 1 m.
class Floor final : public ClothShape {
 public:
  Floor() : ClothShape(glm::dvec3(0.0), 1.0) {}
  double Distance(const glm::dvec3& p_O, glm::dvec3* gradient_O) const override {
    *gradient_O = {0, 0, 1};
    return p_O.z;
  }
};

}  // namespace physics
