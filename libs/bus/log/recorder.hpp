#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "bus/log/clock_channel.hpp"
#include "bus/log/mcap_writer.hpp"
#include "bus/node.hpp"

namespace bus::log {

// When a recording continues in another file; 0: never.
struct Split {
  std::uint64_t bytes = 0;
  std::int64_t age_ns = 0;
};

// Of a command line, --split_MB and --split_s; empty: never. Errors: kInvalidInput.
core::Result<Split> ReadSplit(const std::string& megabytes, const std::string& seconds);

// Writes an observer's messages to MCAP files: a channel for every topic and writer, payloads as on the bus, and their
// descriptors. Log time is the arrival at the observer, by its own clock; publish time is the envelope's, by the
// writer's clock (log time where there is none). Both are CLOCK_MONOTONIC; "clock/<node>" holds their offsets
// (WriteClocks). A split message is one message per part; the envelope behind the payload gives the part
// (recorded_payload.hpp).
class Recorder {
 public:
  // Loss when the process is killed; shorter periods would make more and smaller chunks.
  static constexpr std::int64_t kFlushPeriod_ns = 100'000'000;

  // `about`: the subject of the recording; written first, then `more`, at the front of every part. Errors: kIo.
  static core::Result<std::unique_ptr<Recorder>> Create(const std::filesystem::path& path, const TextMap& about,
                                                        const std::vector<Metadata>& more = {}, Split split = {});

  core::Result<void> Add(const Observation& observation);
  // Metadata that becomes known later: written here, and at the front of every following part.
  core::Result<void> Write(const Metadata& metadata);
  core::Result<void> Write(const Attachment& attachment);  // in this part only
  // Writes the clock samples of the observer `node` when they are due. Call it with every Tick.
  core::Result<void> WriteClocks(const Node& node, std::int64_t now_ns);
  // Call it at least every kFlushPeriod_ns, with or without messages. `num_dropped`: observations that the node had to
  // drop so far; an increase is written as a record "dropped", so that no loss is silent.
  core::Result<void> Tick(std::int64_t now_ns, std::uint64_t num_dropped);
  core::Result<void> Close(std::int64_t now_ns, std::uint64_t num_dropped);

  [[nodiscard]] std::uint64_t num_messages() const { return num_messages_; }
  [[nodiscard]] std::uint64_t num_bytes() const { return num_bytes_before_ + writer_->num_bytes(); }
  // "run.mcap", then "run.1.mcap", "run.2.mcap", ...
  [[nodiscard]] const std::vector<std::filesystem::path>& files() const { return files_; }

 private:
  Recorder(std::filesystem::path path, std::vector<Metadata> front, Split split)
      : path_(std::move(path)), front_(std::move(front)), split_(split) {}
  core::Result<void> Open();
  std::uint16_t ChannelOf(const Observation& observation);

  std::filesystem::path path_;
  std::vector<Metadata> front_;
  Split split_;
  std::unique_ptr<McapWriter> writer_;
  std::vector<std::filesystem::path> files_;
  std::map<MessageType, std::uint16_t> schemas_;                           // of this part
  std::map<std::pair<std::string, std::string>, std::uint16_t> channels_;  // topic, writer
  ClockChannel clocks_;
  std::int64_t begun_ns_ = 0;  // of this part; 0: at the next Tick
  std::int64_t flushed_ns_ = 0;
  std::uint64_t num_dropped_ = 0;
  std::uint64_t num_messages_ = 0;      // of observations
  std::uint64_t num_bytes_before_ = 0;  // in earlier parts
};

}  // namespace bus::log
