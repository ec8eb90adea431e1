#include "physics/engine/sweeper.hpp"

#include <algorithm>
#include <cmath>

namespace physics {
namespace {

bool IsOf(const btConstraintArray& pool, const btSolverConstraint* row) {
  return pool.size() > 0 && row >= &pool[0] && row <= &pool[pool.size() - 1];
}

}  // namespace

void Sweeper::Reserve(int num_bodies, int num_contacts, int num_rows) {
  const auto grow = [](auto* vector, int size) {
    if (vector->size() < static_cast<std::size_t>(size)) vector->resize(static_cast<std::size_t>(size));
  };
  grow(&changes_, num_bodies);
  grow(&normal_impulses_, num_contacts);
  grow(&rows_, num_rows);
}

Sweeper::Vector6 Sweeper::Pairs(const btVector3& linear, const btVector3& angular) {
  return {Pair{linear[0], angular[0]}, Pair{linear[1], angular[1]}, Pair{linear[2], angular[2]}};
}

Sweeper::Vector6 Sweeper::ChangeOf(const btSolverBody& body) {
  return Pairs(body.m_deltaLinearVelocity, body.m_deltaAngularVelocity);
}

Sweeper::Side Sweeper::MakeSide(const btVector3& linear, const btVector3& angular, const btVector3& angular_component,
                                int body, const btAlignedObjectArray<btSolverBody>& bodies) {
  const btSolverBody& its = bodies[body];
  Side side{};
  side.J = Pairs(linear, angular);
  if (its.m_originalBody != nullptr) side.per_Ns = Pairs(linear * its.m_invMass, angular_component);  // it moves
  side.change = &changes_[static_cast<std::size_t>(body)];
  *side.change = ChangeOf(its);
  return side;
}

void Sweeper::Load(std::span<btSolverConstraint* const> rows, const btConstraintArray& contacts,
                   const btConstraintArray& frictions, const btAlignedObjectArray<btSolverBody>& bodies) {
  num_rows_ = rows.size();
  for (std::size_t i = 0; i < num_rows_; ++i) {
    const btSolverConstraint& from = *rows[i];
    PackedRow& row = rows_[i];
    row.a = MakeSide(from.m_contactNormal1, from.m_relpos1CrossNormal, from.m_angularComponentA, from.m_solverBodyIdA,
                     bodies);
    row.b = MakeSide(from.m_contactNormal2, from.m_relpos2CrossNormal, from.m_angularComponentB, from.m_solverBodyIdB,
                     bodies);
    row.rhs = from.m_rhs;
    row.cfm = from.m_cfm;
    row.effective_mass_kg = from.m_jacDiagABInv;
    row.inverse_mass_per_kg = 1.0 / from.m_jacDiagABInv;
    row.lower = from.m_lowerLimit;
    row.upper = from.m_upperLimit;
    row.impulse = from.m_appliedImpulse;
    row.friction = from.m_friction;
    row.normal_impulse = nullptr;
    if (IsOf(frictions, rows[i])) {
      // The impulse of a contact that is not in the island cannot change; it is in Bullet's own row.
      const btSolverConstraint& contact = contacts[from.m_frictionIndex];
      const bool is_swept = contact.m_jacDiagABInv > 0.0;
      row.normal_impulse = is_swept ? normal_impulses_[static_cast<std::size_t>(from.m_frictionIndex)]
                                    : static_cast<const double*>(&contact.m_appliedImpulse);
    } else if (IsOf(contacts, rows[i])) {
      normal_impulses_[static_cast<std::size_t>(rows[i] - &contacts[0])] = &row.impulse;
    }
  }
}

// Projected Gauss-Seidel update of one row: changes its impulse by its residual within its limits, and the velocities
// of both bodies by M^-1 J^T d lambda:
//   d lambda = rhs - cfm lambda - (J_a dv_a + J_b dv_b) / (J M^-1 J^T).
inline double Sweeper::Relax(PackedRow* row, Vector6* change_a, Vector6* change_b) {
  const auto along = [](const Vector6& J, const Vector6& v) {
    const Pair sums = J.x * v.x + J.y * v.y + J.z * v.z;
    return sums[0] + sums[1];
  };
  double change = row->rhs - row->impulse * row->cfm;
  const double along_a = along(row->a.J, *change_a), along_b = along(row->b.J, *change_b);
  change -= along_a * row->effective_mass_kg;
  change -= along_b * row->effective_mass_kg;
  double after = row->impulse + change;
  if (after < row->lower) {
    after = row->lower;
    change = after - row->impulse;
  } else if (after > row->upper) {
    after = row->upper;
    change = after - row->impulse;
  }
  if (change == 0.0) return 0.0;  // an open contact: spares the next row a wait for the velocities
  row->impulse = after;
  const auto push = [change](const Vector6& per_Ns, Vector6* v) {
    v->x += per_Ns.x * change;
    v->y += per_Ns.y * change;
    v->z += per_Ns.z * change;
  };
  push(row->a.per_Ns, change_a);
  push(row->b.per_Ns, change_b);
  return change * row->inverse_mass_per_kg;
}

double Sweeper::Sweep() {
  double largest = 0.0;
  // Most rows act on the same two bodies as the previous one, so the bodies' velocities stay in registers.
  const PackedRow* last = nullptr;
  Vector6 a, b;
  const auto copy = [](const Vector6& from, Vector6* to) {  // one by one, or the compiler keeps both in memory
    to->x = from.x;
    to->y = from.y;
    to->z = from.z;
  };
  const auto put_back = [&] {
    if (last == nullptr) return;
    copy(a, last->a.change);
    copy(b, last->b.change);
  };
  for (std::size_t i = 0; i < num_rows_; ++i) {
    PackedRow& row = rows_[i];
    if (row.normal_impulse != nullptr) {
      row.upper = row.friction * std::max(0.0, *row.normal_impulse);
      row.lower = -row.upper;
      if (row.upper == 0.0 && row.impulse == 0.0) continue;  // no normal force, no friction
    }
    if (last == nullptr || row.a.change != last->a.change || row.b.change != last->b.change) {
      put_back();
      copy(*row.a.change, &a);
      copy(*row.b.change, &b);
      last = &row;
    }
    largest = std::max(largest, std::abs(Relax(&row, &a, &b)));
  }
  put_back();
  return largest;
}

void Sweeper::Store(std::span<btSolverConstraint* const> rows, btAlignedObjectArray<btSolverBody>* bodies) const {
  const auto store = [&](const Side& side, int body) {
    btSolverBody& its = (*bodies)[body];
    if (its.m_originalBody == nullptr) return;
    const auto& [x, y, z] = *side.change;
    its.m_deltaLinearVelocity.setValue(x[0], y[0], z[0]);
    its.m_deltaAngularVelocity.setValue(x[1], y[1], z[1]);
  };
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const PackedRow& row = rows_[i];
    btSolverConstraint& to = *rows[i];
    to.m_appliedImpulse = row.impulse;
    to.m_lowerLimit = row.lower;
    to.m_upperLimit = row.upper;
    store(row.a, to.m_solverBodyIdA);
    store(row.b, to.m_solverBodyIdB);
  }
}

}  // namespace physics
