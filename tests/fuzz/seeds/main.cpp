#include <algorithm>
#include <array>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <span>
#include <string>
#include <vector>

#include "bus/bulk/bulk.hpp"
#include "bus/latest/history.hpp"
#include "bus/log/mcap_writer.hpp"
#include "bus/security/keys.hpp"
#include "bus/wire/codec.hpp"
#include "bus/wire/control.hpp"
#include "bus/wire/envelope.hpp"
#include "bus/wire/schema.hpp"
#include "physics/checkpoint_file.hpp"
#include "proto/bulk.pb.h"
#include "proto/bus.pb.h"
#include "replay/fields.hpp"
#include "replay/step_codec.hpp"
#include "tests/fuzz/bulk_blocks.hpp"

// write_fuzz_seeds FOLDER: writes valid messages and files as first inputs of the fuzzers, by the code that writes them
// in a run. Texts come from scenarios/.

namespace {

using Bytes = std::vector<std::uint8_t>;
constexpr std::size_t kBudget = bus::kMaxDatagramBytes - bus::kEnvelopeFixedBytes;

void Keep(const std::filesystem::path& folder, const std::string& name, std::span<const std::uint8_t> bytes) {
  std::filesystem::create_directories(folder);
  std::ofstream out(folder / name, std::ios::binary);
  out.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
}

void AppendPiece(std::span<const std::uint8_t> piece, Bytes* out) {
  out->push_back(static_cast<std::uint8_t>(piece.size()));
  out->push_back(static_cast<std::uint8_t>(piece.size() >> 8));
  out->insert(out->end(), piece.begin(), piece.end());
}
void AppendPiece(const std::string& text, Bytes* out) {
  AppendPiece(std::span(reinterpret_cast<const std::uint8_t*>(text.data()), text.size()), out);
}

template <class M>
Bytes PartsOf(std::uint8_t kind, const M& message) {
  bus::LatestCodec<M> codec;
  Bytes input{kind};
  std::array<std::uint8_t, kBudget> bytes;
  for (int part = 0; part < codec.NumParts(message, kBudget); ++part) {
    AppendPiece({bytes.data(), codec.Encode(message, part, kBudget, bytes.data(), bytes.size())}, &input);
  }
  return input;
}

template <class M>
Bytes StateOf(std::uint8_t kind, const M& value) {
  std::string bytes;
  bus::EncodeState(value, &bytes);
  Bytes input{kind};
  input.insert(input.end(), bytes.begin(), bytes.end());
  return input;
}

core::PhysicsState SomeState() {
  core::PhysicsState state;
  for (std::uint16_t i = 0; i < 3; ++i) {
    state.bodies.push_back({i, {}, {}});
    state.mechanisms.push_back({i, 1, 0.5, 2.0});
  }
  return state;
}

void WriteLatest(const std::filesystem::path& folder) {
  core::ContactSet contacts;
  for (std::uint32_t i = 0; i < 3; ++i) contacts.planes.push_back({i, {}, {}, {0.0, 0.0, 1.0}, 100.0});
  core::SheetState sheet;
  sheet.num_columns = 2;
  for (int i = 0; i < 6; ++i) sheet.p_W.push_back(glm::vec3(i));
  core::LogicStatus status;
  status.step = "cover";
  status.active_states = {"a", "b"};
  status.lamps.push_back({1, 0.5f, 0.5f, 0.0f});
  Keep(folder, "device_state", PartsOf(0, core::DeviceState{}));
  Keep(folder, "device_command", PartsOf(1, core::DeviceCommand{}));
  Keep(folder, "haptic_proxy", PartsOf(2, core::HapticProxy{}));
  Keep(folder, "contact_set", PartsOf(3, contacts));
  Keep(folder, "physics_state", PartsOf(4, SomeState()));
  Keep(folder, "reaction", PartsOf(5, core::Reaction{}));
  Keep(folder, "sheet_state", PartsOf(6, sheet));
  Keep(folder, "logic_status", StateOf(7, status));
  Keep(folder, "figures", StateOf(8, bus::Figures{{{"step_p50_us", 12.0}, {"x", 1.0}}}));
}

void WriteEnvelopes(const std::filesystem::path& folder) {
  bus::Envelope envelope;
  envelope.header.direct = {1, 5, {}};
  Bytes bytes(bus::kMaxEnvelopeBytes + 8);
  Keep(folder, "plain", std::span(bytes).first(bus::WriteEnvelope(envelope, 8, bytes.data())));
  envelope.header.direct.Add(core::Stage::kDeviceSend, 7);
  envelope.header.through_physics = envelope.header.direct;
  envelope.num_parts = 3;
  Keep(folder, "stamped", std::span(bytes).first(bus::WriteEnvelope(envelope, 0, bytes.data())));
}

oos::NodeRecord SomeRecord() {
  oos::NodeRecord record;
  record.set_name("physics_node");
  record.set_instance(5);
  record.set_boot(6);
  record.set_data_endpoint("127.0.0.1:4000");
  record.set_heartbeat_endpoint("127.0.0.1:4001");
  record.set_router_endpoint("tcp://127.0.0.1:4002");
  record.add_observed_patterns("contacts/*");
  oos::TopicDeclaration* topic = record.add_topics();
  topic->set_name("physics/state");
  topic->set_message_type(5);
  topic->set_is_written(true);
  oos::Schema* schema = record.add_schemas();
  schema->set_digest(1);
  schema->set_canonical("1:double");
  return record;
}

void WriteControls(const std::filesystem::path& folder) {
  const auto keep = [&folder](const std::string& name, const oos::Control& control) {
    const std::string bytes = control.SerializeAsString();
    Keep(folder, name, {reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()});
  };
  oos::Control control;
  *control.mutable_hello()->mutable_node() = SomeRecord();
  keep("hello", control);
  *control.mutable_roster()->add_nodes() = SomeRecord();
  keep("roster", control);
  control.mutable_refusal()->set_why("why");
  keep("refusal", control);
  control.mutable_heartbeat()->set_name("physics_node");
  control.mutable_heartbeat()->add_topics()->set_sent(3);
  keep("heartbeat", control);
  control.mutable_subscribe()->set_name("visual_node");
  keep("subscribe", control);
  control.mutable_subscribe_ack()->set_next_event(1);
  keep("subscribe_ack", control);
  control.mutable_state_snapshot()->add_entries()->set_topic("logic/status");
  keep("snapshot", control);
  control.mutable_state_delta()->set_topic("logic/status");
  keep("delta", control);
  control.mutable_event()->mutable_event()->set_name("node_lost");
  keep("event", control);
  control.mutable_event_ack()->set_sequence(4);
  keep("event_ack", control);
  control.mutable_parameter_request()->mutable_change()->set_name("force_cap_N");
  keep("parameter_request", control);
  control.mutable_parameter_reply()->set_why("no");
  keep("parameter_reply", control);
}

void WriteSchemas(const std::filesystem::path& folder) {
  Bytes input;
  for (const auto type : {bus::MessageType::kReaction, bus::MessageType::kLogicStatus}) {
    AppendPiece(bus::SchemaOf(type).canonical, &input);
  }
  AppendPiece(std::string("contacts/*/*"), &input);
  AppendPiece(std::string("contacts/haptic/a-b"), &input);
  Keep(folder, "two", input);
}

bus::log::Schema SchemaRecord(bus::MessageType type) {
  const std::string descriptors = bus::DescriptorSetOf(type);
  return {1, bus::SchemaOf(type).name, "protobuf", {descriptors.begin(), descriptors.end()}};
}

void WriteRecordings(const std::filesystem::path& corpus) {
  using namespace bus::log;
  const std::filesystem::path file = std::filesystem::temp_directory_path() / "fuzz_seed.mcap";
  std::filesystem::remove(file);
  {
    auto writer = McapWriter::Create(file, {"", "vr_oos"});
    if (!writer) return;
    const std::uint16_t schema = (*writer)->AddSchema("oos.Event", "protobuf", {1, 2, 3});
    const std::uint16_t channel = (*writer)->AddChannel(schema, "event", "protobuf", {{"writer", "logic_node"}});
    for (std::uint32_t i = 0; i < 4; ++i) {
      (void)(*writer)->Write(Message{channel, i, i, i, {8, 1}});
      if (i == 1) (void)(*writer)->Flush();
    }
    (void)(*writer)->Write(Attachment{1, 2, "scenario.xml", "text/xml", {'<', '/', '>'}});
    (void)(*writer)->Write(Metadata{"versions", {{"vr_oos", "1"}}});
    (void)(*writer)->Close();
  }
  std::ifstream in(file, std::ios::binary);
  const Bytes whole((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
  Keep(corpus / "mcap", "whole", whole);
  Keep(corpus / "mcap", "cut", std::span(whole).first(whole.size() / 2));
  std::filesystem::remove(file);

  Bytes records;
  AppendRecord(Schema{1, "oos.Event", "protobuf", {1}}, &records);
  AppendRecord(Channel{0, 1, "event", "protobuf", {{"writer", "logic_node"}}}, &records);
  AppendRecord(Message{0, 1, 2, 3, {4}}, &records);
  Keep(corpus / "mcap_chunk", "records", records);

  Bytes payload{0};
  const Schema schema = SchemaRecord(bus::MessageType::kDeviceCommand);
  AppendPiece(schema.name, &payload);
  AppendPiece(schema.data, &payload);
  payload.insert(payload.end(), {8, 1});
  Keep(corpus / "payload_json", "own_descriptor", payload);
  Keep(corpus / "payload_json", "event", Bytes{9, 8, 2, 18, 1, 'a'});
}

void WriteCheckpoint(const std::filesystem::path& folder) {
  std::array<physics::Checkpoint, 2> parts;
  for (physics::Checkpoint& part : parts) {
    part.BeginWriting();
    double value = 0.25;
    part.Exchange(&value);
  }
  const std::array<const physics::Checkpoint*, 2> places{&parts[0], &parts[1]};
  std::filesystem::create_directories(folder);
  (void)physics::WriteCheckpointFile(folder / "two_parts", 7, 42, places);
}

void WriteSealed(const std::filesystem::path& folder) {
  bus::Envelope envelope;
  envelope.session = 7;
  envelope.node = 5;
  envelope.header.sequence = 40;
  bus::detail::EarlierSamples earlier;
  earlier.Keep({38, 1, {}, {}}, Bytes{1, 2});
  earlier.Keep({39, 2, {3, 4, {}}, {}}, Bytes{5});
  Bytes bytes(bus::kMaxDatagramBytes);
  envelope.history_bytes =
      static_cast<std::uint16_t>(earlier.Write(40, bytes.data() + bus::kEnvelopeFixedBytes + 4, 512));
  envelope.is_sealed = true;
  Keep(folder, "sealed", std::span(bytes).first(bus::WriteEnvelope(envelope, 4, bytes.data())));
  envelope.is_sealed = false;
  Keep(folder, "clear", std::span(bytes).first(bus::WriteEnvelope(envelope, 4, bytes.data())));
}

void WriteSteps(const std::filesystem::path& folder) {
  replay::StepEncoder encoder(4096);
  core::PhysicsState state = SomeState();
  core::ContactSet contacts;
  core::LogicStatus status;
  status.step = "cover";
  status.active_states = {"a"};
  Bytes input;
  for (std::uint64_t tick = 1; tick <= 2; ++tick) {
    state.tick = tick;
    encoder.Begin(tick);
    replay::Visit(encoder, state);
    replay::Visit(encoder, contacts);
    replay::Visit(encoder, status);
    AppendPiece(encoder.Finish(tick), &input);
  }
  Keep(folder, "two_steps", input);
}

void WriteKeys(const std::filesystem::path& folder) {
  const std::filesystem::path keys = std::filesystem::temp_directory_path() / "fuzz_seed_keys";
  std::filesystem::remove_all(keys);
  if (!bus::MakeKeys(keys, {"physics_node"})) return;
  Bytes input;
  for (const char* name : {"allowed", "physics_node.key"}) {
    std::ifstream in(keys / name);
    AppendPiece(std::string((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>()), &input);
  }
  Keep(folder, "two_members", input);
  std::filesystem::remove_all(keys);
}

void WriteBulk(const std::filesystem::path& folder) {
  constexpr std::uint8_t kSmallOwner = 0, kLargeOwner = 1, kRequester = 2, kOffer = 3, kFolder = 4;
  constexpr std::uint64_t kChunkBytes = std::uint64_t{64} << 10;
  const std::string small = bus::BulkHash(fuzz::SmallBlock()), large = bus::BulkHash(fuzz::LargeBlock());
  const auto chunk = [](const std::string& hash, std::uint64_t offset, const std::string& data) {
    oos::BulkMessage message;
    message.mutable_chunk()->set_hash(hash);
    message.mutable_chunk()->set_offset(offset);
    message.mutable_chunk()->set_data(data);
    return message.SerializeAsString();
  };
  const auto request = [](const std::string& hash, std::uint64_t offset) {
    oos::BulkMessage message;
    message.mutable_request()->set_hash(hash);
    message.mutable_request()->set_offset(offset);
    return message.SerializeAsString();
  };
  const auto keep = [&folder](const std::string& name, std::uint8_t kind, const std::vector<std::string>& pieces) {
    Bytes input{kind};
    for (const std::string& piece : pieces) AppendPiece(piece, &input);
    Keep(folder, name, input);
  };
  const auto keep_text = [&folder](const std::string& name, std::uint8_t kind, const std::string& text) {
    Bytes input{kind};
    input.insert(input.end(), text.begin(), text.end());
    Keep(folder, name, input);
  };
  oos::BulkMessage no;
  no.mutable_chunk()->set_hash(small);
  no.mutable_chunk()->set_why("not any more");
  keep("chunk", kSmallOwner, {chunk(small, 0, "mesh")});
  keep("chunk_of_another_content", kSmallOwner, {chunk(small, 0, "hsem"), no.SerializeAsString()});
  keep("last_chunk", kLargeOwner, {chunk(large, kChunkBytes, "mesh"), chunk(large, 2 * kChunkBytes, "mesh")});
  keep("requests", kRequester, {request(large, 0), request(large, kChunkBytes), request(small, 0)});
  std::string offer;
  bus::EncodeState(bus::BulkOffer{"scenario/scenario.xml", small, 4, "tcp://127.0.0.1:4000"}, &offer);
  keep_text("offer", kOffer, offer);
  keep_text("folder", kFolder, "scenario.xml\nmeshes/module.obj\n");
  keep_text("folder_above", kFolder, "meshes/../../outside\n");
  keep_text("folder_elsewhere", kFolder, "/tmp/outside\n");
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::cerr << "write_fuzz_seeds FOLDER\n";
    return 2;
  }
  const std::filesystem::path corpus = argv[1];
  WriteLatest(corpus / "latest_codec");
  WriteEnvelopes(corpus / "envelope");
  WriteControls(corpus / "control");
  WriteSchemas(corpus / "schema");
  WriteRecordings(corpus);
  WriteCheckpoint(corpus / "checkpoint");
  WriteSealed(corpus / "sealed");
  WriteSteps(corpus / "step");
  WriteKeys(corpus / "keys");
  WriteBulk(corpus / "bulk");
  return 0;
}
