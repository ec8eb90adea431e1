#pragma once

#include <atomic>
#include <cstdint>
#include <string>
#include <thread>

#include "bus/rt/latest_value.hpp"
#include "tactile/usb_driver.hpp"

namespace device_bridge {

// A thread for a driver, whose calls wait for the device. Set and state are wait-free, for the real-time thread.
class TactileThread {
 public:
  TactileThread(const std::string& name, tactile::UsbTable table, std::unique_ptr<tactile::UsbTransport> transport);
  // Waits until the motors are off.
  ~TactileThread();
  TactileThread(const TactileThread&) = delete;
  TactileThread& operator=(const TactileThread&) = delete;

  void Set(const tactile::Strengths& strengths) noexcept { wanted_.Write(strengths); }
  [[nodiscard]] const tactile::DriverState& state() noexcept;

 private:
  void Run(const std::string& name);

  tactile::UsbDriver driver_;
  bus::LatestValue<tactile::Strengths> wanted_;
  bus::LatestValue<tactile::DriverState> state_;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

}  // namespace device_bridge
