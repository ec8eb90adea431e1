#include "bus/log/payload_decoder.hpp"
#include "bus/wire/schema.hpp"
#include "tests/fuzz/quiet_protobuf.hpp"
#include "tests/fuzz/reader.hpp"

namespace fuzz {

// The payload of one of this build's messages, or of a message with its own descriptor, as a recording may contain.
void FuzzPayloadJson(Input input) {
  QuietProtobuf();
  Reader reader(input);
  const std::uint8_t kind = reader.Byte() % 16;
  const auto type = static_cast<bus::MessageType>(kind);
  if (kind != 0 && kind <= static_cast<std::uint8_t>(bus::kLastMessageType)) {
    static bus::log::PayloadDecoder known;
    bus::log::Schema schema{kind, bus::SchemaOf(type).name, "protobuf", {}};
    const std::string descriptors = bus::DescriptorSetOf(type);
    schema.data.assign(descriptors.begin(), descriptors.end());
    (void)known.ToJson(schema, reader.Rest());
    (void)bus::PayloadText(type, reader.Rest());
    return;
  }
  bus::log::PayloadDecoder decoder;
  bus::log::Schema schema{1, TextOf(reader.Piece()), "protobuf", {}};
  const Input descriptors = reader.Piece();
  schema.data.assign(descriptors.begin(), descriptors.end());
  (void)decoder.ToJson(schema, reader.Rest());
}

}  // namespace fuzz
