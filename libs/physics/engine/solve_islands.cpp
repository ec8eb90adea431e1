// The part of RowSolver that finds and solves islands.
#include <algorithm>
#include <cmath>
#include <utility>

#include "physics/engine/row_solver.hpp"
#include "physics/engine/row_speed.hpp"

namespace physics {
namespace {

// The rule of two solvers: sweeps first, the direct one where they have not converged, and then at once for a while.
// `oos bench physics --pair mass_ratio,rows` shows time and error. Reference.HeavyOnLight* fail with 100 sweeps, which
// postpone the direct solver, and with one direct step, after which sweeps fail again; 5 sweeps and 120 direct steps
// pass, so within that the values are free: more sweeps are cheap for many easy rows, more direct steps for few hard
// ones.
constexpr int kMaxRounds = 12;  // of Newton's method; a tangent moves a few times at most
constexpr int kFewestSweeps = 20;
constexpr std::int8_t kDirectSteps = 32;
constexpr std::int8_t kStepsWithout = -4;     // after a direct solve that did not converge; -1 and -100 pass every test
constexpr double kAcceptable_m_per_s = 1e-6;  // residual that counts as a fallback: 1 nm per step
// Redundant rows have no compliance of their own; this part of their diagonal makes the matrix positive definite.
constexpr double kRegularisation = 1e-9;
// The distribution of friction over many points is not unique. This part of the diagonal keeps each near its last
// value, and the solve is repeated until it exerts no force (proximal point method): to a speed of 1e-9 m/s, at most 8
// times. Larger values make the matrix better conditioned and need more repetitions.
constexpr double kFrictionHold = 1e-4;
constexpr double kHeldSpeed_m_per_s = 1e-9;
constexpr int kMaxHolds = 8;

// Element J_i M^-1 J_j^T of the system matrix: the sum over the bodies on which both rows act.
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

}  // namespace

int RowSolver::Root(int body) {
  int root = body;
  while (root_of_body_[static_cast<std::size_t>(root)] != root) root = root_of_body_[static_cast<std::size_t>(root)];
  return root;
}

// Union-find; the smaller index becomes the root, so that the result does not depend on addresses.
void RowSolver::Unite(const btConstraintArray& rows) {
  for (int i = 0; i < rows.size(); ++i) {
    if (!CanMove(rows[i].m_solverBodyIdA) || !CanMove(rows[i].m_solverBodyIdB)) continue;
    const int a = Root(rows[i].m_solverBodyIdA);
    const int b = Root(rows[i].m_solverBodyIdB);
    root_of_body_[static_cast<std::size_t>(std::max(a, b))] = std::min(a, b);
  }
}

// Two bodies that can move are in one island if a row acts on both. Sorts the rows with a finite effective mass by
// island.
void RowSolver::FindIslands() {
  const int num_bodies = m_tmpSolverBodyPool.size();
  for (int i = 0; i < num_bodies; ++i) {
    root_of_body_[static_cast<std::size_t>(i)] = i;
    rows_of_root_[static_cast<std::size_t>(i)] = 0;
  }
  Unite(m_tmpSolverNonContactConstraintPool);
  Unite(m_tmpSolverContactConstraintPool);
  const auto visit = [this](auto&& use) {
    for (btConstraintArray* pool : {&m_tmpSolverNonContactConstraintPool, &m_tmpSolverContactConstraintPool,
                                    &m_tmpSolverContactFrictionConstraintPool}) {
      for (int i = 0; i < pool->size(); ++i) {
        btSolverConstraint& row = (*pool)[i];
        if (!(row.m_jacDiagABInv > 0.0)) continue;
        const int a = row.m_solverBodyIdA;
        use(static_cast<std::size_t>(Root(CanMove(a) ? a : row.m_solverBodyIdB)), &row);
      }
    }
  };
  visit([this](std::size_t root, btSolverConstraint*) { ++rows_of_root_[root]; });
  islands_.clear();
  int first = 0;
  for (int root = 0; root < num_bodies; ++root) {
    int& next = rows_of_root_[static_cast<std::size_t>(root)];
    if (next > 0) islands_.push_back({root, first, next});
    first += std::exchange(next, first);
  }
  visit([this](std::size_t root, btSolverConstraint* row) {
    rows_[static_cast<std::size_t>(rows_of_root_[root]++)] = row;
  });
}

bool RowSolver::IsContact(const btSolverConstraint& row) const {
  const btConstraintArray& pool = m_tmpSolverContactConstraintPool;
  return pool.size() > 0 && &row >= &pool[0] && &row <= &pool[pool.size() - 1];
}
bool RowSolver::IsFriction(const btSolverConstraint& row) const {
  const btConstraintArray& pool = m_tmpSolverContactFrictionConstraintPool;
  return pool.size() > 0 && &row >= &pool[0] && &row <= &pool[pool.size() - 1];
}

// Residual of a row's condition in m/s (or rad/s); 0 at a limit that the residual would exceed.
double RowSolver::Violation(const btSolverConstraint& row) {
  btSolverBody& a = m_tmpSolverBodyPool[row.m_solverBodyIdA];
  btSolverBody& b = m_tmpSolverBodyPool[row.m_solverBodyIdB];
  const double impulse = row.m_appliedImpulse;
  const double missing = (row.m_rhs - impulse * row.m_cfm) / row.m_jacDiagABInv -
                         Along(row.m_contactNormal1, row.m_relpos1CrossNormal, a.internalGetDeltaLinearVelocity(),
                               a.internalGetDeltaAngularVelocity()) -
                         Along(row.m_contactNormal2, row.m_relpos2CrossNormal, b.internalGetDeltaLinearVelocity(),
                               b.internalGetDeltaAngularVelocity());
  if (missing > 0.0 && impulse >= row.m_upperLimit) return 0.0;
  if (missing < 0.0 && impulse <= row.m_lowerLimit) return 0.0;
  return std::abs(missing);
}

bool RowSolver::HasResidual(const Island& island) {
  for (int i = 0; i < island.num_rows; ++i) {
    const btSolverConstraint& row = *rows_[static_cast<std::size_t>(island.first + i)];
    if (Violation(row) > kAcceptable_m_per_s) return true;
  }
  return false;
}

// Makes up to `most` sweeps; true if the last one changed no speed by more than the tolerance.
bool RowSolver::Sweep(const Island& island, int most, double tolerance_m_per_s) {
  const std::span<btSolverConstraint* const> rows{&rows_[static_cast<std::size_t>(island.first)],
                                                  static_cast<std::size_t>(island.num_rows)};
  sweeper_.Load(rows, m_tmpSolverContactConstraintPool, m_tmpSolverContactFrictionConstraintPool, m_tmpSolverBodyPool);
  bool is_settled = false;
  for (int i = 0; i < most && !is_settled; ++i) {
    is_settled = sweeper_.Sweep() <= tolerance_m_per_s;
    ++work_.num_sweeps;
    work_.num_row_updates += static_cast<std::uint64_t>(island.num_rows);
  }
  sweeper_.Store(rows, &m_tmpSolverBodyPool);
  return is_settled;
}

// Chooses the rows for the direct solver. Contacts without force and slope, and their friction, are left out; MoveLines
// adds them again when their gap closes.
bool RowSolver::ChooseDirect(const Island& island) {
  num_direct_rows_ = 0;
  for (int i = 0; i < island.num_rows; ++i) {
    btSolverConstraint* row = rows_[static_cast<std::size_t>(island.first + i)];
    const int contact = IsFriction(*row)  ? row->m_frictionIndex
                        : IsContact(*row) ? static_cast<int>(row - &m_tmpSolverContactConstraintPool[0])
                                          : -1;
    if (contact >= 0 && contact_rows_[static_cast<std::size_t>(contact)].is_idle) {
      Push(row, -row->m_appliedImpulse);
      continue;
    }
    if (num_direct_rows_ == DirectSolver::kMaxRows) return false;
    direct_rows_[static_cast<std::size_t>(num_direct_rows_++)] = row;
  }
  return true;
}

void RowSolver::Push(btSolverConstraint* row, double impulse) {
  row->m_appliedImpulse = row->m_appliedImpulse + impulse;
  btSolverBody& a = m_tmpSolverBodyPool[row->m_solverBodyIdA];
  btSolverBody& b = m_tmpSolverBodyPool[row->m_solverBodyIdB];
  a.internalApplyImpulse(row->m_contactNormal1 * a.internalGetInvMass(), row->m_angularComponentA, impulse);
  b.internalApplyImpulse(row->m_contactNormal2 * b.internalGetInvMass(), row->m_angularComponentB, impulse);
}

// Fills the direct solver's system; the present impulses are its initial guess.
void RowSolver::FillDirect() {
  btSolverConstraint* const* const rows = direct_rows_.data();
  const int n = num_direct_rows_;
  for (int i = 0; i < n; ++i) {
    const btSolverConstraint& row = *rows[i];
    for (int j = 0; j <= i; ++j) direct_.A(i, j) = Coupling(row, *rows[j], m_tmpSolverBodyPool);
    direct_.lambda(i) = row.m_appliedImpulse;
    direct_.b(i) = row.m_rhs / row.m_jacDiagABInv;
    direct_.bounds(i) = {row.m_lowerLimit, row.m_upperLimit, DirectSolver::kNoNormal, 0.0};
    if (!IsFriction(row)) {
      direct_.A(i, i) = direct_.A(i, i) * (1.0 + kRegularisation) + row.m_cfm / row.m_jacDiagABInv;
      continue;
    }
    direct_.A(i, i) = direct_.A(i, i) * (1.0 + kFrictionHold) + row.m_cfm / row.m_jacDiagABInv;
    const btSolverConstraint* normal = &m_tmpSolverContactConstraintPool[row.m_frictionIndex];
    direct_.bounds(i).normal = static_cast<int>(std::find(rows, rows + n, normal) - rows);
    direct_.bounds(i).friction = row.m_friction;
  }
}

bool RowSolver::SolveDirectly(const Island& island) {
  if (!ChooseDirect(island)) return false;
  FillDirect();
  const int n = num_direct_rows_;
  const auto held = [this](int i) {
    return kFrictionHold / (1.0 + kFrictionHold) * direct_.A(i, i) * direct_.lambda(i);
  };
  for (int hold = 0; hold < kMaxHolds; ++hold) {
    for (int i = 0; i < n; ++i) {
      const btSolverConstraint& row = *direct_rows_[static_cast<std::size_t>(i)];
      held_[static_cast<std::size_t>(i)] = IsFriction(row) ? held(i) : 0.0;
      direct_.b(i) = row.m_rhs / row.m_jacDiagABInv + held_[static_cast<std::size_t>(i)];
    }
    if (!direct_.Solve(n)) return false;
    double largest = 0.0;
    for (int i = 0; i < n; ++i) {
      if (!IsFriction(*direct_rows_[static_cast<std::size_t>(i)])) continue;
      largest = std::max(largest, std::abs(held(i) - held_[static_cast<std::size_t>(i)]));
    }
    if (largest <= kHeldSpeed_m_per_s) break;
  }
  ++work_.num_direct_solves;
  for (int i = 0; i < n; ++i) {
    btSolverConstraint* row = direct_rows_[static_cast<std::size_t>(i)];
    Push(row, direct_.lambda(i) - row->m_appliedImpulse);
  }
  return true;
}

void RowSolver::SolveOnce(const Island& island, int max_sweeps, double tolerance_m_per_s) {
  std::int8_t& direct_steps = direct_steps_[static_cast<std::size_t>(island.root)];
  const auto solve_directly = [&] {
    if (direct_steps < 0) return false;
    if (SolveDirectly(island)) return true;
    direct_steps = kStepsWithout;
    return false;
  };
  if (direct_steps > 0 && solve_directly()) return;
  const int first_sweeps = std::min(max_sweeps, std::max(kFewestSweeps, island.num_rows));
  if (Sweep(island, first_sweeps, tolerance_m_per_s)) return;
  if (solve_directly()) {
    direct_steps = kDirectSteps;
    return;
  }
  const bool is_settled = Sweep(island, max_sweeps - first_sweeps, tolerance_m_per_s);
  if (!is_settled && HasResidual(island)) ++work_.num_fallbacks;
}

btScalar RowSolver::solveGroupCacheFriendlyIterations(btCollisionObject**, int, btPersistentManifold**, int,
                                                      btTypedConstraint**, int, const btContactSolverInfo& info,
                                                      btIDebugDraw*) {
  FindIslands();
  for (const Island& island : islands_) {
    ++work_.num_islands;
    work_.num_rows += static_cast<std::uint64_t>(island.num_rows);
    int rounds = 0;
    do {
      SolveOnce(island, info.m_numIterations, std::sqrt(info.m_leastSquaresResidualThreshold));
    } while (++rounds < kMaxRounds && MoveLines(island));
    std::int8_t& direct_steps = direct_steps_[static_cast<std::size_t>(island.root)];
    direct_steps = static_cast<std::int8_t>(direct_steps + (direct_steps < 0 ? 1 : direct_steps > 0 ? -1 : 0));
  }
  return 0.0;
}

void RowSolver::ExchangeState(Checkpoint* checkpoint) {
  for (std::int8_t& steps : direct_steps_) checkpoint->Exchange(&steps);
}

}  // namespace physics
