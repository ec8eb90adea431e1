#include "bus/log/mcap_writer.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <set>
#include <utility>
#include <vector>

namespace bus::log {

struct McapWriter::Impl {
  std::filesystem::path path;
  int file = -1;
  std::uint64_t position = 0;
  std::uint32_t crc = 0;  // of everything so far
  std::map<std::uint16_t, Schema> schemas;
  std::map<std::uint16_t, Channel> channels;
  std::set<std::uint16_t> written_schemas, written_channels;
  Bytes chunk;  // records of the open one
  std::uint64_t first_ns = 0, last_ns = 0;
  std::uint64_t chunk_messages = 0;
  std::map<std::uint16_t, MessageIndex> indices;  // of the open chunk
  Statistics statistics;
  std::vector<ChunkIndex> chunks;
  std::vector<AttachmentIndex> attachments;
  std::vector<MetadataIndex> metadata;

  core::Result<void> Put(const Bytes& bytes) {
    std::size_t done = 0;
    while (done < bytes.size()) {
      const ssize_t wrote = ::write(file, bytes.data() + done, bytes.size() - done);
      if (wrote < 0 && errno == EINTR) continue;
      if (wrote < 0) {
        return core::Fail(core::ErrorCode::kIo, path.string() + ": cannot be written: " + std::strerror(errno));
      }
      done += static_cast<std::size_t>(wrote);
    }
    position += bytes.size();
    crc = Crc32(bytes, crc);
    return {};
  }

  // Schema and channel stand before their first message, in its chunk.
  void Introduce(std::uint16_t id) {
    if (!written_channels.insert(id).second) return;
    const Channel& channel = channels.at(id);
    if (channel.schema_id != 0 && written_schemas.insert(channel.schema_id).second) {
      AppendRecord(schemas.at(channel.schema_id), &chunk);
    }
    AppendRecord(channel, &chunk);
    indices[id].channel_id = id;
  }

  core::Result<void> CloseChunk() {
    if (chunk_messages == 0) return {};
    ChunkIndex index;
    index.first_ns = first_ns;
    index.last_ns = last_ns;
    index.chunk_start = position;
    index.compressed_size = index.uncompressed_size = chunk.size();
    Bytes out;
    AppendRecord(Chunk{first_ns, last_ns, chunk.size(), Crc32(chunk), "", std::move(chunk)}, &out);
    index.chunk_length = out.size();
    for (auto& [id, entries] : indices) {
      if (entries.entries.empty()) continue;
      index.message_index_offsets[id] = position + out.size();
      AppendRecord(entries, &out);
      entries.entries.clear();
    }
    index.message_index_length = out.size() - index.chunk_length;
    ++statistics.chunk_count;
    chunks.push_back(std::move(index));
    chunk.clear();
    chunk_messages = 0;
    return Put(out);
  }

  template <class Records>
  void AppendGroup(const Records& records, Opcode group, Bytes* summary, std::vector<SummaryOffset>* groups) const {
    const std::size_t begin = summary->size();
    for (const auto& record : records) AppendRecord(record, summary);
    if (summary->size() > begin) groups->push_back({group, position + begin, summary->size() - begin});
  }
};

namespace {

template <class Map>
std::vector<typename Map::mapped_type> ValuesOf(const Map& map) {
  std::vector<typename Map::mapped_type> values;
  for (const auto& [key, value] : map) values.push_back(value);
  return values;
}

}  // namespace

McapWriter::McapWriter(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}

McapWriter::~McapWriter() {
  if (impl_->file >= 0) ::close(impl_->file);
}

core::Result<std::unique_ptr<McapWriter>> McapWriter::Create(const std::filesystem::path& path, const Header& header) {
  auto impl = std::make_unique<Impl>();
  impl->path = path;
  impl->file = ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0644);
  if (impl->file < 0) {
    const std::string why =
        errno == EEXIST ? "is there already; name another file, or remove it" : std::strerror(errno);
    return core::Fail(core::ErrorCode::kIo, path.string() + ": " + why);
  }
  Bytes out(kMcapMagic.begin(), kMcapMagic.end());
  AppendRecord(header, &out);
  std::unique_ptr<McapWriter> writer(new McapWriter(std::move(impl)));
  if (auto done = writer->impl_->Put(out); !done) return tl::unexpected(done.error());
  return writer;
}

std::uint16_t McapWriter::AddSchema(const std::string& name, const std::string& encoding, const Bytes& data) {
  const auto id = static_cast<std::uint16_t>(++impl_->statistics.schema_count);
  impl_->schemas[id] = {id, name, encoding, data};
  return id;
}

std::uint16_t McapWriter::AddChannel(std::uint16_t schema, const std::string& topic,
                                     const std::string& message_encoding, const TextMap& metadata) {
  const auto id = static_cast<std::uint16_t>(impl_->statistics.channel_count++);
  impl_->channels[id] = {id, schema, topic, message_encoding, metadata};
  return id;
}

core::Result<void> McapWriter::Write(const Message& message) {
  Impl& w = *impl_;
  w.Introduce(message.channel_id);
  const std::uint64_t at = w.chunk.size();
  AppendRecord(message, &w.chunk);
  MessageIndex& index = w.indices[message.channel_id];
  index.channel_id = message.channel_id;
  index.entries.emplace_back(message.log_time_ns, at);
  const auto widen = [&](bool is_first, std::uint64_t* first, std::uint64_t* last) {
    *first = is_first ? message.log_time_ns : std::min(*first, message.log_time_ns);
    *last = is_first ? message.log_time_ns : std::max(*last, message.log_time_ns);
  };
  widen(w.chunk_messages++ == 0, &w.first_ns, &w.last_ns);
  widen(w.statistics.message_count++ == 0, &w.statistics.first_ns, &w.statistics.last_ns);
  ++w.statistics.channel_message_counts[message.channel_id];
  return w.chunk.size() >= kChunkBytes ? w.CloseChunk() : core::Result<void>{};
}

core::Result<void> McapWriter::Write(const Attachment& attachment) {
  if (auto done = impl_->CloseChunk(); !done) return done;
  Bytes out;
  AppendRecord(attachment, &out);
  impl_->attachments.push_back({impl_->position, out.size(), attachment.log_time_ns, attachment.create_time_ns,
                                attachment.data.size(), attachment.name, attachment.media_type});
  ++impl_->statistics.attachment_count;
  return impl_->Put(out);
}

core::Result<void> McapWriter::Write(const Metadata& metadata) {
  if (auto done = impl_->CloseChunk(); !done) return done;
  Bytes out;
  AppendRecord(metadata, &out);
  impl_->metadata.push_back({impl_->position, out.size(), metadata.name});
  ++impl_->statistics.metadata_count;
  return impl_->Put(out);
}

core::Result<void> McapWriter::Flush() {
  return impl_->CloseChunk();
}

core::Result<void> McapWriter::Close(ToDisk to_disk) {
  Impl& w = *impl_;
  if (auto done = w.CloseChunk(); !done) return done;
  Bytes data_end;
  AppendRecord(DataEnd{w.crc}, &data_end);
  if (auto done = w.Put(data_end); !done) return done;

  const std::uint64_t summary_start = w.position;
  Bytes summary;
  std::vector<SummaryOffset> groups;
  w.AppendGroup(ValuesOf(w.schemas), Opcode::kSchema, &summary, &groups);
  w.AppendGroup(ValuesOf(w.channels), Opcode::kChannel, &summary, &groups);
  w.AppendGroup(std::vector<Statistics>{w.statistics}, Opcode::kStatistics, &summary, &groups);
  w.AppendGroup(w.metadata, Opcode::kMetadataIndex, &summary, &groups);
  w.AppendGroup(w.attachments, Opcode::kAttachmentIndex, &summary, &groups);
  w.AppendGroup(w.chunks, Opcode::kChunkIndex, &summary, &groups);
  const std::uint64_t offsets_start = summary_start + summary.size();
  for (const SummaryOffset& group : groups) AppendRecord(group, &summary);
  // The checksum covers the summary and the footer up to itself.
  Footer footer{summary_start, offsets_start, 0};
  Bytes tail;
  AppendRecord(footer, &tail);
  footer.summary_crc = Crc32(std::span(tail).first(tail.size() - sizeof footer.summary_crc), Crc32(summary));
  AppendRecord(footer, &summary);
  summary.insert(summary.end(), kMcapMagic.begin(), kMcapMagic.end());
  if (auto done = w.Put(summary); !done) return done;
  if (to_disk == ToDisk::kNow && ::fdatasync(w.file) != 0 && errno != EINVAL && errno != EROFS) {
    return core::Fail(core::ErrorCode::kIo,
                      w.path.string() + ": cannot be brought to the disk: " + std::strerror(errno));
  }
  ::close(std::exchange(w.file, -1));
  return {};
}

std::uint64_t McapWriter::num_messages() const {
  return impl_->statistics.message_count;
}
std::uint64_t McapWriter::num_bytes() const {
  return impl_->position;
}

}  // namespace bus::log
