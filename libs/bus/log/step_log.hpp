#pragma once

#include <semaphore.h>

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "bus/log/mcap_writer.hpp"
#include "bus/log/step_sink.hpp"
#include "bus/log/tap.hpp"
#include "core/result.hpp"

namespace bus::log {

inline std::string StepTopic(const std::string& node) {
  return "replay/" + node + "/step";
}

// Steps of nodes as an MCAP file: a channel replay/<node>/step for each of them, their time as the log time, their tick
// as the sequence number. `about` goes into the metadata record "replay/<node>". Not real-time.
class StepFile {
 public:
  static core::Result<std::unique_ptr<StepFile>> Create(const std::filesystem::path& path);

  // Declares a node, before its first step. `fields` lists the fields of a step; it becomes the schema's text.
  std::uint16_t AddNode(const std::string& node, const std::string& fields, const TextMap& about);
  core::Result<void> Attach(const std::string& name, const std::vector<std::uint8_t>& bytes);
  core::Result<void> Write(std::uint16_t channel, std::uint64_t tick, std::int64_t now_ns,
                           std::span<const std::uint8_t> step);
  // Records that steps of this node were lost, so that no loss is silent.
  core::Result<void> WriteLoss(const std::string& node, std::uint64_t count, std::int64_t now_ns);
  core::Result<void> Flush() { return writer_->Flush(); }
  core::Result<void> Close();

 private:
  explicit StepFile(std::unique_ptr<McapWriter> writer) : writer_(std::move(writer)) {}
  std::unique_ptr<McapWriter> writer_;
  core::Result<void> first_failure_;  // of AddNode
};

// Records the steps of one node while it runs: a ring, and a thread that writes it to a file within 100 ms.
class StepLog final : public StepSink {
 public:
  StepLog(std::unique_ptr<StepFile> file, std::string node, std::uint16_t channel);
  ~StepLog() override;
  StepLog(const StepLog&) = delete;
  StepLog& operator=(const StepLog&) = delete;

  bool Push(std::uint64_t tick, std::int64_t now_ns, std::span<const std::uint8_t> step) noexcept override;

  // Writes what is left and closes the file. Returns the first error of writing, after which nothing was written.
  core::Result<void> Close();

  [[nodiscard]] std::uint64_t num_lost() const { return tap_.dropped(slot_); }

 private:
  void Run();
  void Drain();

  std::unique_ptr<StepFile> file_;
  std::string node_;
  std::uint16_t channel_ = 0;
  Tap tap_;
  std::uint16_t slot_ = 0;
  std::uint64_t reported_lost_ = 0;
  core::Result<void> done_;  // of the thread
  std::atomic<bool> is_stopping_{false};
  sem_t wake_{};
  std::thread thread_;
};

}  // namespace bus::log
