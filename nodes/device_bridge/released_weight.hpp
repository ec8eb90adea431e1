#pragma once

#include <vector>

#include "core/messages/physics.hpp"
#include "core/result.hpp"
#include "physics/mass_properties.hpp"
#include "scene/scenario.hpp"

namespace device_bridge {

// What bodies have given by sinking in gravity. A hand that lowers a part gets work that no hand has put in: it was in
// the part's height when the run began.
//
// A sheet counts as a part of the object that it is sewn to, at its middle, as if it did not bend: what it gives by
// hanging down becomes heat, and its nodes are not on the way to the bridge. Only sheets that are active at the start.
//
// A state is late, so the account leads it by as much as changed in its last steps. Update is real-time safe.
class ReleasedWeight {
 public:
  // Reads meshes if the scenario has gravity. Errors: of collision::LoadMasses.
  static core::Result<ReleasedWeight> Create(const scene::Scenario& scenario);

  // Once per state of physics_node.
  void Update(const core::PhysicsState& state) noexcept;
  // Never negative: that a part is lifted is paid for by what lifts it.
  [[nodiscard]] double energy_J() const;

 private:
  [[nodiscard]] double PotentialEnergy_J(const core::PhysicsState& state) const noexcept;

  glm::dvec3 gravity_W_m_per_s2_{0.0};
  std::vector<physics::MassProperties> masses_;  // per object, with its sheet; empty without gravity
  bool has_begun_ = false;
  double start_J_ = 0.0;
  double before_J_ = 0.0;
  double energy_J_ = 0.0;
};

}  // namespace device_bridge
