#include "view/contact_marks.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace view {
namespace {

constexpr glm::vec3 kDistanceColor{1.0f, 0.85f, 0.2f};

// gap [m] = n_G . (X_GS p_S - q_G)
double Gap_m(const core::ContactPlane& plane, const core::Pose& X_GS) {
  return glm::dot(glm::dvec3(plane.n_G), X_GS * glm::dvec3(plane.p_S) - glm::dvec3(plane.q_G));
}

// Calls visit(p_W, n_W, force_N, depth_m) for each plane that is penetrated: force = stiffness * depth along n, from G
// to S, at the point of S as it is drawn.
template <class Visit>
void VisitPenetrations(const SeenContact& contact, Visit&& visit) {
  const core::Pose X_GS = contact.X_WG.inverse() * contact.X_WS;
  for (const core::ContactPlane& plane : contact.set.planes) {
    const double depth_m = -Gap_m(plane, X_GS);
    const double force_N = plane.stiffness_N_per_m * depth_m;
    if (force_N <= 0.0) continue;
    visit(contact.X_WS_drawn * glm::dvec3(plane.p_S), contact.X_WG.rotate(glm::dvec3(plane.n_G)), force_N, depth_m);
  }
}

}  // namespace

Arrow ForceArrow(const glm::dvec3& p_W, const glm::dvec3& force_W_N, const glm::vec3& color) {
  const double force_N = glm::length(force_W_N);
  if (force_N < 1e-9) return {p_W, glm::dvec3(0.0), color};
  const double length_m = std::min(kArrowMax_m, kArrowBase_m + kArrowPerNewton_m * force_N);
  return {p_W, (length_m / force_N) * force_W_N, color};
}

RingArrow TorqueRing(const glm::dvec3& p_W, const glm::dvec3& torque_W_Nm, const glm::vec3& color) {
  RingArrow ring;
  ring.p_WCentre = p_W;
  const double torque_Nm = glm::length(torque_W_Nm);
  if (torque_Nm > 1e-12) ring.axis_W = torque_W_Nm / torque_Nm;
  ring.sweep_rad = std::min(kRingMax_rad, kRingBase_rad + kRingPerNm_rad * torque_Nm);
  ring.color = color;
  return ring;
}

glm::vec3 HeatColor(double share) {
  constexpr glm::vec3 kColors[] = {
      {0.05f, 0.15f, 1.0f}, {0.0f, 0.9f, 1.0f}, {0.1f, 1.0f, 0.1f}, {1.0f, 0.9f, 0.0f}, {1.0f, 0.05f, 0.0f}};
  const double place = 4.0 * std::clamp(share, 0.0, 1.0);
  const auto below = std::min<std::size_t>(3, static_cast<std::size_t>(place));
  return glm::mix(kColors[below], kColors[below + 1], static_cast<float>(place - static_cast<double>(below)));
}

void AddForceArrows(const SeenContact& contact, Scene* scene) {
  // Neighbouring planes with similar normals (within 37 degrees, acos 0.8) share an arrow: their summed force at their
  // centre of pressure, p = sum(force_i p_i) / sum(force_i). Limits chosen by eye.
  struct Patch {
    glm::dvec3 force_W{0.0};
    glm::dvec3 weighted_W{0.0};  // sum of force times point
    double weight_N = 0.0;
  };
  core::FixedVector<Patch, core::kMaxContactPlanes> patches;
  VisitPenetrations(contact, [&](const glm::dvec3& p_W, const glm::dvec3& n_W, double force_N, double /*depth_m*/) {
    Patch* patch = std::find_if(patches.begin(), patches.end(), [&](const Patch& other) {
      return glm::dot(other.force_W, n_W) > 0.8 * glm::length(other.force_W) &&
             glm::distance(other.weighted_W / other.weight_N, p_W) < kPatch_m;
    });
    if (patch == patches.end()) {
      patches.push_back({});
      patch = &patches.back();
    }
    patch->force_W += force_N * n_W;
    patch->weighted_W += force_N * p_W;
    patch->weight_N += force_N;
  });
  for (const Patch& patch : patches) {
    scene->arrows.push_back(ForceArrow(patch.weighted_W / patch.weight_N, patch.force_W, kContactColor));
  }
  if (!contact.set.planes.empty()) return;
  // A set with a wrench F_So = (f, tau) alone: the arrow starts at the point of the wrench's axis that is nearest to
  // So,
  //   p_SoAxis = f x tau / |f|^2,   the shortest p with p x f = the part of tau perpendicular to f.
  const core::Wrench& F = contact.set.F_So_W;
  const double square = glm::dot(F.force_N, F.force_N);
  if (square < 1e-12) return;
  const glm::dvec3 p_SoAxis_W = glm::cross(F.force_N, F.torque_Nm) / square;
  scene->arrows.push_back(ForceArrow(contact.X_WS_drawn.translation + p_SoAxis_W, F.force_N, kContactColor));
}

void AddTorqueRing(const SeenContact& contact, Scene* scene) {
  const glm::dvec3& p_WSo = contact.X_WS_drawn.translation;
  glm::dvec3 torque_W_Nm(0.0);
  VisitPenetrations(contact, [&](const glm::dvec3& p_W, const glm::dvec3& n_W, double force_N, double /*depth_m*/) {
    torque_W_Nm += glm::cross(p_W - p_WSo, force_N * n_W);
  });
  if (contact.set.planes.empty()) torque_W_Nm = contact.set.F_So_W.torque_Nm;
  if (glm::length(torque_W_Nm) < kLeastTorque_Nm) return;
  scene->rings.push_back(TorqueRing(p_WSo, torque_W_Nm, kContactColor));
}

void AddDepthPoints(const SeenContact& contact, std::vector<glm::vec3>* p_W, std::vector<glm::vec3>* colors) {
  VisitPenetrations(contact,
                    [&](const glm::dvec3& at_W, const glm::dvec3& /*n_W*/, double /*force_N*/, double depth_m) {
                      p_W->emplace_back(at_W);
                      colors->push_back(HeatColor(depth_m / kFullDepth_m));
                    });
}

void AddDistance(const SeenContact& contact, Scene* scene) {
  const core::Pose X_GS = contact.X_WG.inverse() * contact.X_WS;
  const core::ContactPlane* nearest = nullptr;
  double least_m = 0.0;
  for (const core::ContactPlane& plane : contact.set.planes) {
    const double gap_m = Gap_m(plane, X_GS);
    if (gap_m <= 0.0) return;
    if (nearest != nullptr && gap_m >= least_m) continue;
    nearest = &plane;
    least_m = gap_m;
  }
  if (nearest == nullptr) return;
  const glm::dvec3 p_W = contact.X_WS_drawn * glm::dvec3(nearest->p_S);
  const glm::dvec3 q_W = p_W - least_m * contact.X_WG.rotate(glm::dvec3(nearest->n_G));
  const std::vector<glm::vec3> ends = {glm::vec3(p_W), glm::vec3(q_W)};
  scene->lines.push_back({std::make_shared<const std::vector<glm::vec3>>(ends), kDistanceColor});
  char text[32];
  std::snprintf(text, sizeof text, "%.2f mm", 1e3 * least_m);
  scene->labels.push_back({p_W, text, kDistanceColor});
}

}  // namespace view
