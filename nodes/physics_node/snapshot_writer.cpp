#include "nodes/physics_node/snapshot_writer.hpp"

#include <cstdio>
#include <utility>

namespace physics_node {

SnapshotWriter::SnapshotWriter(std::filesystem::path file, std::uint64_t content)
    : file_(std::move(file)), content_(content) {
  sem_init(&wake_, 0, 0);
  thread_ = std::thread([this] { Run(); });
}

SnapshotWriter::~SnapshotWriter() {
  is_stopping_.store(true);
  sem_post(&wake_);
  thread_.join();
  sem_destroy(&wake_);
}

void SnapshotWriter::Commit() {
  is_busy_.store(true, std::memory_order_release);
  sem_post(&wake_);
}

void SnapshotWriter::Run() {
  while (true) {
    sem_wait(&wake_);
    if (is_busy_.load(std::memory_order_acquire)) {
      if (const auto written = WriteSnapshot(file_, content_, snapshot_); written) {
        num_written_.fetch_add(1);
      } else if (num_failed_.fetch_add(1) == 0) {
        std::printf("%s\n", written.error().detail.c_str());
        std::fflush(stdout);
      }
      is_busy_.store(false, std::memory_order_release);
    }
    if (is_stopping_.load()) return;
  }
}

}  // namespace physics_node
