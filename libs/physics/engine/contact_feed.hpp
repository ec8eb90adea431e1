#pragma once

#include <BulletCollision/NarrowPhaseCollision/btPersistentManifold.h>

#include <array>
#include <vector>

#include "core/messages/haptic.hpp"
#include "core/pose.hpp"
#include "physics/checkpoint.hpp"
#include "physics/contact_kind.hpp"
#include "physics/engine/contact_law.hpp"

class btDispatcher;
class btRigidBody;

namespace physics {

// Planes of one pair (architecture D5) as Bullet manifolds. A manifold has room for four points, so each pair has
// several; they are created once and refilled in each step, so a step does not allocate. Points are written directly,
// as addManifoldPoint would merge and drop neighbours.
class ContactFeed {
 public:
  ContactFeed(btDispatcher* dispatcher, btRigidBody* sampled, btRigidBody* field, ContactKind kind);
  ContactFeed(ContactFeed&& other) noexcept = default;

  void Set(const core::ContactSet& set);
  // The planes with their impulses; the manifolds are filled from them in each step.
  void ExchangeState(Checkpoint* checkpoint);
  void Clear();
  void Rest();  // removes the points from the solver, keeps the planes
  // The same, for a time in which they exert no force: the next contact does not start from the last one's impulses.
  void Mute();
  [[nodiscard]] bool empty() const { return num_planes_ == 0; }

  // Evaluates every gap at the poses of the start of the step, g = n . (X_WS p_S - X_WG q_G) [m], and fills the
  // manifolds. Planes with a positive gap are included, so that contact can begin within the step.
  void Inject(const core::Pose& X_WS, const core::Pose& X_WG, double dt_s);
  // Reads the impulses back, for the warm start, and calls visit(p_W, impulse on S in W) for each point with an
  // impulse.
  template <typename Visit>
  void Collect(Visit&& visit);

  // Work that the bodies have done against the planes since these began to push, less what has come back.
  [[nodiscard]] double paid_J() const { return paid_J_; }

  // Number of planes, then id and normal impulse of each.
  template <typename Visit>
  void VisitImpulses(Visit&& visit) const {
    visit(num_planes_);
    for (int i = 0; i < num_planes_; ++i) {
      const Plane& plane = planes_[static_cast<std::size_t>(i)];
      visit(plane.plane.id);
      visit(plane.impulse);
    }
  }

  // Smallest gap [m] over the planes whose normal is within 60 degrees of `along_W`, or over all if that is null.
  [[nodiscard]] double SmallestGap(const core::Pose& X_WS, const core::Pose& X_WG, glm::dvec3* p_W,
                                   const glm::dvec3* along_W = nullptr) const;
  // Mean distance [m] of the planes' points from their middle, each with the force of its spring as weight; 0: nothing
  // presses.
  [[nodiscard]] double PressedRadius(const core::Pose& X_WS, const core::Pose& X_WG) const;

 private:
  static constexpr int kPerManifold = 4;
  static constexpr int kNumManifolds = static_cast<int>(core::kMaxContactPlanes) / kPerManifold;

  struct Plane {
    core::ContactPlane plane;
    double impulse = 0.0;           // normal, of the last step
    glm::dvec3 friction_W_Ns{0.0};  // on S, of the last step
  };

  btManifoldPoint& PointOf(int i) {
    return manifolds_[static_cast<std::size_t>(i / kPerManifold)]->getContactPoint(i % kPerManifold);
  }

  // Speed of S along the point's normal, from G, at the place where the solver pushes.
  [[nodiscard]] double Speed_m_per_s(const btManifoldPoint& point) const;
  void FindPaidShare(double dt_s);

  const btRigidBody* sampled_ = nullptr;
  const btRigidBody* field_ = nullptr;
  std::array<btPersistentManifold*, kNumManifolds> manifolds_{};
  std::array<Plane, core::kMaxContactPlanes> planes_{};
  std::array<ContactLaw, core::kMaxContactPlanes> laws_{};       // of this step; the solver reads them via the points
  std::array<double, core::kMaxContactPlanes> start_m_per_s_{};  // of the planes' points, along their normals
  int num_planes_ = 0;
  int num_injected_ = 0;
  ContactKind kind_ = ContactKind::kCompliant;
  double softness_ = 0.0;  // of a hard contact
  double damping_ = 0.0;
  double friction_ = 0.0;
  double paid_J_ = 0.0;
};

template <typename Visit>
void ContactFeed::Collect(Visit&& visit) {
  for (int i = 0; i < num_injected_; ++i) {
    const btManifoldPoint& point = PointOf(i);
    const btVector3 friction = point.m_appliedImpulseLateral1 * point.m_lateralFrictionDir1 +
                               point.m_appliedImpulseLateral2 * point.m_lateralFrictionDir2;
    planes_[static_cast<std::size_t>(i)].impulse = point.m_appliedImpulse;
    if (kind_ == ContactKind::kPassive) {
      paid_J_ -= 0.5 * point.m_appliedImpulse * (start_m_per_s_[static_cast<std::size_t>(i)] + Speed_m_per_s(point));
    }
    planes_[static_cast<std::size_t>(i)].friction_W_Ns = {friction.x(), friction.y(), friction.z()};
    const btVector3 impulse = point.m_appliedImpulse * point.m_normalWorldOnB + friction;
    if (point.m_appliedImpulse == 0.0 && impulse.length2() == 0.0) continue;
    const btVector3& p = point.m_positionWorldOnA;
    visit(glm::dvec3(p.x(), p.y(), p.z()), glm::dvec3(impulse.x(), impulse.y(), impulse.z()));
  }
}

}  // namespace physics
