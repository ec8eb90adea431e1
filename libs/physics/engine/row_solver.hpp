#pragma once

#include <BulletDynamics/ConstraintSolver/btSequentialImpulseConstraintSolver.h>
#include <BulletDynamics/ConstraintSolver/btTypedConstraint.h>

#include <array>
#include <vector>

#include "physics/engine/direct_solver.hpp"
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
//
// Where sequential impulses do not converge (large mass ratios, stiff chains) the islands that are wrong by more than
// 1e-6 m/s and have at most DirectSolver::kMaxRows rows are solved directly, from the present impulses on.
class RowSolver final : public btSequentialImpulseConstraintSolver {
 public:
  void Reserve(int num_bodies, int num_contacts, int num_rows);

  // Islands solved directly, and those where that failed and the sequential result stayed, since the start.
  [[nodiscard]] std::uint64_t num_direct() const { return num_direct_; }
  [[nodiscard]] std::uint64_t num_fallbacks() const { return num_fallbacks_; }

 protected:
  void convertJoints(btTypedConstraint** constraints, int num_constraints, const btContactSolverInfo& info) override;
  btScalar solveGroupCacheFriendlyFinish(btCollisionObject** bodies, int num_bodies,
                                         const btContactSolverInfo& info) override;

  btScalar solveGroupCacheFriendlyIterations(btCollisionObject** bodies, int num_bodies,
                                             btPersistentManifold** manifolds, int num_manifolds,
                                             btTypedConstraint** constraints, int num_constraints,
                                             const btContactSolverInfo& info, btIDebugDraw* drawer) override;

 private:
  int Root(int body);
  [[nodiscard]] bool CanMove(int body) { return m_tmpSolverBodyPool[body].internalGetInvMass().x() > 0.0; }
  void FindIslands();
  double Violation(const btSolverConstraint& row);
  void SolveIslandDirectly(int root);

  DirectSolver direct_;
  std::vector<int> root_of_body_;
  std::vector<std::uint8_t> is_wrong_;  // by root
  std::array<btSolverConstraint*, DirectSolver::kMaxRows> island_{};
  std::uint64_t num_direct_ = 0;
  std::uint64_t num_fallbacks_ = 0;
  btTypedConstraint** constraints_ = nullptr;
  int num_constraints_ = 0;
};

}  // namespace physics
