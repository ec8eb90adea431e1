#include "core/messages/trace.hpp"

#include <gtest/gtest.h>

#include "core/clock.hpp"

namespace core {
namespace {

TEST(Trace, StampsOfALongWayStayInOrder) {
  Trace trace{1, 5 * core::kNanosecondsPerSecond, {}};
  for (const std::int64_t s : {6, 7, 8, 10}) trace.Add(Stage::kFrameDone, s * core::kNanosecondsPerSecond);
  EXPECT_EQ(trace.stamps[0].offset_ns, core::kNanosecondsPerSecond);
  EXPECT_EQ(trace.stamps[1].offset_ns, 2 * core::kNanosecondsPerSecond);
  EXPECT_EQ(trace.stamps[2].offset_ns, std::numeric_limits<std::int32_t>::max());
  EXPECT_EQ(trace.stamps[3].offset_ns, trace.stamps[2].offset_ns);
}

}  // namespace
}  // namespace core
