#pragma once

#include <BulletDynamics/ConstraintSolver/btSequentialImpulseConstraintSolver.h>

#include <span>
#include <vector>

namespace physics {

// Projected Gauss-Seidel sweeps (sequential impulses) over the rows of one island, on a packed copy of their data:
// Bullet's rows and bodies take half a kilobyte each, and a step spends most of its time here. The operations and their
// order are those of btSequentialImpulseConstraintSolver::resolveSingleConstraintRowGeneric, so the results are the
// same bits.
class Sweeper {
 public:
  void Reserve(int num_bodies, int num_contacts, int num_rows);

  // `rows`: joints, then contacts, then the friction rows, whose m_frictionIndex is their contact's place in
  // `contacts`.
  void Load(std::span<btSolverConstraint* const> rows, const btConstraintArray& contacts,
            const btConstraintArray& frictions, const btAlignedObjectArray<btSolverBody>& bodies);
  // One pass over all rows; returns the largest change of a row's speed (m/s or rad/s).
  double Sweep();
  // Copies impulses, friction limits and velocities back to Bullet's rows and bodies.
  void Store(std::span<btSolverConstraint* const> rows, btAlignedObjectArray<btSolverBody>* bodies) const;

 private:
  // A linear and an angular component in one SIMD register.
  typedef double Pair __attribute__((vector_size(16)));
  struct Vector6 {
    Pair x{}, y{}, z{};
  };
  // One of the two bodies that a row acts on.
  struct Side {
    Vector6 J;        // row of the Jacobian
    Vector6 per_Ns;   // M^-1 J^T: change of velocity per unit impulse
    Vector6* change;  // change of the body's velocity in this step
  };
  struct PackedRow {
    Side a, b;
    double rhs, cfm, inverse_mass_per_kg, effective_mass_kg;
    double lower, upper, impulse;
    double friction;
    const double* normal_impulse;  // null: no friction row
  };
  static Vector6 Pairs(const btVector3& linear, const btVector3& angular);
  static Vector6 ChangeOf(const btSolverBody& body);
  Side MakeSide(const btVector3& linear, const btVector3& angular, const btVector3& angular_component, int body,
                const btAlignedObjectArray<btSolverBody>& bodies);
  static double Relax(PackedRow* row, Vector6* change_a, Vector6* change_b);

  std::vector<PackedRow> rows_;
  std::size_t num_rows_ = 0;
  std::vector<Vector6> changes_;                // by body
  std::vector<const double*> normal_impulses_;  // by contact
};

}  // namespace physics
