#include "tools/oos/live/heard_topic.hpp"

#include <gtest/gtest.h>

namespace oos {
namespace {

bus::Observation Message(std::int64_t published_ns, std::int64_t received_ns, std::size_t num_bytes, unsigned part = 0,
                         unsigned num_parts = 1) {
  bus::Observation observation;
  observation.topic = "physics/state";
  observation.writer = "physics_node";
  observation.publish_ns = published_ns;
  observation.received_ns = received_ns;
  observation.num_bytes = num_bytes;
  observation.part = part;
  observation.num_parts = num_parts;
  return observation;
}

TEST(HeardTopic, CountsMessagesNotDatagrams) {
  HeardTopic heard;
  for (std::int64_t i = 0; i < 11; ++i) {
    const std::int64_t now_ns = i * 100'000'000 + (i >= 5 ? 50'000'000 : 0);
    heard.Add(Message(now_ns, now_ns, 1000, 0, 2), 0, 0);
    heard.Add(Message(now_ns, now_ns + 10, 200, 1, 2), 0, 0);
  }
  EXPECT_EQ(heard.num_messages(), 11U);
  EXPECT_NEAR(heard.rate_Hz(), 10.0 / 1.05, 1e-9);
  EXPECT_NEAR(heard.longest_gap_ms(), 150.0, 1e-9);
  EXPECT_EQ(heard.smallest_bytes(), 1200U);
  EXPECT_EQ(heard.largest_bytes(), 1200U);
  EXPECT_EQ(heard.num_bytes(), 11U * 1200U);
}

// A clock that is 5 ms ahead, known within 0.3 ms: what it stamped 105 ms is our 100 ms.
TEST(HeardTopic, DelayIsByThisMachinesClockAndHasABound) {
  HeardTopic heard;
  for (std::int64_t i = 0; i < 100; ++i) {
    heard.Add(Message(105'000'000, 100'000'000 + i * 10'000, 100), 5'000'000, 300'000);
  }
  const HeardTopic::Delay delay = heard.delay();
  EXPECT_EQ(delay.num, 100U);
  EXPECT_NEAR(delay.smallest_ms, 0.0, 1e-12);
  EXPECT_NEAR(delay.median_ms, 0.49, 0.032 * 0.49);
  EXPECT_NEAR(delay.largest_ms, 0.99, 1e-9);
  EXPECT_NEAR(delay.bound_ms, 0.3, 1e-12);
}

// A topic's memory does not grow with time: delays are kept only on request, and as a histogram.
TEST(HeardTopics, DelaysAreKeptOnlyOnRequestAndAsAHistogram) {
  bus::PeerStatus writer;
  writer.name = "physics_node";
  HeardTopics echo(false), delays(true);
  for (std::int64_t i = 0; i < 1000; ++i) {
    echo.Add(Message(0, 1'000'000 + i, 100), {writer});
    delays.Add(Message(0, 1'000'000 + i, 100), {writer});
  }
  EXPECT_EQ(echo.all().at("physics/state").num_messages(), 1000U);
  EXPECT_EQ(echo.all().at("physics/state").delay().num, 0U);
  const HeardTopic::Delay delay = delays.all().at("physics/state").delay();
  EXPECT_EQ(delay.num, 1000U);
  EXPECT_NEAR(delay.p99_ms, 1.001, 0.032);
  EXPECT_GE(delay.p99_ms, 1.0);
}

// By a clock that is known within a bound a message may come before it was sent.
TEST(HeardTopic, ADelayBelowZeroIsShownAsItIs) {
  HeardTopic heard;
  heard.Add(Message(1'200'000, 1'000'000, 100), 0, 300'000);
  EXPECT_NEAR(heard.delay().smallest_ms, -0.2, 1e-12);
  EXPECT_NEAR(heard.delay().largest_ms, -0.2, 1e-12);
}

// Its bytes are those of the later message that it came with.
TEST(HeardTopic, ACopyOfALostMessageIsAMessageButNoDatagram) {
  HeardTopic heard;
  heard.Add(Message(2, 3, 100), 0, 0);
  heard.Add(Message(1, 3, 0), 0, 0);
  EXPECT_EQ(heard.num_messages(), 2U);
  EXPECT_EQ(heard.smallest_bytes(), 100U);
  EXPECT_EQ(heard.num_bytes(), 100U);
}

TEST(HeardTopics, AWriterWhoseClockIsNotKnownHasNoDelay) {
  HeardTopics heard(true);
  bus::PeerStatus other;
  other.name = "haptic_node";
  heard.Add(Message(1, 2, 100), {other});
  EXPECT_EQ(heard.all().at("physics/state").delay().num, 0U);
  EXPECT_EQ(heard.all().at("physics/state").num_without_clock(), 1U);
}

}  // namespace
}  // namespace oos
