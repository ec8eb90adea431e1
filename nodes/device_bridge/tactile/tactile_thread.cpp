#include "nodes/device_bridge/tactile/tactile_thread.hpp"

#include <utility>

#include "bus/rt/thread_setup.hpp"
#include "core/clock.hpp"

namespace device_bridge {

TactileThread::TactileThread(const std::string& name, tactile::UsbTable table,
                             std::unique_ptr<tactile::UsbTransport> transport)
    : driver_(std::move(table), std::move(transport)), thread_([this, name] { Run(name); }) {}

TactileThread::~TactileThread() {
  stop_.store(true);
  thread_.join();
}

const tactile::DriverState& TactileThread::state() noexcept {
  state_.Update();
  return state_.value();
}

// Without priority: a person does not feel when a motor starts some milliseconds later, and nothing else waits for it.
void TactileThread::Run(const std::string& name) {
  bus::ThreadSetup setup;
  setup.name = "tac-" + name;
  setup.mode = bus::RealTimeMode::kOff;
  bus::SetUpThread(setup);
  while (!stop_.load(std::memory_order_relaxed)) {
    if (wanted_.Update()) driver_.Take(wanted_.value());
    driver_.Turn(core::MonotonicNow_ns());
    state_.Write(driver_.state());
    std::this_thread::sleep_for(std::chrono::nanoseconds(tactile::UsbDriver::kTurn_ns));
  }
  driver_.Stop();
}

}  // namespace device_bridge
