#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <random>

#include "bus/log/killed_recorder.hpp"

namespace bus::log {
namespace {

TEST(KilledRecorderSlow, LosesNothingThatIsOlderThan100msInAThousandKills) {
  const auto folder = KillFolder("killed_slow");
  std::mt19937_64 random(2);
  std::int64_t worst_ns = 0;
  for (int i = 0; i < 1000; ++i) {
    const KilledRecorder killed = RecordAndKill(folder, 50 + random() % 3000, true);
    ASSERT_LE(killed.lost_ns(), 100'000'000) << i;
    ASSERT_EQ(killed.saved_ns.size(),
              killed.saved_ns.empty() ? 0U : static_cast<std::size_t>(killed.saved_ns.back() / 1'000'000))
        << "a hole, kill " << i;
    worst_ns = std::max(worst_ns, killed.lost_ns());
  }
  std::printf("1000 kills in virtual time: at most %.1f ms lost\n", static_cast<double>(worst_ns) * 1e-6);
  std::filesystem::remove_all(folder);
}

// In real time how much is lost is a figure of the machine too, and is told; that there are no holes is a claim.
TEST(KilledRecorderSlow, HasNoHolesInRealTime) {
  const auto folder = KillFolder("killed_real");
  std::mt19937_64 random(3);
  std::vector<std::int64_t> lost_ns;
  for (int i = 0; i < 100; ++i) {
    const std::uint64_t num_messages = 150 + random() % 300;
    const KilledRecorder killed = RecordAndKill(folder, num_messages, false);
    ASSERT_TRUE(std::is_sorted(killed.saved_ns.begin(), killed.saved_ns.end()));
    ASSERT_LE(killed.saved_ns.size(), num_messages + 50);
    lost_ns.push_back(killed.lost_ns());
  }
  std::sort(lost_ns.begin(), lost_ns.end());
  std::printf("100 kills in real time: median %.1f ms lost, at most %.1f ms\n",
              static_cast<double>(lost_ns[lost_ns.size() / 2]) * 1e-6, static_cast<double>(lost_ns.back()) * 1e-6);
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace bus::log
