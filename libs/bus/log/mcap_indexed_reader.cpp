#include "bus/log/mcap_indexed_reader.hpp"

#include <algorithm>
#include <utility>

#include "bus/log/mapped_file.hpp"

namespace bus::log {
namespace {

constexpr std::size_t kFooterBytes = kRecordHeadBytes + 8 + 8 + 4;

std::uint64_t ReadLength(std::span<const std::uint8_t> bytes) {
  std::uint64_t length = 0;
  for (std::size_t i = 0; i < 8; ++i) length |= std::uint64_t{bytes[i]} << 8 * i;
  return length;
}

// Calls visit(opcode, content, offset) for each; false: the bytes end within a record, or visit returned false.
template <class Visit>
bool ForEachRecord(std::span<const std::uint8_t> bytes, Visit&& visit) {
  for (std::size_t at = 0; at < bytes.size();) {
    if (bytes.size() - at < kRecordHeadBytes) return false;
    const std::uint64_t length = ReadLength(bytes.subspan(at + 1));
    if (length > bytes.size() - at - kRecordHeadBytes) return false;
    const auto content = bytes.subspan(at + kRecordHeadBytes, static_cast<std::size_t>(length));
    if (!visit(static_cast<Opcode>(bytes[at]), content, at)) return false;
    at += kRecordHeadBytes + static_cast<std::size_t>(length);
  }
  return true;
}

}  // namespace

tl::unexpected<core::Error> McapIndexedReader::Damaged(std::uint64_t at, const std::string& what) const {
  return core::Fail(core::ErrorCode::kDamaged, path_.string() + ": byte " + std::to_string(at) + ": " + what +
                                                   "; 'oos recover' saves what can be saved");
}

core::Result<McapIndexedReader> McapIndexedReader::Open(const std::filesystem::path& path) {
  McapIndexedReader reader;
  reader.path_ = path;
  reader.file_.open(path, std::ios::binary);
  std::error_code error;
  reader.size_ = std::filesystem::file_size(path, error);
  if (!reader.file_ || error) return core::Fail(core::ErrorCode::kIo, path.string() + ": cannot be read");
  auto has_index = reader.ReadSummary();
  if (!has_index) return tl::unexpected(has_index.error());
  reader.has_index_ = *has_index;
  if (!reader.has_index_) {
    if (auto done = reader.ReadAll(); !done) return tl::unexpected(done.error());
  }
  return reader;
}

core::Result<Bytes> McapIndexedReader::ReadAt(std::uint64_t offset, std::uint64_t length) {
  if (offset > size_ || length > size_ - offset) return Damaged(offset, "the index points behind the file's end");
  Bytes bytes(static_cast<std::size_t>(length));
  file_.clear();
  file_.seekg(static_cast<std::streamoff>(offset));
  file_.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(length));
  if (!file_) return core::Fail(core::ErrorCode::kIo, path_.string() + ": cannot be read");
  return bytes;
}

// False: the file has no summary that lists its chunks.
core::Result<bool> McapIndexedReader::ReadSummary() {
  const std::size_t tail_bytes = kFooterBytes + kMcapMagic.size();
  if (size_ < 2 * kMcapMagic.size() + kFooterBytes) return false;
  const auto tail = ReadAt(size_ - tail_bytes, tail_bytes);
  if (!tail) return tl::unexpected(tail.error());
  Footer footer;
  const bool has_footer = std::equal(kMcapMagic.begin(), kMcapMagic.end(), tail->begin() + kFooterBytes) &&
                          (*tail)[0] == static_cast<std::uint8_t>(Opcode::kFooter) &&
                          ReadRecord(std::span(*tail).subspan(kRecordHeadBytes, 20), &footer);
  if (!has_footer || footer.summary_start == 0) return false;
  if (footer.summary_start > size_ - tail_bytes) return Damaged(size_ - tail_bytes, "the footer points behind itself");
  const auto summary = ReadAt(footer.summary_start, size_ - kMcapMagic.size() - footer.summary_start);
  if (!summary) return tl::unexpected(summary.error());
  if (footer.summary_crc != 0 && footer.summary_crc != Crc32(std::span(*summary).first(summary->size() - 4))) {
    return Damaged(footer.summary_start, "the summary's checksum is wrong");
  }
  const bool is_read = ForEachRecord(*summary, [this](Opcode opcode, std::span<const std::uint8_t> content, auto) {
    const auto keep = [&content](auto record, auto&& store) {
      if (!ReadRecord(content, &record)) return false;
      store(std::move(record));
      return true;
    };
    switch (opcode) {
      case Opcode::kSchema:
        return keep(Schema{}, [this](Schema s) { schemas_[s.id] = std::move(s); });
      case Opcode::kChannel:
        return keep(Channel{}, [this](Channel c) { channels_[c.id] = std::move(c); });
      case Opcode::kStatistics:
        return keep(Statistics{}, [this](Statistics s) { statistics_ = std::move(s); });
      case Opcode::kChunkIndex:
        return keep(ChunkIndex{}, [this](ChunkIndex c) { chunks_.push_back(std::move(c)); });
      case Opcode::kMetadataIndex:
        return keep(MetadataIndex{}, [this](MetadataIndex m) { metadata_index_.push_back(std::move(m)); });
      case Opcode::kAttachmentIndex:
        return keep(AttachmentIndex{}, [this](AttachmentIndex a) { attachment_index_.push_back(std::move(a)); });
      default:
        return true;
    }
  });
  if (!is_read) return Damaged(footer.summary_start, "the summary cannot be read");
  std::stable_sort(chunks_.begin(), chunks_.end(),
                   [](const ChunkIndex& a, const ChunkIndex& b) { return a.first_ns < b.first_ns; });
  // Only the statistics show that these chunks and indices are complete.
  const bool is_complete = statistics_ && statistics_->chunk_count == chunks_.size() &&
                           (statistics_->chunk_count > 0 || statistics_->message_count == 0) &&
                           statistics_->metadata_count == metadata_index_.size() &&
                           statistics_->attachment_count == attachment_index_.size();
  return is_complete;
}

// Uses the times of its messages: no checksum covers the times in its head.
void McapIndexedReader::AddToIndex(std::span<const std::uint8_t> content, std::uint64_t chunk_start) {
  constexpr std::size_t kTimeAt = 2 + 4;  // behind channel and sequence
  Chunk chunk;
  if (!ReadRecord(content, &chunk)) return;  // reported by the check of the file
  ChunkIndex index;
  index.chunk_start = chunk_start;
  index.chunk_length = kRecordHeadBytes + content.size();
  index.first_ns = std::numeric_limits<std::uint64_t>::max();
  ForEachRecord(chunk.records, [&index](Opcode opcode, std::span<const std::uint8_t> record, std::size_t) {
    if (opcode != Opcode::kMessage || record.size() < kTimeAt + 8) return true;
    const std::uint64_t time_ns = ReadLength(record.subspan(kTimeAt));
    index.first_ns = std::min(index.first_ns, time_ns);
    index.last_ns = std::max(index.last_ns, time_ns);
    return true;
  });
  chunks_.push_back(std::move(index));
}

// Checks the whole file and builds its index. Messages outside of chunks cannot be indexed: a file with such is kept in
// memory.
core::Result<void> McapIndexedReader::ReadAll() {
  chunks_.clear();
  schemas_.clear();
  channels_.clear();
  statistics_.reset();
  const auto file = MappedFile::Open(path_);
  if (!file) return tl::unexpected(file.error());
  size_ = file->bytes().size();  // it may have grown
  const std::size_t begin = std::min(kMcapMagic.size(), file->bytes().size());
  ForEachRecord(file->bytes().subspan(begin),
                [&](Opcode opcode, std::span<const std::uint8_t> content, std::size_t at) {
                  if (opcode == Opcode::kMessage) is_in_memory_ = true;
                  if (opcode == Opcode::kChunk) AddToIndex(content, begin + at);
                  return opcode != Opcode::kDataEnd;
                });
  const auto contents = ReadMcapRecords(path_, [this](const AnyRecord& record) {
    const auto* message = std::get_if<Message>(&record);
    if (is_in_memory_ && message != nullptr) messages_.push_back({*message, messages_.size()});
    if (const auto* statistics = std::get_if<Statistics>(&record)) statistics_ = *statistics;
  });
  if (!contents) return tl::unexpected(contents.error());
  schemas_ = contents->schemas;
  channels_ = contents->channels;
  metadata_ = contents->metadata;
  attachments_ = contents->attachments;
  std::stable_sort(chunks_.begin(), chunks_.end(),
                   [](const ChunkIndex& a, const ChunkIndex& b) { return a.first_ns < b.first_ns; });
  std::stable_sort(messages_.begin(), messages_.end(),
                   [](const Placed& a, const Placed& b) { return a.message.log_time_ns < b.message.log_time_ns; });
  return {};
}

template <class Record>
core::Result<Record> McapIndexedReader::ReadRecordAt(std::uint64_t offset, std::uint64_t length, const char* what) {
  const auto bytes = ReadAt(offset, length);
  if (!bytes) return tl::unexpected(bytes.error());
  Record record;
  const bool is_read = bytes->size() >= kRecordHeadBytes && (*bytes)[0] == static_cast<std::uint8_t>(Record::kOpcode) &&
                       ReadLength(std::span(*bytes).subspan(1)) == bytes->size() - kRecordHeadBytes &&
                       ReadRecord(std::span(*bytes).subspan(kRecordHeadBytes), &record);
  if (!is_read) return Damaged(offset, what);
  return record;
}

core::Result<void> McapIndexedReader::ReadChunk(const ChunkIndex& index) {
  auto chunk = ReadRecordAt<Chunk>(index.chunk_start, index.chunk_length, "a chunk that cannot be read");
  if (!chunk) return tl::unexpected(chunk.error());
  if (!chunk->compression.empty()) {
    return core::Fail(core::ErrorCode::kUnsupported, path_.string() + ": its chunks are compressed with " +
                                                         chunk->compression + "; recordings of this system are not");
  }
  const bool is_intact = chunk->records.size() == chunk->uncompressed_size &&
                         (chunk->uncompressed_crc == 0 || chunk->uncompressed_crc == Crc32(chunk->records));
  if (!is_intact) return Damaged(index.chunk_start, "a chunk whose checksum is wrong");
  const bool is_read =
      ForEachRecord(chunk->records, [&](Opcode opcode, std::span<const std::uint8_t> content, std::size_t at) {
        if (opcode == Opcode::kSchema) {
          Schema schema;
          if (!ReadRecord(content, &schema)) return false;
          schemas_[schema.id] = std::move(schema);
        } else if (opcode == Opcode::kChannel) {
          Channel channel;
          if (!ReadRecord(content, &channel)) return false;
          channels_[channel.id] = std::move(channel);
        } else if (opcode == Opcode::kMessage) {
          Placed placed{{}, index.chunk_start + at};
          if (!ReadRecord(content, &placed.message) || !channels_.contains(placed.message.channel_id)) return false;
          const std::uint64_t time_ns = placed.message.log_time_ns;
          if (time_ns >= from_ns_ && time_ns < to_ns_) waiting_.push(std::move(placed));
        }
        return true;
      });
  if (!is_read) return Damaged(index.chunk_start, "a chunk with a record that cannot be read");
  return {};
}

void McapIndexedReader::Seek(std::uint64_t from_ns, std::uint64_t to_ns) {
  from_ns_ = from_ns;
  to_ns_ = to_ns;
  waiting_ = {};
  next_ = 0;
}

core::Result<bool> McapIndexedReader::Next(Message* message) {
  if (is_in_memory_) {
    while (next_ < messages_.size()) {
      const Message& next = messages_[next_++].message;
      if (next.log_time_ns < from_ns_ || next.log_time_ns >= to_ns_) continue;
      *message = next;
      return true;
    }
    return false;
  }
  // A chunk is opened when no waiting message is earlier than its first.
  while (next_ < chunks_.size() &&
         (waiting_.empty() || chunks_[next_].first_ns <= waiting_.top().message.log_time_ns)) {
    const ChunkIndex& index = chunks_[next_++];
    if (index.last_ns < from_ns_ || index.first_ns >= to_ns_) continue;
    if (auto done = ReadChunk(index); !done) return tl::unexpected(done.error());
  }
  if (waiting_.empty()) return false;
  *message = waiting_.top().message;
  waiting_.pop();
  return true;
}

core::Result<void> McapIndexedReader::ReadMessages(const Visitor& visit, std::uint64_t from_ns, std::uint64_t to_ns) {
  Seek(from_ns, to_ns);
  Message message;
  for (;;) {
    const auto has_one = Next(&message);
    if (!has_one) return tl::unexpected(has_one.error());
    if (!*has_one || !visit(channels_.at(message.channel_id), message)) return {};
  }
}

core::Result<std::vector<Metadata>> McapIndexedReader::ReadMetadata(const std::string& name) {
  std::vector<Metadata> found;
  for (const Metadata& metadata : metadata_) {
    if (name.empty() || metadata.name == name) found.push_back(metadata);
  }
  for (const MetadataIndex& index : metadata_index_) {
    if (!has_index_ || (!name.empty() && index.name != name)) continue;
    auto record = ReadRecordAt<Metadata>(index.offset, index.length, "metadata that cannot be read");
    if (!record) return tl::unexpected(record.error());
    found.push_back(std::move(*record));
  }
  return found;
}

core::Result<std::vector<Attachment>> McapIndexedReader::ReadAttachments(const std::string& name) {
  std::vector<Attachment> found;
  for (const Attachment& attachment : attachments_) {
    if (name.empty() || attachment.name == name) found.push_back(attachment);
  }
  for (const AttachmentIndex& index : attachment_index_) {
    if (!has_index_ || (!name.empty() && index.name != name)) continue;
    auto record = ReadRecordAt<Attachment>(index.offset, index.length, "a damaged attachment");
    if (!record) return tl::unexpected(record.error());
    found.push_back(std::move(*record));
  }
  return found;
}

}  // namespace bus::log
