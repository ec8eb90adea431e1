#include "bus/log/mcap_reader.hpp"

#include <algorithm>
#include <cstring>
#include <memory>
#include <optional>
#include <utility>

#include "bus/log/channel_copier.hpp"
#include "bus/log/mapped_file.hpp"
#include "bus/log/mcap_writer.hpp"
#include "core/hash.hpp"

namespace bus::log {
namespace {

bool HasMagic(std::span<const std::uint8_t> bytes) {
  return bytes.size() >= kMcapMagic.size() && std::equal(kMcapMagic.begin(), kMcapMagic.end(), bytes.begin());
}

struct RawRecord {
  Opcode opcode = Opcode::kHeader;
  std::span<const std::uint8_t> content;
  std::size_t begin = 0, end = 0;  // of the whole record
};

// Empty: no complete record at `at`.
std::optional<RawRecord> RecordAt(std::span<const std::uint8_t> bytes, std::size_t at) {
  if (bytes.size() - at < kRecordHeadBytes) return {};
  std::uint64_t length = 0;
  for (std::size_t i = 0; i < 8; ++i) length |= std::uint64_t{bytes[at + 1 + i]} << 8 * i;
  if (length > bytes.size() - at - kRecordHeadBytes) return {};
  const std::size_t begin = at + kRecordHeadBytes;
  return RawRecord{static_cast<Opcode>(bytes[at]), bytes.subspan(begin, static_cast<std::size_t>(length)), at,
                   begin + static_cast<std::size_t>(length)};
}

bool IsIntact(const Chunk& chunk) {
  return chunk.records.size() == chunk.uncompressed_size &&
         (chunk.uncompressed_crc == 0 || chunk.uncompressed_crc == Crc32(chunk.records));
}

// Takes records at the top or within a chunk.
class Collector {
 public:
  explicit Collector(const MessageVisitor& visit, const RecordVisitor& visit_record = {})
      : visit_(visit), visit_record_(visit_record) {}

  // Null, or the error.
  const char* Take(const RawRecord& record) {
    switch (record.opcode) {
      case Opcode::kHeader:
        return Read<Header>(record, "the header cannot be read",
                            [this](Header& header) { contents.header = std::move(header); });
      case Opcode::kSchema: {
        Schema schema;
        if (!ReadRecord(record.content, &schema) || schema.id == 0) return "a schema that cannot be read";
        Report(schema);
        contents.schemas[schema.id] = std::move(schema);
        return nullptr;
      }
      case Opcode::kChannel: {
        Channel channel;
        if (!ReadRecord(record.content, &channel)) return "a channel that cannot be read";
        if (channel.schema_id != 0 && !contents.schemas.contains(channel.schema_id)) return "a channel without schema";
        Report(channel);
        contents.channels[channel.id] = std::move(channel);
        return nullptr;
      }
      case Opcode::kMessage:
        return TakeMessage(record.content);
      case Opcode::kMetadata:
        return Read<Metadata>(record, "metadata that cannot be read",
                              [this](Metadata& metadata) { contents.metadata.push_back(std::move(metadata)); });
      case Opcode::kAttachment:
        return Read<Attachment>(record, "a damaged attachment", [this](Attachment& attachment) {
          contents.attachments.push_back(std::move(attachment));
        });
      case Opcode::kAttachmentIndex:
        return Read<AttachmentIndex>(record, "an attachment's index that cannot be read");
      case Opcode::kMetadataIndex:
        return Read<MetadataIndex>(record, "a metadata index that cannot be read");
      case Opcode::kChunkIndex:
        return Read<ChunkIndex>(record, "a chunk's index that cannot be read");
      case Opcode::kStatistics:
        return Read<Statistics>(record, "statistics that cannot be read");
      case Opcode::kSummaryOffset:
        return Read<SummaryOffset>(record, "a summary offset that cannot be read");
      case Opcode::kDataEnd:
        return Read<DataEnd>(record, "the data's end cannot be read");
      case Opcode::kFooter:
        return Read<Footer>(record, "the footer cannot be read");
      default:
        return nullptr;  // message indices and private records
    }
  }

  // The records of a chunk; those of a truncated one end early.
  const char* TakeAll(std::span<const std::uint8_t> records, bool is_cut) {
    std::size_t at = 0;
    while (at < records.size()) {
      const auto record = RecordAt(records, at);
      if (!record) return is_cut ? nullptr : "a chunk with half a record";
      if (const char* wrong = Take(*record)) return wrong;
      at = record->end;
    }
    return nullptr;
  }

  McapContents contents;

 private:
  const char* TakeMessage(std::span<const std::uint8_t> content) {
    Message message;
    if (!ReadRecord(content, &message)) return "a message that cannot be read";
    const auto channel = contents.channels.find(message.channel_id);
    if (channel == contents.channels.end()) return "a message without channel";
    Statistics& s = contents.statistics;
    const bool is_first = s.message_count++ == 0;
    s.first_ns = is_first ? message.log_time_ns : std::min(s.first_ns, message.log_time_ns);
    s.last_ns = is_first ? message.log_time_ns : std::max(s.last_ns, message.log_time_ns);
    ++s.channel_message_counts[message.channel_id];
    Report(message);
    if (visit_) visit_(channel->second, message);
    return nullptr;
  }

  template <class Record>
  void Report(const Record& record) {
    if (visit_record_) visit_record_(record);
  }
  template <class Record, class Keep>
  const char* Read(const RawRecord& raw, const char* wrong, Keep&& keep) {
    Record record;
    if (!ReadRecord(raw.content, &record)) return wrong;
    Report(record);
    keep(record);
    return nullptr;
  }
  template <class Record>
  const char* Read(const RawRecord& raw, const char* wrong) {
    return Read<Record>(raw, wrong, [](Record&) {});
  }

  const MessageVisitor& visit_;
  const RecordVisitor visit_record_;
};

class StrictReader {
 public:
  StrictReader(const std::filesystem::path& path, std::span<const std::uint8_t> bytes, const MessageVisitor& visit,
               const RecordVisitor& visit_record = {})
      : path_(path), bytes_(bytes), collector_(visit, visit_record) {}

  core::Result<McapContents> Read() {
    if (!HasMagic(bytes_)) return Damaged(0, "this is not an MCAP file");
    std::size_t at = kMcapMagic.size();
    bool is_first = true;
    while (at < bytes_.size()) {
      const auto record = RecordAt(bytes_, at);
      if (!record && HasMagic(bytes_.last(kMcapMagic.size()))) return Damaged(at, "a record beyond the file's end");
      if (!record) return Finish(false);  // cut off
      if (is_first && record->opcode != Opcode::kHeader) return Damaged(at, "the header is missing");
      is_first = false;
      if (record->opcode == Opcode::kDataEnd) return ReadEnd(*record);
      if (auto done = TakeOne(*record); !done) return tl::unexpected(done.error());
      at = record->end;
    }
    return Finish(false);
  }

  [[nodiscard]] const McapContents& so_far() const { return collector_.contents; }

 private:
  McapContents& contents() { return collector_.contents; }
  [[nodiscard]] tl::unexpected<core::Error> Damaged(std::size_t at, const std::string& what) const {
    return core::Fail(core::ErrorCode::kDamaged, path_.string() + ": byte " + std::to_string(at) + ": " + what +
                                                     "; 'oos recover' saves what can be saved");
  }
  core::Result<McapContents> Finish(bool has_summary) {
    McapContents& done = contents();
    done.has_summary = has_summary;
    done.statistics.schema_count = static_cast<std::uint16_t>(done.schemas.size());
    done.statistics.channel_count = static_cast<std::uint32_t>(done.channels.size());
    done.statistics.attachment_count = static_cast<std::uint32_t>(done.attachments.size());
    done.statistics.metadata_count = static_cast<std::uint32_t>(done.metadata.size());
    return std::move(done);
  }

  core::Result<void> TakeOne(const RawRecord& record) {
    if (record.opcode != Opcode::kChunk) {
      if (const char* wrong = collector_.Take(record)) return Damaged(record.begin, wrong);
      return {};
    }
    Chunk chunk;
    if (!ReadRecord(record.content, &chunk)) return Damaged(record.begin, "a chunk that cannot be read");
    if (!chunk.compression.empty()) {
      return core::Fail(core::ErrorCode::kUnsupported,
                        path_.string() + ": its chunks are compressed with " + chunk.compression +
                            "; recordings of this system are not: convert it with the MCAP command line tool");
    }
    if (!IsIntact(chunk)) return Damaged(record.begin, "a chunk whose checksum is wrong");
    ++contents().statistics.chunk_count;
    if (const char* wrong = collector_.TakeAll(chunk.records, false)) return Damaged(record.begin, wrong);
    return {};
  }

  // From the end of the data section to the end of the file.
  core::Result<McapContents> ReadEnd(const RawRecord& data_end) {
    DataEnd end;
    if (!ReadRecord(data_end.content, &end)) return Damaged(data_end.begin, "the data's end cannot be read");
    if (end.data_section_crc != 0 && end.data_section_crc != Crc32(bytes_.first(data_end.begin))) {
      return Damaged(data_end.begin, "the data's checksum is wrong");
    }
    (void)collector_.Take(data_end);
    for (std::size_t at = data_end.end; at < bytes_.size();) {
      const auto record = RecordAt(bytes_, at);
      if (!record) return Finish(false);
      if (record->opcode == Opcode::kFooter) return ReadFooter(*record);
      if (const char* wrong = collector_.Take(*record)) return Damaged(at, wrong);
      at = record->end;
    }
    return Finish(false);
  }
  core::Result<McapContents> ReadFooter(const RawRecord& record) {
    Footer footer;
    if (!ReadRecord(record.content, &footer)) return Damaged(record.begin, "the footer cannot be read");
    if (!HasMagic(bytes_.subspan(record.end))) return Finish(false);
    const std::size_t begin = footer.summary_start == 0 ? record.begin : static_cast<std::size_t>(footer.summary_start);
    const std::size_t end = record.end - sizeof footer.summary_crc;
    if (begin > end) return Damaged(record.begin, "the footer names a summary behind itself");
    if (footer.summary_crc != 0 && footer.summary_crc != Crc32(bytes_.subspan(begin, end - begin))) {
      return Damaged(begin, "the summary's checksum is wrong");
    }
    (void)collector_.Take(record);
    return Finish(true);
  }

  const std::filesystem::path& path_;
  std::span<const std::uint8_t> bytes_;
  Collector collector_;
};

// Collects the sound records, in the file's order.
class Salvager {
 public:
  Salvager(std::span<const std::uint8_t> bytes, const MessageVisitor& visit) : bytes_(bytes), collector_(visit) {}

  void Salvage() {
    std::size_t at = HasMagic(bytes_) ? kMcapMagic.size() : 0;
    while (at < bytes_.size()) {
      const auto record = RecordAt(bytes_, at);
      if (record && IsKnown(*record)) {
        if (record->opcode == Opcode::kFooter) return;
        TakeOne(*record);
        at = record->end;
        continue;
      }
      const std::size_t next = FindChunk(at + 1);
      if (next == bytes_.size() && TakeCutChunk(at)) return;
      recovery.num_skipped_bytes += next - at;
      at = next;
    }
  }

  McapRecovery recovery;
  [[nodiscard]] const McapContents& so_far() const { return collector_.contents; }

 private:
  // Whether this can be a record: a damaged length leads into the middle of another one.
  [[nodiscard]] bool IsKnown(const RawRecord& record) const {
    if (record.opcode < Opcode::kHeader || record.opcode > Opcode::kDataEnd) return false;
    if (record.end == bytes_.size()) return true;
    const std::uint8_t next = bytes_[record.end];
    if (record.opcode == Opcode::kFooter) return HasMagic(bytes_.subspan(record.end));
    return next >= static_cast<std::uint8_t>(Opcode::kHeader) && next <= static_cast<std::uint8_t>(Opcode::kDataEnd);
  }

  void TakeOne(const RawRecord& record) {
    if (record.opcode == Opcode::kChunk) {
      Chunk chunk;
      if (!ReadRecord(record.content, &chunk) || !chunk.compression.empty() || !IsIntact(chunk)) {
        ++recovery.num_damaged_chunks;
        return;
      }
      if (collector_.TakeAll(chunk.records, false) != nullptr) ++recovery.num_damaged_chunks;
    } else {
      (void)collector_.Take(record);
    }
  }

  // The next chunk whose checksum is right.
  [[nodiscard]] std::size_t FindChunk(std::size_t from) const {
    for (std::size_t at = from; at < bytes_.size(); ++at) {
      if (bytes_[at] != static_cast<std::uint8_t>(Opcode::kChunk)) continue;
      const auto record = RecordAt(bytes_, at);
      Chunk chunk;
      if (record && ReadRecord(record->content, &chunk) && chunk.uncompressed_crc != 0 && IsIntact(chunk)) return at;
    }
    return bytes_.size();
  }

  // The complete messages of a truncated chunk. Its checksum cannot be used, so only their lengths are checked.
  bool TakeCutChunk(std::size_t at) {
    // first, last and uncompressed size, checksum, no compression, length
    constexpr std::size_t kChunkHeadBytes = 8 + 8 + 8 + 4 + 4 + 8;
    const std::size_t begin = at + kRecordHeadBytes + kChunkHeadBytes;
    if (bytes_.size() < begin || bytes_[at] != static_cast<std::uint8_t>(Opcode::kChunk)) return false;
    std::uint64_t size = 0;
    std::uint64_t length = 0;
    for (std::size_t i = 0; i < 8; ++i) {
      size |= std::uint64_t{bytes_[at + kRecordHeadBytes + 16 + i]} << 8 * i;
      length |= std::uint64_t{bytes_[begin - 8 + i]} << 8 * i;
    }
    if (size != length || size <= bytes_.size() - begin) return false;  // compressed, or no chunk
    (void)collector_.TakeAll(bytes_.subspan(begin), true);
    return true;
  }

  std::span<const std::uint8_t> bytes_;
  Collector collector_;
};

// Digest of a sequence of messages.
class Digest {
 public:
  void Add(const Channel& channel, const Message& message) {
    const std::uint64_t numbers[] = {value_, message.sequence, message.log_time_ns, message.publish_time_ns};
    value_ = core::Hash64(numbers, sizeof numbers, core::Hash64(channel.topic));
    value_ = core::Hash64(message.data.data(), message.data.size(), value_);
    ++count_;
  }
  [[nodiscard]] std::uint64_t count() const { return count_; }
  bool operator==(const Digest&) const = default;

 private:
  std::uint64_t value_ = 0, count_ = 0;
};

// The output of RecoverMcap, written message by message: a recording need not fit into memory.
class RecoveredFile {
 public:
  explicit RecoveredFile(std::filesystem::path path) : path_(std::move(path)) {}
  RecoveredFile(const RecoveredFile&) = delete;
  RecoveredFile& operator=(const RecoveredFile&) = delete;
  ~RecoveredFile() {
    std::error_code error;
    if (writer_ != nullptr && !is_good_)
      std::filesystem::remove(path_, error);  // no incomplete recovery is left behind
  }

  // `so_far`: the contents before the message, including its schema.
  void Add(const McapContents& so_far, const Channel& channel, const Message& message) {
    if (error_) return;
    if (writer_ == nullptr && !Note(Create(so_far.header))) return;
    const auto schema = so_far.schemas.find(channel.schema_id);
    const Schema* its = schema == so_far.schemas.end() ? nullptr : &schema->second;
    if (Note(copier_->Copy(0, channel, its, message))) digest_.Add(channel, message);
  }

  // After the last message: verifies the file by reading it back. Returns the number of messages; kDamaged: none.
  core::Result<std::uint64_t> Finish(const McapContents& contents, const std::filesystem::path& from) {
    if (error_) return tl::unexpected(*error_);
    if (writer_ == nullptr) {
      return core::Fail(core::ErrorCode::kDamaged, from.string() + ": not one message could be saved");
    }
    for (const Metadata& metadata : contents.metadata) {
      if (auto done = writer_->Write(metadata); !done) return tl::unexpected(done.error());
    }
    for (const Attachment& attachment : contents.attachments) {
      if (auto done = writer_->Write(attachment); !done) return tl::unexpected(done.error());
    }
    if (auto done = writer_->Close(); !done) return tl::unexpected(done.error());
    Digest again;
    const auto read =
        ReadMcap(path_, [&](const Channel& channel, const Message& message) { again.Add(channel, message); });
    if (!read) return tl::unexpected(read.error());
    if (again != digest_ || !read->has_summary) {
      return core::Fail(core::ErrorCode::kIo,
                        path_.string() + ": does not read back as it was written; is the disk full?");
    }
    is_good_ = true;
    return digest_.count();
  }

 private:
  core::Result<void> Create(const Header& header) {
    auto writer = McapWriter::Create(path_, header);
    if (!writer) return tl::unexpected(writer.error());
    writer_ = std::move(*writer);
    copier_.emplace(writer_.get());
    return {};
  }
  bool Note(core::Result<void> done) {
    if (!done) error_ = done.error();
    return done.has_value();
  }

  std::filesystem::path path_;
  std::unique_ptr<McapWriter> writer_;
  std::optional<ChannelCopier> copier_;
  Digest digest_;
  std::optional<core::Error> error_;
  bool is_good_ = false;
};

}  // namespace

core::Result<McapContents> ReadMcap(const std::filesystem::path& path, const MessageVisitor& visit) {
  const auto file = MappedFile::Open(path);
  if (!file) return tl::unexpected(file.error());
  return StrictReader(path, file->bytes(), visit).Read();
}

core::Result<McapContents> ReadMcapRecords(const std::filesystem::path& path, const RecordVisitor& visit) {
  const auto file = MappedFile::Open(path);
  if (!file) return tl::unexpected(file.error());
  const MessageVisitor none;
  return StrictReader(path, file->bytes(), none, visit).Read();
}

core::Result<McapRecovery> RecoverMcap(const std::filesystem::path& from, const std::filesystem::path& to) {
  const auto file = MappedFile::Open(from);
  if (!file) return tl::unexpected(file.error());
  // An intact file may hold private records, which the salvager would treat as damage.
  const MessageVisitor none;
  const auto whole = StrictReader(from, file->bytes(), none).Read();
  McapRecovery recovery;
  recovery.was_whole = whole && whole->has_summary;
  RecoveredFile recovered(to);
  const McapContents* so_far = nullptr;
  const MessageVisitor copy = [&](const Channel& channel, const Message& message) {
    recovered.Add(*so_far, channel, message);
  };
  core::Result<std::uint64_t> num_messages = std::uint64_t{0};
  if (recovery.was_whole) {
    StrictReader reader(from, file->bytes(), copy);
    so_far = &reader.so_far();
    const auto again = reader.Read();
    if (!again) return tl::unexpected(again.error());
    num_messages = recovered.Finish(*again, from);
  } else {
    Salvager salvager(file->bytes(), copy);
    so_far = &salvager.so_far();
    salvager.Salvage();
    recovery.num_damaged_chunks = salvager.recovery.num_damaged_chunks;
    recovery.num_skipped_bytes = salvager.recovery.num_skipped_bytes;
    num_messages = recovered.Finish(salvager.so_far(), from);
  }
  if (!num_messages) return tl::unexpected(num_messages.error());
  recovery.num_messages = *num_messages;
  return recovery;
}

}  // namespace bus::log
