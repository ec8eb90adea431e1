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

// Bullet's sequential-impulse solver with soft rows done right.
//
// Bullet relaxes a joint row with softness gamma by d lambda = (rhs - J dv) / (J M^-1 J^T) - cfm lambda, that is
// without gamma in the denominator: for one row lambda_{n+1} = rhs - cfm lambda_n, which diverges as soon as
// gamma > J M^-1 J^T, i.e. for every spring softer than m/dt^2 (2 kg at 1 ms: 2 MN/m). Dividing by
// (J M^-1 J^T + gamma), as Bullet itself does for contacts, makes each row's update exact. Rows also start from their
// last impulse, and their results are handed back for measurement.
//
// Contact rows follow their ContactLaw, which is not linear where contact begins or ends: rows are lines through it,
// and solving alternates with moving the lines to the speeds found until they agree within 1e-9 m/s (Newton's method).
//
// Solver rule. Bodies that can move and are joined by rows make an island; islands are solved one by one, so that a far
// part costs nothing here. An island gets as many sweeps of sequential impulses as it has rows, at least 20 and at most
// the limit; most converge in a few. One that does not is solved directly from there on, if it has at most
// DirectSolver::kMaxRows rows, and is solved directly at once in the next 32 steps, from the last step's impulses:
// those tell which contacts push, so that the first guess is mostly right. Where the direct solver fails it is left out
// for 4 steps. Without it the sweeps go on to the limit; what is then wrong by more than 1e-6 m/s is counted as a
// fallback.
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
  bool IsWrong(const Island& island);
  bool ChooseDirect(const Island& island);
  void FillDirect();
  void Push(btSolverConstraint* row, double impulse);
  bool SolveDirectly(const Island& island);
  void SolveOnce(const Island& island, int max_sweeps, double tolerance_m_per_s);

  // What a contact row is made from. Speeds along it: `start` at the start of the step, `free` after all outer forces.
  struct ContactRow {
    const ContactLaw* law = nullptr;
    double start_m_per_s = 0.0;
    double free_m_per_s = 0.0;
    double inverse_mass_per_kg = 0.0;
    bool is_idle = false;  // no force here, and none a little deeper
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
  std::vector<int> rows_of_root_;          // where the next row of that root goes
  std::vector<std::int8_t> direct_steps_;  // by root: so many steps more directly at once; negative: not at all
  std::vector<btSolverConstraint*> rows_;
  std::vector<Island> islands_;
  SolverWork work_;
  int num_contacts_ = 0;  // room for
  int num_rows_ = 0;
  btTypedConstraint** constraints_ = nullptr;
  int num_constraints_ = 0;
};

}  // namespace physics
