#pragma once

#include <atomic>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <thread>

#include "bus/log/tap_writer.hpp"

namespace bus::log {

// A tap with the thread that writes it to a file. Create it before its node; it must outlive the node:
//
//   auto recorder = TapRecorder::Create(file);
//   node_options.tap = (*recorder)->tap();
class TapRecorder {
 public:
  static core::Result<std::unique_ptr<TapRecorder>> Create(TapFile file, std::size_t ring_bytes = std::size_t{8} << 20);
  ~TapRecorder();  // stops
  TapRecorder(const TapRecorder&) = delete;
  TapRecorder& operator=(const TapRecorder&) = delete;

  [[nodiscard]] Tap* tap() { return &tap_; }

  // Empties the tap and closes the file. Errors: kIo, including earlier ones.
  core::Result<void> Stop();

  // After Stop.
  [[nodiscard]] const TapWriter& writer() const { return *writer_; }

 private:
  explicit TapRecorder(std::size_t ring_bytes) : tap_(ring_bytes) {}
  void Run();

  Tap tap_;
  std::unique_ptr<TapWriter> writer_;
  std::mutex mutex_;
  std::condition_variable stopped_;
  bool is_stopping_ = false;
  std::thread thread_;
};

}  // namespace bus::log
