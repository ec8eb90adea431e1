// Repeats module_replacement for VR_OOS_SOAK_MINUTES (default 3): no process grows, and in every run the bus's message
// counts add up. For an hour: VR_OOS_SOAK_MINUTES=60 system_tests_slow_test --gtest_filter='Soak.*'

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <deque>
#include <fstream>
#include <limits>
#include <map>
#include <memory>
#include <sstream>

#include "bus/topics.hpp"
#include "core/clock.hpp"
#include "tests/support.hpp"
#include "tests/support/bus_watch.hpp"
#include "tools/oos/run/session/session.hpp"

namespace system_tests {
namespace {

constexpr double kSamplePeriod_s = 0.5;
constexpr std::size_t kNumRecentSamples = 10;
constexpr double kSettled_s = 15.0;  // of a run: everything has been touched, shown and connected
constexpr double kMaxGrowth = 0.03;  // of a process's memory in a run, from then on
constexpr long kPageNoise_kB = 2048;
// visual_node, from its first picture of a step on: what develops such pictures, which are drawn at twice their width
// and height (15 MB at 1280x720), a picture of each step until the run's end (7 of 0.9 MB), and what the software
// renderer compiles for what a view shows first (14 MB for the first, 1 to 7 MB for each further step); while one is
// drawn also its film and itself (45 MB), which are returned afterwards. Whether it goes on growing is seen in the
// quietest stretch.
constexpr long kPictures_kB = 90'000;
// A leak grows in every stretch of a run, what is made once does not. 30 samples are 15 s and 450 pictures.
constexpr std::size_t kStretchSamples = 30;
constexpr long kStretchGrowth_kB = 1024;

struct Usage {
  long memory_kB = 0;  // anonymous, resident: what the process itself holds
  int descriptors = 0;
  int threads = 0;
  long queue_bytes = 0;  // waiting in its UDP sockets
};

long FieldOf(const std::filesystem::path& file, const std::string& name) {
  std::ifstream in(file);
  for (std::string line; std::getline(in, line);) {
    if (line.rfind(name, 0) == 0) return std::strtol(line.c_str() + name.size(), nullptr, 10);
  }
  return 0;
}

// Bytes that wait in UDP sockets, by inode.
std::map<long, long> UdpQueues() {
  std::map<long, long> queues;
  std::ifstream in("/proc/net/udp");
  std::string line;
  std::getline(in, line);
  while (std::getline(in, line)) {
    unsigned long receive = 0;
    long inode = 0;
    if (std::sscanf(line.c_str(), "%*d: %*s %*s %*s %*x:%lx %*s %*s %*d %*d %ld", &receive, &inode) == 2) {
      queues[inode] = static_cast<long>(receive);
    }
  }
  return queues;
}

Usage UsageOf(pid_t process, const std::map<long, long>& udp) {
  const auto folder = std::filesystem::path("/proc") / std::to_string(process);
  Usage usage;
  usage.memory_kB = FieldOf(folder / "status", "RssAnon:");
  usage.threads = static_cast<int>(FieldOf(folder / "status", "Threads:"));
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(folder / "fd", error)) {
    ++usage.descriptors;
    const std::string target = std::filesystem::read_symlink(entry.path(), error).string();
    if (target.rfind("socket:[", 0) != 0) continue;
    const auto queue = udp.find(std::strtol(target.c_str() + 8, nullptr, 10));
    if (queue != udp.end()) usage.queue_bytes += queue->second;
  }
  return usage;
}

// The usage of one process in one run.
struct Course {
  Usage settled, last;
  long largest_queue_bytes = 0;
  std::deque<long> recent_queue_bytes;                      // in the newest samples
  std::deque<long> recent_memory_kB;                        // in the newest kStretchSamples
  long least_growth_kB = std::numeric_limits<long>::max();  // over any stretch after kSettled_s
};

struct Loop {
  oos::SessionOutcome outcome;
  std::map<std::string, Course> courses;
  std::vector<std::string> open_accounts;
  std::uint64_t num_accounts = 0;
};

// Reliable topics: sent = received + dropped exactly. LATEST: the same but for messages still under way when the counts
// are read.
void CheckAccounts(const std::vector<bus::PeerStatus>& peers, Loop* loop) {
  constexpr std::uint64_t kUnderWay = 200;  // the counts of the two ends are up to 0.1 s old each, at 1 kHz
  loop->open_accounts.clear();
  loop->num_accounts = 0;
  for (const bus::PeerStatus& peer : peers) {
    for (const bus::ReportedAccount& account : peer.accounts) {
      const bus::TopicRule* rule = bus::FindTopicRule(account.topic);
      const bool is_latest = rule != nullptr && rule->topic_class == bus::TopicClass::kLatest;
      // A writer of LATEST does not know what arrived: the reader's account has both counts.
      if (is_latest && account.is_writer) continue;
      const std::uint64_t arrived = account.received + account.dropped;
      const std::uint64_t apart = arrived > account.sent ? arrived - account.sent : account.sent - arrived;
      ++loop->num_accounts;
      if (apart <= (is_latest ? kUnderWay : 0)) continue;
      std::ostringstream line;
      line << peer.name << " with " << account.peer << ", " << account.topic << ": " << account.sent << " sent, "
           << account.received << " received, " << account.dropped << " dropped";
      loop->open_accounts.push_back(line.str());
    }
  }
}

Loop RunOnce(const scene::Scenario& scenario, const std::filesystem::path& out, std::uint64_t seed) {
  Loop loop;
  std::unique_ptr<BusWatch> watch;
  double next_s = 0.0;
  oos::SessionOptions options;
  options.out = out;
  options.seed = seed;
  options.is_headless = true;
  options.program_folder = std::filesystem::path(VR_OOS_BINARY_DIR) / "bin";
  options.while_running = [&](process::Group& group, double seconds, double) {
    if (watch == nullptr) watch = std::make_unique<BusWatch>("/proc/self/ns/net", "127.0.0.1", "right");
    if (seconds < next_s) return;
    next_s = seconds + kSamplePeriod_s;
    const auto udp = UdpQueues();
    for (const process::Group::Child& child : group.children()) {
      Course& course = loop.courses[child.name];
      course.last = UsageOf(child.pid, udp);
      course.largest_queue_bytes = std::max(course.largest_queue_bytes, course.last.queue_bytes);
      course.recent_queue_bytes.push_back(course.last.queue_bytes);
      if (course.recent_queue_bytes.size() > kNumRecentSamples) course.recent_queue_bytes.pop_front();
      if (seconds < kSettled_s) {
        course.settled = course.last;
        continue;
      }
      course.recent_memory_kB.push_back(course.last.memory_kB);
      if (course.recent_memory_kB.size() <= kStretchSamples) continue;
      course.recent_memory_kB.pop_front();
      course.least_growth_kB =
          std::min(course.least_growth_kB, course.recent_memory_kB.back() - course.recent_memory_kB.front());
    }
    CheckAccounts(watch->peers(), &loop);
  };
  auto outcome = oos::RunSession(scenario, options);
  EXPECT_TRUE(outcome) << outcome.error().detail;
  if (outcome) loop.outcome = *outcome;
  if (watch != nullptr) {
    EXPECT_EQ(watch->trouble(), "");
  }
  return loop;
}

TEST(Soak, RepeatedModuleReplacementGrowsNoProcess) {
  const char* minutes_text = std::getenv("VR_OOS_SOAK_MINUTES");
  const double minutes = minutes_text != nullptr ? std::strtod(minutes_text, nullptr) : 3.0;
  ASSERT_GT(minutes, 0.0);
  const scene::Scenario scenario = Load("module_replacement");
  const auto out = std::filesystem::path(VR_OOS_BINARY_DIR) / "soak";
  const std::int64_t begin_ns = core::MonotonicNow_ns();
  const auto passed_s = [&] { return static_cast<double>(core::MonotonicNow_ns() - begin_ns) * 1e-9; };
  std::map<std::string, std::vector<long>> kept_kB;  // of each process at the end of each loop
  Usage first_own;
  int num_loops = 0;
  long largest_queue_bytes = 0;
  while (num_loops < 2 || passed_s() < 60.0 * minutes) {
    std::filesystem::remove_all(out);
    const Loop loop = RunOnce(scenario, out, static_cast<std::uint64_t>(++num_loops));
    SCOPED_TRACE(num_loops);
    EXPECT_TRUE(loop.outcome.is_final) << loop.outcome.why;
    EXPECT_GT(loop.num_accounts, 20u);
    EXPECT_EQ(loop.open_accounts, std::vector<std::string>());
    std::printf("loop %d, %.0f s:", num_loops, passed_s());
    for (const auto& [name, course] : loop.courses) {
      const long before_kB = course.settled.memory_kB, after_kB = course.last.memory_kB;
      std::printf(" %s %ld -> %ld kB, %d fd;", name.c_str(), before_kB, after_kB, course.last.descriptors);
      const long pictures_kB = name == "visual_node" ? kPictures_kB : 0;
      EXPECT_LE(after_kB, before_kB + pictures_kB + std::max(kPageNoise_kB, static_cast<long>(kMaxGrowth * before_kB)))
          << name;
      EXPECT_LE(course.least_growth_kB, kStretchGrowth_kB) << name << " grows all the time";
      EXPECT_LE(course.last.descriptors, course.settled.descriptors + 1) << name;  // a checkpoint that is being written
      EXPECT_LE(course.last.threads, course.settled.threads) << name;
      // Datagrams wait while a process gets no processor for a moment; in one that cannot keep up they always wait. The
      // bound is a fraction of a socket's buffer.
      EXPECT_LT(*std::min_element(course.recent_queue_bytes.begin(), course.recent_queue_bytes.end()), 200'000) << name;
      largest_queue_bytes = std::max(largest_queue_bytes, course.largest_queue_bytes);
      kept_kB[name].push_back(after_kB);
    }
    const Usage own = UsageOf(getpid(), UdpQueues());
    std::printf(" registry and launcher %ld kB, %d fd\n", own.memory_kB, own.descriptors);
    if (num_loops == 2) first_own = own;  // the first loop fills caches
    kept_kB["registry and launcher"].push_back(own.memory_kB);
    if (num_loops > 2) {
      EXPECT_LE(own.descriptors, first_own.descriptors);
      EXPECT_LE(own.threads, first_own.threads);
    }
    std::fflush(stdout);
  }
  // Memory differs between loops: each thread of the launcher takes an arena of the allocator, new ones until all are
  // in use, and the driver caches what was drawn. A leak shows when the second half needs more than the first.
  for (const auto& [name, kB] : kept_kB) {
    if (kB.size() < 6) break;
    const auto half = kB.begin() + static_cast<std::ptrdiff_t>(kB.size() / 2);
    const long first_kB = *std::max_element(kB.begin(), half), second_kB = *std::max_element(half, kB.end());
    std::printf("%s: at most %ld kB in the first half, %ld kB in the second\n", name.c_str(), first_kB, second_kB);
    EXPECT_LE(second_kB, first_kB + std::max(kPageNoise_kB, first_kB / 20)) << name;
  }
  std::printf("%d loops in %.1f minutes; at most %ld bytes waited in a UDP socket\n", num_loops, passed_s() / 60.0,
              largest_queue_bytes);
}

}  // namespace
}  // namespace system_tests
