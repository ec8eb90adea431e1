#include "bus/wire/envelope.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <random>
#include <vector>

#include "bus/wire/codec.hpp"

namespace bus {
namespace {

Envelope MakeEnvelope() {
  Envelope envelope;
  envelope.part = 1;
  envelope.num_parts = 3;
  envelope.topic = TopicId("physics/state");
  envelope.schema_digest = 77;
  envelope.session = 0x1122334455667788;
  envelope.node = 5;
  envelope.boot = 9;
  envelope.header.sequence = 1234;
  envelope.header.publish_ns = 5'000'000'123;
  envelope.header.direct.id = core::MakeTraceId(1, 42);
  envelope.header.direct.origin_ns = 4'999'000'000;
  envelope.header.direct.Add(core::Stage::kDeviceSend, 4'999'010'000);
  envelope.header.direct.Add(core::Stage::kHapticReceive, 4'999'100'000);
  envelope.header.through_physics.id = core::MakeTraceId(0, 40);
  envelope.header.through_physics.origin_ns = 4'990'000'000;
  envelope.header.through_physics.Add(core::Stage::kPhysicsSend, 4'992'000'000);
  return envelope;
}

std::vector<std::uint8_t> Encode(const Envelope& envelope, const std::vector<std::uint8_t>& payload) {
  const std::size_t head = EnvelopeBytes(envelope.header);
  std::vector<std::uint8_t> bytes(head + payload.size());
  std::copy(payload.begin(), payload.end(), bytes.begin() + static_cast<std::ptrdiff_t>(head));
  EXPECT_EQ(WriteEnvelope(envelope, payload.size(), bytes.data()), bytes.size());
  return bytes;
}

TEST(Envelope, GivesBackWhatWasWritten) {
  const Envelope sent = MakeEnvelope();
  const std::vector<std::uint8_t> payload = {1, 2, 3, 4, 5};
  const auto bytes = Encode(sent, payload);
  EXPECT_EQ(bytes.size(), 96u + 3 * 5 + 5);
  const auto message = ParseEnvelope(bytes);
  ASSERT_TRUE(message.has_value()) << message.error().detail;
  const Envelope& got = message->envelope;
  EXPECT_EQ(got.topic_class, sent.topic_class);
  EXPECT_EQ(got.part, 1);
  EXPECT_EQ(got.num_parts, 3);
  EXPECT_EQ(got.topic, sent.topic);
  EXPECT_EQ(got.schema_digest, sent.schema_digest);
  EXPECT_EQ(got.session, sent.session);
  EXPECT_EQ(got.node, sent.node);
  EXPECT_EQ(got.boot, sent.boot);
  EXPECT_EQ(got.header.sequence, sent.header.sequence);
  EXPECT_EQ(got.header.publish_ns, sent.header.publish_ns);
  EXPECT_EQ(got.header.direct.id, sent.header.direct.id);
  EXPECT_EQ(got.header.direct.origin_ns, sent.header.direct.origin_ns);
  ASSERT_EQ(got.header.direct.stamps.size(), 2u);
  EXPECT_EQ(got.header.direct.stamps[1].stage, core::Stage::kHapticReceive);
  EXPECT_EQ(got.header.direct.stamps[1].offset_ns, 100'000);
  ASSERT_EQ(got.header.through_physics.stamps.size(), 1u);
  EXPECT_EQ(got.header.through_physics.stamps[0].offset_ns, 2'000'000);
  EXPECT_EQ(std::vector<std::uint8_t>(message->payload.begin(), message->payload.end()), payload);
}

TEST(Envelope, HasTheDocumentedLayout) {
  const auto bytes = Encode(MakeEnvelope(), {});
  EXPECT_EQ(std::memcmp(bytes.data(), "VOOS", 4), 0);
  EXPECT_EQ(bytes[4], 1);
  EXPECT_EQ(bytes[16], 0x88);  // session, lowest byte first
  EXPECT_EQ(bytes[40], 1234 & 0xff);
}

TEST(Envelope, RefusesEveryTruncation) {
  const auto bytes = Encode(MakeEnvelope(), {1, 2, 3, 4, 5});
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    EXPECT_FALSE(ParseEnvelope(std::span(bytes).first(size)).has_value()) << size;
  }
  auto longer = bytes;
  longer.push_back(0);
  EXPECT_FALSE(ParseEnvelope(longer).has_value());
}

TEST(Envelope, RefusesEveryFlippedBit) {
  auto bytes = Encode(MakeEnvelope(), {1, 2, 3, 4, 5});
  for (std::size_t bit = 0; bit < bytes.size() * 8; ++bit) {
    bytes[bit / 8] ^= static_cast<std::uint8_t>(1 << (bit % 8));
    EXPECT_FALSE(ParseEnvelope(bytes).has_value()) << "bit " << bit;
    bytes[bit / 8] ^= static_cast<std::uint8_t>(1 << (bit % 8));
  }
}

TEST(Envelope, RefusesRandomBytesEvenAfterAValidStart) {
  std::mt19937_64 random(7);
  std::vector<std::uint8_t> bytes;
  for (int round = 0; round < 20'000; ++round) {
    bytes.resize(random() % 1400);
    for (std::uint8_t& byte : bytes) byte = static_cast<std::uint8_t>(random());
    if (round % 2 == 1 && bytes.size() >= 8) std::memcpy(bytes.data(), "VOOS\x01\x01\x00\x01", 8);
    const auto message = ParseEnvelope(bytes);
    ASSERT_FALSE(message.has_value());
    ASSERT_EQ(message.error().code, core::ErrorCode::kDamaged);
  }
}

}  // namespace
}  // namespace bus
