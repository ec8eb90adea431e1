// The part of RowSolver that creates contact rows.
#include <algorithm>
#include <cmath>

#include "physics/engine/row_solver.hpp"
#include "physics/engine/row_speed.hpp"

namespace physics {
namespace {

// Newton's method ends when the law and its tangent agree to this speed: a hundred times the solver's tolerance, and
// far below any speed of interest.
constexpr double kLineTolerance_m_per_s = 1e-9;
// Newton steps for a row alone, to start near its solution: each doubles the digits, so four make 1e-8 of a guess that
// is a third off. Too few cost rounds of all rows, no error.
constexpr int kGuesses = 4;
// Softness added to a row whose law has slope 0, relative to its effective mass: Bullet divides by it. It changes
// forces by one part in 10^9.
constexpr double kLeastSlope = 1e-9;

double StartSpeed(const btSolverConstraint& row, const btSolverBody& a, const btSolverBody& b) {
  return Along(row.m_contactNormal1, row.m_relpos1CrossNormal, a.m_linearVelocity, a.m_angularVelocity) +
         Along(row.m_contactNormal2, row.m_relpos2CrossNormal, b.m_linearVelocity, b.m_angularVelocity);
}

double OuterSpeed(const btSolverConstraint& row, const btSolverBody& a, const btSolverBody& b) {
  return Along(row.m_contactNormal1, row.m_relpos1CrossNormal, a.m_externalForceImpulse, a.m_externalTorqueImpulse) +
         Along(row.m_contactNormal2, row.m_relpos2CrossNormal, b.m_externalForceImpulse, b.m_externalTorqueImpulse);
}

// Direction of a friction row's force on S.
btVector3 DirectionOnS(const btSolverConstraint& row) {
  return row.m_contactNormal1.length2() > 0.0 ? row.m_contactNormal1 : -row.m_contactNormal2;
}

// Makes a friction row the implicit spring F = -k (u + dt v1) over the slip u along it, with the plane's stiffness k;
// the row's limits stay Coulomb's. As in SetLine, A = -dt k u and B = dt^2 k.
void SetSpring(const ContactLaw& law, double free_m_per_s, double dt_s, btSolverConstraint* row) {
  if (!(row->m_jacDiagABInv > 0.0)) return;
  const double W = 1.0 / row->m_jacDiagABInv;
  const btVector3 direction_W = DirectionOnS(*row);
  const double u_m = glm::dot(glm::dvec3(direction_W.x(), direction_W.y(), direction_W.z()), law.slip_W_m);
  const double B = std::max(dt_s * dt_s * law.stiffness_N_per_m, kLeastSlope / W);
  const double A = -B / dt_s * u_m;
  row->m_jacDiagABInv = B / (1.0 + B * W);
  row->m_cfm = 1.0 / (1.0 + B * W);
  row->m_rhs = (A - B * free_m_per_s) / (1.0 + B * W);
}

}  // namespace

RowSolver::ContactRow RowSolver::MakeContactRow(const btSolverConstraint& row) const {
  const btSolverBody& a = m_tmpSolverBodyPool[row.m_solverBodyIdA];
  const btSolverBody& b = m_tmpSolverBodyPool[row.m_solverBodyIdB];
  ContactRow made;
  made.law = static_cast<const ContactLaw*>(
      static_cast<const btManifoldPoint*>(row.m_originalContactPoint)->m_userPersistentData);
  made.start_m_per_s = StartSpeed(row, a, b);
  made.free_m_per_s = made.start_m_per_s + OuterSpeed(row, a, b);
  made.inverse_mass_per_kg = Along(row.m_contactNormal1, row.m_relpos1CrossNormal,
                                   row.m_contactNormal1 * a.internalGetInvMass(), row.m_angularComponentA) +
                             Along(row.m_contactNormal2, row.m_relpos2CrossNormal,
                                   row.m_contactNormal2 * b.internalGetInvMass(), row.m_angularComponentB);
  return made;
}

// Sets the row to the tangent of the law at the end speed v*, with force F* [N] and slope z [N s/m]. With the impulse
// lambda = dt (F* + z v*) - dt z v1 =: A - B v1 [N s], v1 = v_free + J dv and the inverse effective mass W [1/kg],
// Bullet's update d lambda = rhs - cfm lambda - D J dv solves the row in one step for
//   D = B / (1 + B W),  cfm = 1 / (1 + B W),  rhs = (A - B v_free) / (1 + B W).
void RowSolver::SetLine(ContactRow* made, double at_m_per_s, btSolverConstraint* row) const {
  const ContactRow& from = *made;
  const double W = from.inverse_mass_per_kg;
  if (from.law->kind == ContactKind::kHard) {
    const double D = 1.0 / (W * (1.0 + from.law->softness));
    row->m_jacDiagABInv = D;
    row->m_cfm = from.law->softness / (1.0 + from.law->softness);
    row->m_rhs = D * (HardSpeed_m_per_s(from.law->gap_m, dt_s_) - from.free_m_per_s);
    return;
  }
  const ForceLine line = CompliantForce(*from.law, W, from.start_m_per_s, at_m_per_s, dt_s_, &made->piece);
  made->is_idle = line.force_N <= 0.0 && line.slope_N_s_per_m == 0.0;
  const double B = std::max(dt_s_ * line.slope_N_s_per_m, kLeastSlope / W);
  const double A = dt_s_ * line.force_N + B * at_m_per_s;
  row->m_jacDiagABInv = B / (1.0 + B * W);
  row->m_cfm = 1.0 / (1.0 + B * W);
  row->m_rhs = (A - B * from.free_m_per_s) / (1.0 + B * W);
}

double RowSolver::SolvedSpeed(const ContactRow& from, const btSolverConstraint& row) const {
  const btSolverBody& a = m_tmpSolverBodyPool[row.m_solverBodyIdA];
  const btSolverBody& b = m_tmpSolverBodyPool[row.m_solverBodyIdB];
  return from.free_m_per_s +
         Along(row.m_contactNormal1, row.m_relpos1CrossNormal, a.m_deltaLinearVelocity, a.m_deltaAngularVelocity) +
         Along(row.m_contactNormal2, row.m_relpos2CrossNormal, b.m_deltaLinearVelocity, b.m_deltaAngularVelocity);
}

void RowSolver::WarmStart(btSolverConstraint* friction) {
  btSolverBody& a = m_tmpSolverBodyPool[friction->m_solverBodyIdA];
  btSolverBody& b = m_tmpSolverBodyPool[friction->m_solverBodyIdB];
  const glm::dvec3& last_W = contact_rows_[static_cast<std::size_t>(friction->m_frictionIndex)].law->friction_W_Ns;
  const double start = DirectionOnS(*friction).dot(btVector3(last_W.x, last_W.y, last_W.z));
  friction->m_appliedImpulse = start;
  a.internalApplyImpulse(friction->m_contactNormal1 * a.internalGetInvMass(), friction->m_angularComponentA, start);
  b.internalApplyImpulse(friction->m_contactNormal2 * b.internalGetInvMass(), friction->m_angularComponentB, start);
}

void RowSolver::convertContacts(btPersistentManifold** manifolds, int num_manifolds, const btContactSolverInfo& info) {
  btSequentialImpulseConstraintSolver::convertContacts(manifolds, num_manifolds, info);
  dt_s_ = info.m_timeStep;
  const int num_rows = m_tmpSolverContactConstraintPool.size();
  for (int i = 0; i < num_rows; ++i) {
    btSolverConstraint& row = m_tmpSolverContactConstraintPool[i];
    ContactRow& from = contact_rows_[static_cast<std::size_t>(i)];
    from = MakeContactRow(row);
    if (!(from.inverse_mass_per_kg > 0.0)) {
      row.m_jacDiagABInv = row.m_rhs = row.m_cfm = 0.0;  // neither body can move
      continue;
    }
    // First tangent: at the end speed of the row alone.
    double speed = from.free_m_per_s;
    for (int guess = 0; guess < kGuesses; ++guess) {
      SetLine(&from, speed, &row);
      speed = from.free_m_per_s + from.inverse_mass_per_kg * std::max(0.0, static_cast<double>(row.m_rhs));
    }
  }
  // Bullet's friction rows ignore external torques within the step. They also lack a warm start, as their directions
  // follow the sliding and change in each step; so the last friction is projected onto the new directions.
  for (int i = 0; i < m_tmpSolverContactFrictionConstraintPool.size(); ++i) {
    btSolverConstraint& row = m_tmpSolverContactFrictionConstraintPool[i];
    const btSolverBody& a = m_tmpSolverBodyPool[row.m_solverBodyIdA];
    const btSolverBody& b = m_tmpSolverBodyPool[row.m_solverBodyIdB];
    const double free_m_per_s = StartSpeed(row, a, b) + OuterSpeed(row, a, b);
    const ContactLaw& law = *contact_rows_[static_cast<std::size_t>(row.m_frictionIndex)].law;
    if (law.kind == ContactKind::kElastic) {
      SetSpring(law, free_m_per_s, dt_s_, &row);
    } else {
      row.m_rhs = -row.m_jacDiagABInv * free_m_per_s;
    }
    WarmStart(&row);
  }
}

// Newton step: sets the tangents of compliant rows to the speeds found. False when all tangents agree with their law.
bool RowSolver::MoveLines(const Island& island) {
  bool any = false;
  for (int i = 0; i < island.num_rows; ++i) {
    btSolverConstraint& row = *rows_[static_cast<std::size_t>(island.first + i)];
    if (!IsContact(row)) continue;
    ContactRow& from = contact_rows_[static_cast<std::size_t>(&row - &m_tmpSolverContactConstraintPool[0])];
    if (from.law->kind == ContactKind::kHard) continue;
    const double speed = SolvedSpeed(from, row);
    const ForceLine line = CompliantForce(*from.law, from.inverse_mass_per_kg, from.start_m_per_s, speed, dt_s_);
    const double impulse = dt_s_ * std::max(0.0, line.force_N);
    // The tangent's value A - B v1 rather than the row's impulse, which is not exact before the solver has converged.
    const double of_row = std::max(0.0, (row.m_rhs - row.m_jacDiagABInv * (speed - from.free_m_per_s)) / row.m_cfm);
    if (std::abs(impulse - of_row) * from.inverse_mass_per_kg <= kLineTolerance_m_per_s) continue;
    SetLine(&from, speed, &row);
    any = true;
  }
  return any;
}

}  // namespace physics
