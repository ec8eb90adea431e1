#pragma once

#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <csignal>
#include <cstdint>
#include <ctime>
#include <filesystem>
#include <string>
#include <vector>

#include "bus/log/mcap_reader.hpp"
#include "bus/log/tap_recorder.hpp"
#include "core/clock.hpp"

namespace bus::log {

// For tests: a process that records and is killed by kill -9.
struct KilledRecorder {
  std::int64_t died_ns = 0;            // by the clock of what it recorded
  std::vector<std::int64_t> saved_ns;  // times of the messages that its file still holds, in the file's order
  std::vector<std::uint32_t> saved;    // their sequence numbers: it put 1, 2, 3, ...
  std::int64_t unwritten_ns = 0;       // time since the last write to its file, at its death
  [[nodiscard]] std::int64_t lost_ns() const { return saved_ns.empty() ? died_ns : died_ns - saved_ns.back(); }
};

// In memory where possible.
inline std::filesystem::path KillFolder(const std::string& name) {
  const std::filesystem::path memory = "/dev/shm";
  return (std::filesystem::exists(memory) ? memory : std::filesystem::temp_directory_path()) /
         (name + std::to_string(getpid()));
}

// By the kernel's clock of files.
inline std::int64_t SinceLastWrite_ns(const std::filesystem::path& file) {
  timespec now{};
  struct stat status {};
  clock_gettime(CLOCK_REALTIME_COARSE, &now);
  if (stat(file.c_str(), &status) != 0) return 0;
  return (now.tv_sec - status.st_mtim.tv_sec) * core::kNanosecondsPerSecond + now.tv_nsec - status.st_mtim.tv_nsec;
}

// Kills a child after it has put `num_messages` into its tap, one for each millisecond, wherever it happens to be then.
// In virtual time the child works as fast as it can and services its writer itself; otherwise a TapRecorder does.
inline KilledRecorder RecordAndKill(const std::filesystem::path& folder, std::uint64_t num_messages,
                                    bool is_virtual_time) {
  struct Shared {
    std::atomic<std::uint64_t> num_put;
    std::atomic<std::int64_t> now_ns;
  };
  void* memory = mmap(nullptr, sizeof(Shared), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  auto* shared = new (memory) Shared{};
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
  const TapFile file{folder / "node.mcap", "node", {}, {}, 0, 0};

  const pid_t child = fork();
  if (child == 0) {
    const std::vector<std::uint8_t> payload(300, 7);
    const auto run = [&](Tap* tap, auto&& wait) {
      const std::uint16_t slot = tap->AddTopic({TapKind::kSent, "event", TopicClass::kEvent, "", ""});
      for (std::uint64_t i = 1;; ++i) {
        const std::int64_t now_ns = wait(static_cast<std::int64_t>(i) * core::kMillisecond_ns);
        tap->Put(slot, i, now_ns, now_ns, {}, payload);
        shared->now_ns.store(now_ns);
        shared->num_put.store(i);
      }
    };
    if (is_virtual_time) {
      Tap tap;
      auto writer = TapWriter::Create(file, &tap, 0);
      if (!writer) _exit(1);
      run(&tap, [&](std::int64_t now_ns) {
        if (now_ns % TapWriter::kService_ns == 0) (*writer)->Service(now_ns);
        return now_ns;
      });
    } else {
      auto recorder = TapRecorder::Create(file);
      if (!recorder) _exit(1);
      const std::int64_t begin_ns = core::MonotonicNow_ns();
      run((*recorder)->tap(), [&](std::int64_t after_ns) {
        const std::int64_t until_ns = begin_ns + after_ns;
        const timespec until{until_ns / 1'000'000'000, until_ns % 1'000'000'000};
        clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr);
        return core::MonotonicNow_ns();
      });
    }
    _exit(1);
  }

  int status = 0;
  while (shared->num_put.load() < num_messages && waitpid(child, &status, WNOHANG) == 0) sched_yield();
  kill(child, SIGKILL);
  waitpid(child, &status, 0);
  KilledRecorder killed;
  killed.unwritten_ns = SinceLastWrite_ns(file.path);
  killed.died_ns = shared->now_ns.load();
  munmap(memory, sizeof(Shared));
  const auto mended = folder / "mended.mcap";
  if (RecoverMcap(file.path, mended)) {
    (void)ReadMcap(mended, [&](const Channel&, const Message& message) {
      killed.saved_ns.push_back(static_cast<std::int64_t>(message.log_time_ns));
      killed.saved.push_back(message.sequence);
    });
  }
  return killed;
}

}  // namespace bus::log
