#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <functional>
#include <limits>
#include <map>
#include <optional>
#include <queue>
#include <string>
#include <vector>

#include "bus/log/mcap_reader.hpp"

namespace bus::log {

// Reads messages by log time with a file's index, and only the chunks that are needed. For a file without an index (its
// writer died, or wrote none) Open builds one.
class McapIndexedReader {
 public:
  // Errors: kIo; kDamaged; kUnsupported, as ReadMcap.
  static core::Result<McapIndexedReader> Open(const std::filesystem::path& path);

  // Next() gives the messages with from_ns <= log time < to_ns from here on, by log time; those of one time in the
  // file's order. False: there are no more. Errors: kDamaged.
  void Seek(std::uint64_t from_ns = 0, std::uint64_t to_ns = std::numeric_limits<std::uint64_t>::max());
  core::Result<bool> Next(Message* message);
  // Visits all messages of that interval; the visitor returns false to stop.
  using Visitor = std::function<bool(const Channel& channel, const Message& message)>;
  core::Result<void> ReadMessages(const Visitor& visit, std::uint64_t from_ns = 0,
                                  std::uint64_t to_ns = std::numeric_limits<std::uint64_t>::max());

  // Complete if the file's summary repeats them, otherwise after all messages were read.
  [[nodiscard]] const std::map<std::uint16_t, Schema>& schemas() const { return schemas_; }
  [[nodiscard]] const std::map<std::uint16_t, Channel>& channels() const { return channels_; }
  [[nodiscard]] const std::optional<Statistics>& statistics() const { return statistics_; }  // as stored in the file
  [[nodiscard]] bool has_index() const { return has_index_; }
  // Metadata records of this name, or all. Attachments likewise. Errors: kDamaged.
  core::Result<std::vector<Metadata>> ReadMetadata(const std::string& name = {});
  core::Result<std::vector<Attachment>> ReadAttachments(const std::string& name = {});

 private:
  struct Placed {
    Message message;
    std::uint64_t offset = 0;  // place in the file's order
    bool operator>(const Placed& other) const {
      return message.log_time_ns != other.message.log_time_ns ? message.log_time_ns > other.message.log_time_ns
                                                              : offset > other.offset;
    }
  };
  core::Result<bool> ReadSummary();
  core::Result<void> ReadAll();
  void AddToIndex(std::span<const std::uint8_t> content, std::uint64_t chunk_start);
  core::Result<Bytes> ReadAt(std::uint64_t offset, std::uint64_t length);
  core::Result<void> ReadChunk(const ChunkIndex& index);
  template <class Record>
  core::Result<Record> ReadRecordAt(std::uint64_t offset, std::uint64_t length, const char* what);
  [[nodiscard]] tl::unexpected<core::Error> Damaged(std::uint64_t at, const std::string& what) const;

  std::filesystem::path path_;
  std::ifstream file_;
  std::uint64_t size_ = 0;
  bool has_index_ = false;     // of its own
  bool is_in_memory_ = false;  // its messages
  std::map<std::uint16_t, Schema> schemas_;
  std::map<std::uint16_t, Channel> channels_;
  std::optional<Statistics> statistics_;
  std::vector<ChunkIndex> chunks_;  // by first time
  std::vector<MetadataIndex> metadata_index_;
  std::vector<AttachmentIndex> attachment_index_;
  // State of Next(): messages of open chunks, and the first chunk that is still closed.
  std::uint64_t from_ns_ = 0, to_ns_ = std::numeric_limits<std::uint64_t>::max();
  std::priority_queue<Placed, std::vector<Placed>, std::greater<>> waiting_;
  std::size_t next_ = 0;          // chunk, or message
  std::vector<Placed> messages_;  // in memory
  // For a file without an index.
  std::vector<Metadata> metadata_;
  std::vector<Attachment> attachments_;
};

}  // namespace bus::log
