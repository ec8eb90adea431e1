#pragma once

#include <cstdint>
#include <string>
#include <unordered_map>
#include <vector>

#include "core/messages/logic.hpp"
#include "nodes/physics_node/build_world.hpp"
#include "nodes/physics_node/ports.hpp"

namespace physics_node {

enum class ParameterKind : std::uint8_t { kPairActive, kPairStiffness, kMechanismFigure, kSheetRelease, kSheetActive };

struct ParameterSlot {
  ParameterKind kind{};
  std::size_t index = 0;  // of the scenario's pair, mechanism or object
  int mechanism = kNone;  // kMechanismFigure: of the world
  int tunable = kNone;    // its place there
};

// The parameters that can be changed at run time (scenarios/README.md), by name.
class Parameters {
 public:
  Parameters(const scene::Scenario& scenario, const BuiltWorld& built);

  [[nodiscard]] std::vector<std::string> Names() const;  // ascending
  [[nodiscard]] const ParameterSlot* Find(const std::string& name) const;
  // Whether this node has the parameter and accepts the value and the manner of the change. Only values of mechanisms
  // can be ramped or held.
  [[nodiscard]] bool Accepts(const physics::World& world, const core::ParameterChange& change) const;

 private:
  std::unordered_map<std::string, ParameterSlot> slots_;
};

// Tracks changes of mechanisms' values that are ramped or held, until they have settled.
class LiveChanges {
 public:
  LiveChanges(physics::World* world, const Parameters& parameters);

  // Begins a change that Parameters accepts. No allocation.
  ChangeOutcome Begin(const ParameterSlot& slot, const core::ParameterChange& change);
  // After a step: calls report(name, change) for every change that has reached its value in it.
  template <typename Report>
  void ReportSettled(Report&& report);
  // Call it after restoring the world: finds the changes that are in progress.
  void FindPending();

 private:
  struct Figure {
    std::string name;
    int mechanism = kNone;
    int tunable = kNone;
    bool is_pending = false;
  };
  physics::World* world_;
  std::vector<Figure> figures_;
  int num_pending_ = 0;
};

template <typename Report>
void LiveChanges::ReportSettled(Report&& report) {
  if (num_pending_ == 0) return;
  for (Figure& figure : figures_) {
    if (!figure.is_pending) continue;
    const physics::ChangeReport& change = world_->change_report(figure.mechanism, figure.tunable);
    if (change.last_tick == 0) continue;
    figure.is_pending = false;
    --num_pending_;
    report(figure.name, change);
  }
}

}  // namespace physics_node
