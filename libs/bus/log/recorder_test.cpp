#include "bus/log/recorder.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <set>

#include "bus/log/mcap_reader.hpp"
#include "bus/log/payload_decoder.hpp"
#include "bus/registry.hpp"
#include "bus/schema.hpp"
#include "proto/physics.pb.h"

namespace bus::log {
namespace {

class RecorderTest : public ::testing::Test {
 protected:
  ~RecorderTest() override { std::filesystem::remove(path_); }
  std::filesystem::path path_ =
      std::filesystem::path(::testing::TempDir()) / ("recorder" + std::to_string(::getpid()) + ".mcap");
};

Observation Reaction(const std::string& writer, std::uint64_t sequence, double force_N) {
  oos::Reaction reaction;
  for (int i = 0; i < 6; ++i) reaction.add_f_do_w(i == 0 ? force_N : 0.0);
  Observation o;
  o.topic = "physics/right/reaction";
  o.writer = writer;
  o.sequence = sequence;
  o.publish_ns = static_cast<std::int64_t>(1000 * sequence);
  o.received_ns = o.publish_ns + 50;
  o.type = MessageType::kReaction;
  o.payload = reaction.SerializeAsString();
  return o;
}

TEST_F(RecorderTest, PayloadsAreReadByTheDescriptorsInTheFile) {
  auto recorder = std::move(*Recorder::Create(path_, {{"session", "7"}}));
  ASSERT_TRUE(recorder->Add(Reaction("physics_node", 1, 2.5)));
  ASSERT_TRUE(recorder->Add(Reaction("physics_node", 2, -4.0)));
  ASSERT_TRUE(recorder->Close(0, 0));
  std::vector<std::pair<Channel, Message>> messages;
  const auto contents =
      ReadMcap(path_, [&](const Channel& channel, const Message& m) { messages.emplace_back(channel, m); });
  ASSERT_TRUE(contents) << contents.error().detail;
  ASSERT_EQ(messages.size(), 2U);
  EXPECT_EQ(messages[1].second.log_time_ns, 2050U);
  EXPECT_EQ(messages[1].second.publish_time_ns, 2000U);
  EXPECT_EQ(messages[0].first.metadata.at("writer"), "physics_node");
  EXPECT_EQ(contents->metadata.at(0).entries.at("session"), "7");
  PayloadDecoder decoder;
  const auto json = decoder.ToJson(contents->schemas.at(messages[1].first.schema_id), messages[1].second.data);
  ASSERT_TRUE(json) << json.error().detail;
  EXPECT_NE(json->find("-4"), std::string::npos) << *json;
  EXPECT_FALSE(decoder.ToJson({9, "oos.Missing", "protobuf", {}}, messages[1].second.data));
  EXPECT_FALSE(decoder.ToJson({10, "x", "json", {}}, messages[1].second.data));
}

TEST_F(RecorderTest, WritersOfOneTopicHaveChannelsOfTheirOwn) {
  auto recorder = std::move(*Recorder::Create(path_, {}));
  ASSERT_TRUE(recorder->Add(Reaction("physics_node", 1, 0.0)));
  ASSERT_TRUE(recorder->Add(Reaction("other_node", 1, 0.0)));
  ASSERT_TRUE(recorder->Close(0, 0));
  std::set<std::uint16_t> channels;
  ASSERT_TRUE(ReadMcap(path_, [&](const Channel& channel, const Message&) { channels.insert(channel.id); }));
  EXPECT_EQ(channels.size(), 2U);
}

TEST_F(RecorderTest, WhatIsOlderThanTheFlushPeriodSurvivesADeath) {
  auto recorder = std::move(*Recorder::Create(path_, {}));
  std::uint64_t last = 0;
  std::int64_t now_ns = 1'000'000'000;
  for (std::uint64_t i = 1; i <= 500; ++i, now_ns += 1'000'000) {
    ASSERT_TRUE(recorder->Add(Reaction("physics_node", i, 0.0)));
    if (i % 5 == 0) {
      ASSERT_TRUE(recorder->Tick(now_ns, 0));
    }
  }
  recorder.reset();  // without Close, as a death is
  ASSERT_TRUE(ReadMcap(path_, [&](const Channel&, const Message& m) { last = m.sequence; }));
  EXPECT_GE(last, 400U);
}

TEST_F(RecorderTest, WhatTheNodeDroppedIsWrittenDown) {
  auto recorder = std::move(*Recorder::Create(path_, {}));
  ASSERT_TRUE(recorder->Add(Reaction("physics_node", 1, 0.0)));
  ASSERT_TRUE(recorder->Tick(10, 3));
  ASSERT_TRUE(recorder->Tick(20, 3));
  ASSERT_TRUE(recorder->Close(30, 8));
  const auto contents = ReadMcap(path_, [](const Channel&, const Message&) {});
  ASSERT_TRUE(contents);
  std::uint64_t sum = 0;
  for (const Metadata& metadata : contents->metadata) {
    if (metadata.name == "dropped") sum += std::stoull(metadata.entries.at("count"));
  }
  EXPECT_EQ(sum, 8U);
}

}  // namespace
}  // namespace bus::log
