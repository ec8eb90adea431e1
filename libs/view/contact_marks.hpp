#pragma once

#include <vector>

#include "core/messages/haptic.hpp"
#include "view/scene.hpp"

namespace view {

// Chosen for the eye, without a study.
// Length of an arrow [m] = min(max, base + force / N * per_newton): 15 mm for a touch, at most 150 mm, from 34 N on.
inline constexpr double kArrowBase_m = 0.015;
inline constexpr double kArrowPerNewton_m = 0.004;
inline constexpr double kArrowMax_m = 0.15;
// Sweep of a ring [rad] = min(max, base + torque / Nm * per_Nm): a quarter turn for 0.5 Nm, at most 300 degrees.
inline constexpr double kRingBase_rad = 0.5;
inline constexpr double kRingPerNm_rad = 2.1;
inline constexpr double kRingMax_rad = 5.2;
inline constexpr double kLeastTorque_Nm = 1e-3;  // none is drawn below
inline constexpr double kPatch_m = 0.03;       // contact points nearer than this share an arrow if their normals agree
inline constexpr double kFullDepth_m = 0.002;  // penetration at the red end of the colours

inline constexpr glm::vec3 kContactColor{0.20f, 0.95f, 0.35f};

Arrow ForceArrow(const glm::dvec3& p_W, const glm::dvec3& force_W_N, const glm::vec3& color);
RingArrow TorqueRing(const glm::dvec3& p_W, const glm::dvec3& torque_W_Nm, const glm::vec3& color);

// Blue at 0, then cyan, green and yellow, red at 1 and beyond. Colours between are mixed linearly.
glm::vec3 HeatColor(double share);

// A pair's contact, evaluated with the bodies' newest poses (architecture D5).
struct SeenContact {
  const core::ContactSet& set;
  core::Pose X_WS, X_WG;  // for gaps: of a hand's part, at the device's pose
  core::Pose X_WS_drawn;  // S as it is drawn: of a hand's part, at the coupling's pose
};

void AddForceArrows(const SeenContact& contact, Scene* scene);
// The contact's torque on S about its origin.
void AddTorqueRing(const SeenContact& contact, Scene* scene);
// A point at each plane that is penetrated.
void AddDepthPoints(const SeenContact& contact, std::vector<glm::vec3>* p_W, std::vector<glm::vec3>* colors);
// From the point of S that is nearest to its plane, to that plane; none when S penetrates one.
void AddDistance(const SeenContact& contact, Scene* scene);

}  // namespace view
