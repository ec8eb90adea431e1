#pragma once

#include <atomic>
#include <semaphore>
#include <thread>

#include "bus/rt/thread_setup.hpp"
#include "nodes/physics_node/sheet_keeper.hpp"

namespace physics_node {

// Steps sheets on a thread of its own, with a lower priority than the world's, so that ticks do not wait for it.
class SheetThread final : public SheetRunner {
 public:
  explicit SheetThread(bus::RealTimeMode mode, int fifo_priority);
  ~SheetThread() override;
  SheetThread(const SheetThread&) = delete;
  SheetThread& operator=(const SheetThread&) = delete;

  void Start(void (*step)(void*), void* context) override;
  [[nodiscard]] bool IsIdle() const override { return !is_busy_.load(std::memory_order_acquire); }
  void WaitUntilIdle() override;

 private:
  void Run(const bus::ThreadSetup& setup);

  void (*step_)(void*) = nullptr;
  void* context_ = nullptr;
  std::atomic<bool> is_busy_{false};
  std::atomic<bool> is_stopping_{false};
  std::binary_semaphore wake_{0};
  std::thread thread_;
};

}  // namespace physics_node
