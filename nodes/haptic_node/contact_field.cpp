#include "nodes/haptic_node/contact_field.hpp"

#include <algorithm>
#include <array>

namespace haptic_node {
namespace {

using Chosen = core::FixedVector<const vps::HeldContact*, core::kMaxFieldContacts>;

// Whether a is to be kept rather than b.
bool Matters(const vps::HeldContact& a, const vps::HeldContact& b) {
  if (a.normal_N != b.normal_N) return a.normal_N > b.normal_N;
  return a.gap_m < b.gap_m;
}

Chosen Choose(std::span<const vps::HeldContact> contacts) {
  Chosen chosen;
  for (const vps::HeldContact& contact : contacts) {
    if (chosen.full() && !Matters(contact, *chosen.back())) continue;
    if (!chosen.full()) {
      chosen.push_back(&contact);
    } else {
      chosen.back() = &contact;
    }
    for (std::size_t k = chosen.size() - 1; k > 0 && Matters(*chosen[k], *chosen[k - 1]); --k) {
      std::swap(chosen[k], chosen[k - 1]);
    }
  }
  return chosen;
}

}  // namespace

void WriteContactField(const vps::GodObject& god_object, const core::Pose& X_WD, std::span<const core::Pose> X_WO,
                       std::span<const core::Twist> V_WO, core::DeviceCommand* command) noexcept {
  const vps::GodObjectParameters& tool = god_object.parameters();
  const core::Pose& X_WC = god_object.X_WC();
  command->has_field = true;
  command->X_WD = X_WD;
  command->X_WC = X_WC;
  command->stiffness_N_per_m = tool.stiffness_N_per_m;
  command->stiffness_Nm_per_rad = tool.stiffness_Nm_per_rad;
  command->contacts.clear();
  for (const vps::HeldContact* contact : Choose(god_object.contacts())) {
    core::FieldContact c;
    c.p_C_W = glm::vec3(contact->p_W - X_WC.translation);
    c.n_W = glm::vec3(contact->n_W);
    c.v_W = glm::vec3(core::PointVelocity(V_WO[contact->body], contact->p_W - X_WO[contact->body].translation));
    c.slip_W = glm::vec3(contact->slip_W);
    c.gap_m = static_cast<float>(contact->gap_m);
    c.friction = static_cast<float>(contact->friction);
    c.most_N = contact->cycles_lost > 0 ? static_cast<float>(contact->most_N) : 0.0f;
    c.normal_N = static_cast<float>(contact->normal_N);
    c.tangent_W_N = glm::vec3(contact->tangent_W_N);
    command->contacts.push_back(c);
  }
}

}  // namespace haptic_node
