#include "bus/log/recorder.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "bus/log/mcap_reader.hpp"
#include "bus/log/payload_decoder.hpp"
#include "bus/membership/registry.hpp"
#include "bus/testing/make_node.hpp"
#include "bus/wire/schema.hpp"
#include "proto/physics.pb.h"
#include "proto/recording.pb.h"

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

TEST_F(RecorderTest, SplitsBySizeAndAgeAndEachPartStandsAlone) {
  const std::vector<Metadata> more = {{"platform", {{"simd", "portable"}}}};
  auto recorder = std::move(*Recorder::Create(path_, {{"session", "7"}}, more, {.bytes = 3000, .age_ns = 0}));
  std::int64_t now_ns = 1'000'000'000;
  for (std::uint64_t i = 1; i <= 60; ++i, now_ns += 10'000'000) {
    ASSERT_TRUE(recorder->Add(Reaction("physics_node", i, 0.0)));
    if (i == 10) {
      ASSERT_TRUE(recorder->Write(Metadata{"hosts", {{"peer", "physics_node"}}}));
    }
    ASSERT_TRUE(recorder->Tick(now_ns, 0));
  }
  ASSERT_TRUE(recorder->Close(now_ns, 0));
  EXPECT_EQ(recorder->num_messages(), 60U);
  const auto files = recorder->files();
  ASSERT_GT(files.size(), 2U);
  EXPECT_EQ(files[1].filename().string(), path_.stem().string() + ".1.mcap");
  std::uint64_t next = 1, num_bytes = 0;
  for (std::size_t part = 0; part < files.size(); ++part) {
    num_bytes += std::filesystem::file_size(files[part]);
    const auto contents = ReadMcap(files[part], [&](const Channel& channel, const Message& message) {
      EXPECT_EQ(channel.topic, "physics/right/reaction");
      EXPECT_EQ(message.sequence, next++);
    });
    ASSERT_TRUE(contents) << contents.error().detail;
    EXPECT_TRUE(contents->has_summary);
    std::map<std::string, TextMap> metadata_of;
    for (const Metadata& metadata : contents->metadata) metadata_of[metadata.name] = metadata.entries;
    EXPECT_EQ(metadata_of.at("recording").at("session"), "7");
    EXPECT_EQ(metadata_of.at("recording").at("part"), std::to_string(part));
    EXPECT_EQ(metadata_of.at("platform").at("simd"), "portable");
    EXPECT_EQ(metadata_of.count("hosts"), 1U) << "part " << part;
    if (part > 0) std::filesystem::remove(files[part]);
  }
  EXPECT_EQ(next, 61U);
  EXPECT_EQ(recorder->num_bytes(), num_bytes);

  const auto aged_path = path_.string() + ".aged.mcap";
  auto aged = std::move(*Recorder::Create(aged_path, {}, {}, {.bytes = 0, .age_ns = 200'000'000}));
  for (std::int64_t i = 1; i <= 60; ++i) {
    ASSERT_TRUE(aged->Tick(10'000'000 * i, 0));
  }
  ASSERT_TRUE(aged->Close(700'000'000, 0));
  EXPECT_EQ(aged->files().size(), 3U);
  for (const auto& file : aged->files()) std::filesystem::remove(file);
}

TEST(RecorderSplit, IsReadFromTheCommandLine) {
  EXPECT_EQ(ReadSplit("", "")->bytes, 0U);
  EXPECT_EQ(ReadSplit("1.5", "")->bytes, 1'500'000U);
  EXPECT_EQ(ReadSplit("", "60")->age_ns, 60'000'000'000);
  for (const char* text : {"-1", "ten", "1x", "nan", "1e10"}) EXPECT_FALSE(ReadSplit(text, "")) << text;
}

TEST_F(RecorderTest, RecordsPeerClocksTwiceASecond) {
  const auto registry = testing::MakeRegistry();
  const auto peer = testing::MakeNode("peer", registry->endpoint());
  const auto observer = testing::MakeNode("observer", registry->endpoint());
  ASSERT_TRUE(peer->Start());
  ASSERT_TRUE(observer->Start());
  ASSERT_TRUE(testing::Until([&] {
    testing::WaitBriefly(*peer);
    testing::WaitBriefly(*observer);
    const auto peers = observer->Peers();
    return std::any_of(peers.begin(), peers.end(),
                       [](const PeerStatus& p) { return p.is_alive && p.clock_bound_ns != INT64_MAX; });
  }));
  auto recorder = std::move(*Recorder::Create(path_, {}));
  for (std::int64_t now_ns = 1'000'000'000; now_ns < 2'000'000'000; now_ns += 10'000'000) {
    ASSERT_TRUE(recorder->WriteClocks(*observer, now_ns));
  }
  ASSERT_TRUE(recorder->Close(2'000'000'000, 0));
  std::vector<std::uint64_t> times_ns;
  ASSERT_TRUE(ReadMcap(path_, [&](const Channel& channel, const Message& message) {
    ASSERT_EQ(channel.topic, "clock/observer");
    oos::ClockSample sample;
    ASSERT_TRUE(sample.ParseFromArray(message.data.data(), static_cast<int>(message.data.size())));
    EXPECT_EQ(sample.peer(), "peer");
    EXPECT_EQ(sample.bound_ns(), 0) << "the peer is on this machine";
    times_ns.push_back(message.log_time_ns);
  }));
  EXPECT_EQ(times_ns, (std::vector<std::uint64_t>{1'000'000'000, 1'500'000'000}));
}

}  // namespace
}  // namespace bus::log
