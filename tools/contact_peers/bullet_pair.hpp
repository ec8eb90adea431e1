#pragma once

#include <btBulletCollisionCommon.h>

#include "tools/contact_peers/peers.hpp"

namespace contact_peers {

// Two collision objects in a Bullet world of their own. The objects must outlive the pair.
class BulletPair {
 public:
  BulletPair(btCollisionObject* a, btCollisionObject* b);
  ~BulletPair();
  BulletPair(const BulletPair&) = delete;
  BulletPair& operator=(const BulletPair&) = delete;

  // Force: sum of depth times normal over all manifold points [m]; moment: about B's origin, each at its point on B
  // [m^2].
  contact::Answer Query(const core::Pose& X_AB);
  [[nodiscard]] btCollisionDispatcher* dispatcher() { return &dispatcher_; }

 private:
  btCollisionObject* a_;
  btCollisionObject* b_;
  btDefaultCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_{&configuration_};
  btDbvtBroadphase broadphase_;
  btCollisionWorld world_{&dispatcher_, &broadphase_, &configuration_};
};

}  // namespace contact_peers
