#pragma once

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>
#include <numbers>

// Distances [m, negative inside] and contact wrenches of simple bodies in closed form, centred on the origin.
namespace vps::oracle {

inline double SphereDistance(const glm::dvec3& p, double radius_m) {
  return glm::length(p) - radius_m;
}

inline double BoxDistance(const glm::dvec3& p, const glm::dvec3& size_m) {
  const glm::dvec3 q = glm::abs(p) - 0.5 * size_m;
  return glm::length(glm::max(q, 0.0)) + std::min(std::max({q.x, q.y, q.z}), 0.0);
}

// Axis z.
inline double CylinderDistance(const glm::dvec3& p, double radius_m, double length_m) {
  const double a = std::hypot(p.x, p.y) - radius_m;
  const double b = std::abs(p.z) - 0.5 * length_m;
  return std::hypot(std::max(a, 0.0), std::max(b, 0.0)) + std::min(std::max(a, b), 0.0);
}

// Axis z.
inline double TorusDistance(const glm::dvec3& p, double major_m, double minor_m) {
  return std::hypot(std::hypot(p.x, p.y) - major_m, p.z) - minor_m;
}

// Without limits in x and y, of a thickness in z.
inline double PlateDistance(const glm::dvec3& p, double thickness_m) {
  return std::abs(p.z) - 0.5 * thickness_m;
}

// A block of size x size x height with a round hole along z: outside distances are exact in the hole and over the
// block's faces and edges; above the hole's rim the distance to the rim.
inline double BlockWithHoleDistance(const glm::dvec3& p, double size_m, double height_m, double hole_radius_m) {
  const double box = BoxDistance(p, {size_m, size_m, height_m});
  const double hole = hole_radius_m - std::hypot(p.x, p.y);  // positive in the hole
  const double beyond = std::abs(p.z) - 0.5 * height_m;
  if (hole > 0.0) return beyond > 0.0 ? std::hypot(hole, beyond) : hole;
  return box > 0.0 ? box : std::max(box, hole);
}

// Force per unit modulus [m^3] along the outward normal of a half space that a flat face of `area_m2` has entered
// evenly by depth: each part of the face counts its depth.
inline double PlateOnHalfSpaceForce(double area_m2, double depth_m) {
  return area_m2 * depth_m;
}

// Sphere of radius R in a half space, lowest point at depth h <= 2 R. At polar angle a from the lowest point the depth
// is h - R (1 - cos a), the upward part of the inward normal cos a, the ring 2 pi R^2 sin a da. With u = 1 - cos a from
// 0 to h / R: force = 2 pi R^2 int (h - R u) (1 - u) du = 2 pi R^2 (h^2 / (2 R) - h^3 / (6 R^2)) = pi R h^2 - pi h^3 /
// 3, the volume of the cap (Archimedes).
inline double SphereOnHalfSpaceForce(double radius_m, double depth_m) {
  return std::numbers::pi * depth_m * depth_m * (radius_m - depth_m / 3.0);
}

// Round peg pressed sideways in a round hole, both of the same axis direction, over a length: by cylinder coordinates
// around the peg's axis the depth at angle a from the direction of the shift e is, with peg radius r and hole radius R,
// |r (cos a, sin a) + (e, 0)| - R. Integrated by the midpoint rule, which is spectrally accurate up to the kinks.
inline double PegInHoleForce(double shift_m, double peg_radius_m, double hole_radius_m, double length_m) {
  constexpr int kSteps = 200'000;  // more than doubles can use: a kink costs about (2 pi / kSteps)^2 = 1e-9
  double sum = 0.0;
  for (int i = 0; i < kSteps; ++i) {
    const double a = 2.0 * std::numbers::pi * (i + 0.5) / kSteps;
    const double r = std::hypot(peg_radius_m * std::cos(a) + shift_m, peg_radius_m * std::sin(a));
    sum += std::max(0.0, r - hole_radius_m) * std::cos(a);
  }
  return sum * 2.0 * std::numbers::pi / kSteps * peg_radius_m * length_m;
}

}  // namespace vps::oracle
