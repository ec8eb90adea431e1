#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <variant>
#include <vector>

#include "bus/log/mcap_records.hpp"
#include "core/result.hpp"

namespace bus::log {

// What a file holds besides its messages.
struct McapContents {
  Header header;
  std::map<std::uint16_t, Schema> schemas;
  std::map<std::uint16_t, Channel> channels;
  std::vector<Metadata> metadata;
  std::vector<Attachment> attachments;
  Statistics statistics;  // counted while reading
  bool has_summary = false;
};

// In the file's order. `channel` stays valid during the call.
using MessageVisitor = std::function<void(const Channel& channel, const Message& message)>;

// Reads a whole file from the front and checks every checksum in it. A file whose writer died has no summary: that is
// not an error (has_summary is false). Errors: kIo; kDamaged with the byte where it is; kUnsupported (compressed
// chunks).
core::Result<McapContents> ReadMcap(const std::filesystem::path& path, const MessageVisitor& visit);

// The same, with every record in the file's order: those within chunks too, but chunks and message indices left out.
using AnyRecord = std::variant<Header, Footer, Schema, Channel, Message, Attachment, AttachmentIndex, Statistics,
                               Metadata, MetadataIndex, ChunkIndex, SummaryOffset, DataEnd>;
using RecordVisitor = std::function<void(const AnyRecord& record)>;
core::Result<McapContents> ReadMcapRecords(const std::filesystem::path& path, const RecordVisitor& visit);

struct McapRecovery {
  std::uint64_t num_messages = 0;
  std::uint64_t num_damaged_chunks = 0;  // left out: their checksum is wrong
  std::uint64_t num_skipped_bytes = 0;   // between readable records
  bool was_whole = false;                // nothing was missing
};

// Recovers a truncated or damaged file into `to`, which must not exist, and verifies it by reading it back. Of a
// truncated chunk the complete messages are saved. Errors: kIo; kDamaged (no MCAP file, or not one message).
core::Result<McapRecovery> RecoverMcap(const std::filesystem::path& from, const std::filesystem::path& to);

}  // namespace bus::log
