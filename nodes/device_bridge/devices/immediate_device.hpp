#pragma once

#include <memory>

#include "core/result.hpp"
#include "nodes/device_bridge/device.hpp"
#include "nodes/device_bridge/devices/plugin_table.hpp"

namespace device_bridge {

// A device whose functions never wait (OOS_DEVICE_IS_IMMEDIATE), called by the bridge's own thread. Its base is W. So a
// simulated arm takes part in lock-step, in virtual time.
class ImmediateDevice final : public Device {
 public:
  static core::Result<std::unique_ptr<ImmediateDevice>> Create(PluginTable plugin, const scene::Device& device);
  ~ImmediateDevice() override;
  ImmediateDevice(const ImmediateDevice&) = delete;
  ImmediateDevice& operator=(const ImmediateDevice&) = delete;

  DeviceReading Read(std::int64_t now_ns) noexcept override;
  void Write(std::int64_t now_ns, const FilteredForce& force) noexcept override;
  void SetHand(const HandTarget& target) noexcept override;
  [[nodiscard]] FeltForce Felt() const noexcept override;
  [[nodiscard]] bool can_lead() const noexcept override {
    return (description_.flags & OOS_DEVICE_LEADS) != 0 && CanLead(plugin_);
  }
  void Lead(const LeadGoal* goal) noexcept override;
  [[nodiscard]] std::uint64_t num_found() const noexcept override { return 1; }
  [[nodiscard]] const oos_device_description& description() const noexcept override { return description_; }
  [[nodiscard]] const DeviceHealth& Health(std::int64_t /*now_ns*/) noexcept override { return health_; }
  [[nodiscard]] const oos_device_state& state() const noexcept override { return state_; }
  [[nodiscard]] bool is_robot() const noexcept override { return GivesJoints(plugin_); }
  bool Joints(oos_device_joints* joints) noexcept override;
  void SetMuted(bool is_muted) noexcept override { is_muted_ = is_muted; }

 private:
  explicit ImmediateDevice(PluginTable plugin) : plugin_(std::move(plugin)) {}
  void Step(std::int64_t now_ns, const oos_device_command* command, const oos_device_hand* hand) noexcept;

  PluginTable plugin_;
  void* device_ = nullptr;
  oos_device_description description_{};
  oos_device_state state_{};
  std::uint64_t num_commands_ = 0;
  std::int64_t last_ns_ = 0;
  bool is_muted_ = false;
  DeviceHealth health_;
};

}  // namespace device_bridge
