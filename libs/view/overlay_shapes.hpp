#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <memory>
#include <string>
#include <vector>

#include "core/pose.hpp"

namespace view {

// What is drawn over a scene to explain it. Plain data; positions in W [m] unless a name says otherwise. It casts no
// shadow, reflects nothing, has no object id, and looks the same in every exposure. Colours are linear RGB.

// From p_WTail to p_WTail + vector_W.
struct Arrow {
  glm::dvec3 p_WTail{0.0};
  glm::dvec3 vector_W{0.0};
  glm::vec3 color{1.0f};
};

// A torque: an arc about an axis, with a head at its end. It turns about axis_W by the right-hand rule.
struct RingArrow {
  glm::dvec3 p_WCentre{0.0};
  glm::dvec3 axis_W{0.0, 0.0, 1.0};  // of unit length
  double radius_m = 0.04;
  double sweep_rad = 1.0;
  glm::vec3 color{1.0f};
};

// Points that many frames have in common are shared, because a scene is copied at the rate of the bus.
using SharedPoints = std::shared_ptr<const std::vector<glm::vec3>>;

struct LineStrip {
  SharedPoints p_W;
  glm::vec3 color{1.0f};
  float width_px = 2.0f;  // at a picture height of 360 px
  float opacity = 1.0f;
};

// Points of a frame P that moves.
struct PointSet {
  core::Pose X_WP;
  SharedPoints p_P;
  SharedPoints colors;  // one for each point; none: all have `color`
  glm::vec3 color{1.0f};
  float size_px = 3.0f;       // at a picture height of 360 px
  float most_m = 1e6f;        // from afar they are smaller
  bool shows_through = true;  // faintly, where parts hide it
};

// Opaque cubes along the axes of a frame P that moves: voxels.
struct Cubes {
  core::Pose X_WP;
  SharedPoints p_P;  // their centres
  double edge_m = 0.001;
  glm::vec3 color{1.0f};
};

// Transparent spheres of a frame P that moves, like soap bubbles: their rims hide most.
struct Spheres {
  core::Pose X_WP;
  std::shared_ptr<const std::vector<glm::vec4>> p_P_radius_m;  // centre, radius
  glm::vec3 color{1.0f};
  float opacity = 0.5f;  // of a rim
};

// Text at a place in the world. It faces the eye, and its letters have the same size at any distance.
struct Label {
  glm::dvec3 p_W{0.0};
  std::string text;
  glm::vec3 color{1.0f};
  double clear_m = 0.0;  // around its place it hides nothing: the part that it is about
};

// Red, green and blue arrows along x, y and z.
struct Axes {
  core::Pose X_WA;
  double length_m = 0.1;
};

// A transparent copy of an instance's mesh at another pose. How phantoms overlap does not depend on their order.
struct Phantom {
  std::uint32_t instance = 0;
  core::Pose X_WM;
  glm::vec3 color{1.0f};
  float opacity = 0.35f;  // of each of its surfaces that faces the eye
};

enum class Anchor : std::uint8_t { kTopLeft, kTopRight, kBottomLeft, kBottomRight };

// A course over time, drawn as bars over the picture: the newest value is the last one, at the right.
struct Graph {
  std::string title;
  std::vector<float> values;
  float most = 1.0f;  // value of a full bar
  glm::vec3 color{1.0f};
};

}  // namespace view
