#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace bus::log {

// Records of an MCAP file (specification version 0): magic, records, magic. A record is u8 opcode, u64 length, content;
// everything is little endian; a text is u32 length and UTF-8, a map or array starts with its length in bytes. Times
// are nanoseconds, here of CLOCK_MONOTONIC of the recording machine.
inline constexpr std::array<std::uint8_t, 8> kMcapMagic = {0x89, 'M', 'C', 'A', 'P', '0', '\r', '\n'};
constexpr std::size_t kRecordHeadBytes = 9;

enum class Opcode : std::uint8_t {
  kHeader = 0x01,
  kFooter = 0x02,
  kSchema = 0x03,
  kChannel = 0x04,
  kMessage = 0x05,
  kChunk = 0x06,
  kMessageIndex = 0x07,
  kChunkIndex = 0x08,
  kAttachment = 0x09,
  kAttachmentIndex = 0x0a,
  kStatistics = 0x0b,
  kMetadata = 0x0c,
  kMetadataIndex = 0x0d,
  kSummaryOffset = 0x0e,
  kDataEnd = 0x0f,
};

using Bytes = std::vector<std::uint8_t>;
using TextMap = std::map<std::string, std::string>;

inline Bytes ToBytes(const std::string& text) {
  return {text.begin(), text.end()};
}

struct Header {
  static constexpr Opcode kOpcode = Opcode::kHeader;
  std::string profile, library;
};
struct Footer {
  static constexpr Opcode kOpcode = Opcode::kFooter;
  std::uint64_t summary_start = 0, summary_offset_start = 0;
  std::uint32_t summary_crc = 0;
};
struct Schema {
  static constexpr Opcode kOpcode = Opcode::kSchema;
  std::uint16_t id = 0;
  std::string name, encoding;
  Bytes data;
};
struct Channel {
  static constexpr Opcode kOpcode = Opcode::kChannel;
  std::uint16_t id = 0, schema_id = 0;
  std::string topic, message_encoding;
  TextMap metadata;
};
struct Message {
  static constexpr Opcode kOpcode = Opcode::kMessage;
  std::uint16_t channel_id = 0;
  std::uint32_t sequence = 0;
  std::uint64_t log_time_ns = 0, publish_time_ns = 0;
  Bytes data;
};
struct Chunk {
  static constexpr Opcode kOpcode = Opcode::kChunk;
  std::uint64_t first_ns = 0, last_ns = 0, uncompressed_size = 0;
  std::uint32_t uncompressed_crc = 0;  // 0: not given
  std::string compression;
  Bytes records;
};
struct MessageIndex {
  static constexpr Opcode kOpcode = Opcode::kMessageIndex;
  std::uint16_t channel_id = 0;
  std::vector<std::pair<std::uint64_t, std::uint64_t>> entries;  // log time, offset in the chunk's records
};
struct ChunkIndex {
  static constexpr Opcode kOpcode = Opcode::kChunkIndex;
  std::uint64_t first_ns = 0, last_ns = 0, chunk_start = 0, chunk_length = 0;
  std::map<std::uint16_t, std::uint64_t> message_index_offsets;
  std::uint64_t message_index_length = 0;
  std::string compression;
  std::uint64_t compressed_size = 0, uncompressed_size = 0;
};
struct Attachment {
  static constexpr Opcode kOpcode = Opcode::kAttachment;
  std::uint64_t log_time_ns = 0, create_time_ns = 0;
  std::string name, media_type;
  Bytes data;
};
struct AttachmentIndex {
  static constexpr Opcode kOpcode = Opcode::kAttachmentIndex;
  std::uint64_t offset = 0, length = 0, log_time_ns = 0, create_time_ns = 0, data_size = 0;
  std::string name, media_type;
};
struct Statistics {
  static constexpr Opcode kOpcode = Opcode::kStatistics;
  std::uint64_t message_count = 0;
  std::uint16_t schema_count = 0;
  std::uint32_t channel_count = 0, attachment_count = 0, metadata_count = 0, chunk_count = 0;
  std::uint64_t first_ns = 0, last_ns = 0;
  std::map<std::uint16_t, std::uint64_t> channel_message_counts;
};
struct Metadata {
  static constexpr Opcode kOpcode = Opcode::kMetadata;
  std::string name;
  TextMap entries;
};
struct MetadataIndex {
  static constexpr Opcode kOpcode = Opcode::kMetadataIndex;
  std::uint64_t offset = 0, length = 0;
  std::string name;
};
struct SummaryOffset {
  static constexpr Opcode kOpcode = Opcode::kSummaryOffset;
  Opcode group = Opcode::kSchema;
  std::uint64_t group_start = 0, group_length = 0;
};
struct DataEnd {
  static constexpr Opcode kOpcode = Opcode::kDataEnd;
  std::uint32_t data_section_crc = 0;  // 0: not given
};

// Appends a whole record, head included.
template <class Record>
void AppendRecord(const Record& record, Bytes* out);

// From a record's content. False: too short, lengths that contradict each other, or an attachment whose checksum is
// wrong. Bytes after the known fields are ignored, as the specification requires.
template <class Record>
bool ReadRecord(std::span<const std::uint8_t> content, Record* out);

// IEEE CRC-32 of zlib, continued from `start`.
std::uint32_t Crc32(std::span<const std::uint8_t> bytes, std::uint32_t start = 0);

}  // namespace bus::log
