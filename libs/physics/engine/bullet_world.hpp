#pragma once

#include <BulletDynamics/ConstraintSolver/btConstraintSolver.h>
#include <BulletDynamics/Dynamics/btDiscreteDynamicsWorld.h>

namespace physics {

// Bullet's world reduced to its constraint solver: collision detection, islands, sleeping and pose integration are
// bypassed. One solver call gets all bodies, manifolds and constraints. Bullet builds islands from its broad phase, not
// from the manifolds given here, so a body could be in two of them and receive its external impulse twice.
class BulletWorld final : public btDiscreteDynamicsWorld {
 public:
  using btDiscreteDynamicsWorld::btDiscreteDynamicsWorld;

  void performDiscreteCollisionDetection() override {}
  void updateAabbs() override {}
  void computeOverlappingPairs() override {}

  // All bodies in the order of addition, including fixed and kinematic ones.
  void set_bodies(btAlignedObjectArray<btCollisionObject*>* bodies) { bodies_ = bodies; }

 protected:
  void createPredictiveContacts(btScalar) override {}
  void calculateSimulationIslands() override {}
  void updateActivationState(btScalar) override {}
  void saveKinematicState(btScalar) override {}  // kinematic velocities are given, not derived from poses
  void predictUnconstraintMotion(btScalar) override {}
  void integrateTransforms(btScalar) override {}  // World integrates, conserving angular momentum

  void internalSingleStepSimulation(btScalar dt) override {
    getSolverInfo().m_timeStep = dt;
    btDispatcher* dispatcher = getDispatcher();
    getConstraintSolver()->solveGroup(&(*bodies_)[0], bodies_->size(), dispatcher->getInternalManifoldPointer(),
                                      dispatcher->getNumManifolds(), m_constraints.size() ? &m_constraints[0] : nullptr,
                                      m_constraints.size(), getSolverInfo(), nullptr, dispatcher);
  }

 private:
  btAlignedObjectArray<btCollisionObject*>* bodies_ = nullptr;
};

}  // namespace physics
