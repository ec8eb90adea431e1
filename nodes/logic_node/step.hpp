#pragma once

#include "nodes/logic_node/ports.hpp"
#include "replay/fields.hpp"

namespace logic_node {

// A recorded step: its inputs and outputs.
struct Step {
  Inputs inputs;
  Outputs outputs;
  core::PhysicsState physics;  // storage for inputs.physics when read from a recording
};

template <class V>
void VisitInputs(V& v, Step& step) {
  Inputs& inputs = step.inputs;
  v.Value("now_ns", inputs.now_ns);
  replay::Optional(v, "physics", inputs.physics, &step.physics);
  replay::Items(v, "grasped_objects", inputs.grasped_objects);
  replay::Items(v, "events", inputs.events);
}

template <class V>
void VisitOutputs(V& v, Step& step) {
  Outputs& outputs = step.outputs;
  replay::Field(v, "status", outputs.status);
  v.Value("is_status_changed", outputs.is_status_changed);
  replay::Items(v, "changes", outputs.changes);
  replay::Items(v, "events", outputs.events);
}

}  // namespace logic_node
