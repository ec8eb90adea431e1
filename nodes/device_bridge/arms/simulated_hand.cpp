#include "nodes/device_bridge/arms/simulated_hand.hpp"

#include <algorithm>
#include <string>
#include <string_view>

#include "core/clock.hpp"
#include "device/say_why.hpp"
#include "nodes/device_bridge/arms/arm_plugin.hpp"
#include "nodes/device_bridge/devices/plugin_values.hpp"
#include "nodes/device_bridge/random.hpp"
#include "tracking/finger_angles.hpp"
#include "tracking/pseudo_grip.hpp"

namespace device_bridge {
namespace {

constexpr std::int64_t kFrame_ns = 16'666'667;  // of cameras
constexpr double kTrackerNoise_m = 1e-4;        // root mean square [devices.md, section 2.1]
constexpr std::uint64_t kTrackerSeed = 60;

enum class GripMethod { kStick, kDistance, kPinch, kFingers };
struct NamedMethod {
  const char* name;
  GripMethod method;
};
constexpr NamedMethod kMethods[] = {{"stick", GripMethod::kStick},
                                    {"distance", GripMethod::kDistance},
                                    {"pinch", GripMethod::kPinch},
                                    {"fingers", GripMethod::kFingers}};

class SimulatedHand {
 public:
  SimulatedHand(GripMethod method, const scene::Device& device)
      : method_(method), max_m_(device.opening_max_m), jaws_(device.opening_max_m, device.opening_start_m) {
    finger_rad_ = tracking::GraspAngles(device.opening_start_m);
    ToArray(device.X_WD_start, hand_.X_BT);
    hand_.opening_m = device.opening_start_m;
    hand_.holds_dead_man = 1;
  }

  void SetHand(const oos_device_hand& hand) { hand_ = hand; }
  void Feel(double reaction_N) { reaction_N_ = reaction_N; }

  void Step(std::int64_t now_ns) {
    if (now_ns >= next_frame_ns_) LookAtHand(now_ns);
    const double dt_s = std::clamp(1e-9 * static_cast<double>(now_ns - moved_ns_), 0.0, core::kTick_s);
    moved_ns_ = now_ns;
    const double before_m = jaws_.opening_m();
    jaws_.Step(wish_, reaction_N_, dt_s);
    if (dt_s > 0.0) opening_velocity_m_per_s_ = (jaws_.opening_m() - before_m) / dt_s;
  }

  void Fill(std::int64_t now_ns, oos_device_state* state) {
    state->flags = seen_.holds_dead_man != 0 ? OOS_DEVICE_IS_ENGAGED : 0;
    state->sequence = ++num_samples_;
    state->device_time_ns = now_ns;
    std::copy(std::begin(seen_.X_BT), std::end(seen_.X_BT), state->X_BD);
    std::copy(std::begin(seen_.V_BT), std::end(seen_.V_BT), state->V_BD);
    state->opening_m = jaws_.opening_m();
    state->opening_velocity_m_per_s = opening_velocity_m_per_s_;
    state->finger_force_N = jaws_.is_on_something() ? -wish_.force_N : 0.0;
    if (method_ != GripMethod::kFingers) return;
    state->num_finger_joints = OOS_DEVICE_FINGER_JOINTS;
    std::copy(finger_rad_.begin(), finger_rad_.end(), state->finger_rad);
  }

 private:
  void LookAtHand(std::int64_t now_ns) {
    next_frame_ns_ = std::max(next_frame_ns_ + kFrame_ns, now_ns);  // of the cameras' own clock
    seen_ = hand_;
    const glm::dvec3 noise_m = random_.GaussianVector(kTrackerNoise_m);
    for (int i = 0; i < 3; ++i) seen_.X_BT[4 + i] += noise_m[i];
    wish_ = Wish();
    finger_rad_ = tracking::GraspAngles(seen_.opening_m);
  }

  // What the person does with fingers or stick, and what comes of it.
  [[nodiscard]] tracking::GripWish Wish() const {
    using tracking::kGripStiffness_N_per_m, tracking::kMaxGrip_N;
    const double wanted_m = std::clamp(hand_.opening_m, 0.0, max_m_);
    const bool presses = jaws_.is_on_something() && wanted_m < jaws_.opening_m();
    const double strength_N = presses ? hand_.grip_strength_N : 0.0;
    switch (method_) {
      case GripMethod::kStick:
        return tracking::WishOfStick(presses ? -strength_N / kMaxGrip_N : wanted_m / max_m_, max_m_, kMaxGrip_N);
      case GripMethod::kDistance: {
        const double fingers_m =
            presses ? std::max(wanted_m, jaws_.opening_m() - strength_N / kGripStiffness_N_per_m) : wanted_m;
        return tracking::WishOfDistance(fingers_m, jaws_.opening_m(), max_m_, kGripStiffness_N_per_m, kMaxGrip_N);
      }
      case GripMethod::kFingers:  // there are no jaws: what is told of them is what the fingers do
        return {wanted_m, 0.0};
      case GripMethod::kPinch:
        break;
    }
    return tracking::WishOfPinch(strength_N / kMaxGrip_N, wanted_m, max_m_, kMaxGrip_N);
  }

  GripMethod method_;
  double max_m_;
  tracking::PseudoJaws jaws_;
  oos_device_hand hand_{};  // of the person
  oos_device_hand seen_{};  // by the cameras
  tracking::FingerAngles finger_rad_{};
  tracking::GripWish wish_;
  Random random_{kTrackerSeed};
  double reaction_N_ = 0.0;
  double opening_velocity_m_per_s_ = 0.0;
  std::int64_t next_frame_ns_ = 0;
  std::int64_t moved_ns_ = 0;
  std::uint64_t num_samples_ = 0;
};

int OpenHand(const oos_device_setting* setting, void** device) {
  std::string_view wanted = kMethods[0].name;
  for (std::uint32_t i = 0; i < setting->num_options; ++i) {
    if (std::string_view(setting->options[i].name) == "grip") wanted = setting->options[i].value;
  }
  for (const NamedMethod& known : kMethods) {
    if (wanted != known.name) continue;
    *device = new SimulatedHand(known.method, ArmFiguresOf(*setting));
    return OOS_DEVICE_OK;
  }
  device::SayWhy(*setting, "option grip: '" + std::string(wanted) + "' is not stick, distance, pinch or fingers");
  return OOS_DEVICE_BAD_SETTING;
}

int DescribeHand(void* /*device*/, oos_device_description* d) {
  d->flags = OOS_DEVICE_IS_SIMULATED | OOS_DEVICE_TAKES_HAND | OOS_DEVICE_IS_IMMEDIATE | OOS_DEVICE_TELLS_VELOCITY;
  constexpr std::string_view kName = "simulated hand before a tracker";
  kName.copy(d->name, sizeof d->name - 1);
  d->sensed = OOS_DEVICE_TRANSLATION | OOS_DEVICE_ROTATION | OOS_DEVICE_GRIP;
  d->rate_hz = 1000.0;
  return OOS_DEVICE_OK;
}

int StepHand(void* device, std::int64_t now_ns, const oos_device_command* command, const oos_device_hand* hand,
             oos_device_state* state) {
  auto& self = *static_cast<SimulatedHand*>(device);
  if (command != nullptr) self.Feel(command->grip_force_N);
  if (hand != nullptr) self.SetHand(*hand);
  self.Step(now_ns);
  self.Fill(now_ns, state);
  return OOS_DEVICE_OK;
}

void CloseHand(void* device) {
  delete static_cast<SimulatedHand*>(device);
}

}  // namespace

const oos_device_plugin& SimulatedHandPlugin() {
  static const oos_device_plugin plugin{
      OOS_DEVICE_ABI_VERSION, sizeof plugin, OpenHand, DescribeHand, StepHand, CloseHand, nullptr, nullptr, nullptr};
  return plugin;
}

}  // namespace device_bridge
