#pragma once

#include <cstddef>
#include <memory>
#include <string_view>

#include "core/messages/haptic.hpp"
#include "core/pose.hpp"
#include "core/result.hpp"
#include "core/wrench.hpp"
#include "physics/checkpoint.hpp"
#include "physics/live_change.hpp"
#include "physics/mass_properties.hpp"
#include "physics/row.hpp"
#include "physics/solver_work.hpp"

namespace physics {

enum class BodyKind { kFixed, kKinematic, kDynamic };

// How a pair's planes push: as the springs that they carry, which keep energy, or as hard contact, which lets the
// bodies come no closer than touching and takes the energy of the approach.
enum class ContactKind { kCompliant, kHard };

struct BodyParams {
  BodyKind kind = BodyKind::kFixed;
  core::Pose X_WO;
  core::Twist V_WO;     // dynamic: start velocity of the mesh-frame origin
  MassProperties mass;  // dynamic only
};

// Impulses applied to free bodies against their change of momentum, since the world was made. Impulses are summed
// from what each contact, mechanism and wrench reports; momentum is read from the bodies' states: two ways to the same
// number, so the residual shows any force that was applied twice, lost, or made up on its way from the solver to the
// bodies and the reports. It does not show a wrong force: a contact ten times too stiff balances as well.
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

// What a contact did in the last step.
struct ContactReport {
  core::Wrench F_So_W;          // on S, about S's mesh origin at the start of the step
  double smallest_gap_m = 1e9;  // over the planes, at the start of the step
  int num_pushing = 0;
};

// Rigid bodies in zero gravity, stepped by Bullet's constraint solver with its collision detection bypassed
// (architecture D6). Poses in and out are of the mesh frame O; the centre of mass may be anywhere.
// Setup calls return errors; Step and the setters used between steps do not allocate, throw or lock.
class World {
 public:
  struct Options {
    int max_iterations = 100;          // of the sequential-impulse solver
    double tolerance_m_per_s = 1e-11;  // it stops when no row changes a velocity by more
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
  // Wrench from outside of this world on a dynamic body, about its mesh origin, in W; held until replaced.
  void SetLoad(int body, const core::Wrench& F_Bo_W);
  // Planes of a pair, held until replaced or cleared; D5. Impulses of planes with the same id go on as warm start.
  void SetContactPlanes(int pair, const core::ContactSet& set);
  // Wrench on S about S's origin, the opposite on G at the same point; held until replaced or cleared [VR-OOS, 3].
  // A pair with a wrench keeps its planes for the gaps below, but only the wrench pushes.
  void SetContactWrench(int pair, const core::Wrench& F_So_W);
  void ClearContact(int pair);
  // A muted pair keeps its planes for SmallestGap_m but does not push (a held object in its gripper).
  void SetContactMuted(int pair, bool is_muted);
  [[nodiscard]] bool HasContactPlanes(int pair) const;
  // Smallest gap of the pair's planes at the present poses; +1e9 without planes.
  [[nodiscard]] double SmallestGap_m(int pair) const;
  // The same over the planes that push S along direction_W (unit): within 60 degrees of it.
  [[nodiscard]] double SmallestGapAlong_m(int pair, const glm::dvec3& direction_W) const;
  // World position of the deepest plane's contact point at the present poses.
  [[nodiscard]] glm::dvec3 DeepestPoint_W(int pair) const;

  void Step(double dt_s);
  // Steps since the world was made: the coming one is num_steps() + 1. It is the tick of the live changes below.
  [[nodiscard]] std::uint64_t num_steps() const;

  // Live changes of a mechanism's stiffness, damping, forces, locks (free axes) and motors, between steps; no
  // allocation. The figure's place in mechanism(index).tunables(), by its name there; -1: it has none of that name.
  [[nodiscard]] int FindTunable(int mechanism, std::string_view name) const;
  // Whether a value makes sense: finite, and not negative where the figure must not be. Ramps need a finite ramp_s >=
  // 0.
  [[nodiscard]] bool CanChange(int mechanism, int tunable, const Change& change) const;
  // Begins a change that CanChange allows. At once it is done on return, with the tick and the energy injected; a ramp
  // begins with the next step; what waits for separation is applied at the top of the step that finds it so. The report
  // is up to date after every step, until the next change of the same figure. Checkpoints hold what is under way.
  const ChangeReport& BeginChange(int mechanism, int tunable, const Change& change);
  [[nodiscard]] const ChangeReport& change_report(int mechanism, int tunable) const;
  // Potential energy of a mechanism's springs at the present poses.
  [[nodiscard]] double StoredEnergy_J(int mechanism) const;

  [[nodiscard]] core::Pose X_WO(int body) const;
  [[nodiscard]] core::Twist V_WO(int body) const;
  [[nodiscard]] BodyKind kind(int body) const;
  [[nodiscard]] std::size_t num_bodies() const;
  [[nodiscard]] const ContactReport& contact(int pair) const;
  // What a mechanism did to its parent in the last step, about the point p_WQ, in W; the child got the opposite.
  [[nodiscard]] core::Wrench MechanismForceOnParent(int index, const glm::dvec3& p_WQ) const;
  [[nodiscard]] int parent_of(int mechanism) const;  // bodies
  [[nodiscard]] int child_of(int mechanism) const;
  Mechanism& mechanism(int index);
  [[nodiscard]] const Mechanism& mechanism(int index) const;

  [[nodiscard]] ImpulseBalance impulse_balance() const;
  // Of it, the steps of a body in which mechanisms pushed it and no contact did, against the impulses of mechanisms;
  // and those in which a contact pushed, against the impulses of contacts.
  [[nodiscard]] ImpulseBalance joint_balance() const;
  [[nodiscard]] ImpulseBalance contact_balance() const;
  // Of one free body: linear momentum, and angular momentum about its centre of mass, in W.
  [[nodiscard]] glm::dvec3 momentum_Ns(int body) const;
  [[nodiscard]] glm::dvec3 spin_Nms(int body) const;
  [[nodiscard]] glm::dvec3 center_of_mass_W(int body) const;
  [[nodiscard]] double kinetic_energy_J(int body) const;
  // Islands that sequential impulses could not solve: how many were solved directly, and how many were left as they
  // were since that failed too or they have too many rows. Counted since the world was made.
  [[nodiscard]] std::uint64_t num_direct_solves() const;
  [[nodiscard]] std::uint64_t num_fallbacks() const;
  [[nodiscard]] const SolverWork& solver_work() const;
  // A run that is restored goes on bit for bit as the one that was saved: states, planes, warm starts, mechanisms.
  // Between steps; allocates. Restore is for a world that was built alike, else it fails and the world is of no use.
  void Save(Checkpoint* checkpoint) const;
  core::Result<void> Restore(Checkpoint* checkpoint);
  // Of the bit patterns of all poses, velocities and momenta, of the impulses of contacts and mechanisms (the warm
  // start of the next step), and of the mechanisms' states: equal runs have equal hashes after every step.
  [[nodiscard]] std::uint64_t StateHash() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace physics
