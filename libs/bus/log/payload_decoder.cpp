#include "bus/log/payload_decoder.hpp"

#include <google/protobuf/descriptor.pb.h>
#include <google/protobuf/dynamic_message.h>
#include <google/protobuf/util/json_util.h>

#include <map>

namespace bus::log {

struct PayloadDecoder::Impl {
  // Of one schema: messages must go before their factory, and that before its pool.
  struct Known {
    google::protobuf::DescriptorPool pool;
    google::protobuf::DynamicMessageFactory factory{&pool};
    std::unique_ptr<google::protobuf::Message> message;
  };
  std::map<std::uint16_t, Known> known;
};

PayloadDecoder::PayloadDecoder() : impl_(std::make_unique<Impl>()) {}
PayloadDecoder::~PayloadDecoder() = default;

core::Result<std::string> PayloadDecoder::ToJson(const Schema& schema, std::span<const std::uint8_t> payload) {
  if (schema.encoding != "protobuf") {
    return core::Fail(core::ErrorCode::kUnsupported, "'" + schema.name + "' is encoded as '" + schema.encoding + "'");
  }
  const auto [place, is_new] = impl_->known.try_emplace(schema.id);
  Impl::Known& known = place->second;
  if (is_new) {
    google::protobuf::FileDescriptorSet set;
    if (set.ParseFromArray(schema.data.data(), static_cast<int>(schema.data.size()))) {
      for (const auto& file : set.file()) known.pool.BuildFile(file);
    }
    if (const auto* type = known.pool.FindMessageTypeByName(schema.name)) {
      known.message.reset(known.factory.GetPrototype(type)->New());
    }
  }
  if (known.message == nullptr) {
    return core::Fail(core::ErrorCode::kDamaged, "the recording's descriptor of '" + schema.name + "' cannot be read");
  }
  if (!known.message->ParseFromArray(payload.data(), static_cast<int>(payload.size()))) {
    return core::Fail(core::ErrorCode::kDamaged, "a payload is no '" + schema.name + "'");
  }
  google::protobuf::util::JsonPrintOptions options;
  options.preserve_proto_field_names = true;
  std::string json;
  if (!google::protobuf::util::MessageToJsonString(*known.message, &json, options).ok()) {
    return core::Fail(core::ErrorCode::kDamaged, "a '" + schema.name + "' has no form as JSON");
  }
  return json;
}

}  // namespace bus::log
