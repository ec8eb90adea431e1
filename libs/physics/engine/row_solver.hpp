#pragma once

#include <BulletDynamics/ConstraintSolver/btSequentialImpulseConstraintSolver.h>
#include <BulletDynamics/ConstraintSolver/btTypedConstraint.h>

#include <array>
#include <vector>

#include "physics/checkpoint.hpp"
#include "physics/engine/contact_law.hpp"
#include "physics/engine/direct_solver.hpp"
#include "physics/engine/sweeper.hpp"
#include "physics/row.hpp"
#include "physics/solver_work.hpp"

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

// Bullet's sequential-impulse solver (projected Gauss-Seidel) with corrected soft rows and a direct solver.
//
// Soft rows. Bullet updates a joint row with compliance gamma by d lambda = (rhs - J dv) / (J M^-1 J^T) - cfm lambda,
// without gamma in the denominator. For one row that is lambda_{n+1} = rhs - cfm lambda_n, which diverges for
// gamma > J M^-1 J^T, i.e. for every spring softer than m/dt^2 (2 kg at 1 ms: 2 MN/m). Dividing by J M^-1 J^T + gamma,
// as Bullet itself does for contacts, makes each row's update exact. Rows are warm started from their last impulse, and
// their impulses are returned for measurement.
//
// Contact rows follow their ContactLaw, which is not linear where contact begins or ends. Rows are tangents of the law;
// solving alternates with moving the tangents to the speeds found, until they agree within 1e-9 m/s (Newton's method).
//
// Solver rule. Bodies that can move and are joined by rows form an island; islands are solved one by one, so distant
// parts add no work. An island gets as many sweeps as it has rows, at least 20 and at most the limit; most converge in
// a few. One that does not is solved directly, if it has at most DirectSolver::kMaxRows rows, and again directly in the
// next 32 steps, warm started: the last impulses show which contacts push, so the first guess is mostly right. After a
// failure the direct solver is not tried for 4 steps. Without it the sweeps continue to the limit; a remaining residual
// above 1e-6 m/s is counted as a fallback.
class RowSolver final : public btSequentialImpulseConstraintSolver {
 public:
  void Reserve(int num_bodies, int num_contacts, int num_rows);

  [[nodiscard]] const SolverWork& work() const { return work_; }
  void ExchangeState(Checkpoint* checkpoint);

 protected:
  void convertContacts(btPersistentManifold** manifolds, int num_manifolds, const btContactSolverInfo& info) override;
  void convertJoints(btTypedConstraint** constraints, int num_constraints, const btContactSolverInfo& info) override;
  btScalar solveGroupCacheFriendlyFinish(btCollisionObject** bodies, int num_bodies,
                                         const btContactSolverInfo& info) override;

  btScalar solveGroupCacheFriendlyIterations(btCollisionObject** bodies, int num_bodies,
                                             btPersistentManifold** manifolds, int num_manifolds,
                                             btTypedConstraint** constraints, int num_constraints,
                                             const btContactSolverInfo& info, btIDebugDraw* drawer) override;

 private:
  // Rows of one island, in rows_; joints, then contacts, then their friction.
  struct Island {
    int root = 0;
    int first = 0;
    int num_rows = 0;
  };

  int Root(int body);
  [[nodiscard]] bool CanMove(int body) { return m_tmpSolverBodyPool[body].internalGetInvMass().x() > 0.0; }
  void Unite(const btConstraintArray& rows);
  void FindIslands();
  [[nodiscard]] bool IsContact(const btSolverConstraint& row) const;
  [[nodiscard]] bool IsFriction(const btSolverConstraint& row) const;
  double Violation(const btSolverConstraint& row);
  bool Sweep(const Island& island, int most, double tolerance_m_per_s);
  bool HasResidual(const Island& island);
  bool ChooseDirect(const Island& island);
  void FillDirect();
  void Push(btSolverConstraint* row, double impulse);
  bool SolveDirectly(const Island& island);
  void SolveOnce(const Island& island, int max_sweeps, double tolerance_m_per_s);

  // Data of a contact row. Speeds along it: `start` at the start of the step, `free` after all external forces.
  struct ContactRow {
    const ContactLaw* law = nullptr;
    double start_m_per_s = 0.0;
    double free_m_per_s = 0.0;
    double inverse_mass_per_kg = 0.0;
    UnpaidPiece piece = UnpaidPiece::kIsStopped;
    bool is_idle = false;  // force and slope are zero
  };
  ContactRow MakeContactRow(const btSolverConstraint& row) const;
  void WarmStart(btSolverConstraint* friction);
  void SetLine(ContactRow* from, double at_m_per_s, btSolverConstraint* row) const;
  [[nodiscard]] double SolvedSpeed(const ContactRow& from, const btSolverConstraint& row) const;
  bool MoveLines(const Island& island);

  Sweeper sweeper_;
  DirectSolver direct_;
  std::array<btSolverConstraint*, DirectSolver::kMaxRows> direct_rows_{};
  int num_direct_rows_ = 0;
  std::array<double, DirectSolver::kMaxRows> held_{};
  std::vector<ContactRow> contact_rows_;
  double dt_s_ = 0.0;
  std::vector<int> root_of_body_;
  std::vector<int> rows_of_root_;          // place of the root's next row in rows_
  std::vector<std::int8_t> direct_steps_;  // by root: remaining steps to solve directly; negative: steps without it
  std::vector<btSolverConstraint*> rows_;
  std::vector<Island> islands_;
  SolverWork work_;
  int num_contacts_ = 0;  // capacity
  int num_rows_ = 0;
  btTypedConstraint** constraints_ = nullptr;
  int num_constraints_ = 0;
};

}  // namespace physics
