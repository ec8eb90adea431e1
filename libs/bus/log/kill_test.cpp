#include <gtest/gtest.h>

#include <random>

#include "bus/testing/killed_recorder.hpp"

namespace bus::log {
namespace {

// In virtual time, so that the claim does not depend on how busy the machine is: the kill itself comes at any
// instruction, also within a write.
TEST(KilledRecorder, LosesNothingThatIsOlderThan100ms) {
  const auto folder = KillFolder("killed");
  std::mt19937_64 random(1);
  for (int i = 0; i < 12; ++i) {
    const KilledRecorder killed = RecordAndKill(folder, 200 + random() % 800, true);
    ASSERT_GT(killed.saved_ns.size(), 0U) << i;
    EXPECT_LE(killed.lost_ns(), 100'000'000) << i;
    for (std::size_t n = 0; n < killed.saved_ns.size(); ++n) {
      ASSERT_EQ(killed.saved[n], n + 1) << "a hole, kill " << i;
      ASSERT_EQ(killed.saved_ns[n], static_cast<std::int64_t>(n + 1) * 1'000'000) << "a hole, kill " << i;
    }
  }
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace bus::log
