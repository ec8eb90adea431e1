// Two processes whose monotonic clocks differ, as on two machines: one lives in a time namespace.

#include <gtest/gtest.h>
#include <sched.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <fstream>

#include "bus/testing/make_node.hpp"

namespace bus {
namespace {

using testing::ExpectAccountsClose;
using testing::kLong_ns;
using testing::MakeNode;
using testing::MakeRegistry;
using testing::Until;
using testing::WaitBriefly;

constexpr std::int64_t kAhead_s = 4711;
constexpr int kNoTimeNamespace = 77;

TEST(Clock, NodesOfOneMachineHaveZeroOffset) {
  const auto registry = MakeRegistry();
  auto here = MakeNode("here", registry->endpoint());
  auto there = MakeNode("there", registry->endpoint());
  ASSERT_TRUE(here->Start().has_value() && there->Start().has_value());
  ASSERT_TRUE(here->WaitForPeers({"there"}, kLong_ns).has_value());
  EXPECT_EQ(here->Peers()[0].clock_offset_ns, 0);
  EXPECT_EQ(here->Peers()[0].clock_bound_ns, 0);
  ExpectAccountsClose({here.get(), there.get()});
}

#if !defined(__SANITIZE_THREAD__)
// In a time namespace of its own, where CLOCK_MONOTONIC is kAhead_s ahead.
[[noreturn]] void RunElsewhere(const std::string& registry) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (unshare(CLONE_NEWTIME) != 0) _exit(kNoTimeNamespace);
  std::ofstream offsets("/proc/self/timens_offsets");
  offsets << "monotonic " << kAhead_s << " 0\n";
  offsets.close();
  if (!offsets) _exit(kNoTimeNamespace);
  const pid_t child = fork();  // only children are in the new namespace
  if (child == 0) {
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    setenv("OOS_MACHINE_ID", "another machine", 1);
    auto node = MakeNode("there", registry);
    auto writer = node->WriteLatest<core::HapticProxy>(HapticProxyTopic("right"));
    if (!node->Start(kLong_ns)) _exit(1);
    for (core::HapticProxy proxy;; WaitBriefly(*node)) {
      proxy.header.direct.id = 1;
      proxy.header.direct.origin_ns = core::MonotonicNow_ns();
      writer.Send(proxy);
    }
  }
  int status = 0;
  waitpid(child, &status, 0);
  _exit(WIFEXITED(status) ? WEXITSTATUS(status) : 1);
}

TEST(Clock, TheOffsetOfATimeNamespaceIsEstimatedWithinItsBound) {
  const auto registry = MakeRegistry();
  const pid_t other = fork();
  ASSERT_GE(other, 0);
  if (other == 0) RunElsewhere(registry->endpoint());
  auto here = MakeNode("here", registry->endpoint());
  const auto& proxy = here->ReadLatest<core::HapticProxy>(HapticProxyTopic("right"));
  const auto started = here->Start();
  int status = 0, num_stamps = 0, num_foreign_stamps = 0;
  bool has_ended = false;
  int num_readings = 0, num_wrong = 0;
  std::int64_t last_ns = 0, tightest_ns = INT64_MAX;
  Until([&] {
    WaitBriefly(*here);
    has_ended = waitpid(other, &status, WNOHANG) == other;
    if (proxy.is_fresh() && proxy.value().header.direct.valid()) {
      ++num_stamps;
      const std::int64_t age_ns = proxy.received_ns() - proxy.value().header.direct.origin_ns;
      if (std::abs(age_ns) > kLong_ns) ++num_foreign_stamps;
    }
    for (const PeerStatus& peer : here->Peers()) {
      if (peer.clock_bound_ns == INT64_MAX || peer.clock_offset_ns == last_ns) continue;
      last_ns = peer.clock_offset_ns;
      ++num_readings;
      tightest_ns = std::min(tightest_ns, peer.clock_bound_ns);
      const std::int64_t error_ns = peer.clock_offset_ns - kAhead_s * core::kNanosecondsPerSecond;
      if (std::abs(error_ns) > peer.clock_bound_ns) ++num_wrong;
    }
    return has_ended || (num_readings >= 20 && num_stamps >= 20);
  });
  if (!has_ended) {
    kill(other, SIGKILL);
    waitpid(other, nullptr, 0);
  }
  if (has_ended && WIFEXITED(status) && WEXITSTATUS(status) == kNoTimeNamespace) {
    GTEST_SKIP() << "this kernel, or this user, has no time namespaces";
  }
  ASSERT_TRUE(started.has_value());
  EXPECT_GE(num_readings, 20);
  EXPECT_EQ(num_wrong, 0);
  EXPECT_GE(num_stamps, 20);
  EXPECT_EQ(num_foreign_stamps, 0) << "stamps come in this machine's clock";
  EXPECT_LT(tightest_ns, core::kNanosecondsPerSecond);
  ExpectAccountsClose({here.get()});
  RecordProperty("tightest_bound_us", std::to_string(static_cast<double>(tightest_ns) * 1e-3));
}
#endif

}  // namespace
}  // namespace bus
