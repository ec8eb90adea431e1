#include "nodes/device_bridge/devices/replay_plugin.hpp"

#include <algorithm>
#include <cstring>
#include <string>
#include <vector>

#include "bus/log/mcap_reader.hpp"
#include "bus/log/recorded_message.hpp"
#include "bus/topics.hpp"
#include "core/messages/device.hpp"
#include "device/say_why.hpp"
#include "nodes/device_bridge/devices/plugin_values.hpp"

namespace device_bridge {
namespace {

struct ReplayDevice {
  std::vector<core::DeviceState> states;  // by their times
  std::int64_t begin_ns = 0;              // of the replay; 0: not begun
};

int OpenReplay(const oos_device_setting* setting, void** device) {
  std::string file = setting->address;
  std::string role = setting->role;
  if (const std::size_t colon = file.rfind(':'); colon != std::string::npos) {
    role = file.substr(colon + 1);
    file.resize(colon);
  }
  const std::string topic = bus::DeviceStateTopic(role);
  auto replay = std::make_unique<ReplayDevice>();
  bus::log::RecordedMessage<core::DeviceState> assembly;
  const auto read = bus::log::ReadMcap(file, [&](const bus::log::Channel& channel, const bus::log::Message& message) {
    if (channel.topic != topic) return;
    if (const auto* state = assembly.Take(bus::log::SplitRecorded(message.data))) replay->states.push_back(*state);
  });
  if (!read) {
    device::SayWhy(*setting, read.error().detail);
    return OOS_DEVICE_BAD_SETTING;
  }
  if (replay->states.empty()) {
    device::SayWhy(*setting, file + ": has no message of " + topic + "; name the recorded role after a colon");
    return OOS_DEVICE_BAD_SETTING;
  }
  std::stable_sort(replay->states.begin(), replay->states.end(),
                   [](const auto& a, const auto& b) { return a.sample_ns < b.sample_ns; });
  *device = replay.release();
  return OOS_DEVICE_OK;
}

int DescribeReplay(void* /*device*/, oos_device_description* description) {
  std::strncpy(description->name, "recording", sizeof description->name - 1);
  description->flags = OOS_DEVICE_IS_SIMULATED | OOS_DEVICE_TELLS_VELOCITY;
  description->sensed = OOS_DEVICE_TRANSLATION | OOS_DEVICE_ROTATION | OOS_DEVICE_GRIP;
  description->rate_hz = 1000.0;
  return OOS_DEVICE_OK;
}

int StepReplay(void* device, std::int64_t now_ns, const oos_device_command* /*command*/,
               const oos_device_hand* /*hand*/, oos_device_state* state) {
  auto& replay = *static_cast<ReplayDevice*>(device);
  if (replay.begin_ns == 0) replay.begin_ns = now_ns;
  const std::int64_t at_ns = replay.states.front().sample_ns + now_ns - replay.begin_ns;
  const auto next = std::upper_bound(replay.states.begin(), replay.states.end(), at_ns,
                                     [](std::int64_t time_ns, const auto& s) { return time_ns < s.sample_ns; });
  const core::DeviceState& now = next == replay.states.begin() ? *next : *(next - 1);
  const bool is_over = next == replay.states.end();
  state->flags = now.is_engaged && !is_over ? OOS_DEVICE_IS_ENGAGED : 0;
  // After its end the last sample comes again and again.
  state->sequence = is_over ? replay.states.size() + static_cast<std::uint64_t>(at_ns / 1'000'000)
                            : static_cast<std::uint64_t>(next - replay.states.begin());
  state->device_time_ns = now.sample_ns;
  ToArray(now.X_WD, state->X_BD);
  if (!is_over) ToArray(now.V_WD, state->V_BD);
  state->opening_m = now.opening_m;
  state->opening_velocity_m_per_s = is_over ? 0.0 : now.opening_velocity_m_per_s;
  state->num_finger_joints = 0;
  if (now.finger_rad.size() == OOS_DEVICE_FINGER_JOINTS) {
    state->num_finger_joints = OOS_DEVICE_FINGER_JOINTS;
    std::copy(now.finger_rad.begin(), now.finger_rad.end(), state->finger_rad);
  }
  return OOS_DEVICE_OK;
}

void CloseReplay(void* device) {
  delete static_cast<ReplayDevice*>(device);
}

}  // namespace

const oos_device_plugin& ReplayPlugin() {
  static const oos_device_plugin plugin{OOS_DEVICE_ABI_VERSION,
                                        sizeof plugin,
                                        OpenReplay,
                                        DescribeReplay,
                                        StepReplay,
                                        CloseReplay,
                                        nullptr,
                                        nullptr,
                                        nullptr};
  return plugin;
}

}  // namespace device_bridge
