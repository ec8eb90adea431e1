#pragma once

#include <cstddef>
#include <memory>
#include <string_view>

#include "core/messages/haptic.hpp"
#include "core/pose.hpp"
#include "core/result.hpp"
#include "core/wrench.hpp"
#include "physics/checkpoint.hpp"
#include "physics/contact_kind.hpp"
#include "physics/live_change.hpp"
#include "physics/mass_properties.hpp"
#include "physics/row.hpp"
#include "physics/solver_work.hpp"

namespace physics {

enum class BodyKind { kFixed, kKinematic, kDynamic };

struct BodyParams {
  BodyKind kind = BodyKind::kFixed;
  core::Pose X_WO;
  core::Twist V_WO;     // dynamic: start velocity of the mesh-frame origin
  MassProperties mass;  // dynamic only
};

// Compares the impulses on free bodies with their change of momentum since the world was created. Impulses are summed
// from the reports of contacts, mechanisms and wrenches; momentum is read from the bodies' states. So the residual
// shows any force that was lost or applied twice between solver, bodies and reports. It does not show a wrong force: a
// contact that is ten times too stiff balances too.
struct ImpulseBalance {
  double linear_residual_Ns = 0.0;    // sum over bodies of |change of p - impulses|
  double linear_magnitude_Ns = 0.0;   // sum of the magnitudes of all impulses
  double angular_residual_Nms = 0.0;  // same about the world origin
  double angular_magnitude_Nms = 0.0;
  [[nodiscard]] double relative() const {
    return linear_magnitude_Ns > 0.0 ? linear_residual_Ns / linear_magnitude_Ns : linear_residual_Ns;
  }
  [[nodiscard]] double relative_angular() const {
    return angular_magnitude_Nms > 0.0 ? angular_residual_Nms / angular_magnitude_Nms : angular_residual_Nms;
  }
};

// Effect of a contact in the last step.
struct ContactReport {
  core::Wrench F_So_W;          // on S, about S's mesh origin at the start of the step
  double smallest_gap_m = 1e9;  // over the planes, at the start of the step
  int num_pushing = 0;
};

// Rigid bodies, with Bullet's constraint solver and without its collision detection (architecture D6).
// Poses are of the mesh frame O; the centre of mass may be anywhere. Setup returns errors; Step and the setters used
// between steps do not allocate, throw or lock.
class World {
 public:
  struct Options {
    int max_iterations = 100;          // sweeps of the projected Gauss-Seidel solver; chosen, see engine/row_solver.hpp
    double tolerance_m_per_s = 1e-11;  // it has converged when no row changes a speed by more; near rounding at 1 m/s
    glm::dvec3 gravity_W_m_per_s2{0.0};
  };

  World();
  explicit World(const Options& options);
  ~World();
  World(const World&) = delete;
  World& operator=(const World&) = delete;

  // Setup.
  core::Result<int> AddBody(const BodyParams& params);
  core::Result<int> AddContactPair(int sampled_body, int field_body, ContactKind kind = ContactKind::kCompliant);
  core::Result<int> AddMechanism(int parent_body, int child_body, std::unique_ptr<Mechanism> mechanism);
  [[nodiscard]] int world_body() const;  // a fixed body whose mesh frame is W

  // Between steps.
  void SetKinematic(int body, const core::Pose& X_WO, const core::Twist& V_WO);
  // From the next Step on; not part of a checkpoint.
  void SetGravity(const glm::dvec3& gravity_W_m_per_s2);
  // External wrench on a dynamic body, about its mesh origin, in W; held until replaced.
  void SetLoad(int body, const core::Wrench& F_Bo_W);
  // Planes of a pair, held until replaced or cleared (D5). Planes with the same id keep their impulses as warm start.
  void SetContactPlanes(int pair, const core::ContactSet& set);
  // Wrench on S about S's origin, the opposite on G at the same point; held until replaced or cleared [VR-OOS, 3].
  // A pair with a wrench keeps its planes for the gaps below, but only the wrench acts.
  void SetContactWrench(int pair, const core::Wrench& F_So_W);
  void ClearContact(int pair);
  // A muted pair keeps its planes for SmallestGap_m but exerts no force (an object held in its gripper).
  void SetContactMuted(int pair, bool is_muted);
  [[nodiscard]] bool HasContactPlanes(int pair) const;
  // Smallest gap [m] of the pair's planes at the present poses; +1e9 without planes.
  [[nodiscard]] double SmallestGap_m(int pair) const;
  // The same over the planes that push S along direction_W (unit): within 60 degrees of it.
  [[nodiscard]] double SmallestGapAlong_m(int pair, const glm::dvec3& direction_W) const;
  // Mean distance of what presses from its middle: friction mu under a force N holds the torque mu N r about the
  // normal.
  [[nodiscard]] double PressedRadius_m(int pair) const;
  // World position of the deepest plane's contact point at the present poses.
  [[nodiscard]] glm::dvec3 DeepestPoint_W(int pair) const;

  void Step(double dt_s);
  // Steps since the world was created; the coming one is num_steps() + 1, the tick of the changes below.
  [[nodiscard]] std::uint64_t num_steps() const;

  // Changes of a mechanism's stiffness, damping, forces, locks (free axes) and motors between steps, without
  // allocation. Index in mechanism(index).tunables() by name; -1: none of that name.
  [[nodiscard]] int FindTunable(int mechanism, std::string_view name) const;
  // Whether the value is valid: finite, and not negative unless signed. Ramps need a finite ramp_s >= 0.
  [[nodiscard]] bool CanChange(int mechanism, int tunable, const Change& change) const;
  // Begins a change that CanChange allows. An immediate change is complete on return, with its tick and injected
  // energy; a ramp begins with the next step; a held change is applied at the start of the step in which it injects no
  // energy. The report is up to date after every step, until the next change of the same value. Checkpoints include
  // changes in progress.
  const ChangeReport& BeginChange(int mechanism, int tunable, const Change& change);
  [[nodiscard]] const ChangeReport& change_report(int mechanism, int tunable) const;
  // Potential energy of a mechanism's springs at the present poses.
  [[nodiscard]] double StoredEnergy_J(int mechanism) const;

  [[nodiscard]] core::Pose X_WO(int body) const;
  [[nodiscard]] core::Twist V_WO(int body) const;
  [[nodiscard]] BodyKind kind(int body) const;
  [[nodiscard]] std::size_t num_bodies() const;
  [[nodiscard]] const ContactReport& contact(int pair) const;
  // Wrench of a mechanism on its parent in the last step, about the point p_WQ, in W; the child received the opposite.
  [[nodiscard]] core::Wrench MechanismForceOnParent(int index, const glm::dvec3& p_WQ) const;
  [[nodiscard]] int parent_of(int mechanism) const;  // bodies
  [[nodiscard]] int child_of(int mechanism) const;
  Mechanism& mechanism(int index);
  [[nodiscard]] const Mechanism& mechanism(int index) const;

  [[nodiscard]] ImpulseBalance impulse_balance() const;
  // Its parts: over the steps of a body in which mechanisms but no contact acted, relative to the mechanisms' impulses;
  // and over those in which a contact acted, relative to the contacts' impulses.
  [[nodiscard]] ImpulseBalance joint_balance() const;
  [[nodiscard]] ImpulseBalance contact_balance() const;
  // Linear momentum of a free body, and its angular momentum about its centre of mass, in W.
  [[nodiscard]] glm::dvec3 momentum_Ns(int body) const;
  [[nodiscard]] glm::dvec3 spin_Nms(int body) const;
  [[nodiscard]] glm::dvec3 center_of_mass_W(int body) const;
  [[nodiscard]] double kinetic_energy_J(int body) const;
  // Number of islands since the world was created that were solved directly, and that were left with a residual because
  // the direct solver failed or had too many rows.
  [[nodiscard]] std::uint64_t num_direct_solves() const;
  [[nodiscard]] std::uint64_t num_fallbacks() const;
  [[nodiscard]] const SolverWork& solver_work() const;
  // Between steps: save and restore the complete state (bodies, planes, warm starts, mechanisms). A restored run
  // continues bit for bit. Both allocate. Restore needs a world that was built in the same way, else it fails with
  // kInvalidInput.
  void Save(Checkpoint* checkpoint) const;
  core::Result<void> Restore(Checkpoint* checkpoint);
  // Hash of the bit patterns of all poses, velocities and momenta, of the impulses of contacts and mechanisms (the warm
  // start of the next step), and of the mechanisms' states. Equal runs have equal hashes after every step.
  [[nodiscard]] std::uint64_t StateHash() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace physics
