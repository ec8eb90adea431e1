#include "bus/wire/control.hpp"

#include "bus/node_core.hpp"
#include "core/clock.hpp"
#include "proto/bus.pb.h"

namespace bus::detail {

std::vector<std::uint8_t> EncodeControl(const Identity& identity, TopicClass topic_class, const oos::Control& control) {
  Envelope envelope;
  envelope.topic_class = topic_class;
  envelope.schema_digest = kProtocolVersion;
  envelope.session = identity.session;
  envelope.node = identity.node;
  envelope.boot = identity.boot;
  envelope.header.publish_ns = core::MonotonicNow_ns();
  const std::size_t payload = control.ByteSizeLong();
  std::vector<std::uint8_t> bytes(kEnvelopeFixedBytes + payload);
  control.SerializeWithCachedSizesToArray(bytes.data() + kEnvelopeFixedBytes);
  WriteEnvelope(envelope, payload, bytes.data());
  return bytes;
}

bool DecodeControl(std::span<const std::uint8_t> bytes, std::uint64_t session, oos::Control* control) {
  Envelope envelope;
  std::span<const std::uint8_t> payload;
  return bytes.size() <= kMaxMessageBytes && ReadEnvelope(bytes, &envelope, &payload) == EnvelopeStatus::kOk &&
         envelope.session == session && envelope.topic_class != TopicClass::kLatest &&
         control->ParseFromArray(payload.data(), static_cast<int>(payload.size()));
}

TopicClass ClassOf(const oos::Control& control) {
  switch (control.body_case()) {
    case oos::Control::kSubscribe:
    case oos::Control::kSubscribeAck:
    case oos::Control::kStateSnapshot:
    case oos::Control::kStateDelta:
      return TopicClass::kState;
    case oos::Control::kEvent:
    case oos::Control::kEventAck:
    case oos::Control::kEviction:
      return TopicClass::kEvent;
    case oos::Control::kParameterRequest:
    case oos::Control::kParameterReply:
      return TopicClass::kService;
    default:
      return TopicClass::kControl;
  }
}

}  // namespace bus::detail
