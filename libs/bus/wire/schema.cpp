#include "bus/wire/schema.hpp"

#include <google/protobuf/descriptor.h>
#include <google/protobuf/descriptor.pb.h>

#include <algorithm>
#include <array>
#include <map>
#include <memory>
#include <set>
#include <vector>

#include "core/hash.hpp"
#include "proto/bulk.pb.h"
#include "proto/camera.pb.h"
#include "proto/device.pb.h"
#include "proto/haptic.pb.h"
#include "proto/logic.pb.h"
#include "proto/physics.pb.h"
#include "proto/rays.pb.h"
#include "proto/viewing.pb.h"

namespace bus {
namespace {

using google::protobuf::Descriptor;
using google::protobuf::FieldDescriptor;

const google::protobuf::Message* Prototype(MessageType type) {
  switch (type) {
#define PROTOTYPE(Message)      \
  case MessageType::k##Message: \
    return &oos::Message::default_instance();
    BUS_MESSAGES(PROTOTYPE)
#undef PROTOTYPE
    case MessageType::kNone:
      break;
  }
  return nullptr;
}

// Names are left out: they are not on the wire.
std::string Canonical(const Descriptor& descriptor) {
  std::vector<const FieldDescriptor*> fields;
  for (int i = 0; i < descriptor.field_count(); ++i) fields.push_back(descriptor.field(i));
  std::sort(fields.begin(), fields.end(), [](const auto* a, const auto* b) { return a->number() < b->number(); });
  std::string text;
  for (const FieldDescriptor* field : fields) {
    if (!text.empty()) text += ' ';
    text += std::to_string(field->number()) + ':';
    if (field->is_repeated()) text += "repeated_";
    text += field->message_type() != nullptr ? '{' + Canonical(*field->message_type()) + '}'
                                             : std::string(field->type_name());
  }
  return text;
}

// Splits at the top level: "1:double 2:{1:float 2:float}" -> {1: "double", 2: "{1:float 2:float}"}.
std::map<std::string, std::string> Fields(const std::string& canonical) {
  std::map<std::string, std::string> fields;
  std::size_t begin = 0;
  int depth = 0;
  for (std::size_t i = 0; i <= canonical.size(); ++i) {
    if (i < canonical.size() && canonical[i] == '{') ++depth;
    if (i < canonical.size() && canonical[i] == '}') --depth;
    if (i < canonical.size() && (canonical[i] != ' ' || depth > 0)) continue;
    const std::string field = canonical.substr(begin, i - begin);
    const std::size_t colon = field.find(':');
    if (colon != std::string::npos) fields[field.substr(0, colon)] = field.substr(colon + 1);
    begin = i + 1;
  }
  return fields;
}

// "repeated_{...}" -> inner text, or empty when the type is not a message.
std::string Inner(const std::string& type) {
  const std::size_t open = type.find('{');
  return open == std::string::npos ? std::string() : type.substr(open + 1, type.size() - open - 2);
}

// Schemas come from other processes: none of this build's nests deeper than 3.
constexpr int kMaxNesting = 16;

bool AreCompatible(const std::string& canonical_a, const std::string& canonical_b, int depth, std::string* why) {
  if (depth > kMaxNesting) {
    *why = "messages are nested more than " + std::to_string(kMaxNesting) + " deep";
    return false;
  }
  const auto a = Fields(canonical_a);
  const auto b = Fields(canonical_b);
  for (const auto& [number, type] : a) {
    const auto found = b.find(number);
    if (found == b.end() || found->second == type) continue;
    const bool both_messages = !Inner(type).empty() && !Inner(found->second).empty() &&
                               (type.front() == 'r') == (found->second.front() == 'r');
    if (both_messages && AreCompatible(Inner(type), Inner(found->second), depth + 1, why)) continue;
    *why = "field " + number + " is " + type + " in one and " + found->second + " in the other";
    return false;
  }
  return true;
}

// proto/options.proto is for proto/generate.py alone: readers of recordings need neither the file nor its options.
constexpr const char* kOptionsFile = "proto/options.proto";

template <class Described>
void RemoveOwnOptions(Described* described) {
  if (!described->has_options()) return;
  auto* options = described->mutable_options();
  std::vector<const FieldDescriptor*> set;
  options->GetReflection()->ListFields(*options, &set);
  for (const FieldDescriptor* field : set) {
    if (field->is_extension()) options->GetReflection()->ClearField(options, field);
  }
  if (options->ByteSizeLong() == 0) described->clear_options();
}

void RemoveOwnOptions(google::protobuf::FileDescriptorProto* file) {
  auto* dependencies = file->mutable_dependency();
  dependencies->erase(std::remove(dependencies->begin(), dependencies->end(), kOptionsFile), dependencies->end());
  for (google::protobuf::DescriptorProto& message : *file->mutable_message_type()) {
    RemoveOwnOptions<google::protobuf::DescriptorProto>(&message);
    for (google::protobuf::FieldDescriptorProto& field : *message.mutable_field()) RemoveOwnOptions(&field);
  }
}

// A file behind those that it imports, each once.
void AddFile(const google::protobuf::FileDescriptor& file, std::set<std::string>* known,
             google::protobuf::FileDescriptorSet* set) {
  if (file.name() == kOptionsFile || !known->insert(file.name()).second) return;
  for (int i = 0; i < file.dependency_count(); ++i) AddFile(*file.dependency(i), known, set);
  google::protobuf::FileDescriptorProto* added = set->add_file();
  file.CopyTo(added);
  RemoveOwnOptions(added);
}

}  // namespace

std::string DescriptorSetOf(MessageType type) {
  const google::protobuf::Message* prototype = Prototype(type);
  return prototype == nullptr ? std::string() : DescriptorSetOf(*prototype->GetDescriptor());
}

std::string DescriptorSetOf(const Descriptor& message) {
  google::protobuf::FileDescriptorSet set;
  std::set<std::string> known;
  AddFile(*message.file(), &known, &set);
  return set.SerializeAsString();
}

const PayloadSchema& SchemaOf(MessageType type) {
  static const auto schemas = [] {
    std::map<MessageType, PayloadSchema> all;
    for (int i = 1; i <= static_cast<int>(kLastMessageType); ++i) {
      const auto known = static_cast<MessageType>(i);
      const Descriptor& descriptor = *Prototype(known)->GetDescriptor();
      PayloadSchema schema{descriptor.full_name(), Canonical(descriptor), 0};
      schema.digest = static_cast<std::uint32_t>(core::Hash64(schema.canonical));
      all[known] = std::move(schema);
    }
    return all;
  }();
  static const PayloadSchema none;
  const auto found = schemas.find(type);
  return found == schemas.end() ? none : found->second;
}

bool AreCompatible(const std::string& canonical_a, const std::string& canonical_b, std::string* why) {
  return AreCompatible(canonical_a, canonical_b, 0, why);
}

std::string PayloadText(MessageType type, std::span<const std::uint8_t> payload) {
  const google::protobuf::Message* prototype = Prototype(type);
  if (prototype == nullptr) return "(unknown message type)\n";
  const std::unique_ptr<google::protobuf::Message> message(prototype->New());
  if (!message->ParseFromArray(payload.data(), static_cast<int>(payload.size()))) return "(not readable)\n";
  return message->DebugString();
}

}  // namespace bus
