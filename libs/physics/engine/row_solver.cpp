#include "physics/engine/row_solver.hpp"

#include <algorithm>

#include "physics/engine/bullet_conversions.hpp"

namespace physics {
namespace {

// Lower bound of a row's impedance k dt + d [N s/m], since the compliance of a row without spring and damper would be
// infinite. It changes the force by less than one part in 10^9 for any inertia above 1e-12 kg (m^2).
constexpr double kSmallestImpedance = 1e-9;

double Impedance(const Row& row, double dt) {
  return std::max(kSmallestImpedance, row.stiffness * dt + row.damping);
}

}  // namespace

void RowConstraint::getInfo1(btConstraintInfo1* info) {
  info->m_numConstraintRows = static_cast<int>(
      std::count_if(mechanism_->rows().begin(), mechanism_->rows().end(), [](const Row& r) { return r.is_active; }));
  info->nub = 0;
}

void RowConstraint::getInfo2(btConstraintInfo2* info) {
  const double dt = 1.0 / info->fps;
  const glm::dvec3 p_WCm_child = FromBullet(getRigidBodyA().getCenterOfMassPosition());
  const glm::dvec3 p_WCm_parent = FromBullet(getRigidBodyB().getCenterOfMassPosition());
  int i = 0;
  for (const Row& row : mechanism_->rows()) {
    if (!row.is_active) continue;
    const int at = i * info->rowskip;
    const glm::dvec3 ang_child = glm::cross(row.p_W - p_WCm_child, row.linear_W) + row.angular_W;
    const glm::dvec3 ang_parent = glm::cross(row.p_W - p_WCm_parent, row.linear_W) + row.angular_W;
    for (int c = 0; c < 3; ++c) {
      info->m_J1linearAxis[at + c] = row.linear_W[c];
      info->m_J1angularAxis[at + c] = ang_child[c];
      info->m_J2linearAxis[at + c] = -row.linear_W[c];
      info->m_J2angularAxis[at + c] = -ang_parent[c];
    }
    if (row.is_hard) {
      info->cfm[at] = 0.0;
      info->m_constraintError[at] = row.velocity_bias;
    } else {
      // With the impulse lambda = dt F and F = F0 - z v, z the impedance: v + gamma lambda = gamma dt F0, where
      // gamma = 1 / (dt z) is the row's compliance (Bullet's constraint force mixing).
      const double gamma = 1.0 / (dt * Impedance(row, dt));
      info->cfm[at] = gamma;
      info->m_constraintError[at] = gamma * dt * row.force;
    }
    info->m_lowerLimit[at] = row.lower * dt;
    info->m_upperLimit[at] = row.upper * dt;
    ++i;
  }
}

void RowSolver::Reserve(int num_bodies, int num_contacts, int num_rows) {
  m_tmpSolverBodyPool.reserve(num_bodies + 1);
  const auto grow = [](auto* vector, int size) {
    if (vector->size() < static_cast<std::size_t>(size)) vector->resize(static_cast<std::size_t>(size));
  };
  grow(&root_of_body_, num_bodies + 1);
  grow(&rows_of_root_, num_bodies + 1);
  grow(&direct_steps_, num_bodies + 1);
  islands_.reserve(root_of_body_.size());
  grow(&contact_rows_, num_contacts);
  num_contacts_ = std::max(num_contacts_, num_contacts);
  num_rows_ = std::max(num_rows_, num_rows);
  grow(&rows_, num_rows_ + 3 * num_contacts_);
  sweeper_.Reserve(num_bodies + 1, num_contacts_, num_rows_ + 3 * num_contacts_);
  m_tmpSolverContactConstraintPool.reserve(num_contacts);
  m_tmpSolverContactFrictionConstraintPool.reserve(2 * num_contacts);
  m_tmpSolverNonContactConstraintPool.reserve(num_rows);
  m_orderTmpConstraintPool.reserve(2 * num_contacts);
  m_orderFrictionConstraintPool.reserve(2 * num_contacts);
  m_orderNonContactConstraintPool.reserve(num_rows);
  m_tmpConstraintSizesPool.reserve(num_rows);
}

void RowSolver::convertJoints(btTypedConstraint** constraints, int num_constraints, const btContactSolverInfo& info) {
  btSequentialImpulseConstraintSolver::convertJoints(constraints, num_constraints, info);
  constraints_ = constraints;
  num_constraints_ = num_constraints;
  int at = 0;
  for (int i = 0; i < num_constraints; ++i) {
    for (Row& row : static_cast<RowConstraint*>(constraints[i])->mechanism().rows()) {
      if (!row.is_active) {
        row.impulse = 0.0;
        continue;
      }
      btSolverConstraint& c = m_tmpSolverNonContactConstraintPool[at++];
      if (!(c.m_jacDiagABInv > 0.0)) continue;  // neither body can move along the row
      const double gamma = c.m_cfm;
      const double softened = 1.0 / (1.0 / c.m_jacDiagABInv + gamma);
      c.m_rhs *= softened / c.m_jacDiagABInv;
      c.m_jacDiagABInv = softened;
      c.m_cfm = gamma * softened;
      const double start = std::clamp(row.impulse, c.m_lowerLimit, c.m_upperLimit);
      c.m_appliedImpulse = start;
      btSolverBody& a = m_tmpSolverBodyPool[c.m_solverBodyIdA];
      btSolverBody& b = m_tmpSolverBodyPool[c.m_solverBodyIdB];
      a.internalApplyImpulse(c.m_contactNormal1 * a.internalGetInvMass(), c.m_angularComponentA, start);
      b.internalApplyImpulse(c.m_contactNormal2 * b.internalGetInvMass(), c.m_angularComponentB, start);
    }
  }
}

btScalar RowSolver::solveGroupCacheFriendlyFinish(btCollisionObject** bodies, int num_bodies,
                                                  const btContactSolverInfo& info) {
  int at = 0;
  for (int i = 0; i < num_constraints_; ++i) {
    for (Row& row : static_cast<RowConstraint*>(constraints_[i])->mechanism().rows()) {
      if (row.is_active) row.impulse = m_tmpSolverNonContactConstraintPool[at++].m_appliedImpulse;
    }
  }
  return btSequentialImpulseConstraintSolver::solveGroupCacheFriendlyFinish(bodies, num_bodies, info);
}

}  // namespace physics
