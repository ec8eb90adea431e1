// LATEST between two network namespaces whose packet filter drops datagrams at random: the age of the newest sample,
// and agreement of the accounts with the kernel's count of drops. Encrypted, as nodes run by default.

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sched.h>
#include <sys/stat.h>
#include <sys/types.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <string>
#include <thread>
#include <vector>

#include "bus/membership/registry.hpp"
#include "bus/node.hpp"
#include "bus/security/keys.hpp"
#include "core/clock.hpp"

namespace bus {
namespace {

constexpr std::int64_t kPeriod_ns = core::kTick_ns;
constexpr std::int64_t kPatience_ns = 10 * core::kNanosecondsPerSecond;

// Output of a shell command, without its last newline.
std::string Shell(const std::string& command) {
  std::string text;
  FILE* pipe = popen((command + " 2>&1").c_str(), "r");
  if (pipe == nullptr) return "popen failed";
  std::array<char, 256> part;
  while (std::fgets(part.data(), part.size(), pipe) != nullptr) text += part.data();
  const int status = pclose(pipe);
  while (!text.empty() && text.back() == '\n') text.pop_back();
  return status == 0 ? text : "failed: " + text;
}

// An unnamed network namespace: it ends with its last file and socket, even when the test dies.
class Network {
 public:
  Network() {
    std::thread([this] {
      if (unshare(CLONE_NEWNET) == 0) fd_ = open("/proc/thread-self/ns/net", O_RDONLY | O_CLOEXEC);
    }).join();
  }
  ~Network() {
    if (fd_ >= 0) close(fd_);
  }
  Network(const Network&) = delete;
  Network& operator=(const Network&) = delete;

  [[nodiscard]] bool is_there() const { return fd_ >= 0; }
  // Sockets, threads and processes that begin in `body` belong to this network.
  void Do(const std::function<void()>& body) const {
    std::thread([&] {
      if (setns(fd_, CLONE_NEWNET) != 0) ADD_FAILURE() << "setns";
      body();
    }).join();
  }
  [[nodiscard]] std::string Run(const std::string& command) const {
    std::string answer;
    Do([&] { answer = Shell(command); });
    return answer;
  }
  [[nodiscard]] std::string path() const { return "/proc/" + std::to_string(getpid()) + "/fd/" + std::to_string(fd_); }

 private:
  int fd_ = -1;
};

double Percentile_ms(std::vector<std::int64_t> times_ns, double fraction) {
  if (times_ns.empty()) return 0.0;
  const auto place = static_cast<std::ptrdiff_t>(fraction * static_cast<double>(times_ns.size() - 1));
  std::nth_element(times_ns.begin(), times_ns.begin() + place, times_ns.end());
  return static_cast<double>(times_ns[static_cast<std::size_t>(place)]) * 1e-6;
}

class LossyNetwork : public testing::Test {
 protected:
  void SetUp() override {
    if (geteuid() != 0) GTEST_SKIP() << "network namespaces need root";
    if (!writers_.is_there() || !readers_.is_there()) GTEST_SKIP() << "this kernel makes no network namespaces";
    const std::string veth = writers_.Run("ip link add w type veth peer name r netns " + readers_.path());
    if (!veth.empty()) GTEST_SKIP() << "no pair of virtual interfaces: " << veth;
    ASSERT_EQ(writers_.Run("ip addr add 10.78.0.1/24 dev w && ip link set w up && ip link set lo up"), "");
    ASSERT_EQ(readers_.Run("ip addr add 10.78.0.2/24 dev r && ip link set r up && ip link set lo up"), "");
    const std::string filter = readers_.Run(
        "nft add table ip f && nft add chain ip f i '{ type filter hook input priority 0; }' && "
        "nft add rule ip f i udp dport 9 numgen random mod 1000 '<' 1 counter drop");
    if (!filter.empty()) GTEST_SKIP() << "the packet filter cannot drop at random: " << filter;

    keys_ = std::filesystem::temp_directory_path() / ("loss_test-" + std::to_string(getpid()));
    ASSERT_TRUE(MakeKeys(keys_, {"writer", "reader"}));
    writers_.Do([this] {
      RegistryOptions options;
      options.endpoint = "tcp://10.78.0.1:0";
      options.session = 7;
      options.keys = keys_.string();
      auto registry = Registry::Create(options);
      ASSERT_TRUE(registry) << registry.error().detail;
      registry_ = std::move(*registry);
    });
    ASSERT_NE(registry_, nullptr);
    writers_.Do([this] { writer_node_ = Make("writer", "10.78.0.1"); });
    readers_.Do([this] { reader_node_ = Make("reader", "10.78.0.2"); });
    ASSERT_TRUE(writer_node_ != nullptr && reader_node_ != nullptr);
    writer_ = writer_node_->WriteLatest<core::HapticProxy>(HapticProxyTopic("right"));
    reader_ = &reader_node_->ReadLatest<core::HapticProxy>(HapticProxyTopic("right"));
    reader_->KeepHistory(8);
    writers_.Do([this] { ASSERT_TRUE(writer_node_->Start(kPatience_ns)); });
    readers_.Do([this] { ASSERT_TRUE(reader_node_->Start(kPatience_ns)); });
    ASSERT_TRUE(writer_node_->WaitForPeers({"reader"}, kPatience_ns));
    ASSERT_TRUE(reader_node_->WaitForPeers({"writer"}, kPatience_ns));
    while (!writer_.has_subscribers()) std::this_thread::yield();
    const std::string endpoint = writer_node_->Peers()[0].udp_endpoint;
    port_ = endpoint.substr(endpoint.rfind(':') + 1);
  }
  void TearDown() override {
    reader_node_.reset();
    writer_node_.reset();
    registry_.reset();
    std::error_code error;
    if (!keys_.empty()) std::filesystem::remove_all(keys_, error);
  }

  std::unique_ptr<Node> Make(const std::string& name, const std::string& address) {
    NodeOptions options;
    options.name = name;
    options.registry = registry_->endpoint();
    options.bind_address = address;
    options.session = 7;
    options.keys = keys_.string();
    auto node = Node::Create(options);
    EXPECT_TRUE(node) << node.error().detail;
    return node ? std::move(*node) : nullptr;
  }

  void SetLoss(int per_mille) {
    std::string rule = "nft flush chain ip f i";
    if (per_mille > 0) {
      rule += " && nft add rule ip f i udp dport " + port_ + " numgen random mod 1000 '<' " +
              std::to_string(per_mille) + " counter drop";
    }
    ASSERT_EQ(readers_.Run(rule), "");
  }
  std::uint64_t DroppedByFilter() {
    const std::string packets = readers_.Run("nft list chain ip f i | grep -o 'packets [0-9]*' | cut -d' ' -f2");
    return packets.empty() ? 0 : std::stoull(packets);
  }

  TopicCounters Read() const {
    for (const TopicCounters& topic : reader_node_->counters().topics) {
      if (topic.topic == HapticProxyTopic("right")) return topic;
    }
    return {};
  }

  void SendNext() {
    proxy_.cycle = ++cycle_;
    EXPECT_EQ(writer_.Send(proxy_), 1);
  }

  Network writers_, readers_;
  std::filesystem::path keys_;
  std::string port_;
  std::unique_ptr<Registry> registry_;
  std::unique_ptr<Node> writer_node_, reader_node_;
  LatestWriter<core::HapticProxy> writer_;
  LatestReader<core::HapticProxy>* reader_ = nullptr;
  core::HapticProxy proxy_;
  std::uint64_t cycle_ = 0;
};

void WaitUntil(std::int64_t time_ns) {
  const timespec until{time_ns / core::kNanosecondsPerSecond, time_ns % core::kNanosecondsPerSecond};
  clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr);
}

// All times by CLOCK_MONOTONIC, which both networks share.
struct Sent {
  std::int64_t due_ns = 0, published_ns = 0, done_ns = 0;

  // How much later than its tick the sample reached the reader's socket because the writer's thread was held up.
  [[nodiscard]] std::int64_t held_up_ns() const { return done_ns - due_ns; }
};
struct Reading {
  std::int64_t due_ns = 0, woke_ns = 0, done_ns = 0;
  std::int64_t age_ns = 0;     // when it was done, of the newest sample that had come
  std::uint64_t newest = 0;    // that sample's cycle
  std::uint64_t received = 0;  // by the node in all, so far

  [[nodiscard]] std::int64_t held_up_ns() const { return done_ns - woke_ns; }
};

// Samples lost between the newest one of a reading and the next one that arrived. When the later reading brings several
// at once but not all, which of them were lost is unknown, and all are taken to be the first.
std::uint64_t ConsecutiveLosses(const Reading& reading, const Reading& next_with_news) {
  const std::uint64_t received = next_with_news.received - reading.received;
  const std::uint64_t sent = next_with_news.newest - reading.newest;
  return sent > received ? sent - received : 0;
}

// A thread in one network sends at 1 kHz, one in the other reads at its own ticks, whose phase against the writer's
// sweeps once a second. The age of the newest sample depends on the machine and is only printed: `oos bench bus` judges
// the goal of 2.1 ms for the 99th percentile. Tested here is what holds on any machine: age is at most (consecutive
// losses + 1) periods and a hop, plus the measured delays of the two threads.
TEST_F(LossyNetwork, AgeGrowsOnlyByConsecutiveLosses) {
  constexpr int kReadings = 4000;
  constexpr std::int64_t kReadPeriod_ns = kPeriod_ns + kPeriod_ns / 1000;
  constexpr std::int64_t kRunIn_ns = 50 * kPeriod_ns;
  constexpr std::int64_t kHop_ns = kPeriod_ns / 2;  // a tenth of it is usual
  for (const int per_mille : {0, 1, 10, 50}) {
    SetLoss(per_mille);
    std::vector<Sent> sent;  // of cycle `first` and following
    std::vector<Reading> readings;
    const std::uint64_t first = cycle_ + 1;
    const std::int64_t start_ns = core::MonotonicNow_ns() + 10 * kPeriod_ns;
    std::atomic<bool> is_done{false};
    std::thread writer([&] {
      writers_.Do([&] {
        for (std::int64_t tick = 0; !is_done.load(); ++tick) {
          const std::int64_t due_ns = start_ns + tick * kPeriod_ns;
          WaitUntil(due_ns);
          SendNext();
          sent.push_back({due_ns, proxy_.header.publish_ns, core::MonotonicNow_ns()});
        }
      });
    });
    readers_.Do([&] {
      for (int i = 0; i < kReadings; ++i) {
        Reading reading;
        reading.due_ns = start_ns + kRunIn_ns + i * kReadPeriod_ns;
        WaitUntil(reading.due_ns);
        reading.woke_ns = core::MonotonicNow_ns();
        reader_node_->Poll();
        reading.done_ns = core::MonotonicNow_ns();
        reading.age_ns = reader_->publish_age_ns(reading.done_ns);
        reading.newest = reader_->value().cycle;
        reading.received = Read().received;
        if (reading.newest >= first) readings.push_back(reading);
      }
    });
    is_done.store(true);
    writer.join();
    ASSERT_GT(readings.size(), static_cast<std::size_t>(kReadings) * 9 / 10);

    std::vector<std::int64_t> ages_ns, writer_late_ns, reader_late_ns;
    for (const Sent& one : sent) writer_late_ns.push_back(one.published_ns - one.due_ns);
    std::uint64_t most_losses = 0;
    int num_unexplained = 0;
    auto next = readings.begin();
    for (const Reading& reading : readings) {
      ages_ns.push_back(reading.age_ns);
      reader_late_ns.push_back(reading.woke_ns - reading.due_ns);
      while (next != readings.end() && next->newest <= reading.newest) ++next;
      if (next == readings.end()) continue;  // the test was over before something newer came
      const std::uint64_t losses = ConsecutiveLosses(reading, *next);
      most_losses = std::max(most_losses, losses);
      const Sent& awaited = sent.at(reading.newest + losses + 1 - first);
      const std::int64_t oldest_ns = static_cast<std::int64_t>(losses + 1) * kPeriod_ns + kHop_ns;
      if (reading.age_ns <= oldest_ns + awaited.held_up_ns() + reading.held_up_ns()) continue;
      ++num_unexplained;
      std::printf(
          "cycle %llu is %.3f ms old, %llu lost after it; the next was held up by %.3f ms, the reading by %.3f ms\n",
          static_cast<unsigned long long>(reading.newest), static_cast<double>(reading.age_ns) * 1e-6,
          static_cast<unsigned long long>(losses), static_cast<double>(awaited.held_up_ns()) * 1e-6,
          static_cast<double>(reading.held_up_ns()) * 1e-6);
    }
    std::printf(
        "loss %4.1f %%: age of the newest sample p50 %.3f p99 %.3f max %.3f ms, %llu lost in a row at most; woke up "
        "late, "
        "p99 and max: writer %.3f, %.3f, reader %.3f, %.3f ms\n",
        per_mille * 0.1, Percentile_ms(ages_ns, 0.5), Percentile_ms(ages_ns, 0.99), Percentile_ms(ages_ns, 1.0),
        static_cast<unsigned long long>(most_losses), Percentile_ms(writer_late_ns, 0.99),
        Percentile_ms(writer_late_ns, 1.0), Percentile_ms(reader_late_ns, 0.99), Percentile_ms(reader_late_ns, 1.0));
    // A few are allowed: on a busy processor the kernel may defer reception to a thread of its own, whose delay neither
    // thread measures. Head-of-line blocking, as with TCP, would cost three readings for every loss.
    EXPECT_LE(num_unexplained, kReadings / 1000) << "at " << per_mille << " of 1000 lost";
    if (per_mille == 0) {
      EXPECT_EQ(most_losses, 0);
    }
    if (per_mille >= 10) {
      EXPECT_GT(most_losses, 0);
    }
  }
}

TEST_F(LossyNetwork, AccountsAgreeExactlyWithThePacketFilter) {
  SetLoss(0);
  SendNext();
  while (reader_->value().cycle != cycle_) reader_node_->Wait(core::MonotonicNow_ns() + kPeriod_ns);
  const TopicCounters before = Read();
  SetLoss(100);  // one in ten, so that three in a row are frequent
  constexpr std::uint64_t kMessages = 20'000;
  for (std::uint64_t i = 0; i < kMessages; ++i) {
    SendNext();
    reader_node_->Poll();
  }
  const std::uint64_t dropped_by_filter = DroppedByFilter();
  SetLoss(0);
  SendNext();
  while (reader_->value().cycle != cycle_) reader_node_->Wait(core::MonotonicNow_ns() + kPeriod_ns);
  const TopicCounters after = Read();
  EXPECT_GT(dropped_by_filter, kMessages / 20);
  const std::uint64_t received = after.received - before.received;
  const std::uint64_t restored = after.restored - before.restored;
  const std::uint64_t lost = after.dropped - before.dropped;
  EXPECT_EQ(received + restored + lost, kMessages + 1);
  EXPECT_EQ(kMessages + 1 - received, dropped_by_filter);
  EXPECT_LT(lost, dropped_by_filter / 20);  // three in a row, of a hundred such
  std::printf("%llu sent, %llu dropped by the packet filter: %llu restored, %llu lost\n",
              static_cast<unsigned long long>(kMessages + 1), static_cast<unsigned long long>(dropped_by_filter),
              static_cast<unsigned long long>(restored), static_cast<unsigned long long>(lost));
  for (const RefusalCount& refusal : reader_node_->counters().refusals) {
    EXPECT_EQ(refusal.reason, "unknown_sender");  // a heartbeat that came before the roster
  }
}

}  // namespace
}  // namespace bus
