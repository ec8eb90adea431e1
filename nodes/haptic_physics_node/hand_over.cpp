#include "nodes/haptic_physics_node/hand_over.hpp"

namespace haptic_physics_node {
namespace {

void Stamp(std::uint64_t number, std::int64_t now_ns, core::Header* header) {
  header->sequence = number;
  header->publish_ns = now_ns;
}

}  // namespace

void HandOver::TakeProxies(std::uint64_t number, std::int64_t now_ns, haptic_node::Outputs* outputs) {
  for (core::HapticProxy& proxy : outputs->proxies) Stamp(number, now_ns, &proxy.header);
  cycle.proxies = outputs->proxies;
  cycle.received_ns = now_ns;
}

void HandOver::TakeContacts(std::uint64_t number, std::int64_t now_ns, haptic_node::Outputs* outputs) {
  for (std::size_t i = 0; i < outputs->contacts.size() && i < cycle.contacts.size(); ++i) {
    if (outputs->contacts_updated[i] == 0) continue;
    Stamp(number, now_ns, &outputs->contacts[i].header);
    cycle.contacts[i] = outputs->contacts[i];
  }
}

void HandOver::TakeAnswer(std::uint64_t number, std::int64_t now_ns, physics_node::Outputs* outputs) {
  Stamp(number, now_ns, &outputs->state.header);
  for (core::Reaction& reaction : outputs->reactions) Stamp(number, now_ns, &reaction.header);
  answer.state = outputs->state;
  answer.reactions = outputs->reactions;
  answer.received_ns = now_ns;
}

}  // namespace haptic_physics_node
