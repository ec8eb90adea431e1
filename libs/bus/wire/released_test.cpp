// proto/ against its last release: fields may be added; released ones keep their meaning.
//
//   OOS_WRITE_RELEASE=proto/released/2.txt bus_test --gtest_filter='Released.*'   writes a new one

#include <google/protobuf/descriptor.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "proto/bulk.pb.h"
#include "proto/bus.pb.h"
#include "proto/camera.pb.h"
#include "proto/device.pb.h"
#include "proto/haptic.pb.h"
#include "proto/logic.pb.h"
#include "proto/physics.pb.h"
#include "proto/rays.pb.h"
#include "proto/recording.pb.h"
#include "proto/viewing.pb.h"

namespace bus {
namespace {

using google::protobuf::Descriptor;
using google::protobuf::FieldDescriptor;
using google::protobuf::FileDescriptor;

constexpr const char* kRelease = VR_OOS_SOURCE_DIR "/proto/released/1.txt";

// "oos.PhysicsState 3" -> "repeated oos.BodyState bodies".
using Listing = std::map<std::string, std::string>;

std::string TypeOf(const FieldDescriptor& field) {
  const std::string type = field.message_type() != nullptr ? field.message_type()->full_name()
                           : field.enum_type() != nullptr  ? field.enum_type()->full_name()
                                                           : std::string(field.type_name());
  return (field.is_repeated() ? "repeated " : "") + type;
}

void List(const Descriptor& message, Listing* listing) {
  for (int i = 0; i < message.field_count(); ++i) {
    const FieldDescriptor& field = *message.field(i);
    (*listing)[message.full_name() + " " + std::to_string(field.number())] = TypeOf(field) + " " + field.name();
  }
  for (int i = 0; i < message.reserved_range_count(); ++i) {
    for (int number = message.reserved_range(i)->start; number < message.reserved_range(i)->end; ++number) {
      (*listing)[message.full_name() + " " + std::to_string(number)] = "reserved";
    }
  }
  for (int i = 0; i < message.nested_type_count(); ++i) List(*message.nested_type(i), listing);
}

Listing ListFile(const FileDescriptor& file) {
  Listing listing;
  for (int i = 0; i < file.message_type_count(); ++i) List(*file.message_type(i), &listing);
  return listing;
}

std::vector<const FileDescriptor*> Files() {
  return {oos::BulkMessage::descriptor()->file(), oos::CameraImage::descriptor()->file(),
          oos::Control::descriptor()->file(),     oos::DeviceState::descriptor()->file(),
          oos::HapticProxy::descriptor()->file(), oos::HeadState::descriptor()->file(),
          oos::LogicStatus::descriptor()->file(), oos::PhysicsState::descriptor()->file(),
          oos::RayFrame::descriptor()->file(),    oos::TakenSample::descriptor()->file()};
}

Listing ListAll() {
  Listing listing;
  for (const FileDescriptor* file : Files()) listing.merge(ListFile(*file));
  return listing;
}

Listing Read(std::istream& in) {
  Listing listing;
  for (std::string message, number, rest; in >> message >> number && std::getline(in >> std::ws, rest);) {
    listing[message + " " + number] = rest;
  }
  return listing;
}

// A field may be added, renamed, or given up when its number is reserved. Its type stays.
std::vector<std::string> FindBreaks(const Listing& released, const Listing& now) {
  const auto type_of = [](const std::string& text) { return text.substr(0, text.rfind(' ')); };
  std::vector<std::string> breaks;
  for (const auto& [field, was] : released) {
    const auto is = now.find(field);
    if (is == now.end()) {
      breaks.push_back(field + " (" + was + ") is gone; reserve its number");
    } else if (was == "reserved" && is->second != "reserved") {
      breaks.push_back(field + " was given up, and is used again as " + is->second);
    } else if (is->second != "reserved" && type_of(is->second) != type_of(was)) {
      breaks.push_back(field + " was " + was + ", and is " + is->second + "; take a new number");
    }
  }
  return breaks;
}

TEST(Released, WhatIsOnTheWireKeepsItsMeaning) {
  const Listing now = ListAll();
  if (const char* file = std::getenv("OOS_WRITE_RELEASE")) {
    std::ofstream out(file);
    for (const auto& [field, text] : now) out << field << ' ' << text << '\n';
    ASSERT_TRUE(out.good()) << file;
  }
  std::ifstream in(kRelease);
  const Listing released = Read(in);
  ASSERT_GT(released.size(), 100u) << kRelease;
  for (const std::string& line : FindBreaks(released, now)) ADD_FAILURE() << line;
}

TEST(Released, HoldsEveryFileOfProto) {
  std::ifstream in(kRelease);
  const Listing released = Read(in);
  std::set<std::string> held;
  for (const FileDescriptor* file : Files()) {
    for (const auto& [field, text] : ListFile(*file)) {
      if (released.count(field) != 0) held.insert(file->name());
    }
  }
  for (const auto& entry : std::filesystem::directory_iterator(VR_OOS_SOURCE_DIR "/proto")) {
    const std::string name = "proto/" + entry.path().filename().string();
    if (entry.path().extension() != ".proto" || name == "proto/foxglove.proto") continue;  // Foxglove's, not ours
    if (name == "proto/options.proto") continue;                                           // on no wire
    if (name == "proto/web_scene.proto") continue;  // from scene_stream to the page that it comes with, of one version
    EXPECT_EQ(held.count(name), 1u) << name << " can be changed without notice: list it here and in " << kRelease;
  }
}

TEST(Released, BreaksAreNamedAndAdditionsAreNot) {
  std::istringstream was("m 1 double x\nm 2 repeated float y\nm 3 uint64 z\nm 4 reserved\n");
  std::istringstream is("m 1 float x\nm 2 repeated float why\nm 4 uint32 back\nm 5 string new\n");
  EXPECT_EQ(FindBreaks(Read(was), Read(is)),
            (std::vector<std::string>{"m 1 was double x, and is float x; take a new number",
                                      "m 3 (uint64 z) is gone; reserve its number",
                                      "m 4 was given up, and is used again as uint32 back"}));
}

}  // namespace
}  // namespace bus
