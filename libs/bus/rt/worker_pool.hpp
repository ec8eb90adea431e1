#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <string>
#include <thread>
#include <vector>

#include "core/parallel_for.hpp"

namespace bus {

// A fixed pool of threads behind core::ParallelFor. The caller works too, so `num_workers` counts it: 1 means no other
// thread at all. Idle workers spin for a few microseconds, then sleep on a futex. Bodies write only to their own slot,
// so results do not depend on the number of workers or on who takes which index.
class WorkerPool final : public core::ParallelFor {
 public:
  // `fifo_priority` 0: scheduled as the creating thread; otherwise SCHED_FIFO is tried, without error if not allowed.
  explicit WorkerPool(unsigned num_workers, const std::string& name = "work", int fifo_priority = 0);
  ~WorkerPool() override;
  WorkerPool(const WorkerPool&) = delete;
  WorkerPool& operator=(const WorkerPool&) = delete;

  // One caller at a time; returns when every body has run. No allocation, no lock. count < 2^32 - 1.
  void Run(std::size_t count, Body body, void* context) override;
  [[nodiscard]] unsigned num_workers() const { return static_cast<unsigned>(threads_.size()) + 1; }

 private:
  static constexpr std::uint64_t kClosed = 0xffffffffULL;  // index part of a ticket that hands out no index

  void WorkerLoop();
  bool TakeAndRun(std::uint32_t epoch);

  // Ticket = epoch in the upper half, next index in the lower: taking an index and checking that it belongs to the
  // job one has read is a single compare-and-swap, so a worker that wakes late cannot touch the next job by mistake.
  alignas(64) std::atomic<std::uint64_t> ticket_{kClosed};
  alignas(64) std::atomic<std::size_t> finished_{0};
  alignas(64) std::atomic<std::uint32_t> epoch_{0};  // workers sleep on this
  std::atomic<Body> body_{nullptr};
  std::atomic<void*> context_{nullptr};
  std::atomic<std::size_t> count_{0};
  std::atomic<bool> is_stopping_{false};
  std::vector<std::thread> threads_;
};

}  // namespace bus
