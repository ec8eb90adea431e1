#include "bus/log/payload_decoder.hpp"

#include <google/protobuf/descriptor.pb.h>
#include <google/protobuf/dynamic_message.h>
#include <google/protobuf/util/json_util.h>
#include <google/protobuf/util/message_differencer.h>

#include <map>

namespace bus::log {

namespace {

using Payload = google::protobuf::Message;

core::Result<void> Parse(const Schema& schema, std::span<const std::uint8_t> payload, Payload* message) {
  if (!message->ParseFromArray(payload.data(), static_cast<int>(payload.size()))) {
    return core::Fail(core::ErrorCode::kDamaged, "a payload is no '" + schema.name + "'");
  }
  message->DiscardUnknownFields();  // the envelope behind a recorded payload
  return {};
}

}  // namespace

struct PayloadDecoder::Impl {
  // Of one schema: messages must go before their factory, and that before its pool.
  struct Known {
    google::protobuf::DescriptorPool pool;
    google::protobuf::DynamicMessageFactory factory{&pool};
    std::unique_ptr<Payload> message;
  };
  std::map<std::uint16_t, Known> known;

  core::Result<Payload*> MessageOf(const Schema& schema) {
    if (schema.encoding != "protobuf") {
      return core::Fail(core::ErrorCode::kUnsupported, "'" + schema.name + "' is encoded as '" + schema.encoding + "'");
    }
    const auto [place, is_new] = known.try_emplace(schema.id);
    Known& its = place->second;
    if (is_new) {
      google::protobuf::FileDescriptorSet set;
      if (set.ParseFromArray(schema.data.data(), static_cast<int>(schema.data.size()))) {
        for (const auto& file : set.file()) its.pool.BuildFile(file);
      }
      if (const auto* type = its.pool.FindMessageTypeByName(schema.name)) {
        its.message.reset(its.factory.GetPrototype(type)->New());
      }
    }
    if (its.message == nullptr) {
      return core::Fail(core::ErrorCode::kDamaged,
                        "the recording's descriptor of '" + schema.name + "' cannot be read");
    }
    return its.message.get();
  }
};

PayloadDecoder::PayloadDecoder() : impl_(std::make_unique<Impl>()) {}
PayloadDecoder::~PayloadDecoder() = default;

core::Result<std::string> PayloadDecoder::ToJson(const Schema& schema, std::span<const std::uint8_t> payload) {
  const auto message = impl_->MessageOf(schema);
  if (!message) return tl::unexpected(message.error());
  if (auto done = Parse(schema, payload, *message); !done) return tl::unexpected(done.error());
  google::protobuf::util::JsonPrintOptions options;
  options.preserve_proto_field_names = true;
  std::string json;
  if (!google::protobuf::util::MessageToJsonString(**message, &json, options).ok()) {
    return core::Fail(core::ErrorCode::kDamaged, "a '" + schema.name + "' has no form as JSON");
  }
  return json;
}

core::Result<std::string> PayloadDecoder::Difference(const Schema& schema, std::span<const std::uint8_t> a,
                                                     std::span<const std::uint8_t> b) {
  const auto message = impl_->MessageOf(schema);
  if (!message) return tl::unexpected(message.error());
  const std::unique_ptr<Payload> first((*message)->New());
  const std::unique_ptr<Payload> second((*message)->New());
  if (auto done = Parse(schema, a, first.get()); !done) return tl::unexpected(done.error());
  if (auto done = Parse(schema, b, second.get()); !done) return tl::unexpected(done.error());
  google::protobuf::util::MessageDifferencer differencer;
  std::string report;
  differencer.ReportDifferencesToString(&report);
  if (differencer.Compare(*first, *second)) return std::string("the same fields, written in another way");
  return report;
}

}  // namespace bus::log
