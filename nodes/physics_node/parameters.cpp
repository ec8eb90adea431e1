#include "nodes/physics_node/parameters.hpp"

#include <algorithm>
#include <cmath>

namespace physics_node {
namespace {

physics::Change ChangeOf(const core::ParameterChange& change) {
  const physics::ChangeMode mode = change.manner == core::ChangeManner::kRamped ? physics::ChangeMode::kRamped
                                   : change.manner == core::ChangeManner::kWhenSeparated
                                       ? physics::ChangeMode::kWhenSeparated
                                       : physics::ChangeMode::kAtOnce;
  return {change.value, mode, change.ramp_s};
}

}  // namespace

Parameters::Parameters(const scene::Scenario& scenario, const BuiltWorld& built) {
  for (std::size_t i = 0; i < scenario.pairs.size(); ++i) {
    if (built.contact_of_pair[i] == kNone) continue;
    const std::string name = "pair." + scenario.PairName(i);
    slots_[name + ".active"] = {ParameterKind::kPairActive, i};
    if (scenario.pairs[i].owner != scene::PairOwner::kPhysics) continue;
    slots_[name + ".stiffness_N_per_m"] = {ParameterKind::kPairStiffness, i};
  }
  for (std::size_t i = 0; i < scenario.mechanisms.size(); ++i) {
    const std::string& name = scenario.mechanisms[i].name;
    if (built.sheet_hooks[i] != nullptr) {
      slots_[name + ".release_force_N"] = {ParameterKind::kSheetRelease, i};
      continue;
    }
    for (const char* figure : scene::LiveFigures(scenario.mechanisms[i])) {
      const int tunable = built.world->FindTunable(built.mechanism_of[i], figure);
      if (tunable == kNone) continue;
      slots_[name + "." + figure] = {ParameterKind::kMechanismFigure, i, built.mechanism_of[i], tunable};
    }
  }
  for (std::size_t i = 0; i < scenario.objects.size(); ++i) {
    if (scenario.objects[i].sheet) {
      slots_["sheet." + scenario.objects[i].name + ".active"] = {ParameterKind::kSheetActive, i};
    }
  }
}

std::vector<std::string> Parameters::Names() const {
  std::vector<std::string> names;
  for (const auto& [name, slot] : slots_) names.push_back(name);
  std::sort(names.begin(), names.end());
  return names;
}

const ParameterSlot* Parameters::Find(const std::string& name) const {
  const auto found = slots_.find(name);
  return found == slots_.end() ? nullptr : &found->second;
}

bool Parameters::Accepts(const physics::World& world, const core::ParameterChange& change) const {
  const ParameterSlot* slot = Find(change.name);
  if (slot == nullptr) return false;
  if (slot->kind == ParameterKind::kMechanismFigure) {
    return world.CanChange(slot->mechanism, slot->tunable, ChangeOf(change));
  }
  const bool is_stiffness = slot->kind == ParameterKind::kPairStiffness;
  return change.manner == core::ChangeManner::kAtOnce && std::isfinite(change.value) && change.value >= 0.0 &&
         (!is_stiffness || change.value > 0.0);
}

LiveChanges::LiveChanges(physics::World* world, const Parameters& parameters) : world_(world) {
  for (const std::string& name : parameters.Names()) {
    const ParameterSlot& slot = *parameters.Find(name);
    if (slot.kind == ParameterKind::kMechanismFigure) figures_.push_back({name, slot.mechanism, slot.tunable});
  }
}

ChangeOutcome LiveChanges::Begin(const ParameterSlot& slot, const core::ParameterChange& change) {
  const physics::ChangeReport& report = world_->BeginChange(slot.mechanism, slot.tunable, ChangeOf(change));
  const bool is_pending = report.last_tick == 0;
  for (Figure& figure : figures_) {
    if (figure.mechanism != slot.mechanism || figure.tunable != slot.tunable) continue;
    num_pending_ += static_cast<int>(is_pending) - static_cast<int>(figure.is_pending);
    figure.is_pending = is_pending;
  }
  return {true, is_pending, report.injected_J};
}

void LiveChanges::FindPending() {
  num_pending_ = 0;
  for (Figure& figure : figures_) {
    const physics::Mechanism& mechanism = world_->mechanism(figure.mechanism);
    figure.is_pending = mechanism.tunables()[static_cast<std::size_t>(figure.tunable)].state.is_pending;
    num_pending_ += static_cast<int>(figure.is_pending);
  }
}

}  // namespace physics_node
