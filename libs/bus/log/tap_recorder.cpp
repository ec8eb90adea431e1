#include "bus/log/tap_recorder.hpp"

#include <pthread.h>
#include <sched.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <unistd.h>

#include <chrono>
#include <csignal>

#include "core/clock.hpp"

namespace bus::log {

core::Result<std::unique_ptr<TapRecorder>> TapRecorder::Create(TapFile file, std::size_t ring_bytes) {
  std::unique_ptr<TapRecorder> recorder(new TapRecorder(ring_bytes));
  auto writer = TapWriter::Create(std::move(file), &recorder->tap_, core::MonotonicNow_ns());
  if (!writer) return tl::unexpected(writer.error());
  recorder->writer_ = std::move(*writer);
  // Signals are for the node's own threads.
  sigset_t all, before;
  sigfillset(&all);
  pthread_sigmask(SIG_SETMASK, &all, &before);
  recorder->thread_ = std::thread([raw = recorder.get()] { raw->Run(); });
  pthread_setname_np(recorder->thread_.native_handle(), "tap-writer");
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
  return recorder;
}

TapRecorder::~TapRecorder() {
  (void)Stop();
}

void TapRecorder::Run() {
  prctl(PR_SET_TIMERSLACK, 1UL);
  // Never real-time, whichever thread created it.
  const sched_param normal{};
  pthread_setschedparam(pthread_self(), SCHED_OTHER, &normal);
  // But nice -5 where that is allowed, so that a busy machine does not make a kill cost more than 100 ms.
  setpriority(PRIO_PROCESS, static_cast<id_t>(gettid()), -5);
  std::unique_lock lock(mutex_);
  while (!is_stopping_) {
    writer_->Service(core::MonotonicNow_ns());
    stopped_.wait_for(lock, std::chrono::nanoseconds(TapWriter::kService_ns), [this] { return is_stopping_; });
  }
}

core::Result<void> TapRecorder::Stop() {
  if (!thread_.joinable()) return {};
  {
    const std::lock_guard lock(mutex_);
    is_stopping_ = true;
  }
  stopped_.notify_all();
  thread_.join();
  return writer_->Close(core::MonotonicNow_ns());
}

}  // namespace bus::log
