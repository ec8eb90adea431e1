#include "bus/log/recorder.hpp"

#include <cstdlib>

#include "bus/log/recorded_payload.hpp"
#include "bus/log/tap_points.hpp"
#include "bus/wire/schema.hpp"

namespace bus::log {
core::Result<Split> ReadSplit(const std::string& megabytes, const std::string& seconds) {
  const auto read = [](const std::string& text, double* number) {
    if (text.empty()) return true;
    char* end = nullptr;
    *number = std::strtod(text.c_str(), &end);
    return end == text.c_str() + text.size() && *number >= 0.0 && *number <= 1e9;
  };
  double split_MB = 0.0, split_s = 0.0;
  if (!read(megabytes, &split_MB) || !read(seconds, &split_s)) {
    return core::Fail(core::ErrorCode::kInvalidInput, "--split_MB and --split_s need numbers from 0 to 1e9; 0: never");
  }
  return Split{static_cast<std::uint64_t>(split_MB * 1e6), static_cast<std::int64_t>(split_s * 1e9)};
}

core::Result<std::unique_ptr<Recorder>> Recorder::Create(const std::filesystem::path& path, const TextMap& about,
                                                         const std::vector<Metadata>& more, Split split) {
  std::vector<Metadata> front = {{"recording", about}};
  front.insert(front.end(), more.begin(), more.end());
  std::unique_ptr<Recorder> recorder(new Recorder(path, std::move(front), split));
  if (auto done = recorder->Open(); !done) return tl::unexpected(done.error());
  return recorder;
}

core::Result<void> Recorder::Open() {
  std::filesystem::path path = path_;
  if (!files_.empty()) path.replace_extension("." + std::to_string(files_.size()) + path_.extension().string());
  auto writer = McapWriter::Create(path, {"", "vr-oos"});
  if (!writer) return tl::unexpected(writer.error());
  if (writer_ != nullptr) num_bytes_before_ += writer_->num_bytes();
  writer_ = std::move(*writer);
  schemas_.clear();
  channels_.clear();
  clocks_.BeginFile();
  begun_ns_ = 0;
  front_.front().entries["part"] = std::to_string(files_.size());
  for (const Metadata& metadata : front_) {
    if (auto done = writer_->Write(metadata); !done) return done;
  }
  files_.push_back(path);
  return {};
}

core::Result<void> Recorder::Write(const Metadata& metadata) {
  front_.push_back(metadata);
  return writer_->Write(metadata);
}

core::Result<void> Recorder::Write(const Attachment& attachment) {
  return writer_->Write(attachment);
}

core::Result<void> Recorder::WriteClocks(const Node& node, std::int64_t now_ns) {
  if (!clocks_.is_due(now_ns)) return {};
  return clocks_.Write(node.name(), detail::ClocksOf(node.Peers()), now_ns, writer_.get());
}

std::uint16_t Recorder::ChannelOf(const Observation& observation) {
  const auto [channel, is_new] = channels_.try_emplace({observation.topic, observation.writer}, std::uint16_t{0});
  if (!is_new) return channel->second;
  const auto [schema, is_new_schema] = schemas_.try_emplace(observation.type, std::uint16_t{0});
  if (is_new_schema && observation.type != MessageType::kNone) {
    schema->second =
        writer_->AddSchema(SchemaOf(observation.type).name, "protobuf", ToBytes(DescriptorSetOf(observation.type)));
  }
  channel->second =
      writer_->AddChannel(schema->second, observation.topic, "protobuf",
                          {{"writer", observation.writer}, {"class", std::string(NameOf(observation.topic_class))}});
  return channel->second;
}

core::Result<void> Recorder::Add(const Observation& observation) {
  const auto log_ns = static_cast<std::uint64_t>(observation.received_ns);
  const auto publish_ns = observation.publish_ns > 0 ? static_cast<std::uint64_t>(observation.publish_ns) : log_ns;
  Message message{ChannelOf(observation), static_cast<std::uint32_t>(observation.sequence), log_ns, publish_ns,
                  ToBytes(observation.payload)};
  if (observation.topic_class == TopicClass::kLatest) {
    Envelope envelope;
    envelope.part = static_cast<std::uint8_t>(observation.part);
    envelope.num_parts = static_cast<std::uint8_t>(observation.num_parts);
    envelope.topic = TopicId(observation.topic);
    envelope.node = TopicId(observation.writer);
    envelope.schema_digest = SchemaOf(observation.type).digest;
    envelope.header.sequence = observation.sequence;
    envelope.header.publish_ns = observation.publish_ns;
    AppendEnvelope(envelope, &message.data);
  }
  ++num_messages_;
  return writer_->Write(message);
}

core::Result<void> Recorder::Tick(std::int64_t now_ns, std::uint64_t num_dropped) {
  if (num_dropped > num_dropped_) {
    const Metadata loss{"dropped",
                        {{"count", std::to_string(num_dropped - num_dropped_)},
                         {"until_ns", std::to_string(now_ns)},
                         {"why", "the recorder was too slow"}}};
    num_dropped_ = num_dropped;
    if (auto done = writer_->Write(loss); !done) return done;
  }
  if (now_ns - flushed_ns_ < kFlushPeriod_ns / 2) return {};
  flushed_ns_ = now_ns;
  if (auto done = writer_->Flush(); !done) return done;
  if (begun_ns_ == 0) begun_ns_ = now_ns;
  const bool is_full = split_.bytes != 0 && writer_->num_bytes() >= split_.bytes;
  const bool is_old = split_.age_ns != 0 && now_ns - begun_ns_ >= split_.age_ns;
  if (!is_full && !is_old) return {};
  // No fsync here: it may take long, and the node would have to drop what arrives meanwhile.
  if (auto done = writer_->Close(McapWriter::ToDisk::kLater); !done) return done;
  return Open();
}

core::Result<void> Recorder::Close(std::int64_t now_ns, std::uint64_t num_dropped) {
  if (auto done = Tick(now_ns, num_dropped); !done) return done;
  return writer_->Close();
}

}  // namespace bus::log
