#include "core/messages/trace.hpp"

#include <gtest/gtest.h>

namespace core {
namespace {

constexpr std::int64_t kSecond_ns = 1'000'000'000;

TEST(Trace, StampsOfALongWayStayInOrder) {
  Trace trace{1, 5 * kSecond_ns, {}};
  for (const std::int64_t s : {6, 7, 8, 10}) trace.Add(Stage::kFrameDone, s * kSecond_ns);
  EXPECT_EQ(trace.stamps[0].offset_ns, kSecond_ns);
  EXPECT_EQ(trace.stamps[1].offset_ns, 2 * kSecond_ns);
  EXPECT_EQ(trace.stamps[2].offset_ns, std::numeric_limits<std::int32_t>::max());
  EXPECT_EQ(trace.stamps[3].offset_ns, trace.stamps[2].offset_ns);
}

}  // namespace
}  // namespace core
