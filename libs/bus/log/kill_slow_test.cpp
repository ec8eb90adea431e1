#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <random>
#include <string>

#include "bus/testing/killed_recorder.hpp"

namespace bus::log {
namespace {

TEST(KilledRecorderSlow, LosesNothingThatIsOlderThan100msInAThousandKills) {
  const auto folder = KillFolder("killed_slow");
  std::mt19937_64 random(2);
  std::int64_t worst_ns = 0;
  for (int i = 0; i < 1000; ++i) {
    const KilledRecorder killed = RecordAndKill(folder, 50 + random() % 3000, true);
    ASSERT_LE(killed.lost_ns(), 100'000'000) << i;
    for (std::size_t n = 0; n < killed.saved.size(); ++n) ASSERT_EQ(killed.saved[n], n + 1) << "a hole, kill " << i;
    worst_ns = std::max(worst_ns, killed.lost_ns());
  }
  std::printf("1000 kills in virtual time: at most %.1f ms lost\n", static_cast<double>(worst_ns) * 1e-6);
  std::filesystem::remove_all(folder);
}

// Allowed loss of a kill: the writer is serviced every 10 ms and flushes what is older than 40 ms; the other half is
// margin for a busy machine.
constexpr std::int64_t kMaxLost_ns = 100'000'000;
// Nothing written for twice the flush period: the machine did not schedule the writer, which is not its fault. Such a
// kill proves nothing and is repeated, a limited number of times: a writer that never writes shows the same.
constexpr std::int64_t kHeldUp_ns = 2 * TapWriter::kFlushPeriod_ns;
constexpr int kMaxHeldUp = 20;

TEST(KilledRecorderSlow, HasNoHolesInRealTimeAndLosesAtMost100ms) {
  const auto folder = KillFolder("killed_real");
  std::mt19937_64 random(3);
  std::vector<std::int64_t> lost_ns;
  int num_held_up = 0;
  while (lost_ns.size() < 100) {
    const KilledRecorder killed = RecordAndKill(folder, 150 + random() % 300, false);
    for (std::size_t n = 0; n < killed.saved.size(); ++n) {
      ASSERT_EQ(killed.saved[n], n + 1) << "a hole, kill " << lost_ns.size();
    }
    ASSERT_TRUE(std::is_sorted(killed.saved_ns.begin(), killed.saved_ns.end()));
    if (!killed.saved.empty() && killed.lost_ns() <= kMaxLost_ns) {
      lost_ns.push_back(killed.lost_ns());
      continue;
    }
    const std::string what =
        killed.saved.empty() ? "nothing was saved" : std::to_string(killed.lost_ns() / 1'000'000) + " ms are lost";
    ASSERT_GT(killed.unwritten_ns, kHeldUp_ns) << what << " though the writer was not held up";
    ASSERT_LT(++num_held_up, kMaxHeldUp) << what << " once more: the writer does not write in time";
    std::printf("kill %zu is done again: %s, the machine had held the writer up for %.0f ms\n", lost_ns.size(),
                what.c_str(), static_cast<double>(killed.unwritten_ns) * 1e-6);
  }
  std::sort(lost_ns.begin(), lost_ns.end());
  std::printf("100 kills in real time: median %.1f ms lost, at most %.1f ms; %d done again\n",
              static_cast<double>(lost_ns[lost_ns.size() / 2]) * 1e-6, static_cast<double>(lost_ns.back()) * 1e-6,
              num_held_up);
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace bus::log
