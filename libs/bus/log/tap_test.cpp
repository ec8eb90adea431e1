#include "bus/log/tap.hpp"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>
#include <string>
#include <thread>

#include "bus/log/mcap_reader.hpp"
#include "bus/log/recorded_payload.hpp"
#include "bus/log/tap_recorder.hpp"
#include "bus/wire/schema.hpp"
#include "proto/physics.pb.h"
#include "proto/recording.pb.h"

namespace bus::log {
namespace {

std::span<const std::uint8_t> BytesOf(const std::string& text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

std::span<const std::uint8_t> BytesOf(const Envelope& envelope) {
  return {reinterpret_cast<const std::uint8_t*>(&envelope), sizeof envelope};
}

TapTopic Topic(TapKind kind, const std::string& name, TopicClass topic_class, MessageType type) {
  return {kind, name, topic_class, SchemaOf(type).name, DescriptorSetOf(type)};
}

TEST(Tap, GivesEntriesBackInOrderAroundTheRingsEnd) {
  Tap tap(1024);
  const std::uint16_t slot = tap.AddTopic({});
  std::uint64_t sent = 0;
  std::uint64_t got = 0;
  for (int round = 0; round < 200; ++round) {
    for (int i = 0; i < 3; ++i) {
      const std::string payload(sent * 7 % 100, static_cast<char>('a' + sent % 26));
      tap.Put(slot, sent, static_cast<std::int64_t>(sent), 0, BytesOf(std::string("key")), BytesOf(payload));
      ++sent;
    }
    tap.Drain([&](const TapHead& entry, std::span<const std::uint8_t> head, std::span<const std::uint8_t> payload) {
      EXPECT_EQ(entry.sequence, got);
      EXPECT_EQ(std::string(head.begin(), head.end()), "key");
      EXPECT_EQ(std::string(payload.begin(), payload.end()),
                std::string(got * 7 % 100, static_cast<char>('a' + got % 26)));
      ++got;
    });
  }
  EXPECT_EQ(got, sent);
  EXPECT_EQ(tap.dropped(slot), 0U);
}

TEST(Tap, CountsWhatDoesNotFitByTopic) {
  Tap tap(1024);
  const std::uint16_t a = tap.AddTopic({});
  const std::uint16_t b = tap.AddTopic({});
  const std::string payload(400, 'x');
  for (const std::uint16_t slot : {a, a, b, b, a}) tap.Put(slot, 1, 0, 0, {}, BytesOf(payload));
  int got = 0;
  tap.Drain([&](const TapHead&, std::span<const std::uint8_t>, std::span<const std::uint8_t>) { ++got; });
  EXPECT_EQ(got, 2);
  EXPECT_EQ(tap.dropped(a), 1U);
  EXPECT_EQ(tap.dropped(b), 2U);
  tap.Put(Tap::kNoSlot, 1, 0, 0, {}, {});
  EXPECT_EQ(tap.AddTopic({}), 2U);
}

TEST(Tap, LosesNothingUncountedBetweenTwoThreads) {
  Tap tap(4096);
  const std::uint16_t slot = tap.AddTopic({});
  constexpr std::uint64_t kEntries = 200'000;
  std::uint64_t got = 0;
  std::uint64_t last = 0;
  bool is_ordered = true;
  const auto drain = [&] {
    tap.Drain([&](const TapHead& entry, std::span<const std::uint8_t>, std::span<const std::uint8_t> payload) {
      is_ordered = is_ordered && entry.sequence > last && payload.size() == entry.sequence % 61;
      last = entry.sequence;
      ++got;
    });
  };
  std::thread producer([&] {
    const std::string payload(61, 'x');
    for (std::uint64_t i = 1; i <= kEntries; ++i) tap.Put(slot, i, 0, 0, {}, BytesOf(payload).first(i % 61));
  });
  while (last < kEntries && got + tap.dropped(slot) < kEntries) drain();
  producer.join();
  drain();
  EXPECT_TRUE(is_ordered);
  EXPECT_EQ(got + tap.dropped(slot), kEntries);
}

TEST(RecordedPayload, BringsPayloadAndEnvelopeBack) {
  oos::Reaction reaction;
  reaction.set_tick(7);
  const std::string payload = reaction.SerializeAsString();
  Envelope envelope;
  envelope.part = 1;
  envelope.num_parts = 3;
  envelope.boot = 99;
  envelope.header.sequence = 12;
  envelope.header.direct.id = 5;
  for (std::size_t stamps = 0; stamps <= core::kMaxStamps; ++stamps) {
    Bytes recorded(payload.begin(), payload.end());
    AppendEnvelope(envelope, &recorded);
    const RecordedPayload split = SplitRecorded(recorded);
    ASSERT_TRUE(split.has_envelope) << stamps;
    EXPECT_EQ(std::string(split.payload.begin(), split.payload.end()), payload);
    EXPECT_EQ(split.envelope.boot, 99U);
    EXPECT_EQ(split.envelope.part, 1);
    EXPECT_EQ(split.envelope.header.direct.stamps.size(), stamps);
    // Protobuf skips it.
    ASSERT_TRUE(reaction.ParseFromArray(recorded.data(), static_cast<int>(recorded.size())));
    EXPECT_EQ(reaction.tick(), 7U);
    envelope.header.direct.Add(core::Stage::kDeviceSend, 1000);
    envelope.header.through_physics.Add(core::Stage::kDeviceSend, 1000);
  }
  const Bytes plain(payload.begin(), payload.end());
  EXPECT_FALSE(SplitRecorded(plain).has_envelope);
  EXPECT_EQ(SplitRecorded(plain).payload.size(), plain.size());
  EXPECT_FALSE(SplitRecorded({}).has_envelope);
}

class TapWriterTest : public ::testing::Test {
 protected:
  TapWriterTest() { std::filesystem::create_directories(folder_); }
  ~TapWriterTest() override { std::filesystem::remove_all(folder_); }
  std::filesystem::path folder_ =
      std::filesystem::path(::testing::TempDir()) / ("tap_writer" + std::to_string(::getpid()));
  TapFile file_{folder_ / "physics_node.mcap", "physics_node", {{"host", {{"kernel", "6.1"}}}}, {}, 0, 0};
};

TEST_F(TapWriterTest, NamesChannelsByWhatHappened) {
  Tap tap(1 << 16);
  const std::uint16_t sent =
      tap.AddTopic(Topic(TapKind::kSent, "physics/right/reaction", TopicClass::kLatest, MessageType::kReaction));
  const std::uint16_t taken =
      tap.AddTopic(Topic(TapKind::kTaken, "haptic/right/proxy", TopicClass::kLatest, MessageType::kHapticProxy));
  const std::uint16_t state =
      tap.AddTopic(Topic(TapKind::kSent, "figures/physics_node", TopicClass::kState, MessageType::kFigures));
  auto writer = std::move(*TapWriter::Create(file_, &tap, 0));
  tap.SetClocks([] { return std::vector<PeerClock>{{"haptic_node", "other", -5, 40, 1e-6}}; });
  Envelope envelope;
  envelope.header.sequence = 3;
  envelope.header.publish_ns = 900;
  oos::Reaction reaction;
  reaction.set_tick(7);
  tap.Put(taken, 3, 1000, 900, BytesOf(envelope), {});
  tap.Put(sent, 3, 2000, 2000, BytesOf(envelope), BytesOf(reaction.SerializeAsString()));
  tap.Put(state, 1, 3000, 3000, BytesOf(std::string("a")), {});
  tap.Put(state, 2, 4000, 4000, BytesOf(std::string("b")), {});
  ASSERT_TRUE(writer->Close(ClockChannel::kPeriod_ns));

  std::vector<std::string> heard;
  const auto contents = ReadMcap(file_.path, [&](const Channel& channel, const Message& message) {
    const auto key = channel.metadata.find("key");
    heard.push_back(channel.topic + (key == channel.metadata.end() ? "" : "=" + key->second));
    if (channel.topic == "taken/physics_node/haptic/right/proxy") {
      oos::TakenSample sample;
      ASSERT_TRUE(sample.ParseFromArray(message.data.data(), static_cast<int>(message.data.size())));
      EXPECT_EQ(sample.sequence(), 3U);
      EXPECT_EQ(sample.received_ns(), 1000);
    }
    if (channel.topic == "clock/physics_node") {
      oos::ClockSample sample;
      ASSERT_TRUE(sample.ParseFromArray(message.data.data(), static_cast<int>(message.data.size())));
      EXPECT_EQ(sample.offset_ns(), -5);
      EXPECT_EQ(sample.peer(), "haptic_node");
    }
    if (channel.topic == "physics/right/reaction") {
      EXPECT_EQ(channel.metadata.at("writer"), "physics_node");
      EXPECT_TRUE(SplitRecorded(message.data).has_envelope);
    }
  });
  ASSERT_TRUE(contents) << contents.error().detail;
  EXPECT_EQ(heard,
            (std::vector<std::string>{"taken/physics_node/haptic/right/proxy", "physics/right/reaction",
                                      "figures/physics_node=a", "figures/physics_node=b", "clock/physics_node"}));
  EXPECT_EQ(contents->metadata.at(1).entries.at("kernel"), "6.1");
}

TEST_F(TapWriterTest, WritesDownWhatTheRingDropped) {
  Tap tap(1024);
  const std::uint16_t a = tap.AddTopic(Topic(TapKind::kSent, "event", TopicClass::kEvent, MessageType::kEvent));
  const std::uint16_t b = tap.AddTopic(Topic(TapKind::kTaken, "event", TopicClass::kEvent, MessageType::kEvent));
  auto writer = std::move(*TapWriter::Create(file_, &tap, 0));
  const std::string payload(400, 'x');
  for (int i = 0; i < 5; ++i) tap.Put(a, 1, 10, 0, {}, BytesOf(payload));
  writer->Service(20);
  for (int i = 0; i < 4; ++i) tap.Put(b, 1, 30, 0, {}, BytesOf(payload));
  ASSERT_TRUE(writer->Close(40));
  const auto contents = ReadMcap(file_.path, [](const Channel&, const Message&) {});
  ASSERT_TRUE(contents) << contents.error().detail;
  EXPECT_EQ(contents->statistics.message_count, 4U);
  std::vector<TextMap> drops;
  for (const Metadata& metadata : contents->metadata) {
    if (metadata.name == "dropped") drops.push_back(metadata.entries);
  }
  ASSERT_EQ(drops.size(), 2U);
  EXPECT_EQ(drops[0].at("event"), "3");
  EXPECT_EQ(drops[0].at("until_ns"), "20");
  EXPECT_EQ(drops[1].at("taken/physics_node/event"), "2");
  EXPECT_EQ(drops[1].count("event"), 0U);
  EXPECT_EQ(writer->num_dropped(), 5U);
}

TEST_F(TapWriterTest, SplitsBySizeAndByTimeIntoFilesThatStandAlone) {
  for (const bool by_size : {true, false}) {
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_);
    TapFile file = file_;
    if (by_size) {
      file.split_bytes = 20'000;
    } else {
      file.split_ns = 500'000'000;
    }
    file.attachments.push_back({0, 0, "scenario.xml", "application/xml", {'<', '>'}});
    Tap tap(1 << 16);
    const std::uint16_t slot = tap.AddTopic(Topic(TapKind::kSent, "event", TopicClass::kEvent, MessageType::kEvent));
    auto writer = std::move(*TapWriter::Create(file, &tap, 0));
    std::int64_t now_ns = 0;
    for (std::uint64_t i = 1; i <= 200; ++i, now_ns += 10'000'000) {
      tap.Put(slot, i, now_ns, 0, {}, BytesOf(std::string(300, 'x')));
      writer->Service(now_ns);
    }
    ASSERT_TRUE(writer->Close(now_ns));
    EXPECT_GE(writer->files().size(), by_size ? 3U : 4U);
    EXPECT_EQ(writer->files().at(1).filename(), "physics_node.1.mcap");
    std::uint64_t next = 1;
    for (const auto& path : writer->files()) {
      const auto contents = ReadMcap(path, [&](const Channel&, const Message& m) { EXPECT_EQ(m.sequence, next++); });
      ASSERT_TRUE(contents) << contents.error().detail;
      EXPECT_TRUE(contents->has_summary);
      EXPECT_EQ(contents->metadata.at(0).name, "recording");
      EXPECT_EQ(contents->metadata.at(1).name, "host");
      EXPECT_EQ(contents->attachments.size(), path == file.path ? 1U : 0U);
    }
    EXPECT_EQ(next, 201U);
  }
}

// The file is at most 100 ms behind at any time.
TEST_F(TapWriterTest, WhatIsOlderThan100msIsInTheFile) {
  Tap tap(1 << 20);
  const std::uint16_t slot = tap.AddTopic(Topic(TapKind::kSent, "event", TopicClass::kEvent, MessageType::kEvent));
  auto writer = std::move(*TapWriter::Create(file_, &tap, 0));
  std::int64_t now_ns = 0;
  for (std::uint64_t i = 1; i <= 400; ++i, now_ns += 1'000'000) {
    tap.Put(slot, i, now_ns, 0, {}, {});
    if (now_ns % TapWriter::kService_ns == 0) writer->Service(now_ns);
    if (i % 37 != 0) continue;
    std::uint64_t last = 0;
    ASSERT_TRUE(ReadMcap(file_.path, [&](const Channel&, const Message& m) { last = m.log_time_ns; }));
    EXPECT_LE(now_ns - static_cast<std::int64_t>(last), 60'000'000);
  }
}

TEST_F(TapWriterTest, ARecorderWritesDownWhatIsPutUntilItIsStopped) {
  auto recorder = std::move(*TapRecorder::Create(file_));
  Tap* tap = recorder->tap();
  const std::uint16_t slot = tap->AddTopic(Topic(TapKind::kSent, "event", TopicClass::kEvent, MessageType::kEvent));
  for (std::uint64_t i = 1; i <= 5000; ++i) tap->Put(slot, i, static_cast<std::int64_t>(i), 0, {}, {});
  ASSERT_TRUE(recorder->Stop());
  const auto contents = ReadMcap(file_.path, [](const Channel&, const Message&) {});
  ASSERT_TRUE(contents) << contents.error().detail;
  EXPECT_EQ(contents->statistics.message_count, 5000U);
  EXPECT_FALSE(TapRecorder::Create(file_)) << "the file is there already";
}

// A full disk must not block the node, and is reported.
TEST_F(TapWriterTest, AFullDiskIsReportedAndLostMessagesAreCounted) {
  Tap tap(1 << 20);
  const std::uint16_t slot = tap.AddTopic(Topic(TapKind::kSent, "event", TopicClass::kEvent, MessageType::kEvent));
  auto writer = std::move(*TapWriter::Create(file_, &tap, 0));
  rlimit before{};
  getrlimit(RLIMIT_FSIZE, &before);
  rlimit small = before;
  small.rlim_cur = 20'000;
  const auto old_handler = std::signal(SIGXFSZ, SIG_IGN);
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &small), 0);
  std::int64_t now_ns = 0;
  for (std::uint64_t i = 1; i <= 500; ++i, now_ns += 1'000'000) {
    tap.Put(slot, i, now_ns, 0, {}, BytesOf(std::string(100, 'x')));
    if (i % 10 == 0) writer->Service(now_ns);
  }
  const auto closed = writer->Close(now_ns);
  setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, old_handler);
  ASSERT_FALSE(closed);
  EXPECT_NE(closed.error().detail.find("cannot be written"), std::string::npos) << closed.error().detail;
  EXPECT_GT(writer->num_dropped(), 300U);
  EXPECT_EQ(tap.dropped(slot), 0U) << "the ring was emptied all the same";
}

}  // namespace
}  // namespace bus::log
