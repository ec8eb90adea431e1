#include "bus/log/merge_mcap.hpp"

#include <algorithm>
#include <map>
#include <memory>
#include <set>
#include <tuple>
#include <utility>

#include "bus/log/channel_copier.hpp"
#include "bus/log/clock_series.hpp"
#include "bus/log/mcap_indexed_reader.hpp"
#include "bus/topics.hpp"
#include "proto/recording.pb.h"

namespace bus::log {
namespace {

struct Input {
  std::filesystem::path path;
  McapIndexedReader reader;
  std::string node;
  std::string machine;
  std::vector<Metadata> metadata;
  Message message;  // the next one, its times by the reference's clock
  bool has_message = false;
};

std::string Entry(const std::vector<Metadata>& records, const std::string& name, const std::string& key) {
  for (const Metadata& record : records) {
    const auto found = record.entries.find(key);
    if (record.name == name && found != record.entries.end()) return found->second;
  }
  return {};
}

class Merger {
 public:
  core::Result<McapMerge> Merge(const std::vector<std::filesystem::path>& from, const std::filesystem::path& to) {
    for (const auto& path : from) {
      if (auto done = Open(path); !done) return tl::unexpected(done.error());
    }
    PlaceOthers();
    if (auto done = clocks_.SetReference(inputs_.front().machine); !done) return tl::unexpected(done.error());
    auto writer = McapWriter::Create(to, {"", "vr-oos"});
    if (!writer) return tl::unexpected(writer.error());
    writer_ = std::move(*writer);
    if (auto done = WriteFront(); !done) return tl::unexpected(done.error());
    if (auto done = CopyMessages(); !done) return tl::unexpected(done.error());
    if (auto done = writer_->Close(); !done) return tl::unexpected(done.error());
    return merge_;
  }

 private:
  core::Result<void> Open(const std::filesystem::path& path) {
    auto reader = McapIndexedReader::Open(path);
    if (!reader) return tl::unexpected(reader.error());
    Input input{path, std::move(*reader), {}, {}, {}, {}, false};
    if (!input.reader.has_index()) merge_.incomplete.push_back(path.string());
    auto metadata = input.reader.ReadMetadata();
    if (!metadata) return tl::unexpected(metadata.error());
    input.metadata = std::move(*metadata);
    input.node = Entry(input.metadata, "recording", "node");
    input.machine = Entry(input.metadata, "host", "clock_id");
    clocks_.AddNode(input.node.empty() ? path.string() : input.node, input.machine);
    if (auto done = ReadClocks(&input); !done) return done;
    inputs_.push_back(std::move(input));
    return {};
  }

  core::Result<void> ReadClocks(Input* input) {
    const std::string topic = "clock/" + input->node;
    return input->reader.ReadMessages([&](const Channel& channel, const Message& message) {
      oos::ClockSample sample;
      if (channel.topic == topic && sample.ParseFromArray(message.data.data(), static_cast<int>(message.data.size()))) {
        clocks_.Add(input->node, sample.peer(),
                    {static_cast<std::int64_t>(message.log_time_ns), sample.offset_ns(), sample.bound_ns()});
        std::int64_t& bound_ns = measured_peers_[{input->machine, sample.peer()}];
        bound_ns = std::max(bound_ns, sample.bound_ns());
      }
      return true;
    });
  }

  // Nodes without a recording of their own: their clocks are known if an observer has recorded clock samples of them. A
  // peer with bound 0 is on the observer's machine; any other stands for a machine of its own.
  void PlaceOthers() {
    for (const auto& [pair, bound_ns] : measured_peers_) {
      const auto& [machine, peer] = pair;
      if (clocks_.MachineOf(peer)) continue;
      others_.push_back(bound_ns == 0 ? machine : "the machine of " + peer);
      clocks_.AddNode(peer, others_.back());
    }
  }

  // Metadata about all files, then the metadata and attachments of each.
  core::Result<void> WriteFront() {
    TextMap about;
    std::set<std::string> machines;
    for (const Input& input : inputs_) {
      const std::string bound = std::to_string(clocks_.BoundOf(input.machine));
      about[input.path.filename().string()] =
          "node=" + input.node + " clock_id=" + input.machine + " bound_ns=" + bound;
      merge_.bound_ns = std::max(merge_.bound_ns, clocks_.BoundOf(input.machine));
      machines.insert(input.machine);
    }
    merge_.num_machines = machines.size();
    for (const std::string& machine : others_) {
      if (machines.insert(machine).second) about[machine] = "bound_ns=" + std::to_string(clocks_.BoundOf(machine));
    }
    about["clock"] = "CLOCK_MONOTONIC of " + inputs_.front().machine;
    if (auto done = writer_->Write(Metadata{"merged", about}); !done) return done;
    std::set<std::pair<std::string, TextMap>> written;
    std::set<std::tuple<std::string, std::string, Bytes>> attached;
    for (Input& input : inputs_) {
      for (const Metadata& metadata : input.metadata) {
        if (!written.emplace(metadata.name, metadata.entries).second) continue;
        if (auto done = writer_->Write(metadata); !done) return done;
      }
      auto attachments = input.reader.ReadAttachments();
      if (!attachments) return tl::unexpected(attachments.error());
      for (const Attachment& a : *attachments) {
        if (!attached.emplace(a.name, a.media_type, a.data).second) continue;
        if (auto done = writer_->Write(a); !done) return done;
      }
    }
    return {};
  }

  // For a message that a node took, or an observer recorded, the publish time is by the writer's clock.
  [[nodiscard]] std::string PublishersMachine(const Input& input) const {
    const Channel& channel = input.reader.channels().at(input.message.channel_id);
    const auto writer = channel.metadata.find("writer");
    if (channel.metadata.count("tap") == 0 && writer != channel.metadata.end() &&
        input.message.publish_time_ns != input.message.log_time_ns) {
      return clocks_.MachineOf(writer->second).value_or(input.machine);
    }
    const auto schema = input.reader.schemas().find(channel.schema_id);
    oos::TakenSample sample;
    if (schema == input.reader.schemas().end() || schema->second.name != sample.GetTypeName() ||
        !sample.ParseFromArray(input.message.data.data(), static_cast<int>(input.message.data.size()))) {
      return input.machine;
    }
    for (const Input& other : inputs_) {
      if (TopicId(other.node) == sample.node()) return other.machine;
    }
    return input.machine;
  }

  core::Result<void> Advance(Input* input) {
    const auto has_one = input->reader.Next(&input->message);
    if (!has_one) return tl::unexpected(has_one.error());
    input->has_message = *has_one;
    if (!*has_one) return {};
    Message& message = input->message;
    const auto correct = [this](const std::string& machine, std::uint64_t* time) {
      *time = static_cast<std::uint64_t>(clocks_.ToReference(machine, static_cast<std::int64_t>(*time)));
    };
    correct(input->machine, &message.log_time_ns);
    correct(PublishersMachine(*input), &message.publish_time_ns);
    return {};
  }

  core::Result<void> CopyMessages() {
    ChannelCopier copier(writer_.get());
    for (Input& input : inputs_) {
      input.reader.Seek();
      if (auto done = Advance(&input); !done) return done;
    }
    for (;;) {
      std::size_t first = inputs_.size();
      for (std::size_t i = 0; i < inputs_.size(); ++i) {
        if (!inputs_[i].has_message) continue;
        const bool is_first =
            first == inputs_.size() || inputs_[i].message.log_time_ns < inputs_[first].message.log_time_ns;
        if (is_first) first = i;
      }
      if (first == inputs_.size()) return {};
      Input& input = inputs_[first];
      const Channel& channel = input.reader.channels().at(input.message.channel_id);
      const auto schema = input.reader.schemas().find(channel.schema_id);
      const Schema* its = schema == input.reader.schemas().end() ? nullptr : &schema->second;
      if (auto done = copier.Copy(first, channel, its, input.message); !done) return done;
      ++merge_.num_messages;
      if (auto done = Advance(&input); !done) return done;
    }
  }

  std::vector<Input> inputs_;
  ClockSeries clocks_;
  std::vector<std::string> others_;  // machines represented by nodes without a recording
  std::map<std::pair<std::string, std::string>, std::int64_t> measured_peers_;  // machine and peer: widest bound
  std::unique_ptr<McapWriter> writer_;
  McapMerge merge_;
};

}  // namespace

core::Result<McapMerge> MergeMcap(const std::vector<std::filesystem::path>& from, const std::filesystem::path& to) {
  if (from.empty()) return core::Fail(core::ErrorCode::kInvalidInput, "there is no file to merge");
  return Merger().Merge(from, to);
}

}  // namespace bus::log
