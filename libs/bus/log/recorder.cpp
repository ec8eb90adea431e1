#include "bus/log/recorder.hpp"

#include "bus/log/recorded_payload.hpp"
#include "bus/schema.hpp"

namespace bus::log {
namespace {

Bytes BytesOf(const std::string& text) {
  return {text.begin(), text.end()};
}

}  // namespace

core::Result<std::unique_ptr<Recorder>> Recorder::Create(const std::filesystem::path& path, const TextMap& about,
                                                         const std::vector<Metadata>& more) {
  auto writer = McapWriter::Create(path, {"", "vr-oos"});
  if (!writer) return tl::unexpected(writer.error());
  if (auto done = (*writer)->Write(Metadata{"recording", about}); !done) return tl::unexpected(done.error());
  for (const Metadata& metadata : more) {
    if (auto done = (*writer)->Write(metadata); !done) return tl::unexpected(done.error());
  }
  return std::unique_ptr<Recorder>(new Recorder(std::move(*writer)));
}

std::uint16_t Recorder::ChannelOf(const Observation& observation) {
  const auto [channel, is_new] = channels_.try_emplace({observation.topic, observation.writer}, std::uint16_t{0});
  if (!is_new) return channel->second;
  const auto [schema, is_new_schema] = schemas_.try_emplace(observation.type, std::uint16_t{0});
  if (is_new_schema && observation.type != MessageType::kNone) {
    schema->second =
        writer_->AddSchema(SchemaOf(observation.type).name, "protobuf", BytesOf(DescriptorSetOf(observation.type)));
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
                  BytesOf(observation.payload)};
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
  return writer_->Flush();
}

core::Result<void> Recorder::Close(std::int64_t now_ns, std::uint64_t num_dropped) {
  if (auto done = Tick(now_ns, num_dropped); !done) return done;
  return writer_->Close();
}

}  // namespace bus::log
