#include "nodes/device_bridge/head/head_watch.hpp"

#include <gtest/gtest.h>

#include <string>

namespace device_bridge {
namespace {

// News as letters, of looks each 8 ms; `poses` says by 'x' at which there was a pose.
std::string NewsOf(const std::string& poses) {
  HeadWatch watch;
  std::string news;
  std::int64_t now_ns = 1'000'000'000;
  for (const char pose : poses) {
    const HeadWatch::News was = watch.Note(now_ns += 8'000'000, pose == 'x');
    if (was != HeadWatch::News::kNone) news += was == HeadWatch::News::kFound ? 'F' : 'L';
  }
  return news;
}

TEST(HeadWatch, TellsOnceThatAHeadIsThereIsLostAndIsBack) {
  const std::string half_a_second(63, '.'), blink(60, '.');
  EXPECT_EQ(NewsOf("x.x.x"), "F");
  EXPECT_EQ(NewsOf("x" + blink + "x" + blink + "x"), "F") << "a hand passes";
  EXPECT_EQ(NewsOf("x" + half_a_second + half_a_second), "FL");
  EXPECT_EQ(NewsOf("x" + half_a_second + "x."), "FLF");
}

TEST(HeadWatch, AHeadThatNeverComesIsLost) {
  EXPECT_EQ(NewsOf(std::string(60, '.')), "");
  EXPECT_EQ(NewsOf(std::string(200, '.')), "L");
}

}  // namespace
}  // namespace device_bridge
