#include "physics/engine/contact_feed.hpp"

#include <BulletCollision/BroadphaseCollision/btDispatcher.h>
#include <BulletDynamics/Dynamics/btRigidBody.h>

#include <algorithm>

#include "physics/engine/bullet_conversions.hpp"

namespace physics {

namespace {

// Of p_S along the plane, from q_G.
glm::dvec3 Slip_W(const core::ContactPlane& plane, const core::Pose& X_WS, const core::Pose& X_WG) {
  const glm::dvec3 n_W = glm::normalize(X_WG.rotate(glm::dvec3(plane.n_G)));
  const glm::dvec3 offset_W = X_WS * glm::dvec3(plane.p_S) - X_WG * glm::dvec3(plane.q_G);
  return offset_W - glm::dot(n_W, offset_W) * n_W;
}

}  // namespace

ContactFeed::ContactFeed(btDispatcher* dispatcher, btRigidBody* sampled, btRigidBody* field, ContactKind kind)
    : sampled_(sampled),
      field_(field),
      kind_(kind),
      softness_(HardSoftness(sampled->isKinematicObject() || field->isKinematicObject())) {
  for (btPersistentManifold*& manifold : manifolds_) {
    manifold = dispatcher->getNewManifold(sampled, field);
    manifold->setContactBreakingThreshold(1e9);
    manifold->setContactProcessingThreshold(1e9);
    manifold->setNumContacts(0);
  }
}

void ContactFeed::Set(const core::ContactSet& set) {
  std::array<Plane, core::kMaxContactPlanes> next{};
  const int count = static_cast<int>(set.planes.size());
  for (int i = 0; i < count; ++i) {
    Plane& plane = next[static_cast<std::size_t>(i)];
    plane.plane = set.planes[static_cast<std::size_t>(i)];
    for (int j = 0; j < num_planes_; ++j) {
      const Plane& old = planes_[static_cast<std::size_t>(j)];
      if (old.plane.id != plane.plane.id) continue;
      plane.impulse = old.impulse;
      plane.friction_W_Ns = old.friction_W_Ns;
    }
  }
  planes_ = next;
  num_planes_ = count;
  damping_ = set.damping_N_s_per_m;
  friction_ = set.friction;
}

void ContactFeed::Clear() {
  num_planes_ = 0;
  paid_J_ = 0.0;
  Rest();
}

void ContactFeed::Rest() {
  num_injected_ = 0;
  for (btPersistentManifold* manifold : manifolds_) manifold->setNumContacts(0);
}

void ContactFeed::Mute() {
  paid_J_ = 0.0;
  Rest();
  for (Plane& plane : planes_) {
    plane.impulse = 0.0;
    plane.friction_W_Ns = glm::dvec3(0.0);
  }
}

void ContactFeed::Inject(const core::Pose& X_WS, const core::Pose& X_WG, double dt_s) {
  num_injected_ = num_planes_;
  // The pair's damping is distributed over the penetrating planes in proportion to their stiffness: d_i = d k_i / sum
  // k.
  std::array<double, core::kMaxContactPlanes> gaps{};
  double pushing_stiffness = 0.0;
  double largest_stiffness = 0.0;
  for (int i = 0; i < num_planes_; ++i) {
    const auto at = static_cast<std::size_t>(i);
    const core::ContactPlane& plane = planes_[at].plane;
    const glm::dvec3 n_W = X_WG.rotate(glm::dvec3(plane.n_G));
    gaps[at] = glm::dot(n_W, X_WS * glm::dvec3(plane.p_S) - X_WG * glm::dvec3(plane.q_G));
    if (gaps[at] <= 0.0) pushing_stiffness += plane.stiffness_N_per_m;
    largest_stiffness = std::max(largest_stiffness, static_cast<double>(plane.stiffness_N_per_m));
  }
  const double total_stiffness = std::max(pushing_stiffness, largest_stiffness);
  for (int m = 0; m < kNumManifolds; ++m) {
    manifolds_[static_cast<std::size_t>(m)]->setNumContacts(
        std::clamp(num_planes_ - kPerManifold * m, 0, kPerManifold));
  }
  for (int i = 0; i < num_planes_; ++i) {
    const auto at = static_cast<std::size_t>(i);
    const core::ContactPlane& plane = planes_[at].plane;
    const double k = plane.stiffness_N_per_m;
    const double d = total_stiffness > 0.0 ? damping_ * k / total_stiffness : 0.0;
    btManifoldPoint& point = PointOf(i);
    point = btManifoldPoint();
    // The same point for both bodies: equal and opposite impulses at one point conserve angular momentum.
    point.m_positionWorldOnA = ToBullet(X_WS * glm::dvec3(plane.p_S));
    point.m_positionWorldOnB = point.m_positionWorldOnA;
    // Normalised again in double: a float normal's length is off by 1e-7, which would scale impulses.
    point.m_normalWorldOnB = ToBullet(glm::normalize(X_WG.rotate(glm::dvec3(plane.n_G))));
    point.m_appliedImpulseLateral1 = 0.0;
    point.m_appliedImpulseLateral2 = 0.0;
    point.m_lateralFrictionDir1.setZero();
    point.m_lateralFrictionDir2.setZero();
    point.m_combinedFriction = friction_;
    point.m_combinedRollingFriction = 0.0;
    point.m_combinedSpinningFriction = 0.0;
    point.m_combinedRestitution = 0.0;
    laws_[at] = {gaps[at], k, gaps[at] <= 0.0 ? d : 0.0, total_stiffness, kind_, planes_[at].friction_W_Ns};
    laws_[at].softness = softness_;
    if (kind_ == ContactKind::kElastic) laws_[at].slip_W_m = Slip_W(plane, X_WS, X_WG);
    point.m_distance1 = gaps[at];
    point.m_userPersistentData = &laws_[at];
    point.m_appliedImpulse = planes_[at].impulse;
  }
  if (kind_ == ContactKind::kPassive) FindPaidShare(dt_s);
}

double ContactFeed::Speed_m_per_s(const btManifoldPoint& point) const {
  const btVector3& p = point.m_positionWorldOnA;
  const btVector3 of_S = sampled_->getVelocityInLocalPoint(p - sampled_->getCenterOfMassPosition());
  const btVector3 of_G = field_->getVelocityInLocalPoint(p - field_->getCenterOfMassPosition());
  return point.m_normalWorldOnB.dot(of_S - of_G);
}

// At the gaps that belong to the speeds at the start of the step, see CompliantForce.
void ContactFeed::FindPaidShare(double dt_s) {
  double held_J = 0.0;
  for (int i = 0; i < num_planes_; ++i) {
    const auto at = static_cast<std::size_t>(i);
    start_m_per_s_[at] = Speed_m_per_s(PointOf(i));
    held_J += SpringEnergy_J(laws_[at].stiffness_N_per_m, laws_[at].gap_m - 0.5 * dt_s * start_m_per_s_[at]);
  }
  // What has not been paid for may have pushed, too; that is not owed.
  paid_J_ = held_J > 0.0 ? std::max(paid_J_, 0.0) : 0.0;
  const double share = held_J > paid_J_ ? paid_J_ / held_J : 1.0;
  for (int i = 0; i < num_planes_; ++i) laws_[static_cast<std::size_t>(i)].paid_share = share;
}

double ContactFeed::SmallestGap(const core::Pose& X_WS, const core::Pose& X_WG, glm::dvec3* p_W,
                                const glm::dvec3* along_W) const {
  double smallest = 1e9;
  for (int i = 0; i < num_planes_; ++i) {
    const core::ContactPlane& plane = planes_[static_cast<std::size_t>(i)].plane;
    const glm::dvec3 n_W = X_WG.rotate(glm::dvec3(plane.n_G));
    if (along_W != nullptr && glm::dot(n_W, *along_W) < 0.5) continue;
    const glm::dvec3 point_W = X_WS * glm::dvec3(plane.p_S);
    const double gap = glm::dot(n_W, point_W - X_WG * glm::dvec3(plane.q_G));
    if (gap < smallest) {
      smallest = gap;
      if (p_W != nullptr) *p_W = point_W;
    }
  }
  return smallest;
}

double ContactFeed::PressedRadius(const core::Pose& X_WS, const core::Pose& X_WG) const {
  std::array<glm::dvec3, core::kMaxContactPlanes> points_W;
  std::array<double, core::kMaxContactPlanes> forces_N;
  glm::dvec3 middle_W(0.0);
  double sum_N = 0.0;
  for (std::size_t i = 0; i < static_cast<std::size_t>(num_planes_); ++i) {
    const core::ContactPlane& plane = planes_[i].plane;
    points_W[i] = X_WS * glm::dvec3(plane.p_S);
    const double gap_m = glm::dot(X_WG.rotate(glm::dvec3(plane.n_G)), points_W[i] - X_WG * glm::dvec3(plane.q_G));
    forces_N[i] = plane.stiffness_N_per_m * std::max(0.0, -gap_m);
    middle_W += forces_N[i] * points_W[i];
    sum_N += forces_N[i];
  }
  if (!(sum_N > 0.0)) return 0.0;
  middle_W /= sum_N;
  double radius_m = 0.0;
  for (std::size_t i = 0; i < static_cast<std::size_t>(num_planes_); ++i)
    radius_m += forces_N[i] / sum_N * glm::length(points_W[i] - middle_W);
  return radius_m;
}

void ContactFeed::ExchangeState(Checkpoint* checkpoint) {
  checkpoint->Exchange(&planes_);
  checkpoint->Exchange(&num_planes_);
  checkpoint->Exchange(&num_injected_);
  checkpoint->Exchange(&damping_);
  checkpoint->Exchange(&friction_);
  if (kind_ == ContactKind::kPassive) checkpoint->Exchange(&paid_J_);
}

}  // namespace physics
