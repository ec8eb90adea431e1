#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "bus/log/clock_channel.hpp"
#include "bus/log/mcap_writer.hpp"
#include "bus/log/tap.hpp"

namespace bus::log {

struct TapFile {
  std::filesystem::path path;  // "out/haptic_node.mcap"; the parts behind it: haptic_node.1.mcap, haptic_node.2.mcap
  std::string node;
  std::vector<Metadata> metadata;       // at the front of every part
  std::vector<Attachment> attachments;  // in the first part
  std::uint64_t split_bytes = 0;        // a new part when this one is larger; 0: never
  std::int64_t split_ns = 0;            // or older
};

// Writes a tap to MCAP files. Channels: the topic's own name for sent messages, "taken/<node>/<topic>" for received
// ones, "step/<node>" for steps, "clock/<node>" for the peers' clocks; metadata of a channel: class, tap (sent, taken,
// step), node, and key where there is one. Entries that the tap dropped become a record "dropped" with the counts by
// topic. Log time is the node's CLOCK_MONOTONIC; messages are in the order in which they happened.
class TapWriter {
 public:
  // Serviced at least every kService_ns, a killed node loses 50 ms of its recording, and at most 100 ms on a busy
  // machine.
  static constexpr std::int64_t kService_ns = 10'000'000;
  static constexpr std::int64_t kFlushPeriod_ns = 40'000'000;

  // Errors: kIo, e.g. the file exists.
  static core::Result<std::unique_ptr<TapWriter>> Create(TapFile file, Tap* tap, std::int64_t now_ns);

  // Takes what is in the tap; flushes and splits when it is time. After an error (disk full) the tap is still emptied
  // and its entries count as dropped; Close returns the error.
  void Service(std::int64_t now_ns);
  core::Result<void> Close(std::int64_t now_ns);

  [[nodiscard]] std::uint64_t num_messages() const { return num_messages_; }
  [[nodiscard]] std::uint64_t num_dropped() const { return num_dropped_; }
  [[nodiscard]] const std::vector<std::filesystem::path>& files() const { return files_; }

 private:
  TapWriter(TapFile file, Tap* tap) : file_(std::move(file)), tap_(tap) {}
  core::Result<void> Open(std::int64_t now_ns);
  core::Result<void> Write(const TapHead& entry, std::span<const std::uint8_t> head,
                           std::span<const std::uint8_t> payload);
  std::uint16_t ChannelOf(std::uint16_t slot, const std::string& key);
  std::uint16_t SchemaNamed(const std::string& name, const std::string& descriptors);
  core::Result<void> WriteDrops(std::int64_t now_ns);
  void Note(core::Result<void> done);

  TapFile file_;
  Tap* tap_;
  std::unique_ptr<McapWriter> writer_;
  std::vector<std::filesystem::path> files_;
  std::map<std::string, std::uint16_t> schemas_;                             // of this part
  std::map<std::pair<std::uint16_t, std::string>, std::uint16_t> channels_;  // slot, key
  ClockChannel clocks_;
  std::vector<std::uint64_t> reported_drops_;  // by slot
  std::vector<std::uint64_t> unwritten_;       // by slot, after an error
  std::optional<core::Error> error_;
  std::int64_t begun_ns_ = 0;
  std::int64_t flushed_ns_ = 0;
  std::uint64_t num_messages_ = 0;
  std::uint64_t num_dropped_ = 0;
};

}  // namespace bus::log
