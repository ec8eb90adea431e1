#pragma once

#include <algorithm>
#include <vector>

#include "nodes/physics_node/ports.hpp"
#include "replay/fields.hpp"

namespace physics_node {

// A recorded tick: its inputs, its outputs, and whether the sheets were late.
struct Step {
  Inputs inputs;
  Outputs outputs;
  bool is_sheet_late = false;  // a sheet step was due while the previous one was in progress

  // Storage for the inputs' pointers when read from a recording.
  std::vector<core::ContactSet> contacts;
  std::vector<core::ParameterChange> changes;
};

template <class V>
void Visit(V& v, ChangeOutcome& outcome) {
  v.Value("is_accepted", outcome.is_accepted);
  v.Value("is_pending", outcome.is_pending);
  v.Value("injected_J", outcome.injected_J);
}

constexpr std::size_t kMaxSlots = 16384;  // more mean a damaged recording

// Contact sets that have never arrived are left out.
template <class V>
void VisitContacts(V& v, Inputs& inputs, std::vector<core::ContactSet>* memory) {
  v.Value("num_contacts", inputs.num_contacts);
  std::size_t num_known = 0;
  if constexpr (!V::kReads) {
    for (std::size_t i = 0; i < inputs.num_contacts; ++i) num_known += inputs.contacts[i].header.sequence != 0 ? 1 : 0;
  }
  num_known = v.Count("contacts", num_known);
  if constexpr (V::kReads) memory->assign(std::min(inputs.num_contacts, kMaxSlots), {});
  std::size_t slot = 0;
  for (std::size_t k = 0; k < num_known; ++k, ++slot) {
    if constexpr (!V::kReads) {
      while (inputs.contacts[slot].header.sequence == 0) ++slot;
    }
    v.Enter("contacts", k);
    v.Value("slot", slot);
    if constexpr (V::kReads) {
      if (slot >= kMaxSlots) return v.Fail();
      if (slot >= memory->size()) memory->resize(slot + 1);
      Visit(v, (*memory)[slot]);
    } else {
      Visit(v, const_cast<core::ContactSet&>(inputs.contacts[slot]));
    }
    v.Leave();
  }
  if constexpr (V::kReads) {
    inputs.contacts = memory->data();
    inputs.num_contacts = memory->size();
  }
}

template <class V>
void VisitInputs(V& v, Step& step) {
  Inputs& inputs = step.inputs;
  v.Value("now_ns", inputs.now_ns);
  replay::Items(v, "proxies", inputs.proxies);
  VisitContacts(v, inputs, &step.contacts);
  replay::ItemsAt(v, "changes", inputs.changes, inputs.num_changes, &step.changes);
  v.Value("is_sheet_late", step.is_sheet_late);
}

template <class V>
void VisitOutputs(V& v, Step& step) {
  replay::Field(v, "state", step.outputs.state);
  replay::Items(v, "reactions", step.outputs.reactions);
  replay::Items(v, "outcomes", step.outputs.outcomes);
  replay::Items(v, "events", step.outputs.events);
}

}  // namespace physics_node
