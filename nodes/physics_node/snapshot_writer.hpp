#pragma once

#include <semaphore.h>

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <thread>

#include "nodes/physics_node/snapshot.hpp"

namespace physics_node {

// Writes snapshots to a file on a thread of its own, so that the step thread never waits for the disk.
class SnapshotWriter {
 public:
  SnapshotWriter(std::filesystem::path file, std::uint64_t content);
  ~SnapshotWriter();
  SnapshotWriter(const SnapshotWriter&) = delete;
  SnapshotWriter& operator=(const SnapshotWriter&) = delete;

  // Step thread: the snapshot to fill, or null while the previous one is still being written. Commit starts writing.
  // Neither locks nor allocates.
  Snapshot* Begin() { return is_busy_.load(std::memory_order_acquire) ? nullptr : &snapshot_; }
  void Commit();

  [[nodiscard]] std::uint64_t num_written() const { return num_written_.load(std::memory_order_relaxed); }
  [[nodiscard]] std::uint64_t num_failed() const { return num_failed_.load(std::memory_order_relaxed); }

 private:
  void Run();

  std::filesystem::path file_;
  std::uint64_t content_ = 0;
  Snapshot snapshot_;
  std::atomic<bool> is_busy_{false};
  std::atomic<bool> is_stopping_{false};
  std::atomic<std::uint64_t> num_written_{0};
  std::atomic<std::uint64_t> num_failed_{0};
  sem_t wake_{};
  std::thread thread_;
};

}  // namespace physics_node
