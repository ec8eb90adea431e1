#include "tools/contact_peers/bullet_pair.hpp"

#include <algorithm>

namespace contact_peers {

BulletPair::BulletPair(btCollisionObject* a, btCollisionObject* b) : a_(a), b_(b) {
  world_.addCollisionObject(a_);
  world_.addCollisionObject(b_);
}

BulletPair::~BulletPair() {
  world_.removeCollisionObject(a_);
  world_.removeCollisionObject(b_);
}

contact::Answer BulletPair::Query(const core::Pose& X_AB) {
  const glm::dquat& q = X_AB.rotation;
  const glm::dvec3& p = X_AB.translation;
  b_->setWorldTransform(btTransform(btQuaternion(q.x, q.y, q.z, q.w), btVector3(p.x, p.y, p.z)));
  world_.performDiscreteCollisionDetection();
  contact::Answer answer;
  for (int m = 0; m < dispatcher_.getNumManifolds(); ++m) {
    const btPersistentManifold* manifold = dispatcher_.getManifoldByIndexInternal(m);
    const bool is_a_first = manifold->getBody0() == a_;
    for (int i = 0; i < manifold->getNumContacts(); ++i) {
      const btManifoldPoint& c = manifold->getContactPoint(i);
      if (c.getDistance() > 0.0) continue;
      // m_normalWorldOnB points towards the manifold's first body.
      const btVector3 normal = is_a_first ? btVector3(-c.m_normalWorldOnB) : c.m_normalWorldOnB;
      const btVector3& at = is_a_first ? c.getPositionWorldOnB() : c.getPositionWorldOnA();
      const glm::dvec3 f = -c.getDistance() * glm::dvec3(normal.x(), normal.y(), normal.z());
      answer.force_A += f;
      answer.moment_A += glm::cross(glm::dvec3(at.x(), at.y(), at.z()) - p, f);
      answer.signed_distance_m = std::min(answer.signed_distance_m, static_cast<double>(c.getDistance()));
      ++answer.contacts;
    }
  }
  return answer;
}

}  // namespace contact_peers
