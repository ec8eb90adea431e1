#include "bus/log/compare_mcap.hpp"

#include <map>
#include <set>
#include <tuple>
#include <utility>

#include "bus/log/mcap_indexed_reader.hpp"
#include "bus/log/payload_decoder.hpp"
#include "bus/log/recorded_payload.hpp"
#include "bus/topics.hpp"

namespace bus::log {
namespace {

struct Said {
  Bytes payload;
  std::uint64_t log_time_ns = 0;
};
using ChannelKey = std::tuple<std::string, std::string, std::string>;  // topic, node, key
// Sequence number, and the how manyth of it: parts of a split message, and what a restarted writer says again.
using Messages = std::map<std::pair<std::uint32_t, std::uint32_t>, Said>;

struct Recording {
  std::map<ChannelKey, Messages> channels;
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

core::Result<Recording> Load(const std::filesystem::path& path, std::string_view pattern) {
  Recording recording;
  auto reader = McapIndexedReader::Open(path);
  if (!reader) return tl::unexpected(reader.error());
  std::map<std::pair<ChannelKey, std::uint32_t>, std::uint32_t> seen;
  const auto read = reader->ReadMessages([&](const Channel& channel, const Message& message) {
    if (!IsCompared(channel, pattern)) return true;
    const ChannelKey key{channel.topic, ValueOf(channel.metadata, "writer"), ValueOf(channel.metadata, "key")};
    const std::uint32_t place = seen[{key, message.sequence}]++;
    const auto payload = SplitRecorded(message.data).payload;
    recording.channels[key][{message.sequence, place}] = {Bytes(payload.begin(), payload.end()), message.log_time_ns};
    const auto schema = reader->schemas().find(channel.schema_id);
    if (schema != reader->schemas().end()) recording.schemas.try_emplace(key, schema->second);
    return true;
  });
  if (!read) return tl::unexpected(read.error());
  return recording;
}

class Comparer {
 public:
  Comparer(const Recording& a, const Recording& b) : a_(a), b_(b) {}

  McapComparison Compare() {
    std::set<ChannelKey> keys;
    for (const auto* recording : {&a_, &b_}) {
      for (const auto& [key, messages] : recording->channels) keys.insert(key);
    }
    for (const ChannelKey& key : keys) CompareChannel(key);
    if (first_at_) TellFirst();
    return std::move(comparison_);
  }

 private:
  struct Place {
    ChannelKey key;
    std::pair<std::uint32_t, std::uint32_t> sequence;
    std::uint64_t time_ns = 0;
    const Said* a = nullptr;  // not there: only b says it
    const Said* b = nullptr;
  };

  static const Messages& MessagesOf(const Recording& recording, const ChannelKey& key) {
    static const Messages none;
    const auto found = recording.channels.find(key);
    return found == recording.channels.end() ? none : found->second;
  }

  void CompareChannel(const ChannelKey& key) {
    const Messages& in_a = MessagesOf(a_, key);
    const Messages& in_b = MessagesOf(b_, key);
    ChannelComparison channel{std::get<0>(key), std::get<1>(key), std::get<2>(key), in_a.size(), in_b.size(), 0, 0, 0};
    for (const auto& [sequence, said] : in_a) {
      const auto other = in_b.find(sequence);
      if (other == in_b.end()) {
        ++channel.num_only_a;
        Note({key, sequence, said.log_time_ns, &said, nullptr});
      } else if (other->second.payload != said.payload) {
        ++channel.num_different;
        Note({key, sequence, said.log_time_ns, &said, &other->second});
      }
    }
    for (const auto& [sequence, said] : in_b) {
      if (in_a.count(sequence) != 0) continue;
      ++channel.num_only_b;
      Note({key, sequence, said.log_time_ns, nullptr, &said});
    }
    comparison_.channels.push_back(channel);
  }

  void Note(const Place& place) {
    if (!first_at_ || place.time_ns < first_at_->time_ns) first_at_ = place;
  }

  void TellFirst() {
    const Place& place = *first_at_;
    MessageDifference first{std::get<0>(place.key), std::get<1>(place.key), place.sequence.first, place.time_ns, {}};
    if (place.a == nullptr || place.b == nullptr) {
      first.what = place.a == nullptr ? "only in the second file" : "only in the first file";
    } else {
      const auto schema = a_.schemas.find(place.key);
      const auto fields = schema == a_.schemas.end()
                              ? core::Result<std::string>("bytes differ")
                              : PayloadDecoder().Difference(schema->second, place.a->payload, place.b->payload);
      first.what = fields ? *fields : fields.error().detail;
    }
    comparison_.first = first;
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
