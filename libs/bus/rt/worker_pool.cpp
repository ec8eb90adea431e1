#include "bus/rt/worker_pool.hpp"

#include <pthread.h>
#include <sched.h>

#include <algorithm>

namespace bus {
namespace {

constexpr int kSpinRounds = 2000;  // some microseconds: the gap between two jobs of one haptic cycle

inline void SpinOnce() {
#if defined(__x86_64__)
  __builtin_ia32_pause();
#endif
}

}  // namespace

WorkerPool::WorkerPool(unsigned num_workers, const std::string& name, int fifo_priority) {
  const unsigned extra = std::max(num_workers, 1U) - 1;
  threads_.reserve(extra);
  for (unsigned i = 0; i < extra; ++i) {
    threads_.emplace_back([this] { WorkerLoop(); });
    pthread_setname_np(threads_.back().native_handle(), (name.substr(0, 11) + "-" + std::to_string(i + 1)).c_str());
    if (fifo_priority > 0) {
      sched_param parameter{};
      parameter.sched_priority = fifo_priority;
      pthread_setschedparam(threads_.back().native_handle(), SCHED_FIFO, &parameter);
    }
  }
}

WorkerPool::~WorkerPool() {
  is_stopping_.store(true, std::memory_order_relaxed);
  epoch_.fetch_add(1, std::memory_order_release);
  epoch_.notify_all();
  for (std::thread& thread : threads_) thread.join();
}

void WorkerPool::Run(std::size_t count, Body body, void* context) {
  if (count == 0) return;
  if (threads_.empty() || count == 1) {
    for (std::size_t i = 0; i < count; ++i) body(context, i);
    return;
  }
  // The ticket is closed, so no worker can take an index while the job is written.
  body_.store(body, std::memory_order_release);
  context_.store(context, std::memory_order_release);
  count_.store(count, std::memory_order_release);
  finished_.store(0, std::memory_order_release);
  const std::uint32_t epoch = epoch_.load(std::memory_order_relaxed) + 1;
  ticket_.store(static_cast<std::uint64_t>(epoch) << 32, std::memory_order_release);
  epoch_.store(epoch, std::memory_order_release);
  epoch_.notify_all();

  while (TakeAndRun(epoch)) {
  }
  // Somebody still runs the last bodies; on a busy machine that thread may need this processor.
  for (int round = 0; finished_.load(std::memory_order_acquire) != count; ++round) {
    if (round < kSpinRounds) {
      SpinOnce();
    } else {
      sched_yield();
    }
  }
  ticket_.store((static_cast<std::uint64_t>(epoch) << 32) | kClosed, std::memory_order_release);
}

bool WorkerPool::TakeAndRun(std::uint32_t epoch) {
  std::uint64_t ticket = ticket_.load(std::memory_order_acquire);
  for (;;) {
    const std::uint64_t index = ticket & kClosed;
    if ((ticket >> 32) != epoch || index == kClosed) return false;
    // Acquire: had we read the next job's data here, we would see the closed ticket below and the swap would fail.
    const std::size_t count = count_.load(std::memory_order_acquire);
    const Body body = body_.load(std::memory_order_acquire);
    void* const context = context_.load(std::memory_order_acquire);
    if (index >= count) return false;
    if (ticket_.compare_exchange_weak(ticket, ticket + 1, std::memory_order_acq_rel, std::memory_order_acquire)) {
      body(context, static_cast<std::size_t>(index));
      finished_.fetch_add(1, std::memory_order_release);
      return true;
    }
  }
}

void WorkerPool::WorkerLoop() {
  std::uint32_t seen = 0;
  for (;;) {
    std::uint32_t epoch = epoch_.load(std::memory_order_acquire);
    for (int round = 0; epoch == seen && round < kSpinRounds; ++round) {
      SpinOnce();
      epoch = epoch_.load(std::memory_order_acquire);
    }
    if (epoch == seen) {
      epoch_.wait(seen, std::memory_order_acquire);
      continue;
    }
    seen = epoch;
    if (is_stopping_.load(std::memory_order_relaxed)) return;
    while (TakeAndRun(epoch)) {
    }
  }
}

}  // namespace bus
