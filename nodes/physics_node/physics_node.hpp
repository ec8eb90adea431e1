#pragma once

#include <memory>
#include <string_view>
#include <vector>

#include "core/result.hpp"
#include "nodes/physics_node/own_contacts.hpp"
#include "nodes/physics_node/ports.hpp"
#include "nodes/physics_node/sheet_keeper.hpp"
#include "nodes/physics_node/snapshot.hpp"
#include "physics/world.hpp"
#include "scene/scenario.hpp"

namespace physics_node {

struct Options {
  collision::Options collision;          // for the pairs that this node computes
  core::ParallelFor* workers = nullptr;  // for these pairs; null: on the thread of Step. Must outlive the node
};

// Owner of every pose that is neither fixed nor a hand's: one tick of 1 ms per Step, without sockets, clock or threads.
//
// Hand parts are kinematic bodies at the device's pose X_WD, not at the coupling pose X_WC. The spring between hand and
// object is then the contact's plane stiffness on the device's penetration, equal to the force on the hand by Eq. 6
// with k_f. At X_WC the object would feel a second, stiffer spring, and action would not equal reaction.
//
// Forces use fresh data only: a contact set older than kMaxAgeTicks haptic cycles is dropped. When haptic_node has been
// silent for kMaxAgeTicks ticks, all its contacts are dropped, hands stop, and reactions are zero. Before it is heard
// for the first time, and while it is silent, bodies have no weight: they would fall through what they stand on.
class PhysicsNode {
 public:
  // As haptic_node's kPhysicsStale_ns, so that both sides give up together: a third of the 60 ms after which no force
  // may be left.
  static constexpr int kMaxAgeTicks = 20;

  // Loads the meshes of physics-owned objects for mass and inertia.
  static core::Result<std::unique_ptr<PhysicsNode>> Create(const scene::Scenario& scenario,
                                                           const Options& options = {});
  // With given mass properties, one entry per object (only those of physics-owned objects are used).
  static core::Result<std::unique_ptr<PhysicsNode>> Create(const scene::Scenario& scenario,
                                                           const std::vector<physics::MassProperties>& mass_of_object,
                                                           const Options& options = {});
  ~PhysicsNode();
  PhysicsNode(const PhysicsNode&) = delete;
  PhysicsNode& operator=(const PhysicsNode&) = delete;

  // One tick. Passes on the stamps of the proxies' direct traces; the caller adds kPhysicsReceive and kPhysicsStart
  // before and kPhysicsSend after. Does not allocate, lock or log.
  void Step(const Inputs& inputs, Outputs* outputs) noexcept;

  // Names of this node's parameters (scenarios/README.md); whether it has the parameter and accepts the change.
  [[nodiscard]] std::vector<std::string> ParameterNames() const;
  [[nodiscard]] bool AcceptsParameter(const core::ParameterChange& change) const;

  [[nodiscard]] std::uint64_t tick() const;  // of the last Step; 0 before the first
  [[nodiscard]] physics::ImpulseBalance impulse_balance() const;
  [[nodiscard]] const physics::World& world() const;
  [[nodiscard]] std::uint64_t StateHash() const;  // also part of Step's outputs

  // Between steps: saves and restores the complete state. A restored node of the same scenario continues bit for bit
  // with the same inputs. Save allocates only while the snapshot grows, so not from the second time on, and waits for a
  // sheet step in progress (is_quiet: there is none). After a failed Restore the node must not be used.
  void Save(Snapshot* snapshot) const;
  [[nodiscard]] bool is_quiet() const;
  core::Result<void> Restore(Snapshot* snapshot);
  // Digest of the data that the node was created from: objects, masses, poses, pairs and mechanisms.
  [[nodiscard]] std::uint64_t content_digest() const;
  // The pairs that this node computes and that touched in the last Step, with the forces that its solver gave them.
  void FillCollisions(core::CollisionMatrix* matrix) const;
  // The pairs that this node computes, as of the last Step.
  OwnContacts& own_contacts();
  SheetKeeper& sheets();

 private:
  struct Impl;
  explicit PhysicsNode(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace physics_node
