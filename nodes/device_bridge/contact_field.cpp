#include "nodes/device_bridge/contact_field.hpp"

#include <algorithm>
#include <cmath>

#include "core/clock.hpp"

namespace device_bridge {
namespace {

vps::HeldContact ContactOf(const core::FieldContact& c, const core::Pose& X_WC, double age_s) {
  const glm::dvec3 n_W(c.n_W);
  const glm::dvec3 way_W = age_s * glm::dvec3(c.v_W);  // of the body
  vps::HeldContact contact;
  contact.p_W = X_WC.translation + glm::dvec3(c.p_C_W);
  contact.n_W = n_W;
  contact.gap_m = c.gap_m - glm::dot(n_W, way_W);
  contact.slip_W = glm::dvec3(c.slip_W) - (way_W - glm::dot(n_W, way_W) * n_W);
  contact.friction = c.friction;
  contact.normal_N = c.normal_N;
  contact.tangent_W_N = glm::dvec3(c.tangent_W_N);
  if (c.most_N > 0.0f) {
    contact.most_N = c.most_N;
    contact.cycles_lost = 1;
  }
  return contact;
}

}  // namespace

// The bodies go on for as long as the command is valid.
double ContactField::Age_s(std::int64_t now_ns) const noexcept {
  return 1e-9 * static_cast<double>(std::clamp<std::int64_t>(now_ns - sampled_ns_, 0, command_.validity_ns));
}

core::Wrench ContactField::ContactsAt(const core::Pose& X_WD, double age_s) const noexcept {
  core::FixedVector<vps::HeldContact, core::kMaxFieldContacts> contacts;
  for (const core::FieldContact& c : command_.contacts) contacts.push_back(ContactOf(c, command_.X_WC, age_s));
  return vps::ContactWrench(tool_, metric_, command_.X_WC, X_WD, {contacts.begin(), contacts.size()});
}

core::Wrench ContactField::Capped(const core::Wrench& F) const noexcept {
  return command_.gain * core::LimitForce(F, command_.force_cap_N);
}

core::Wrench ContactField::Kept(std::int64_t now_ns) const noexcept {
  return std::exp(-1e-9 * static_cast<double>(now_ns - taken_ns_) / decay_s_) * kept_;
}

core::Wrench ContactField::Change(const core::Pose& X_WD, std::int64_t now_ns, core::Wrench* rest) const noexcept {
  if (!command_.has_field) return {};
  const core::Wrench& R = command_.F_rest_Do_W;
  const core::Wrench f = ContactsAt(X_WD, Age_s(now_ns));
  if (rest != nullptr) {
    const double force_N = glm::length(f.force_N + R.force_N);
    *rest = (command_.gain * (force_N > command_.force_cap_N ? command_.force_cap_N / force_N : 1.0)) * R;
  }
  return Capped(f + R) + -Capped(at_D0_ + R) + Kept(now_ns);
}

void ContactField::Take(const core::DeviceCommand& command, const core::Pose& X_WD, std::int64_t now_ns) noexcept {
  const bool continues = command_.has_field && command.has_field;
  const core::Wrench before = continues ? command_.F_Do_W + Change(X_WD, now_ns) : core::Wrench{};
  const core::Wrench R_before = command_.F_rest_Do_W;
  command_ = command;
  taken_ns_ = now_ns;
  kept_ = {};
  if (!command.has_field) return;
  sampled_ns_ = command.header.direct.valid() ? std::min(command.header.direct.origin_ns, now_ns) : now_ns;
  tool_.stiffness_N_per_m = command.stiffness_N_per_m;
  tool_.stiffness_Nm_per_rad = command.stiffness_Nm_per_rad;
  tool_.p_CoCm_C = command.p_CoCm_C;
  metric_ = vps::ToolMetric(tool_);
  at_D0_ = ContactsAt(command.X_WD, 0.0);
  decay_s_ = std::max(Age_s(now_ns), core::kTick_s);
  if (!continues) return;
  const core::Wrench f = ContactsAt(X_WD, Age_s(now_ns));
  const core::Wrench after = command.F_Do_W + Capped(f + command.F_rest_Do_W) + -Capped(at_D0_ + command.F_rest_Do_W);
  const core::Wrench by_rest = Capped(f + command.F_rest_Do_W) + -Capped(f + R_before);
  kept_ = before + by_rest + -after;
}

}  // namespace device_bridge
