#include "bus/log/mcap_records.hpp"

#include <type_traits>

#include "core/hash.hpp"

namespace bus::log {
namespace {

// The one description of every record's fields, visited by both the appender and the reader.
template <class Visitor, class R>
void Fields(Visitor& v, R& r) {
  using Record = std::remove_const_t<R>;
  if constexpr (std::is_same_v<Record, Header>) {
    v(r.profile), v(r.library);
  } else if constexpr (std::is_same_v<Record, Footer>) {
    v(r.summary_start), v(r.summary_offset_start), v(r.summary_crc);
  } else if constexpr (std::is_same_v<Record, Schema>) {
    v(r.id), v(r.name), v(r.encoding), v.Block32(r.data);
  } else if constexpr (std::is_same_v<Record, Channel>) {
    v(r.id), v(r.schema_id), v(r.topic), v(r.message_encoding), v(r.metadata);
  } else if constexpr (std::is_same_v<Record, Message>) {
    v(r.channel_id), v(r.sequence), v(r.log_time_ns), v(r.publish_time_ns), v.Rest(r.data);
  } else if constexpr (std::is_same_v<Record, Chunk>) {
    v(r.first_ns), v(r.last_ns), v(r.uncompressed_size), v(r.uncompressed_crc), v(r.compression), v.Block64(r.records);
  } else if constexpr (std::is_same_v<Record, MessageIndex>) {
    v(r.channel_id), v(r.entries);
  } else if constexpr (std::is_same_v<Record, ChunkIndex>) {
    v(r.first_ns), v(r.last_ns), v(r.chunk_start), v(r.chunk_length), v(r.message_index_offsets);
    v(r.message_index_length), v(r.compression), v(r.compressed_size), v(r.uncompressed_size);
  } else if constexpr (std::is_same_v<Record, Attachment>) {
    v(r.log_time_ns), v(r.create_time_ns), v(r.name), v(r.media_type), v.Block64(r.data);
  } else if constexpr (std::is_same_v<Record, AttachmentIndex>) {
    v(r.offset), v(r.length), v(r.log_time_ns), v(r.create_time_ns), v(r.data_size), v(r.name), v(r.media_type);
  } else if constexpr (std::is_same_v<Record, Statistics>) {
    v(r.message_count), v(r.schema_count), v(r.channel_count), v(r.attachment_count), v(r.metadata_count);
    v(r.chunk_count), v(r.first_ns), v(r.last_ns), v(r.channel_message_counts);
  } else if constexpr (std::is_same_v<Record, Metadata>) {
    v(r.name), v(r.entries);
  } else if constexpr (std::is_same_v<Record, MetadataIndex>) {
    v(r.offset), v(r.length), v(r.name);
  } else if constexpr (std::is_same_v<Record, SummaryOffset>) {
    v(r.group), v(r.group_start), v(r.group_length);
  } else {
    static_assert(std::is_same_v<Record, DataEnd>);
    v(r.data_section_crc);
  }
}

class Appender {
 public:
  explicit Appender(Bytes* out) : out_(out) {}
  template <class Number>
  requires std::is_integral_v<Number>
  void operator()(Number value) {
    for (std::size_t i = 0; i < sizeof value; ++i) out_->push_back(static_cast<std::uint8_t>(value >> 8 * i));
  }
  void operator()(Opcode value) { (*this)(static_cast<std::uint8_t>(value)); }
  void operator()(const std::string& text) {
    (*this)(static_cast<std::uint32_t>(text.size()));
    out_->insert(out_->end(), text.begin(), text.end());
  }
  template <class Key, class Value>
  void operator()(const std::map<Key, Value>& map) {
    WithLength([&] {
      for (const auto& [key, value] : map) (*this)(key), (*this)(value);
    });
  }
  void operator()(const std::vector<std::pair<std::uint64_t, std::uint64_t>>& pairs) {
    WithLength([&] {
      for (const auto& [a, b] : pairs) (*this)(a), (*this)(b);
    });
  }
  void Block32(const Bytes& bytes) {
    (*this)(static_cast<std::uint32_t>(bytes.size()));
    Rest(bytes);
  }
  void Block64(const Bytes& bytes) {
    (*this)(static_cast<std::uint64_t>(bytes.size()));
    Rest(bytes);
  }
  void Rest(const Bytes& bytes) { out_->insert(out_->end(), bytes.begin(), bytes.end()); }

 private:
  template <class Write>
  void WithLength(Write&& write) {
    const std::size_t at = out_->size();
    out_->resize(at + 4);
    write();
    const std::size_t length = out_->size() - at - 4;
    for (std::size_t i = 0; i < 4; ++i) (*out_)[at + i] = static_cast<std::uint8_t>(length >> 8 * i);
  }
  Bytes* out_;
};

class Reader {
 public:
  explicit Reader(std::span<const std::uint8_t> bytes) : rest_(bytes) {}
  [[nodiscard]] bool is_sound() const { return is_sound_; }
  [[nodiscard]] std::span<const std::uint8_t> rest() const { return rest_; }

  template <class Number>
  requires std::is_integral_v<Number>
  void operator()(Number& value) {
    value = 0;
    const auto bytes = Take(sizeof value);
    for (std::size_t i = 0; i < bytes.size(); ++i) value |= static_cast<Number>(Number{bytes[i]} << 8 * i);
  }
  void operator()(Opcode& value) {
    std::uint8_t number = 0;
    (*this)(number);
    value = static_cast<Opcode>(number);
  }
  void operator()(std::string& text) {
    std::uint32_t size = 0;
    (*this)(size);
    const auto bytes = Take(size);
    text.assign(bytes.begin(), bytes.end());
  }
  template <class Key, class Value>
  void operator()(std::map<Key, Value>& map) {
    map.clear();
    WithLength([&] {
      Key key{};
      Value value{};
      (*this)(key), (*this)(value);
      map[key] = value;
    });
  }
  void operator()(std::vector<std::pair<std::uint64_t, std::uint64_t>>& pairs) {
    pairs.clear();
    WithLength([&] {
      std::pair<std::uint64_t, std::uint64_t> entry;
      (*this)(entry.first), (*this)(entry.second);
      pairs.push_back(entry);
    });
  }
  void Block32(Bytes& bytes) {
    std::uint32_t size = 0;
    (*this)(size);
    Assign(Take(size), &bytes);
  }
  void Block64(Bytes& bytes) {
    std::uint64_t size = 0;
    (*this)(size);
    Assign(Take(size), &bytes);
  }
  void Rest(Bytes& bytes) { Assign(Take(rest_.size()), &bytes); }

 private:
  static void Assign(std::span<const std::uint8_t> from, Bytes* to) { to->assign(from.begin(), from.end()); }
  std::span<const std::uint8_t> Take(std::uint64_t size) {
    if (!is_sound_ || size > rest_.size()) {
      is_sound_ = false;
      rest_ = {};
      return {};
    }
    const auto taken = rest_.first(static_cast<std::size_t>(size));
    rest_ = rest_.subspan(static_cast<std::size_t>(size));
    return taken;
  }
  // Entries until the length is used up, exactly.
  template <class Entry>
  void WithLength(Entry&& entry) {
    std::uint32_t length = 0;
    (*this)(length);
    if (!is_sound_ || length > rest_.size()) {
      is_sound_ = false;
      return;
    }
    const auto behind = rest_.subspan(length);
    rest_ = rest_.first(length);
    while (is_sound_ && !rest_.empty()) entry();
    rest_ = behind;
  }
  std::span<const std::uint8_t> rest_;
  bool is_sound_ = true;
};

}  // namespace

std::uint32_t Crc32(std::span<const std::uint8_t> bytes, std::uint32_t start) {
  return core::Crc32(bytes.data(), bytes.size(), start);
}

template <class Record>
void AppendRecord(const Record& record, Bytes* out) {
  Appender append(out);
  append(Record::kOpcode);
  const std::size_t head = out->size();
  append(std::uint64_t{0});
  Fields(append, record);
  // An attachment ends with the checksum of its fields.
  if constexpr (std::is_same_v<Record, Attachment>) append(Crc32(std::span(*out).subspan(head + 8)));
  const std::uint64_t length = out->size() - head - 8;
  for (std::size_t i = 0; i < 8; ++i) (*out)[head + i] = static_cast<std::uint8_t>(length >> 8 * i);
}

template <class Record>
bool ReadRecord(std::span<const std::uint8_t> content, Record* out) {
  Reader read(content);
  Fields(read, *out);
  if constexpr (std::is_same_v<Record, Attachment>) {
    const std::size_t size = content.size() - read.rest().size();
    std::uint32_t crc = 0;
    read(crc);
    if (crc != 0 && crc != Crc32(content.first(size))) return false;
  }
  return read.is_sound();
}

#define BUS_LOG_RECORD(R)                       \
  template void AppendRecord(const R&, Bytes*); \
  template bool ReadRecord(std::span<const std::uint8_t>, R*)
BUS_LOG_RECORD(Header);
BUS_LOG_RECORD(Footer);
BUS_LOG_RECORD(Schema);
BUS_LOG_RECORD(Channel);
BUS_LOG_RECORD(Message);
BUS_LOG_RECORD(Chunk);
BUS_LOG_RECORD(MessageIndex);
BUS_LOG_RECORD(ChunkIndex);
BUS_LOG_RECORD(Attachment);
BUS_LOG_RECORD(AttachmentIndex);
BUS_LOG_RECORD(Statistics);
BUS_LOG_RECORD(Metadata);
BUS_LOG_RECORD(MetadataIndex);
BUS_LOG_RECORD(SummaryOffset);
BUS_LOG_RECORD(DataEnd);
#undef BUS_LOG_RECORD

}  // namespace bus::log
