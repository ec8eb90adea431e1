#pragma once

#include <algorithm>
#include <vector>

#include "nodes/haptic_node/ports.hpp"
#include "replay/fields.hpp"

namespace haptic_node {

// Kind of a recorded step (replay::StepKind): HapticNode::Reevaluate, with the number of the cycle before it. It fills
// only the commands.
constexpr std::uint8_t kReevaluation = 1;

// A recorded cycle: its inputs and outputs. Inputs::budget_points is the budget that the cycle used.
struct Step {
  Inputs inputs;
  Outputs outputs;
  std::uint32_t pairs_late = 0;  // pairs postponed for lack of time; such a cycle cannot be replayed exactly

  // Storage for the inputs' pointers when read from a recording.
  core::PhysicsState physics;
  std::vector<core::ParameterChange> changes;
};

template <class V>
void VisitInputs(V& v, Step& step) {
  Inputs& inputs = step.inputs;
  v.Value("now_ns", inputs.now_ns);
  replay::Items(v, "devices", inputs.devices);
  replay::Optional(v, "physics", inputs.physics, &step.physics);
  replay::Items(v, "reactions", inputs.reactions);
  replay::ItemsAt(v, "changes", inputs.changes, inputs.num_changes, &step.changes);
  v.Value("budget_points", inputs.budget_points);
  v.Value("pairs_late", step.pairs_late);
}

// Of the contacts, only those that were to be sent. Not the collision matrix, which sums up contacts for people.
template <class V>
void VisitOutputs(V& v, Step& step) {
  Outputs& outputs = step.outputs;
  replay::Items(v, "commands", outputs.commands);
  replay::Items(v, "proxies", outputs.proxies);
  std::size_t num_updated = 0;
  for (const std::uint8_t is_updated : outputs.contacts_updated) num_updated += is_updated;
  num_updated = v.Count("contacts", num_updated);
  if constexpr (V::kReads) std::fill(outputs.contacts_updated.begin(), outputs.contacts_updated.end(), 0);
  std::size_t next = 0;
  for (std::size_t k = 0; k < num_updated; ++k, ++next) {
    if constexpr (!V::kReads) {
      while (outputs.contacts_updated[next] == 0) ++next;
    }
    v.Enter("updated", k);
    v.Value("", next);
    v.Leave();
    if constexpr (V::kReads) {
      if (next > 65535) return v.Fail();
      if (next >= outputs.contacts.size()) {
        outputs.contacts.resize(next + 1);
        outputs.contacts_updated.resize(next + 1);
      }
      outputs.contacts_updated[next] = 1;
    }
    v.Enter("contacts", next);
    Visit(v, outputs.contacts[next]);
    v.Leave();
  }
  v.Value("is_in_contact", outputs.is_in_contact);
}

}  // namespace haptic_node
