#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "bus/log/mcap_writer.hpp"
#include "bus/node.hpp"

namespace bus::log {

// Puts what an observer hears into an MCAP file: a channel for every topic and writer, payloads as they were on the
// bus, their descriptors with them. Log time is when the observer got a message, publish time what its envelope says
// (log time where it says nothing), both CLOCK_MONOTONIC. A split message is one message per part; which part stands in
// an envelope behind the payload (recorded_payload.hpp).
class Recorder {
 public:
  // What is not flushed yet is lost when the process is killed.
  static constexpr std::int64_t kFlushPeriod_ns = 100'000'000;

  // `about`: what the recording is of; written first, then `more`. Errors: kIo.
  static core::Result<std::unique_ptr<Recorder>> Create(const std::filesystem::path& path, const TextMap& about,
                                                        const std::vector<Metadata>& more = {});

  core::Result<void> Add(const Observation& observation);
  // Call it at least every kFlushPeriod_ns, with or without messages. `num_dropped`: observations that the node had to
  // drop so far; an increase is written as a record "dropped", so that no loss is silent.
  core::Result<void> Tick(std::int64_t now_ns, std::uint64_t num_dropped);
  core::Result<void> Close(std::int64_t now_ns, std::uint64_t num_dropped);

  [[nodiscard]] std::uint64_t num_messages() const { return writer_->num_messages(); }
  [[nodiscard]] std::uint64_t num_bytes() const { return writer_->num_bytes(); }

 private:
  explicit Recorder(std::unique_ptr<McapWriter> writer) : writer_(std::move(writer)) {}
  std::uint16_t ChannelOf(const Observation& observation);

  std::unique_ptr<McapWriter> writer_;
  std::map<MessageType, std::uint16_t> schemas_;
  std::map<std::pair<std::string, std::string>, std::uint16_t> channels_;  // topic, writer
  std::int64_t flushed_ns_ = 0;
  std::uint64_t num_dropped_ = 0;
};

}  // namespace bus::log
