// LATEST between two network namespaces whose packet filter drops datagrams at random: how old is what a reader sees,
// and do the accounts agree with the kernel's own count of the drops? Encrypted, as nodes run by default.

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sched.h>
#include <sys/stat.h>
#include <sys/types.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <string>
#include <thread>
#include <vector>

#include "bus/keys.hpp"
#include "bus/node.hpp"
#include "bus/registry.hpp"
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

// A network of its own, without a name: it is gone with the last file and socket in it, also when the test dies.
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

struct Ages {
  std::vector<std::int64_t> by_schedule_ns;  // of the newest sample, the computer's own delays left out
  std::vector<std::int64_t> measured_ns;

  static double Percentile_ms(std::vector<std::int64_t> ages, double fraction) {
    if (ages.empty()) return 0.0;
    const auto place = static_cast<std::ptrdiff_t>(fraction * static_cast<double>(ages.size() - 1));
    std::nth_element(ages.begin(), ages.begin() + place, ages.end());
    return static_cast<double>(ages[static_cast<std::size_t>(place)]) * 1e-6;
  }
};

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

TEST_F(LossyNetwork, TheNewestSampleIsOnlyOlderByConsecutiveLosses) {
  constexpr int kTicks = 4000;
  for (const int per_mille : {0, 1, 10, 50}) {
    SetLoss(per_mille);
    Ages ages;
    std::int64_t oversleep_ns = 0;
    const std::uint64_t first = cycle_ + 1;
    const std::int64_t start_ns = core::MonotonicNow_ns() + kPeriod_ns;
    for (int tick = 0; tick < kTicks; ++tick) {
      const std::int64_t due_ns = start_ns + tick * kPeriod_ns;
      WaitUntil(due_ns);
      SendNext();
      // The reader's tick comes at any phase of the writer's: 0.05 to 0.95 of the period later.
      const std::int64_t phase_ns = (50 + 7 * tick % 901) * kPeriod_ns / 1000;
      WaitUntil(due_ns + phase_ns);
      reader_node_->Poll();
      const std::int64_t now_ns = core::MonotonicNow_ns();
      if (!reader_->has_value() || reader_->value().cycle < first) continue;
      oversleep_ns = std::max(oversleep_ns, now_ns - due_ns - phase_ns);
      ages.by_schedule_ns.push_back(static_cast<std::int64_t>(cycle_ - reader_->value().cycle) * kPeriod_ns + phase_ns);
      ages.measured_ns.push_back(reader_->publish_age_ns(now_ns));
    }
    const double p99_ms = Ages::Percentile_ms(ages.by_schedule_ns, 0.99);
    std::printf(
        "loss %4.1f %%: age of the newest sample p50 %.2f p99 %.2f max %.2f ms; with this computer's delays p99 "
        "%.2f max %.2f ms (overslept by %.2f ms at most)\n",
        per_mille * 0.1, Ages::Percentile_ms(ages.by_schedule_ns, 0.5), p99_ms,
        Ages::Percentile_ms(ages.by_schedule_ns, 1.0), Ages::Percentile_ms(ages.measured_ns, 0.99),
        Ages::Percentile_ms(ages.measured_ns, 1.0), static_cast<double>(oversleep_ns) * 1e-6);
    ASSERT_GT(ages.by_schedule_ns.size(), static_cast<std::size_t>(kTicks) * 9 / 10);
    if (per_mille == 0) {
      EXPECT_LT(Ages::Percentile_ms(ages.by_schedule_ns, 1.0), 1.0);  // always the newest of all
    }
    if (per_mille <= 10) {
      EXPECT_LE(p99_ms, 2.1);
    }
  }
}

TEST_F(LossyNetwork, AccountsAgreeWithThePacketFilterToTheMessage) {
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
