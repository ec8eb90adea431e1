#include "tools/dynamics/bullet_rebound.hpp"

#include <btBulletDynamicsCommon.h>

#include <limits>

namespace dynamics {

double BulletReboundRatio(double mass_kg, double stiffness_N_per_m, double speed_m_per_s) {
  btDefaultCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher(&configuration);
  btDbvtBroadphase broadphase;
  btSequentialImpulseConstraintSolver solver;
  btDiscreteDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration);
  world.setGravity({0, 0, 0});
  btBoxShape ground_shape({5, 5, 5});
  btRigidBody ground(btRigidBody::btRigidBodyConstructionInfo(0.0, nullptr, &ground_shape));
  ground.getWorldTransform().setOrigin({0, 0, -5});
  btBoxShape shape({0.05, 0.04, 0.01});
  btVector3 inertia;
  shape.calculateLocalInertia(mass_kg, inertia);
  btRigidBody plate(btRigidBody::btRigidBodyConstructionInfo(mass_kg, nullptr, &shape, inertia));
  plate.getWorldTransform().setOrigin({0, 0, 0.0143});
  plate.setLinearVelocity({0, 0, -speed_m_per_s});
  plate.setActivationState(DISABLE_DEACTIVATION);
  // Each of the four corners is a separate contact; Bullet puts the two bodies' springs in series and adds their
  // dampings.
  plate.setContactStiffnessAndDamping(stiffness_N_per_m / 4.0, 0.0);
  ground.setContactStiffnessAndDamping(1e18, 0.0);
  ground.setFriction(0.0);
  world.addRigidBody(&ground);
  world.addRigidBody(&plate);
  double ratio = std::numeric_limits<double>::quiet_NaN();
  for (int i = 0; i < 4000; ++i) {
    world.stepSimulation(1e-3, 0);
    if (plate.getLinearVelocity().z() > 0.0 && plate.getWorldTransform().getOrigin().z() > 0.0143) {
      ratio = plate.getLinearVelocity().z() / speed_m_per_s;
      break;
    }
  }
  world.removeRigidBody(&plate);
  world.removeRigidBody(&ground);
  return ratio;
}

}  // namespace dynamics
