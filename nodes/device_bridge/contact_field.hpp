#pragma once

#include <cstdint>

#include "core/messages/device.hpp"
#include "vps/coupling/god_object.hpp"

namespace device_bridge {

// The local contact field: between two commands the force of a hand follows its device. A command has the force F0 for
// the device's pose D0, and the contacts of the tool there. At pose D and time t
//   F = F0 + g (cap(f(D, t) + R) - cap(f(D0, 0) + R)),
// where f is the projection that haptic_node makes (vps::ContactWrench) under these contacts, whose bodies go on with
// their velocities, and R what else F0 has in it before it was capped and scaled by g: grasp and mechanisms. So the
// force is F0 where F0 was computed, and nothing is counted twice.
//
// The delay of the round trip is then in what the contacts do not know, not in the stiffness: a wall is as stiff as the
// device's own loop allows.
//
// A command that arrives does not step the coupling's force: what it has at that time, less what the new contacts say,
// is kept and decays in the time that the new command was under way. The error has come in that time, so the force is
// corrected about as fast as it would have changed without delay. A change of R acts at once.
//
// Real-time safe.
class ContactField {
 public:
  // A command was accepted: it acts from now_ns on, with the device at X_WD.
  void Take(const core::DeviceCommand& command, const core::Pose& X_WD, std::int64_t now_ns) noexcept;
  // What comes to the command's force F_Do_W with the device at X_WD; zero without a field. `rest`: what of the sum is
  // not the coupling's.
  [[nodiscard]] core::Wrench Change(const core::Pose& X_WD, std::int64_t now_ns,
                                    core::Wrench* rest = nullptr) const noexcept;
  // The force has faded out: the next command has nothing to continue.
  void Forget() noexcept { command_.has_field = false; }

  [[nodiscard]] bool is_active() const { return command_.has_field; }
  [[nodiscard]] const core::Wrench& F_Do_W() const { return command_.F_Do_W; }  // of the newest command
  // Where the coupling acts, of the newest command; zero with the paper's (Eq. 6).
  [[nodiscard]] const glm::dvec3& p_CoCm_C() const { return command_.p_CoCm_C; }

 private:
  [[nodiscard]] core::Wrench ContactsAt(const core::Pose& X_WD, double age_s) const noexcept;
  [[nodiscard]] core::Wrench Capped(const core::Wrench& F) const noexcept;
  [[nodiscard]] double Age_s(std::int64_t now_ns) const noexcept;
  [[nodiscard]] core::Wrench Kept(std::int64_t now_ns) const noexcept;

  core::DeviceCommand command_;
  vps::GodObjectParameters tool_;
  vps::ToolMetric metric_{vps::GodObjectParameters{}};
  std::int64_t sampled_ns_ = 0;  // the device, for which the command was computed
  std::int64_t taken_ns_ = 0;
  core::Wrench at_D0_;  // f(D0, 0)
  core::Wrench kept_;   // at taken_ns_
  double decay_s_ = 1e-3;
};

}  // namespace device_bridge
