#pragma once

#include <optional>
#include <string>
#include <vector>

#include "nodes/logic_node/ports.hpp"
#include "nodes/logic_node/scxml/expression.hpp"
#include "replay/fields.hpp"
#include "scene/scenario.hpp"

namespace logic_node {

// The published values that conditions can read (scenarios/README.md): <mechanism>.state, <mechanism>.position,
// <role>.grasped.<object>, <object>.x|y|z (W, m), <object>.distance.<object2> (between mesh origins, m).
class Signals {
 public:
  // The scenario must outlive the table.
  explicit Signals(const scene::Scenario& scenario);

  // The signal of that name, with a slot in values(); nullopt when the scenario has no such signal.
  std::optional<scxml::Symbol> Find(const std::string& name);

  // Remedy for an unknown name.
  [[nodiscard]] std::string Suggest(const std::string& name) const;

  // Updates the values from the newest messages. Objects without a message keep their pose from the scenario.
  void Update(const Inputs& inputs);

  [[nodiscard]] const std::vector<double>& values() const { return values_; }

  // The complete state (replay/fields.hpp).
  template <class V>
  void VisitState(V& v) {
    replay::Items(v, "p_WO", p_WO_);
    replay::Items(v, "states", states_);
    replay::Items(v, "positions", positions_);
    replay::Items(v, "grasped", grasped_);
    replay::Items(v, "values", values_);
  }

 private:
  enum class Kind { kState, kPosition, kGrasped, kCoordinate, kDistance };
  struct Signal {
    std::string name;
    Kind kind = Kind::kState;
    int first = 0;   // mechanism, role or object
    int second = 0;  // object, or axis
  };

  [[nodiscard]] std::optional<Signal> Parse(const std::string& name) const;
  [[nodiscard]] int MovedObject(const std::string& name) const;
  [[nodiscard]] double Value(const Signal& signal) const;

  const scene::Scenario& scenario_;
  std::vector<Signal> signals_;
  std::vector<double> values_;
  std::vector<glm::dvec3> p_WO_;      // per object
  std::vector<std::int32_t> states_;  // per mechanism
  std::vector<double> positions_;
  std::vector<int> grasped_;  // object per role; -1: none
};

}  // namespace logic_node
