#include "bus/log/merge_mcap.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "bus/log/clock_series.hpp"
#include "bus/log/compare_mcap.hpp"
#include "bus/log/mcap_indexed_reader.hpp"
#include "bus/log/mcap_writer.hpp"
#include "bus/topics.hpp"
#include "bus/wire/schema.hpp"
#include "proto/physics.pb.h"
#include "proto/recording.pb.h"

namespace bus::log {
namespace {

class MergeTest : public ::testing::Test {
 protected:
  MergeTest() { std::filesystem::create_directories(folder_); }
  ~MergeTest() override { std::filesystem::remove_all(folder_); }
  [[nodiscard]] std::filesystem::path File(const std::string& name) const { return folder_ / name; }

  // A recording of one node: reactions at these times, their tick the place in the list plus `first_tick`.
  struct Options {
    std::string node;
    std::string clock_id;
    std::vector<std::int64_t> times_ns;
    std::uint64_t first_tick = 0;
    std::string peer{};          // of clock samples
    std::int64_t offset_ns = 0;  // peer's clock minus own
    std::int64_t taken_ns = 0;   // publish time of a message of the peer, taken at the last time; 0: none
    bool is_closed = true;
  };
  std::filesystem::path Write(const std::string& name, const Options& o) const {
    const auto path = File(name);
    auto writer = std::move(*McapWriter::Create(path, {"", "test"}));
    EXPECT_TRUE(writer->Write(Metadata{"recording", {{"node", o.node}}}));
    EXPECT_TRUE(writer->Write(Metadata{"host", {{"clock_id", o.clock_id}, {"node", o.node}}}));
    EXPECT_TRUE(writer->Write(Attachment{0, 0, "scenario.xml", "application/xml", {'<', '>'}}));
    const auto schema = writer->AddSchema("oos.Reaction", "protobuf", ToBytes(DescriptorSetOf(MessageType::kReaction)));
    const auto reactions = writer->AddChannel(schema, "physics/right/reaction", "protobuf",
                                              {{"writer", o.node}, {"tap", "sent"}, {"class", "LATEST"}});
    std::uint32_t sequence = 0;
    for (const std::int64_t time_ns : o.times_ns) {
      oos::Reaction reaction;
      reaction.set_tick(o.first_tick + sequence);
      const auto time = static_cast<std::uint64_t>(time_ns);
      EXPECT_TRUE(writer->Write(Message{reactions, ++sequence, time, time, ToBytes(reaction.SerializeAsString())}));
    }
    if (!o.peer.empty()) {
      const auto clocks =
          writer->AddSchema("oos.ClockSample", "protobuf", ToBytes(DescriptorSetOf(*oos::ClockSample::descriptor())));
      const auto channel = writer->AddChannel(clocks, "clock/" + o.node, "protobuf", {{"tap", "clock"}});
      oos::ClockSample sample;
      sample.set_peer(o.peer);
      sample.set_offset_ns(o.offset_ns);
      sample.set_bound_ns(25);
      const auto time = static_cast<std::uint64_t>(o.times_ns.front());
      EXPECT_TRUE(writer->Write(Message{channel, 1, time, time, ToBytes(sample.SerializeAsString())}));
    }
    if (o.taken_ns != 0) {
      const auto taken =
          writer->AddSchema("oos.TakenSample", "protobuf", ToBytes(DescriptorSetOf(*oos::TakenSample::descriptor())));
      const auto channel = writer->AddChannel(taken, "taken/" + o.node + "/x", "protobuf", {{"tap", "taken"}});
      oos::TakenSample sample;
      sample.set_node(TopicId(o.peer));
      EXPECT_TRUE(writer->Write(Message{channel, 9, static_cast<std::uint64_t>(o.times_ns.back()),
                                        static_cast<std::uint64_t>(o.taken_ns), ToBytes(sample.SerializeAsString())}));
    }
    if (o.is_closed) {
      EXPECT_TRUE(writer->Close());
    } else {
      EXPECT_TRUE(writer->Flush());
    }
    return path;
  }

  // "writer sequence @ time" of the reactions in a file.
  static std::vector<std::string> Listed(const std::filesystem::path& path) {
    std::vector<std::string> list;
    auto reader = McapIndexedReader::Open(path);
    EXPECT_TRUE(reader) << (reader ? "" : reader.error().detail);
    if (!reader) return list;
    EXPECT_TRUE(reader->ReadMessages([&](const Channel& channel, const Message& message) {
      if (channel.topic == "physics/right/reaction") {
        list.push_back(channel.metadata.at("writer") + " " + std::to_string(message.sequence) + " @ " +
                       std::to_string(message.log_time_ns));
      }
      return true;
    }));
    return list;
  }

 private:
  std::filesystem::path folder_ =
      std::filesystem::path(::testing::TempDir()) / ("merge_test" + std::to_string(::getpid()));
};

TEST_F(MergeTest, OrdersByTimeAndThenAsTheFilesAreGiven) {
  const auto a = Write("a.mcap", {.node = "a", .clock_id = "m1", .times_ns = {1000, 3000, 3000, 5000}});
  const auto b = Write("b.mcap", {.node = "b", .clock_id = "m1", .times_ns = {2000, 3000, 9000}});
  const auto merge = MergeMcap({a, b}, File("ab.mcap"));
  ASSERT_TRUE(merge) << merge.error().detail;
  EXPECT_EQ(merge->num_messages, 7U);
  EXPECT_EQ(merge->num_machines, 1U);
  EXPECT_EQ(Listed(File("ab.mcap")), (std::vector<std::string>{"a 1 @ 1000", "b 1 @ 2000", "a 2 @ 3000", "a 3 @ 3000",
                                                               "b 2 @ 3000", "a 4 @ 5000", "b 3 @ 9000"}));
  const auto contents = ReadMcap(File("ab.mcap"), [](const Channel&, const Message&) {});
  ASSERT_TRUE(contents) << contents.error().detail;
  EXPECT_EQ(contents->schemas.size(), 1U);
  EXPECT_EQ(contents->channels.size(), 2U);
  EXPECT_EQ(contents->attachments.size(), 1U) << "the same text once";
  EXPECT_EQ(contents->metadata.at(0).name, "merged");
  EXPECT_EQ(contents->metadata.size(), 5U);
}

TEST_F(MergeTest, ConvertsTimesToTheFirstMachinesClock) {
  // b's clock is 1 s ahead of a's; b measured it. Either file as the reference gives the same order.
  const auto a = Write("a.mcap", {.node = "a", .clock_id = "m1", .times_ns = {1000, 3000}});
  const auto b = Write("b.mcap", {.node = "b",
                                  .clock_id = "m2",
                                  .times_ns = {1'000'002'000, 1'000'004'000},
                                  .peer = "a",
                                  .offset_ns = -1'000'000'000,
                                  .taken_ns = 2500});
  auto merge = MergeMcap({a, b}, File("ab.mcap"));
  ASSERT_TRUE(merge) << merge.error().detail;
  EXPECT_EQ(merge->bound_ns, 25);
  EXPECT_EQ(merge->num_machines, 2U);
  EXPECT_EQ(Listed(File("ab.mcap")),
            (std::vector<std::string>{"a 1 @ 1000", "b 1 @ 2000", "a 2 @ 3000", "b 2 @ 4000"}));
  merge = MergeMcap({b, a}, File("ba.mcap"));
  ASSERT_TRUE(merge) << merge.error().detail;
  EXPECT_EQ(Listed(File("ba.mcap")),
            (std::vector<std::string>{"a 1 @ 1000001000", "b 1 @ 1000002000", "a 2 @ 1000003000", "b 2 @ 1000004000"}));
  // A message of a that b took has a's publish time, which stays.
  bool is_seen = false;
  ASSERT_TRUE(ReadMcap(File("ab.mcap"), [&](const Channel& channel, const Message& message) {
    if (channel.topic != "taken/b/x") return;
    is_seen = true;
    EXPECT_EQ(message.publish_time_ns, 2500U);
    EXPECT_EQ(message.log_time_ns, 4000U);
  }));
  EXPECT_TRUE(is_seen);
}

// An observer's recording has no taps: publish times are by clocks of machines without a recording of their own.
TEST_F(MergeTest, ConvertsWriterTimesInAnObserversRecordingToItsClock) {
  {
    auto writer = std::move(*McapWriter::Create(File("heard.mcap"), {"", "test"}));
    ASSERT_TRUE(writer->Write(Metadata{"recording", {{"node", "oos-record-1"}}}));
    ASSERT_TRUE(writer->Write(Metadata{"host", {{"clock_id", "m1"}, {"node", "oos-record-1"}}}));
    const auto schema =
        writer->AddSchema("oos.ClockSample", "protobuf", ToBytes(DescriptorSetOf(*oos::ClockSample::descriptor())));
    const auto clocks = writer->AddChannel(schema, "clock/oos-record-1", "protobuf", {{"tap", "clock"}});
    const auto far = writer->AddChannel(0, "far", "protobuf", {{"writer", "physics_node"}, {"class", "LATEST"}});
    const auto near = writer->AddChannel(0, "near", "protobuf", {{"writer", "logic_node"}, {"class", "LATEST"}});
    const auto unknown = writer->AddChannel(0, "unknown", "protobuf", {{"writer", "x"}, {"class", "LATEST"}});
    const auto add_clock = [&](const std::string& peer, std::int64_t offset_ns, std::int64_t bound_ns) {
      oos::ClockSample sample;
      sample.set_peer(peer);
      sample.set_offset_ns(offset_ns);
      sample.set_bound_ns(bound_ns);
      return writer->Write(Message{clocks, 1, 1000, 1000, ToBytes(sample.SerializeAsString())}).has_value();
    };
    ASSERT_TRUE(add_clock("physics_node", 1'000'000'000, 40));
    ASSERT_TRUE(add_clock("logic_node", 0, 0));
    ASSERT_TRUE(writer->Write(Message{far, 1, 2000, 1'000'001'900, {}}));
    ASSERT_TRUE(writer->Write(Message{near, 1, 2100, 2050, {}}));
    ASSERT_TRUE(writer->Write(Message{unknown, 1, 2200, 2150, {}}));
    ASSERT_TRUE(writer->Close());
  }
  const auto merge = MergeMcap({File("heard.mcap")}, File("merged.mcap"));
  ASSERT_TRUE(merge) << merge.error().detail;
  std::map<std::string, std::pair<std::uint64_t, std::uint64_t>> times;
  const auto contents = ReadMcap(File("merged.mcap"), [&](const Channel& channel, const Message& message) {
    times[channel.topic] = {message.log_time_ns, message.publish_time_ns};
  });
  ASSERT_TRUE(contents) << contents.error().detail;
  EXPECT_EQ(times.at("far"), (std::pair<std::uint64_t, std::uint64_t>{2000, 1900}));
  EXPECT_EQ(times.at("near"), (std::pair<std::uint64_t, std::uint64_t>{2100, 2050}));
  EXPECT_EQ(times.at("unknown"), (std::pair<std::uint64_t, std::uint64_t>{2200, 2150}));
  EXPECT_EQ(contents->metadata.at(0).entries.at("the machine of physics_node"), "bound_ns=40");
}

TEST_F(MergeTest, RefusesClocksThatWereNeverCompared) {
  const auto a = Write("a.mcap", {.node = "a", .clock_id = "m1", .times_ns = {1000}});
  const auto b = Write("b.mcap", {.node = "b", .clock_id = "m2", .times_ns = {2000}});
  const auto merge = MergeMcap({a, b}, File("ab.mcap"));
  ASSERT_FALSE(merge);
  EXPECT_NE(merge.error().detail.find("the clock of b's machine"), std::string::npos) << merge.error().detail;
  EXPECT_FALSE(std::filesystem::exists(File("ab.mcap")));
}

TEST_F(MergeTest, IncludesTheRecordingOfANodeThatDied) {
  const auto a = Write("a.mcap", {.node = "a", .clock_id = "m1", .times_ns = {1000, 3000}});
  const auto b = Write("b.mcap", {.node = "b", .clock_id = "m1", .times_ns = {2000}, .is_closed = false});
  const auto merge = MergeMcap({a, b}, File("ab.mcap"));
  ASSERT_TRUE(merge) << merge.error().detail;
  EXPECT_EQ(merge->num_messages, 3U);
  EXPECT_EQ(merge->incomplete, std::vector<std::string>{b.string()});
}

TEST(ClockSeries, InterpolatesLinearlyAndChainsMachines) {
  ClockSeries clocks;
  clocks.AddNode("a", "m1");
  clocks.AddNode("b", "m2");
  clocks.AddNode("c", "m3");
  clocks.Add("b", "a", {0, -100, 5});
  clocks.Add("b", "a", {1000, -200, 7});
  clocks.Add("b", "c", {0, 50, 9});
  ASSERT_TRUE(clocks.SetReference("m1"));
  EXPECT_EQ(clocks.ToReference("m1", 500), 500);
  EXPECT_EQ(clocks.ToReference("m2", -10), -110);
  EXPECT_EQ(clocks.ToReference("m2", 500), 350);
  EXPECT_EQ(clocks.ToReference("m2", 2000), 1800);
  EXPECT_EQ(clocks.ToReference("m3", 550), 350);
  EXPECT_EQ(clocks.BoundOf("m3"), 16);
  EXPECT_EQ(clocks.BoundOf("m1"), 0);
}

TEST_F(MergeTest, ComparisonNamesTheFirstMessageAndFieldThatDiffer) {
  const auto a = Write("a.mcap", {.node = "a", .clock_id = "m1", .times_ns = {1000, 2000, 3000}, .first_tick = 10});
  const auto b = Write("b.mcap", {.node = "a", .clock_id = "m1", .times_ns = {7000, 8000, 9000}, .first_tick = 10});
  auto comparison = CompareMcap(a, b);
  ASSERT_TRUE(comparison) << comparison.error().detail;
  EXPECT_TRUE(comparison->is_same()) << "times do not count";
  EXPECT_EQ(comparison->channels.at(0).num_a, 3U);

  const auto c =
      Write("c.mcap", {.node = "a", .clock_id = "m1", .times_ns = {1000, 2000, 3000, 4000}, .first_tick = 11});
  comparison = CompareMcap(a, c);
  ASSERT_TRUE(comparison) << comparison.error().detail;
  ASSERT_FALSE(comparison->is_same());
  EXPECT_EQ(comparison->first->topic, "physics/right/reaction");
  EXPECT_EQ(comparison->first->sequence, 1U);
  EXPECT_EQ(comparison->first->log_time_ns, 1000U);
  EXPECT_NE(comparison->first->what.find("tick: 10 -> 11"), std::string::npos) << comparison->first->what;
  EXPECT_EQ(comparison->channels.at(0).num_different, 3U);
  EXPECT_EQ(comparison->channels.at(0).num_only_b, 1U);
  EXPECT_TRUE(CompareMcap(a, c, "device/*")->is_same()) << "nothing of that kind is in them";
}

}  // namespace
}  // namespace bus::log
