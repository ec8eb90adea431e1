#include "nodes/physics_node/sheet_thread.hpp"

namespace physics_node {

SheetThread::SheetThread(bus::RealTimeMode mode, int fifo_priority) {
  bus::ThreadSetup setup;
  setup.name = "sheets";
  // The world's thread has reported missing rights already; without them this one runs as an ordinary thread.
  setup.mode = mode == bus::RealTimeMode::kEnforce ? bus::RealTimeMode::kTry : mode;
  setup.fifo_priority = fifo_priority;
  thread_ = std::thread([this, setup] { Run(setup); });
}

SheetThread::~SheetThread() {
  is_stopping_.store(true, std::memory_order_release);
  wake_.release();
  thread_.join();
}

void SheetThread::Start(void (*step)(void*), void* context) {
  step_ = step;
  context_ = context;
  is_busy_.store(true, std::memory_order_release);
  wake_.release();
}

void SheetThread::WaitUntilIdle() {
  is_busy_.wait(true, std::memory_order_acquire);
}

void SheetThread::Run(const bus::ThreadSetup& setup) {
  bus::SetUpThread(setup);
  while (true) {
    wake_.acquire();
    if (is_stopping_.load(std::memory_order_acquire)) return;
    step_(context_);
    is_busy_.store(false, std::memory_order_release);
    is_busy_.notify_all();
  }
}

}  // namespace physics_node
