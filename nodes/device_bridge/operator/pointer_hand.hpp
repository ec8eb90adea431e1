#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "nodes/device_bridge/device.hpp"
#include "nodes/device_bridge/ports.hpp"
#include "scene/scenario.hpp"

namespace device_bridge {

// A person without a device: the hands' targets follow what viewers send of mouse, keyboard or gamepad (HandInput). As
// the scripted operator's, a target acts on the simulated arm through the spring of its hand alone, so the person feels
// walls by the hand lagging behind, and cannot push harder than the spring allows.
class PointerHand {
 public:
  explicit PointerHand(const scene::Scenario& scenario);

  // One tick of dt_s. `readings`: where the hands are. Real-time: no allocation.
  void Step(const Inputs& inputs, const core::FixedVector<FeltForce, kMaxRoles>& felt,
            const core::FixedVector<DeviceReading, kMaxRoles>& readings, double dt_s) noexcept;
  // Whether the device leads the hand from now on. A hand that is led gives way: its target goes with the device, but
  // for what the person adds, and that relaxes.
  void SetLed(std::size_t role, bool is_led) noexcept { hands_[role].is_led = is_led; }
  // From now on the hand goes on from there.
  void TakeUp(std::size_t role, const HandTarget& target) noexcept;

  [[nodiscard]] const HandTarget& target(std::size_t role) const { return hands_[role].target; }
  // The viewer that steers asks for guidance.
  [[nodiscard]] bool wants_guidance() const { return wants_guidance_; }

 private:
  struct Hand {
    core::Pose X_WWanted;
    double opening_max_m = 0.0;
    double opening_wanted_m = 0.0;
    double longest_lead_m = 0.0;  // of the target before the hand
    bool is_led = false;
    core::Pose X_WD_before;  // of the device, at the latest tick
    HandTarget target;
  };
  struct Viewer {
    std::uint64_t sequence = 0;
    bool is_held = false;
    glm::dvec3 moved_W_m{0.0};
    glm::dvec3 turned_W_rad{0.0};
    double closing = 0.0;
    std::int64_t heard_ns = 0;
  };
  void Take(const core::HandInput& input, Viewer* viewer, std::int64_t now_ns) noexcept;
  static void GiveWay(const DeviceReading& reading, double dt_s, Hand* hand) noexcept;
  static void Follow(const DeviceReading& reading, bool is_off, double dt_s, Hand* hand) noexcept;

  std::vector<Hand> hands_;
  std::array<Viewer, kMaxViewers> viewers_;
  bool wants_guidance_ = false;
};

}  // namespace device_bridge
