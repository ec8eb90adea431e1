#pragma once

#include <atomic>
#include <chrono>
#include <memory>
#include <string>
#include <thread>
#include <utility>

#include "bus/rt/latest_value.hpp"
#include "bus/rt/thread_setup.hpp"
#include "core/clock.hpp"

namespace device_bridge {

// A thread for a driver, whose calls may wait for its device. Set and state are wait-free, for the real-time thread. A
// Driver has Take(Input), Turn(now_ns) every kTurn_ns, Stop() and state().
template <class Driver>
class TactileThread {
 public:
  TactileThread(const std::string& name, std::unique_ptr<Driver> driver)
      : driver_(std::move(driver)), thread_([this, name] { Run(name); }) {}
  // Waits until the device is off.
  ~TactileThread() {
    stop_.store(true);
    thread_.join();
  }
  TactileThread(const TactileThread&) = delete;
  TactileThread& operator=(const TactileThread&) = delete;

  void Set(const typename Driver::Input& input) noexcept { wanted_.Write(input); }
  [[nodiscard]] const typename Driver::State& state() noexcept {
    state_.Update();
    return state_.value();
  }

 private:
  // Without priority: a person does not feel when a motor starts some milliseconds later, and nothing else waits for
  // it.
  void Run(const std::string& name) {
    bus::ThreadSetup setup;
    setup.name = "tac-" + name;
    setup.mode = bus::RealTimeMode::kOff;
    bus::SetUpThread(setup);
    while (!stop_.load(std::memory_order_relaxed)) {
      if (wanted_.Update()) driver_->Take(wanted_.value());
      driver_->Turn(core::MonotonicNow_ns());
      state_.Write(driver_->state());
      std::this_thread::sleep_for(std::chrono::nanoseconds(Driver::kTurn_ns));
    }
    driver_->Stop();
  }

  std::unique_ptr<Driver> driver_;
  bus::LatestValue<typename Driver::Input> wanted_;
  bus::LatestValue<typename Driver::State> state_;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

}  // namespace device_bridge
