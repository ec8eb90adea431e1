#include "bus/log/compare_mcap.hpp"

#include <algorithm>
#include <map>
#include <set>
#include <tuple>
#include <utility>

#include "bus/log/mcap_indexed_reader.hpp"
#include "bus/log/payload_decoder.hpp"
#include "bus/log/recorded_payload.hpp"
#include "bus/topics.hpp"
#include "core/hash.hpp"

namespace bus::log {
namespace {

using ChannelKey = std::tuple<std::string, std::string, std::string>;  // topic, node, key

// 24 bytes for a message, because an hour of a session does not fit into memory. Payloads with the same 64-bit hash are
// taken as equal.
struct Summary {
  std::uint32_t sequence = 0;
  // Index among the messages with that sequence number: parts of a split message, or of a restarted writer.
  std::uint32_t place = 0;
  std::uint64_t hash = 0;  // of the payload
  std::uint64_t log_time_ns = 0;
  [[nodiscard]] std::pair<std::uint32_t, std::uint32_t> number() const { return {sequence, place}; }
};

struct Recording {
  std::filesystem::path path;
  std::map<ChannelKey, std::vector<Summary>> channels;  // by number
  std::map<ChannelKey, Schema> schemas;
};

std::string ValueOf(const TextMap& map, const std::string& key) {
  const auto found = map.find(key);
  return found == map.end() ? std::string() : found->second;
}

bool IsCompared(const Channel& channel, std::string_view pattern) {
  const std::string tap = ValueOf(channel.metadata, "tap");
  return (tap.empty() || tap == "sent") && MatchesPattern(pattern, channel.topic);
}

ChannelKey KeyOf(const Channel& channel) {
  return {channel.topic, ValueOf(channel.metadata, "writer"), ValueOf(channel.metadata, "key")};
}

core::Result<Recording> Load(const std::filesystem::path& path, std::string_view pattern) {
  Recording recording;
  recording.path = path;
  auto reader = McapIndexedReader::Open(path);
  if (!reader) return tl::unexpected(reader.error());
  const auto read = reader->ReadMessages([&](const Channel& channel, const Message& message) {
    if (!IsCompared(channel, pattern)) return true;
    const ChannelKey key = KeyOf(channel);
    const auto payload = SplitRecorded(message.data).payload;
    recording.channels[key].push_back(
        {message.sequence, 0, core::Hash64(payload.data(), payload.size()), message.log_time_ns});
    const auto schema = reader->schemas().find(channel.schema_id);
    if (schema != reader->schemas().end()) recording.schemas.try_emplace(key, schema->second);
    return true;
  });
  if (!read) return tl::unexpected(read.error());
  for (auto& [key, messages] : recording.channels) {
    std::stable_sort(messages.begin(), messages.end(),
                     [](const Summary& a, const Summary& b) { return a.sequence < b.sequence; });
    for (std::size_t i = 1; i < messages.size(); ++i) {
      if (messages[i].sequence == messages[i - 1].sequence) messages[i].place = messages[i - 1].place + 1;
    }
  }
  return recording;
}

// Reads the payload of one message again: the one of its log time with the same sequence number and hash.
core::Result<Bytes> PayloadOf(const Recording& recording, const ChannelKey& key, const Summary& summary) {
  auto reader = McapIndexedReader::Open(recording.path);
  if (!reader) return tl::unexpected(reader.error());
  Bytes found;
  const auto see = [&](const Channel& channel, const Message& message) {
    if (message.sequence != summary.sequence || KeyOf(channel) != key) return true;
    const auto payload = SplitRecorded(message.data).payload;
    if (core::Hash64(payload.data(), payload.size()) != summary.hash) return true;
    found.assign(payload.begin(), payload.end());
    return false;
  };
  if (auto done = reader->ReadMessages(see, summary.log_time_ns, summary.log_time_ns + 1); !done) {
    return tl::unexpected(done.error());
  }
  return found;
}

class Comparer {
 public:
  Comparer(const Recording& a, const Recording& b) : a_(a), b_(b) {}

  core::Result<McapComparison> Compare() {
    std::set<ChannelKey> keys;
    for (const auto* recording : {&a_, &b_}) {
      for (const auto& [key, messages] : recording->channels) keys.insert(key);
    }
    for (const ChannelKey& key : keys) CompareChannel(key);
    if (first_at_) {
      if (auto done = ReportFirst(); !done) return tl::unexpected(done.error());
    }
    return std::move(comparison_);
  }

 private:
  struct Place {
    ChannelKey key;
    std::uint64_t time_ns = 0;
    const Summary* a = nullptr;  // null: only in b
    const Summary* b = nullptr;
  };

  static const std::vector<Summary>& MessagesOf(const Recording& recording, const ChannelKey& key) {
    static const std::vector<Summary> none;
    const auto found = recording.channels.find(key);
    return found == recording.channels.end() ? none : found->second;
  }

  void CompareChannel(const ChannelKey& key) {
    const std::vector<Summary>& in_a = MessagesOf(a_, key);
    const std::vector<Summary>& in_b = MessagesOf(b_, key);
    ChannelComparison channel{std::get<0>(key), std::get<1>(key), std::get<2>(key), in_a.size(), in_b.size(), 0, 0, 0};
    auto a = in_a.begin();
    auto b = in_b.begin();
    while (a != in_a.end() || b != in_b.end()) {
      if (b == in_b.end() || (a != in_a.end() && a->number() < b->number())) {
        ++channel.num_only_a;
        Note({key, a->log_time_ns, &*a, nullptr});
        ++a;
      } else if (a == in_a.end() || b->number() < a->number()) {
        ++channel.num_only_b;
        Note({key, b->log_time_ns, nullptr, &*b});
        ++b;
      } else {
        if (a->hash != b->hash) {
          ++channel.num_different;
          Note({key, a->log_time_ns, &*a, &*b});
        }
        ++a;
        ++b;
      }
    }
    comparison_.channels.push_back(channel);
  }

  void Note(const Place& place) {
    if (!first_at_ || place.time_ns < first_at_->time_ns) first_at_ = place;
  }

  core::Result<void> ReportFirst() {
    const Place& place = *first_at_;
    const Summary& summary = place.a == nullptr ? *place.b : *place.a;
    MessageDifference first{std::get<0>(place.key), std::get<1>(place.key), summary.sequence, place.time_ns, {}};
    if (place.a == nullptr || place.b == nullptr) {
      first.what = place.a == nullptr ? "only in the second file" : "only in the first file";
    } else {
      const auto in_a = PayloadOf(a_, place.key, *place.a);
      if (!in_a) return tl::unexpected(in_a.error());
      const auto in_b = PayloadOf(b_, place.key, *place.b);
      if (!in_b) return tl::unexpected(in_b.error());
      const auto schema = a_.schemas.find(place.key);
      const auto fields = schema == a_.schemas.end() ? core::Result<std::string>("bytes differ")
                                                     : PayloadDecoder().Difference(schema->second, *in_a, *in_b);
      first.what = fields ? *fields : fields.error().detail;
    }
    comparison_.first = first;
    return {};
  }

  const Recording& a_;
  const Recording& b_;
  McapComparison comparison_;
  std::optional<Place> first_at_;
};

}  // namespace

core::Result<McapComparison> CompareMcap(const std::filesystem::path& a, const std::filesystem::path& b,
                                         std::string_view pattern) {
  const auto in_a = Load(a, pattern);
  if (!in_a) return tl::unexpected(in_a.error());
  const auto in_b = Load(b, pattern);
  if (!in_b) return tl::unexpected(in_b.error());
  return Comparer(*in_a, *in_b).Compare();
}

}  // namespace bus::log
