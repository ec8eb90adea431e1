#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "bus/topics.hpp"

namespace google::protobuf {
class Descriptor;
}

namespace bus {

// The shape of a payload, taken from its protobuf descriptor.
struct PayloadSchema {
  std::string name;          // "oos.PhysicsState"
  std::string canonical;     // fields by ascending number, "1:uint64 2:sint64 6:repeated uint32 5:repeated {1:float}"
  std::uint32_t digest = 0;  // of the canonical text
};

const PayloadSchema& SchemaOf(MessageType type);

// Two shapes are compatible when every field number that both have has the same type: proto3 readers skip unknown
// fields. Otherwise false, and `why` names the first field that differs.
bool AreCompatible(const std::string& canonical_a, const std::string& canonical_b, std::string* why);

// A serialized FileDescriptorSet with the payload's message and all that it refers to; a recording carries it so that
// any reader can decode its payloads.
std::string DescriptorSetOf(MessageType type);
std::string DescriptorSetOf(const google::protobuf::Descriptor& message);

// The payload for people, one field a line; a note when it cannot be read.
std::string PayloadText(MessageType type, std::span<const std::uint8_t> payload);

}  // namespace bus
