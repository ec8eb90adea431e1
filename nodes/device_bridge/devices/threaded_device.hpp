#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "bus/rt/thread_setup.hpp"
#include "core/result.hpp"
#include "nodes/device_bridge/device.hpp"
#include "nodes/device_bridge/devices/frame_map.hpp"
#include "nodes/device_bridge/devices/plugin_table.hpp"

namespace device_bridge {

struct DeviceCalibration {
  core::Pose X_WB;
  double residual_m = 0.0;
};
// Of a specimen, by the name and serial number that it gives; none if it was never calibrated.
using FindCalibration =
    std::function<std::optional<DeviceCalibration>(const std::string& name, const std::string& serial)>;

struct ThreadedOptions {
  bus::RealTimeMode rt = bus::RealTimeMode::kOff;
  int fifo_priority = 84;  // below the bridge's own thread, which must never wait for a device
  FindCalibration find_calibration;
  // False: without a thread. Each Read then does one turn of its work, in the time of Read's caller, for devices that
  // never wait: a device of another process in virtual time.
  bool has_thread = true;
};

// A device whose functions are called by a thread of its own, so that whatever they do, the bridge goes on. The thread
// opens the device, opens it again four times a second while it is not there, and gives it the newest force; a force
// older than 60 ms becomes none. A device that is not alive counts as let go: the filter then takes the force away.
class ThreadedDevice final : public Device {
 public:
  // Waits until the first try to open the device has ended, a second at most. Error: the setting is bad.
  static core::Result<std::unique_ptr<ThreadedDevice>> Create(PluginTable plugin, const scene::Device& device,
                                                              const ThreadedOptions& options);
  // Ends the thread. One that hangs in its plug-in is left behind.
  ~ThreadedDevice() override;
  ThreadedDevice(const ThreadedDevice&) = delete;
  ThreadedDevice& operator=(const ThreadedDevice&) = delete;

  DeviceReading Read(std::int64_t now_ns) noexcept override;
  void Write(std::int64_t now_ns, const FilteredForce& force) noexcept override;
  // Without the hand's own force, which nobody measures.
  [[nodiscard]] FeltForce Felt() const noexcept override;
  [[nodiscard]] bool can_lead() const noexcept override;
  void Lead(const LeadGoal* goal) noexcept override;
  [[nodiscard]] std::uint64_t num_found() const noexcept override { return num_found_; }
  [[nodiscard]] const oos_device_description& description() const noexcept override { return description_; }
  [[nodiscard]] const DeviceHealth& Health(std::int64_t now_ns) noexcept override;

  [[nodiscard]] const oos_device_state& state() const noexcept override { return state_; }
  [[nodiscard]] bool is_robot() const noexcept override;
  bool Joints(oos_device_joints* joints) noexcept override;
  [[nodiscard]] core::Pose X_WB() const noexcept override { return map_.X_WB(); }
  void SetMuted(bool is_muted) noexcept override;

 private:
  class Thread;
  ThreadedDevice(std::shared_ptr<Thread> thread, const core::Pose& X_WD_start)
      : thread_(std::move(thread)), map_(X_WD_start) {}
  void TakeNews(std::int64_t now_ns) noexcept;

  std::shared_ptr<Thread> thread_;
  FrameMap map_;
  oos_device_description description_{};
  oos_device_state state_{};
  std::int64_t read_ns_ = 0;    // of the latest Read
  std::int64_t sample_ns_ = 0;  // arrival of the newest sample; 0: none
  std::uint64_t num_found_ = 0;
  std::uint64_t num_written_ = 0;
  bool is_taken_up_ = false;
  DeviceHealth health_;
};

}  // namespace device_bridge
