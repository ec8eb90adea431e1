#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <random>

#include "nodes/device_bridge/devices/immediate_device.hpp"
#include "nodes/device_bridge/safety_filter.hpp"

namespace device_bridge {

// For tests: a device that only writes down what it is commanded.
struct RecordingDevice {
  oos_device_command newest{};
  oos_device_state state{};

  static const oos_device_plugin& Table() {
    static const oos_device_plugin table{
        OOS_DEVICE_ABI_VERSION, sizeof table, Open, Describe, Step, Close, nullptr, nullptr, nullptr};
    return table;
  }
  static RecordingDevice& Instance() {
    static RecordingDevice device;
    return device;
  }

 private:
  static int Open(const oos_device_setting* /*setting*/, void** device) {
    *device = &Instance();
    return OOS_DEVICE_OK;
  }
  static int Describe(void* /*device*/, oos_device_description* description) {
    description->flags = OOS_DEVICE_IS_IMMEDIATE;
    return OOS_DEVICE_OK;
  }
  static int Step(void* device, std::int64_t /*now_ns*/, const oos_device_command* command,
                  const oos_device_hand* /*hand*/, oos_device_state* state) {
    auto& self = *static_cast<RecordingDevice*>(device);
    if (command != nullptr) self.newest = *command;
    *state = self.state;
    return OOS_DEVICE_OK;
  }
  static void Close(void* /*device*/) {}
};

// Counts the commands, of `count` hostile ones, after which a device was given a force above a limit: any bit patterns,
// NaN, 1e300, sequences that repeat and go back, times that reverse, floods between two samples, a device that is let
// go, moves at any speed, or says that it is nowhere.
inline std::uint64_t CountViolations(std::uint64_t count, std::uint64_t seed, std::uint64_t* num_acting) {
  std::mt19937_64 random(seed);
  const auto any_double = [&random] {
    const std::uint64_t bits = random();
    if (bits % 4 == 0) {
      const std::uint64_t pattern = random();
      double value = 0.0;
      std::memcpy(&value, &pattern, sizeof value);
      return value;
    }
    if (bits % 4 == 1) return bits % 8 < 4 ? 1e300 : -1e300;
    return (static_cast<double>(random() % 2001) - 1000.0) * 0.1;
  };
  scene::Device figures;
  figures.role = "right";
  auto made = ImmediateDevice::Create({nullptr, &RecordingDevice::Table()}, figures);
  if (!made) {
    ADD_FAILURE() << made.error().detail;
    return 1;
  }
  Device& device = **made;
  RecordingDevice& recorded = RecordingDevice::Instance();
  std::uint64_t num_violations = 0;
  std::uint64_t sent = 0;
  std::int64_t now_ns = 1'000'000'000;
  *num_acting = 0;
  while (sent < count) {
    FilterLimits limits;
    limits.max_force_N = 1.0 + static_cast<double>(random() % 100);
    limits.max_torque_Nm = 0.1 * limits.max_force_N;
    limits.start_ramp_ns = limits.restart_ramp_ns = 1'000'000;
    SafetyFilter filter = *SafetyFilter::Create(limits);
    const bool is_finite = random() % 2 == 0;  // otherwise a fault soon ends the stream
    std::uint64_t sequence = 0;
    for (int tick = 0; tick < 200; ++tick) {
      now_ns += 1'000'000;
      const std::uint64_t flood = random() % 16 == 0 ? 50 : random() % 4;
      for (std::uint64_t i = 0; i < flood; ++i) {
        core::DeviceCommand command;
        command.header.sequence = random() % 8 == 0 ? random() : ++sequence;
        if (random() % 16 == 0) command.header.direct = {random(), static_cast<std::int64_t>(random()), {}};
        for (int axis = 0; axis < 3; ++axis) {
          command.F_Do_W.force_N[axis] = any_double();
          command.F_Do_W.torque_Nm[axis] = any_double();
          if (is_finite && !std::isfinite(command.F_Do_W.force_N[axis])) command.F_Do_W.force_N[axis] = 1e300;
          if (is_finite && !std::isfinite(command.F_Do_W.torque_Nm[axis])) command.F_Do_W.torque_Nm[axis] = -1e300;
        }
        command.grip_force_N = is_finite ? 1e300 : any_double();
        if (random() % 8 == 0) command.validity_ns = static_cast<std::int64_t>(random());
        const std::int64_t received_ns = random() % 8 == 0 ? static_cast<std::int64_t>(random()) : now_ns;
        filter.Accept(command, received_ns);
        ++sent;
      }
      recorded.state.flags = random() % 32 == 0 ? 0 : OOS_DEVICE_IS_ENGAGED;
      recorded.state.X_BD[0] = 1.0;
      recorded.state.V_BD[3] = !is_finite && random() % 64 == 0 ? any_double() : 0.2;
      const std::int64_t at_ns =
          random() % 32 == 0 ? now_ns - static_cast<std::int64_t>(random() % 1'000'000'000) : now_ns;
      const DeviceReading reading = device.Read(at_ns);
      device.Write(at_ns, filter.Apply(at_ns, reading, {{any_double(), 0, 0}, {0, 0, any_double()}}));
      const double* F = recorded.newest.F_Do_B;
      const double force_N = std::sqrt(F[0] * F[0] + F[1] * F[1] + F[2] * F[2]);
      const double torque_Nm = std::sqrt(F[3] * F[3] + F[4] * F[4] + F[5] * F[5]);
      // Each comparison is false for NaN, too.
      const bool is_within = force_N <= limits.max_force_N && torque_Nm <= limits.max_torque_Nm &&
                             std::abs(recorded.newest.grip_force_N) <= limits.max_grip_force_N &&
                             recorded.newest.brake_N_s_per_m >= 0.0 &&
                             recorded.newest.brake_N_s_per_m <= limits.brake_N_s_per_m;
      num_violations += is_within ? 0 : 1;
      *num_acting += force_N > 0.0 ? 1 : 0;
    }
  }
  return num_violations;
}

}  // namespace device_bridge
