#include "bus/log/tap_writer.hpp"

#include <algorithm>
#include <cstring>
#include <type_traits>
#include <utility>

#include "bus/log/recorded_payload.hpp"
#include "bus/wire/schema.hpp"
#include "core/clock.hpp"
#include "proto/recording.pb.h"

namespace bus::log {
namespace {

static_assert(std::is_trivially_copyable_v<Envelope>, "it lies in the tap as in memory");

std::string ChannelName(const TapTopic& topic, const std::string& node) {
  switch (topic.kind) {
    case TapKind::kSent:
      return topic.name;
    case TapKind::kTaken:
      return "taken/" + node + "/" + topic.name;
    case TapKind::kStep:
      return "step/" + node;
  }
  return topic.name;
}

oos::TakenSample SampleOf(const Envelope& envelope, const TapHead& entry) {
  oos::TakenSample sample;
  sample.set_node(envelope.node);
  sample.set_boot(envelope.boot);
  sample.set_sequence(envelope.header.sequence);
  sample.set_part(envelope.part);
  sample.set_num_parts(envelope.num_parts);
  sample.set_publish_ns(envelope.header.publish_ns);
  sample.set_received_ns(entry.time_ns);
  return sample;
}

const char* NameOf(TapKind kind) {
  return kind == TapKind::kSent ? "sent" : kind == TapKind::kTaken ? "taken" : "step";
}

}  // namespace

core::Result<std::unique_ptr<TapWriter>> TapWriter::Create(TapFile file, Tap* tap, std::int64_t now_ns) {
  std::unique_ptr<TapWriter> writer(new TapWriter(std::move(file), tap));
  if (auto done = writer->Open(now_ns); !done) return tl::unexpected(done.error());
  writer->flushed_ns_ = now_ns;
  return writer;
}

core::Result<void> TapWriter::Open(std::int64_t now_ns) {
  std::filesystem::path path = file_.path;
  if (!files_.empty()) path.replace_extension("." + std::to_string(files_.size()) + file_.path.extension().string());
  auto writer = McapWriter::Create(path, {"", "vr-oos"});
  if (!writer) return tl::unexpected(writer.error());
  writer_ = std::move(*writer);
  schemas_.clear();
  channels_.clear();
  clocks_.BeginFile();
  begun_ns_ = now_ns;
  const TextMap part = {{"node", file_.node},
                        {"part", std::to_string(files_.size())},
                        {"clock", "CLOCK_MONOTONIC of the node's machine"},
                        {"begun_ns", std::to_string(now_ns)}};
  if (auto done = writer_->Write(Metadata{"recording", part}); !done) return done;
  for (const Metadata& metadata : file_.metadata) {
    if (auto done = writer_->Write(metadata); !done) return done;
  }
  if (files_.empty()) {
    for (const Attachment& attachment : file_.attachments) {
      if (auto done = writer_->Write(attachment); !done) return done;
    }
  }
  files_.push_back(path);
  return {};
}

std::uint16_t TapWriter::SchemaNamed(const std::string& name, const std::string& descriptors) {
  if (name.empty()) return 0;
  const auto [schema, is_new] = schemas_.try_emplace(name, std::uint16_t{0});
  if (is_new) schema->second = writer_->AddSchema(name, "protobuf", ToBytes(descriptors));
  return schema->second;
}

std::uint16_t TapWriter::ChannelOf(std::uint16_t slot, const std::string& key) {
  const auto [channel, is_new] = channels_.try_emplace({slot, key}, std::uint16_t{0});
  if (!is_new) return channel->second;
  const TapTopic& topic = tap_->topic(slot);
  TextMap metadata = {{"class", std::string(bus::NameOf(topic.topic_class))}, {"tap", NameOf(topic.kind)}};
  metadata[topic.kind == TapKind::kTaken ? "reader" : "writer"] = file_.node;
  if (!key.empty()) metadata["key"] = key;
  const bool is_reference = topic.kind == TapKind::kTaken && topic.topic_class == TopicClass::kLatest;
  const std::uint16_t schema = is_reference
                                   ? SchemaNamed("oos.TakenSample", DescriptorSetOf(*oos::TakenSample::descriptor()))
                                   : SchemaNamed(topic.schema, topic.descriptors);
  channel->second = writer_->AddChannel(schema, ChannelName(topic, file_.node), "protobuf", metadata);
  return channel->second;
}

core::Result<void> TapWriter::Write(const TapHead& entry, std::span<const std::uint8_t> head,
                                    std::span<const std::uint8_t> payload) {
  const TapTopic& topic = tap_->topic(entry.slot);
  Message message;
  message.sequence = static_cast<std::uint32_t>(entry.sequence);
  message.log_time_ns = static_cast<std::uint64_t>(entry.time_ns);
  message.publish_time_ns = static_cast<std::uint64_t>(entry.publish_ns > 0 ? entry.publish_ns : entry.time_ns);
  message.data.assign(payload.begin(), payload.end());
  std::string key;
  if (topic.topic_class != TopicClass::kLatest || topic.kind == TapKind::kStep) {
    key.assign(head.begin(), head.end());
  } else if (head.size() == sizeof(Envelope)) {
    Envelope envelope;
    std::memcpy(&envelope, head.data(), sizeof envelope);
    if (topic.kind == TapKind::kSent) {
      AppendEnvelope(envelope, &message.data);
    } else {
      message.data = ToBytes(SampleOf(envelope, entry).SerializeAsString());
    }
  }
  message.channel_id = ChannelOf(entry.slot, key);
  ++num_messages_;
  return writer_->Write(message);
}

void TapWriter::Note(core::Result<void> done) {
  if (!done && !error_) error_ = done.error();
}

core::Result<void> TapWriter::WriteDrops(std::int64_t now_ns) {
  TextMap lost;
  reported_drops_.resize(std::max(reported_drops_.size(), tap_->num_topics()));
  unwritten_.resize(reported_drops_.size());
  for (std::size_t slot = 0; slot < reported_drops_.size(); ++slot) {
    const std::uint64_t dropped = tap_->dropped(slot) + unwritten_[slot];
    if (dropped == reported_drops_[slot]) continue;
    lost[ChannelName(tap_->topic(slot), file_.node)] = std::to_string(dropped - reported_drops_[slot]);
    num_dropped_ += dropped - reported_drops_[slot];
    reported_drops_[slot] = dropped;
  }
  if (lost.empty() || error_) return {};
  lost["until_ns"] = std::to_string(now_ns);
  lost["why"] = "the node's ring was full: the disk was too slow";
  return writer_->Write(Metadata{"dropped", lost});
}

void TapWriter::Service(std::int64_t now_ns) {
  tap_->Drain([this](const TapHead& entry, std::span<const std::uint8_t> head, std::span<const std::uint8_t> payload) {
    if (!error_) Note(Write(entry, head, payload));
    if (!error_) return;
    unwritten_.resize(std::max(unwritten_.size(), tap_->num_topics()));
    ++unwritten_[entry.slot];
  });
  Note(WriteDrops(now_ns));
  if (error_) return;
  if (clocks_.is_due(now_ns)) Note(clocks_.Write(file_.node, tap_->Clocks(), now_ns, writer_.get()));
  if (now_ns - flushed_ns_ < kFlushPeriod_ns) return;
  flushed_ns_ = now_ns;
  Note(writer_->Flush());
  const bool is_full = file_.split_bytes != 0 && writer_->num_bytes() >= file_.split_bytes;
  const bool is_old = file_.split_ns != 0 && now_ns - begun_ns_ >= file_.split_ns;
  if (error_ || (!is_full && !is_old)) return;
  // No fsync here: it may take long, and the ring would overflow.
  Note(writer_->Close(McapWriter::ToDisk::kLater));
  if (!error_) Note(Open(now_ns));
}

core::Result<void> TapWriter::Close(std::int64_t now_ns) {
  Service(now_ns);
  if (!error_) Note(writer_->Close());
  if (!error_) return {};
  return core::Fail(error_->code, error_->detail + "; " + std::to_string(num_dropped_) + " messages are not recorded");
}

}  // namespace bus::log
