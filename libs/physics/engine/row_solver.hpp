#pragma once

#include <BulletDynamics/ConstraintSolver/btSequentialImpulseConstraintSolver.h>
#include <BulletDynamics/ConstraintSolver/btTypedConstraint.h>

#include "physics/row.hpp"

namespace physics {

// A mechanism's active rows as a Bullet constraint; body A is the child, B the parent.
class RowConstraint final : public btTypedConstraint {
 public:
  RowConstraint(btRigidBody& child, btRigidBody& parent, Mechanism* mechanism)
      : btTypedConstraint(MAX_CONSTRAINT_TYPE, child, parent), mechanism_(mechanism) {}

  void getInfo1(btConstraintInfo1* info) override;
  void getInfo2(btConstraintInfo2* info) override;
  void setParam(int, btScalar, int) override {}
  btScalar getParam(int, int) const override { return 0.0; }

  Mechanism& mechanism() { return *mechanism_; }

 private:
  Mechanism* mechanism_;
};

// Bullet's sequential-impulse solver with soft rows done right.
//
// Bullet relaxes a joint row with softness gamma by d lambda = (rhs - J dv) / (J M^-1 J^T) - cfm lambda, that is
// without gamma in the denominator: for one row lambda_{n+1} = rhs - cfm lambda_n, which diverges as soon as
// gamma > J M^-1 J^T, i.e. for every spring softer than m/dt^2 (2 kg at 1 ms: 2 MN/m). Dividing by
// (J M^-1 J^T + gamma), as Bullet itself does for contacts, makes each row's update exact. Rows also start from their
// last impulse, and their results are handed back for measurement.
class RowSolver final : public btSequentialImpulseConstraintSolver {
 public:
  void Reserve(int num_bodies, int num_contacts, int num_rows);

 protected:
  void convertJoints(btTypedConstraint** constraints, int num_constraints, const btContactSolverInfo& info) override;
  btScalar solveGroupCacheFriendlyFinish(btCollisionObject** bodies, int num_bodies,
                                         const btContactSolverInfo& info) override;

 private:
  btTypedConstraint** constraints_ = nullptr;
  int num_constraints_ = 0;
};

}  // namespace physics
