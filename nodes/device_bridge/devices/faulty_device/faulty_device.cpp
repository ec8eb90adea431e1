#include <unistd.h>

#include <cmath>
#include <cstring>
#include <map>
#include <stdexcept>
#include <string>

#include "device/plugin.h"

#ifndef ABI_VERSION
#define ABI_VERSION OOS_DEVICE_ABI_VERSION
#endif

namespace {

constexpr std::int64_t kGood_ns = 200'000'000;  // it works before its fault

struct Faulty {
  std::string fault;
  std::int64_t begin_ns = 0;
  std::uint64_t sample = 0;
  double F[6] = {};    // force [N], torque [Nm], as commanded
  double led_m = 0.0;  // along x
  double lead_N = 0.0;
};

// A library stays loaded while a thread hangs in it, so each fault has a count of its own.
int& NumOpened(const std::string& fault) {
  static std::map<std::string, int> counts;
  return counts[fault];
}

std::string OptionOf(const oos_device_setting& setting, const char* name) {
  for (std::uint32_t i = 0; i < setting.num_options; ++i) {
    if (std::strcmp(setting.options[i].name, name) == 0) return setting.options[i].value;
  }
  return "";
}

bool IsToLead(const std::string& fault) {
  return fault.find("lead") != std::string::npos;
}

// After a while, twice: "unplugged", with whatever follows.
bool IsUnplugged(const std::string& fault) {
  return fault.rfind("unplugged", 0) == 0;
}

[[noreturn]] void Hang() {
  while (true) pause();
}

int Open(const oos_device_setting* setting, void** device) {
  const std::string fault = OptionOf(*setting, "fault");
  if (fault == "hang in open") Hang();
  if (fault == "throw in open") throw std::runtime_error("open failed");
  if (fault == "bad setting") {
    std::strncpy(setting->why, "no such port; choose another", setting->why_size - 1);
    return OOS_DEVICE_BAD_SETTING;
  }
  if (++NumOpened(fault) < 3 && fault == "absent at first") return OOS_DEVICE_GONE;
  *device = new Faulty{fault};
  return OOS_DEVICE_OK;
}

int Describe(void* device, oos_device_description* description) {
  const auto& self = *static_cast<const Faulty*>(device);
  std::strcpy(description->name, "faulty");
  std::strcpy(description->serial, IsUnplugged(self.fault) ? std::to_string(NumOpened(self.fault)).c_str() : "1");
  description->flags = OOS_DEVICE_TELLS_APPLIED;
  if (IsToLead(self.fault)) description->flags |= OOS_DEVICE_LEADS;
  description->actuated = description->sensed = OOS_DEVICE_TRANSLATION;
  description->max_force_N = 3.0;
  return OOS_DEVICE_OK;
}

int Step(void* device, std::int64_t now_ns, const oos_device_command* command, const oos_device_hand* /*hand*/,
         oos_device_state* state) {
  auto& self = *static_cast<Faulty*>(device);
  if (self.begin_ns == 0) self.begin_ns = now_ns;
  const bool is_time = now_ns - self.begin_ns > kGood_ns;
  if (command != nullptr) std::memcpy(self.F, command->F_Do_B, sizeof self.F);
  state->flags = OOS_DEVICE_IS_ENGAGED;
  state->sequence = ++self.sample;
  state->X_BD[0] = 1.0;
  // Moves along x with 0.1 m/s, or where it leads, and gives no velocity.
  state->X_BD[4] = IsToLead(self.fault) ? self.led_m : 0.1 * 1e-9 * static_cast<double>(now_ns - self.begin_ns);
  std::memcpy(state->applied, self.F, sizeof self.F);
  state->applied[0] += self.lead_N;
  if (!is_time) return OOS_DEVICE_OK;
  if (self.fault == "hang") Hang();
  if (self.fault == "hang for a while" && now_ns - self.begin_ns < 2 * kGood_ns) usleep(300'000);
  if (self.fault == "throw") throw std::runtime_error("the bus fell off");
  if (self.fault == "throw an int") throw 7;
  if (self.fault == "nan") state->V_BD[0] = state->X_BD[5] = std::nan("");
  if (self.fault == "no unit") state->X_BD[0] = 2.0;
  if (IsUnplugged(self.fault) && NumOpened(self.fault) < 3) return OOS_DEVICE_GONE;
  return OOS_DEVICE_OK;
}

// One joint, 0.4 m above the base.
int Joints(void* device, oos_device_joints* joints) {
  const auto& self = *static_cast<const Faulty*>(device);
  if (self.fault == "throw in joints") throw std::runtime_error("no joints today");
  joints->num_joints = 1;
  joints->joints[0].X_BL[0] = 1.0;
  joints->joints[0].X_BL[6] = 0.4;
  joints->joints[0].position_rad = self.fault == "nan in joints" ? std::nan("") : 0.5;
  return OOS_DEVICE_OK;
}

int Lead(void* device, const oos_device_goal* goal) {
  auto& self = *static_cast<Faulty*>(device);
  if (self.fault == "throw in lead") throw std::runtime_error("no way");
  if (self.fault == "leads nowhere") return OOS_DEVICE_OK;
  if (goal == nullptr && self.fault == "leads forever") return OOS_DEVICE_OK;
  self.lead_N = goal == nullptr ? 0.0 : self.fault == "leads too hard" ? 1.5 * goal->max_force_N : 0.5;
  if (goal != nullptr) self.led_m += 0.01 * (goal->X_BG[4] - self.led_m);
  return OOS_DEVICE_OK;
}

void Close(void* device) {
  delete static_cast<Faulty*>(device);
}

}  // namespace

extern "C" const oos_device_plugin* oos_device_plugin_get() {
  static const oos_device_plugin plugin{ABI_VERSION, sizeof plugin, Open, Describe, Step, Close, nullptr, Joints, Lead};
  return &plugin;
}
