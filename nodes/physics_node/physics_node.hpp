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
  collision::Options collision;          // of the pairs that this node computes
  core::ParallelFor* workers = nullptr;  // for these; null: on the thread of Step. Must outlive the node
};

// Owner of every pose that is not fixed and not a hand: one tick of 1 ms per Step, no socket, clock or thread.
//
// Hand parts enter as kinematic bodies at the device's pose X_WD, not at the coupling pose X_WC: the spring between
// hand and object is then the contact's plane stiffness acting on the device's penetration, which is what the hand
// feels through Eq. 6 with k_f. With X_WC the object would see a second, stiffer spring and action would not equal
// reaction.
//
// Force is made from fresh data only: a contact set older than kMaxAgeTicks haptic cycles is dropped; when haptic_node
// has been silent for kMaxAgeTicks ticks all its contacts are dropped, the hands stop where they are, and reactions are
// 0.
class PhysicsNode {
 public:
  static constexpr int kMaxAgeTicks = 20;

  // Loads the meshes of physics-owned objects for mass and inertia.
  static core::Result<std::unique_ptr<PhysicsNode>> Create(const scene::Scenario& scenario,
                                                           const Options& options = {});
  // Mass properties given, one entry per object (those of physics-owned ones are used).
  static core::Result<std::unique_ptr<PhysicsNode>> Create(const scene::Scenario& scenario,
                                                           const std::vector<physics::MassProperties>& mass_of_object,
                                                           const Options& options = {});
  ~PhysicsNode();
  PhysicsNode(const PhysicsNode&) = delete;
  PhysicsNode& operator=(const PhysicsNode&) = delete;

  // Stamps of the proxies' direct traces are passed on as they are: who calls adds kPhysicsReceive and kPhysicsStart
  // before and kPhysicsSend after. Does not allocate, lock or log.
  void Step(const Inputs& inputs, Outputs* outputs) noexcept;

  // Parameters (scenarios/README.md): those of this node, and whether one is its own and can have this value.
  [[nodiscard]] std::vector<std::string> ParameterNames() const;
  [[nodiscard]] bool AcceptsParameter(const core::ParameterChange& change) const;

  [[nodiscard]] std::uint64_t tick() const;  // of the last Step; 0 before the first
  [[nodiscard]] physics::ImpulseBalance impulse_balance() const;
  [[nodiscard]] const physics::World& world() const;
  [[nodiscard]] std::uint64_t StateHash() const;  // also in the state that Step fills

  // Between steps. A node that was created from the same scenario and is restored goes on bit for bit, if it gets the
  // same inputs. Save allocates only while the snapshot grows, so not from the second time on. A failed Restore leaves
  // a node that is of no use.
  // Save waits for a sheet's step that is under way, unless there is none (is_quiet).
  void Save(Snapshot* snapshot) const;
  [[nodiscard]] bool is_quiet() const;
  core::Result<void> Restore(Snapshot* snapshot);
  // Of what the node was created from: objects, masses, poses, pairs and mechanisms.
  [[nodiscard]] std::uint64_t content_digest() const;
  // What is to be told about the pairs that this node computes, as of the last Step.
  OwnContacts& own_contacts();
  SheetKeeper& sheets();

 private:
  struct Impl;
  explicit PhysicsNode(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace physics_node
