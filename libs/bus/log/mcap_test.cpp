#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "bus/log/mcap_reader.hpp"
#include "bus/log/mcap_writer.hpp"

namespace bus::log {
namespace {

class McapTest : public ::testing::Test {
 protected:
  McapTest() { std::filesystem::create_directories(folder_); }
  ~McapTest() override { std::filesystem::remove_all(folder_); }
  [[nodiscard]] std::filesystem::path File(const std::string& name) const { return folder_ / name; }

  // Two channels of one schema; `per_chunk` messages between flushes. Message i is (topic, i, bytes of i).
  void WriteSample(const std::filesystem::path& path, int num_messages, int per_chunk, bool is_closed = true) const {
    std::filesystem::remove(path);
    auto writer = std::move(*McapWriter::Create(path, {"", "test"}));
    const std::uint16_t schema = writer->AddSchema("oos.Sample", "protobuf", {1, 2, 3});
    const std::uint16_t channels[2] = {writer->AddChannel(schema, "a/state", "protobuf", {{"class", "LATEST"}}),
                                       writer->AddChannel(0, "b", "json", {})};
    ASSERT_TRUE(writer->Write(Metadata{"scenario", {{"name", "touch"}}}));
    for (int i = 0; i < num_messages; ++i) {
      ASSERT_TRUE(writer->Write(MessageOf(channels[i % 2], i)));
      if (i % per_chunk == per_chunk - 1) {
        ASSERT_TRUE(writer->Flush());
      }
    }
    if (!is_closed) {
      ASSERT_TRUE(writer->Flush());
      return;
    }
    ASSERT_TRUE(writer->Write(Attachment{5, 6, "scenario.xml", "application/xml", {'<', '>'}}));
    ASSERT_TRUE(writer->Close());
  }
  static Message MessageOf(std::uint16_t channel, int i) {
    // Sometimes out of order by one, as with two publishers.
    const auto time = static_cast<std::uint64_t>(1000 * (i ^ 1));
    return {channel, static_cast<std::uint32_t>(i), time, time + 7, Bytes(static_cast<std::size_t>(i % 5), 0xa0)};
  }

  static Bytes Load(const std::filesystem::path& path) {
    std::ifstream in(path, std::ios::binary);
    return Bytes((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
  }
  static void Store(const std::filesystem::path& path, const Bytes& bytes, std::size_t size) {
    std::ofstream out(path, std::ios::binary | std::ios::trunc);
    out.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(size));
  }
  // Sequence numbers in the file's order.
  static std::vector<int> SequencesOf(const std::filesystem::path& path) {
    std::vector<int> sequences;
    const auto read = ReadMcap(path, [&](const Channel&, const Message& m) { sequences.push_back(int(m.sequence)); });
    EXPECT_TRUE(read) << (read ? "" : read.error().detail);
    return sequences;
  }
  std::vector<int> Recovered(const std::filesystem::path& from) const {
    const auto to = File("recovered.mcap");
    std::filesystem::remove(to);
    return RecoverMcap(from, to) ? SequencesOf(to) : std::vector<int>{};
  }

 private:
  // In memory where possible: thousands of files are synced.
  std::filesystem::path folder_ =
      std::filesystem::path(std::filesystem::exists("/dev/shm") ? "/dev/shm" : ::testing::TempDir()) /
      ("mcap_test" + std::to_string(::getpid()));
};

std::vector<int> Range(int begin, int end) {
  std::vector<int> range;
  for (int i = begin; i < end; ++i) range.push_back(i);
  return range;
}

TEST_F(McapTest, ReadsBackWhatItWrote) {
  WriteSample(File("a.mcap"), 20, 6);
  int next = 0;
  const auto contents = ReadMcap(File("a.mcap"), [&](const Channel& channel, const Message& message) {
    const Message wanted = MessageOf(static_cast<std::uint16_t>(next % 2), next);
    EXPECT_EQ(channel.topic, next % 2 == 0 ? "a/state" : "b");
    EXPECT_EQ(message.sequence, wanted.sequence);
    EXPECT_EQ(message.log_time_ns, wanted.log_time_ns);
    EXPECT_EQ(message.publish_time_ns, wanted.publish_time_ns);
    EXPECT_EQ(message.data, wanted.data);
    ++next;
  });
  ASSERT_TRUE(contents) << contents.error().detail;
  EXPECT_EQ(next, 20);
  EXPECT_TRUE(contents->has_summary);
  EXPECT_EQ(contents->header.library, "test");
  EXPECT_EQ(contents->schemas.at(1).data, (Bytes{1, 2, 3}));
  EXPECT_EQ(contents->channels.at(0).metadata.at("class"), "LATEST");
  EXPECT_EQ(contents->metadata.at(0).entries.at("name"), "touch");
  EXPECT_EQ(contents->attachments.at(0).name, "scenario.xml");
  EXPECT_EQ(contents->statistics.chunk_count, 4U);
  EXPECT_EQ(contents->statistics.message_count, 20U);
  EXPECT_EQ(contents->statistics.last_ns, 19000U);
}

TEST_F(McapTest, AWriterThatDiedLeavesWhatItFlushed) {
  WriteSample(File("a.mcap"), 20, 6, false);
  const auto contents = ReadMcap(File("a.mcap"), [](const Channel&, const Message&) {});
  ASSERT_TRUE(contents) << contents.error().detail;
  EXPECT_FALSE(contents->has_summary);
  EXPECT_EQ(contents->statistics.message_count, 20U);
}

TEST_F(McapTest, AnExistingFileIsNotOverwritten) {
  WriteSample(File("a.mcap"), 2, 2);
  const Bytes before = Load(File("a.mcap"));
  EXPECT_FALSE(McapWriter::Create(File("a.mcap"), {}));
  EXPECT_EQ(Load(File("a.mcap")), before);
}

// The ends of the records of chunks, and of the messages in them, determine what must survive.
TEST_F(McapTest, RecoveryAfterATruncationAtEveryByteSavesEveryWholeMessage) {
  WriteSample(File("a.mcap"), 12, 4);
  const Bytes bytes = Load(File("a.mcap"));
  std::vector<std::size_t> message_ends;
  for (int i = 0; i < 12; ++i) {
    Bytes record;
    AppendRecord(MessageOf(static_cast<std::uint16_t>(i % 2), i), &record);
    const auto found = std::search(bytes.begin(), bytes.end(), record.begin(), record.end());
    ASSERT_NE(found, bytes.end()) << i;
    message_ends.push_back(static_cast<std::size_t>(found - bytes.begin()) + record.size());
  }
  for (std::size_t size = 0; size <= bytes.size(); ++size) {
    Store(File("cut.mcap"), bytes, size);
    int expected = 0;
    while (expected < 12 && message_ends[static_cast<std::size_t>(expected)] <= size) ++expected;
    ASSERT_EQ(Recovered(File("cut.mcap")), Range(0, expected)) << "cut at " << size;
  }
}

TEST_F(McapTest, RecoveryAfterAnyFlippedBitOfAChunkLosesNoOtherChunk) {
  WriteSample(File("a.mcap"), 12, 4);
  const Bytes bytes = Load(File("a.mcap"));
  // The second chunk: of messages 4 to 7.
  std::vector<std::size_t> chunks;
  for (std::size_t at = kMcapMagic.size(); at + kRecordHeadBytes < bytes.size();) {
    std::uint64_t length = 0;
    for (std::size_t i = 0; i < 8; ++i) length |= std::uint64_t{bytes[at + 1 + i]} << 8 * i;
    if (bytes[at] == static_cast<std::uint8_t>(Opcode::kChunk)) chunks.push_back(at);
    at += kRecordHeadBytes + static_cast<std::size_t>(length);
    if (chunks.size() == 2) {
      chunks.push_back(at);
      break;
    }
  }
  ASSERT_EQ(chunks.size(), 3U);
  const std::vector<int> all = Range(0, 12);
  std::vector<int> others = Range(0, 4);
  for (const int i : Range(8, 12)) others.push_back(i);
  for (std::size_t at = chunks[1]; at < chunks[2]; ++at) {
    for (int bit = 0; bit < 8; ++bit) {
      Bytes damaged = bytes;
      damaged[at] ^= static_cast<std::uint8_t>(1 << bit);
      Store(File("flipped.mcap"), damaged, damaged.size());
      EXPECT_FALSE(ReadMcap(File("flipped.mcap"), [](const Channel&, const Message&) {})) << at << " bit " << bit;
      const std::vector<int> saved = Recovered(File("flipped.mcap"));
      // The times in the chunk's head are not covered by a checksum: a flip there loses nothing.
      ASSERT_TRUE(saved == others || saved == all) << "byte " << at << " bit " << bit;
    }
  }
}

TEST_F(McapTest, WhatIsNoRecordingIsRefusedByName) {
  Store(File("text.mcap"), {'h', 'e', 'l', 'l', 'o', ' ', 'y', 'o', 'u'}, 9);
  const auto read = ReadMcap(File("text.mcap"), [](const Channel&, const Message&) {});
  ASSERT_FALSE(read);
  EXPECT_NE(read.error().detail.find("text.mcap: byte 0: this is not an MCAP file"), std::string::npos);
  EXPECT_FALSE(RecoverMcap(File("text.mcap"), File("b.mcap")));
  EXPECT_FALSE(std::filesystem::exists(File("b.mcap")));
  EXPECT_FALSE(ReadMcap(File("missing.mcap"), [](const Channel&, const Message&) {}));
}

}  // namespace
}  // namespace bus::log
