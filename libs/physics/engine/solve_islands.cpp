// RowSolver's part that solves islands directly.
#include <algorithm>
#include <cmath>

#include "physics/engine/row_solver.hpp"

namespace physics {
namespace {

constexpr double kAcceptable_m_per_s = 1e-6;
// Redundant friction rows have no softness of their own; this part of their diagonal makes the matrix definite.
constexpr double kRegularisation = 1e-9;

double Along(const btVector3& J_linear, const btVector3& J_angular, const btVector3& linear, const btVector3& angular) {
  return J_linear.dot(linear) + J_angular.dot(angular);
}

// J_i M^-1 J_j^T over the bodies that both rows act on.
double Coupling(const btSolverConstraint& i, const btSolverConstraint& j,
                const btAlignedObjectArray<btSolverBody>& bodies) {
  double sum = 0.0;
  const auto add = [&](int body_i, const btVector3& linear_i, const btVector3& angular_i, int body_j,
                       const btVector3& linear_j, const btVector3& component_j) {
    if (body_i != body_j) return;
    sum += Along(linear_i, angular_i, linear_j * bodies[body_i].internalGetInvMass(), component_j);
  };
  const int a = i.m_solverBodyIdA;
  const int b = i.m_solverBodyIdB;
  add(a, i.m_contactNormal1, i.m_relpos1CrossNormal, j.m_solverBodyIdA, j.m_contactNormal1, j.m_angularComponentA);
  add(a, i.m_contactNormal1, i.m_relpos1CrossNormal, j.m_solverBodyIdB, j.m_contactNormal2, j.m_angularComponentB);
  add(b, i.m_contactNormal2, i.m_relpos2CrossNormal, j.m_solverBodyIdA, j.m_contactNormal1, j.m_angularComponentA);
  add(b, i.m_contactNormal2, i.m_relpos2CrossNormal, j.m_solverBodyIdB, j.m_contactNormal2, j.m_angularComponentB);
  return sum;
}

bool IsFriction(const btSolverConstraint& row, const btConstraintArray& frictions) {
  return frictions.size() > 0 && &row >= &frictions[0] && &row <= &frictions[frictions.size() - 1];
}

}  // namespace

int RowSolver::Root(int body) {
  int root = body;
  while (root_of_body_[static_cast<std::size_t>(root)] != root) root = root_of_body_[static_cast<std::size_t>(root)];
  return root;
}

// Bodies that can move are in one island when a row acts on both. The smaller index is the root: no order of addresses.
void RowSolver::FindIslands() {
  for (int i = 0; i < m_tmpSolverBodyPool.size(); ++i) {
    root_of_body_[static_cast<std::size_t>(i)] = i;
    is_wrong_[static_cast<std::size_t>(i)] = 0;
  }
  for (btConstraintArray* pool : {&m_tmpSolverNonContactConstraintPool, &m_tmpSolverContactConstraintPool}) {
    for (int i = 0; i < pool->size(); ++i) {
      const btSolverConstraint& row = (*pool)[i];
      if (!CanMove(row.m_solverBodyIdA) || !CanMove(row.m_solverBodyIdB)) continue;
      const int a = Root(row.m_solverBodyIdA);
      const int b = Root(row.m_solverBodyIdB);
      root_of_body_[static_cast<std::size_t>(std::max(a, b))] = std::min(a, b);
    }
  }
}

// How far in m/s (or rad/s) a row is from its condition.
double RowSolver::Violation(const btSolverConstraint& row) {
  if (!(row.m_jacDiagABInv > 0.0)) return 0.0;
  btSolverBody& a = m_tmpSolverBodyPool[row.m_solverBodyIdA];
  btSolverBody& b = m_tmpSolverBodyPool[row.m_solverBodyIdB];
  const double impulse = row.m_appliedImpulse;
  const double missing = (row.m_rhs - impulse * row.m_cfm) / row.m_jacDiagABInv -
                         Along(row.m_contactNormal1, row.m_relpos1CrossNormal, a.internalGetDeltaLinearVelocity(),
                               a.internalGetDeltaAngularVelocity()) -
                         Along(row.m_contactNormal2, row.m_relpos2CrossNormal, b.internalGetDeltaLinearVelocity(),
                               b.internalGetDeltaAngularVelocity());
  double lower = row.m_lowerLimit;
  double upper = row.m_upperLimit;
  if (IsFriction(row, m_tmpSolverContactFrictionConstraintPool)) {
    upper = row.m_friction *
            std::max(0.0, static_cast<double>(m_tmpSolverContactConstraintPool[row.m_frictionIndex].m_appliedImpulse));
    lower = -upper;
  }
  if (missing > 0.0 && impulse >= upper) return 0.0;
  if (missing < 0.0 && impulse <= lower) return 0.0;
  return std::abs(missing);
}

void RowSolver::SolveIslandDirectly(int root) {
  int n = 0;
  bool fits = true;
  for (btConstraintArray* pool : {&m_tmpSolverNonContactConstraintPool, &m_tmpSolverContactConstraintPool,
                                  &m_tmpSolverContactFrictionConstraintPool}) {
    for (int i = 0; i < pool->size(); ++i) {
      btSolverConstraint& row = (*pool)[i];
      const int body = CanMove(row.m_solverBodyIdA) ? row.m_solverBodyIdA : row.m_solverBodyIdB;
      if (!(row.m_jacDiagABInv > 0.0) || Root(body) != root) continue;
      if (n == DirectSolver::kMaxRows) {
        fits = false;
        break;
      }
      island_[static_cast<std::size_t>(n++)] = &row;
    }
  }
  for (int i = 0; fits && i < n; ++i) {
    const btSolverConstraint& row = *island_[static_cast<std::size_t>(i)];
    for (int j = 0; j <= i; ++j) {
      direct_.A(i, j) = Coupling(row, *island_[static_cast<std::size_t>(j)], m_tmpSolverBodyPool);
    }
    direct_.A(i, i) = direct_.A(i, i) * (1.0 + kRegularisation) + row.m_cfm / row.m_jacDiagABInv;
    direct_.b(i) = row.m_rhs / row.m_jacDiagABInv;
    direct_.lambda(i) = row.m_appliedImpulse;
    direct_.bounds(i) = {row.m_lowerLimit, row.m_upperLimit, DirectSolver::kNoNormal, 0.0};
    if (!IsFriction(row, m_tmpSolverContactFrictionConstraintPool)) continue;
    const btSolverConstraint* normal = &m_tmpSolverContactConstraintPool[row.m_frictionIndex];
    const auto* const at = std::find(island_.data(), island_.data() + n, normal);
    direct_.bounds(i).normal = static_cast<int>(at - island_.data());
    direct_.bounds(i).friction = row.m_friction;
  }
  if (!fits || !direct_.Solve(n)) {
    ++num_fallbacks_;
    return;
  }
  ++num_direct_;
  for (int i = 0; i < n; ++i) {
    btSolverConstraint& row = *island_[static_cast<std::size_t>(i)];
    const double change = direct_.lambda(i) - row.m_appliedImpulse;
    row.m_appliedImpulse = direct_.lambda(i);
    btSolverBody& a = m_tmpSolverBodyPool[row.m_solverBodyIdA];
    btSolverBody& b = m_tmpSolverBodyPool[row.m_solverBodyIdB];
    a.internalApplyImpulse(row.m_contactNormal1 * a.internalGetInvMass(), row.m_angularComponentA, change);
    b.internalApplyImpulse(row.m_contactNormal2 * b.internalGetInvMass(), row.m_angularComponentB, change);
  }
}

btScalar RowSolver::solveGroupCacheFriendlyIterations(btCollisionObject** bodies, int num_bodies,
                                                      btPersistentManifold** manifolds, int num_manifolds,
                                                      btTypedConstraint** constraints, int num_constraints,
                                                      const btContactSolverInfo& info, btIDebugDraw* drawer) {
  const btScalar result = btSequentialImpulseConstraintSolver::solveGroupCacheFriendlyIterations(
      bodies, num_bodies, manifolds, num_manifolds, constraints, num_constraints, info, drawer);
  if (m_leastSquaresResidual <= info.m_leastSquaresResidualThreshold) return result;
  FindIslands();
  bool any = false;
  for (btConstraintArray* pool : {&m_tmpSolverNonContactConstraintPool, &m_tmpSolverContactConstraintPool,
                                  &m_tmpSolverContactFrictionConstraintPool}) {
    for (int i = 0; i < pool->size(); ++i) {
      const btSolverConstraint& row = (*pool)[i];
      if (Violation(row) <= kAcceptable_m_per_s) continue;
      const int body = CanMove(row.m_solverBodyIdA) ? row.m_solverBodyIdA : row.m_solverBodyIdB;
      is_wrong_[static_cast<std::size_t>(Root(body))] = 1;
      any = true;
    }
  }
  for (int root = 0; any && root < m_tmpSolverBodyPool.size(); ++root) {
    if (is_wrong_[static_cast<std::size_t>(root)] != 0) SolveIslandDirectly(root);
  }
  return result;
}

}  // namespace physics
