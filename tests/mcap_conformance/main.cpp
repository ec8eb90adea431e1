// Runs our reader and writer of MCAP for conformance.test.mjs, which compares them with @mcap/core:
//   mcap_driver streamed|indexed FILE...   prints what our reader finds, one line of JSON for each file
//   mcap_driver write OUT < CASE.json      writes the case's records to OUT by our writer

#include <cstdio>
#include <cstring>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>

#include "bus/log/mcap_indexed_reader.hpp"
#include "bus/log/mcap_reader.hpp"
#include "bus/log/mcap_writer.hpp"

namespace {

using nlohmann::json;
namespace log = bus::log;

json Text(std::uint64_t number) {
  return std::to_string(number);
}
json Text(const log::Bytes& bytes) {
  json list = json::array();
  for (const std::uint8_t byte : bytes) list.push_back(std::to_string(byte));
  return list;
}
template <class Key, class Value>
json Text(const std::map<Key, Value>& map) {
  json object = json::object();
  for (const auto& [key, value] : map) object[std::to_string(key)] = std::to_string(value);
  return object;
}

json Typed(const char* type, const json& fields) {
  return {{"type", type}, {"fields", fields}};
}

json ToJson(const log::Header& r) {
  return Typed("Header", {{"library", r.library}, {"profile", r.profile}});
}
json ToJson(const log::Footer& r) {
  return Typed("Footer", {{"summary_crc", Text(r.summary_crc)},
                          {"summary_offset_start", Text(r.summary_offset_start)},
                          {"summary_start", Text(r.summary_start)}});
}
json ToJson(const log::Schema& r) {
  return Typed("Schema", {{"data", Text(r.data)}, {"encoding", r.encoding}, {"id", Text(r.id)}, {"name", r.name}});
}
json ToJson(const log::Channel& r) {
  return Typed("Channel", {{"id", Text(r.id)},
                           {"message_encoding", r.message_encoding},
                           {"metadata", r.metadata},
                           {"schema_id", Text(r.schema_id)},
                           {"topic", r.topic}});
}
json ToJson(const log::Message& r) {
  return Typed("Message", {{"channel_id", Text(r.channel_id)},
                           {"data", Text(r.data)},
                           {"log_time", Text(r.log_time_ns)},
                           {"publish_time", Text(r.publish_time_ns)},
                           {"sequence", Text(r.sequence)}});
}
json ToJson(const log::Attachment& r) {
  return Typed("Attachment", {{"create_time", Text(r.create_time_ns)},
                              {"data", Text(r.data)},
                              {"log_time", Text(r.log_time_ns)},
                              {"media_type", r.media_type},
                              {"name", r.name}});
}
json ToJson(const log::AttachmentIndex& r) {
  return Typed("AttachmentIndex", {{"create_time", Text(r.create_time_ns)},
                                   {"data_size", Text(r.data_size)},
                                   {"length", Text(r.length)},
                                   {"log_time", Text(r.log_time_ns)},
                                   {"media_type", r.media_type},
                                   {"name", r.name},
                                   {"offset", Text(r.offset)}});
}
json ToJson(const log::Statistics& r) {
  return Typed("Statistics", {{"attachment_count", Text(r.attachment_count)},
                              {"channel_count", Text(r.channel_count)},
                              {"channel_message_counts", Text(r.channel_message_counts)},
                              {"chunk_count", Text(r.chunk_count)},
                              {"message_count", Text(r.message_count)},
                              {"message_end_time", Text(r.last_ns)},
                              {"message_start_time", Text(r.first_ns)},
                              {"metadata_count", Text(r.metadata_count)},
                              {"schema_count", Text(r.schema_count)}});
}
json ToJson(const log::Metadata& r) {
  return Typed("Metadata", {{"metadata", r.entries}, {"name", r.name}});
}
json ToJson(const log::MetadataIndex& r) {
  return Typed("MetadataIndex", {{"length", Text(r.length)}, {"name", r.name}, {"offset", Text(r.offset)}});
}
json ToJson(const log::ChunkIndex& r) {
  return Typed("ChunkIndex", {{"chunk_length", Text(r.chunk_length)},
                              {"chunk_start_offset", Text(r.chunk_start)},
                              {"compressed_size", Text(r.compressed_size)},
                              {"compression", r.compression},
                              {"message_end_time", Text(r.last_ns)},
                              {"message_index_length", Text(r.message_index_length)},
                              {"message_index_offsets", Text(r.message_index_offsets)},
                              {"message_start_time", Text(r.first_ns)},
                              {"uncompressed_size", Text(r.uncompressed_size)}});
}
json ToJson(const log::SummaryOffset& r) {
  return Typed("SummaryOffset", {{"group_length", Text(r.group_length)},
                                 {"group_opcode", Text(static_cast<std::uint64_t>(r.group))},
                                 {"group_start", Text(r.group_start)}});
}
json ToJson(const log::DataEnd& r) {
  return Typed("DataEnd", {{"data_section_crc", Text(r.data_section_crc)}});
}

core::Result<json> Streamed(const char* file) {
  json records = json::array();
  const auto contents = log::ReadMcapRecords(file, [&](const log::AnyRecord& any) {
    std::visit([&](const auto& record) { records.push_back(ToJson(record)); }, any);
  });
  if (!contents) return tl::unexpected(contents.error());
  return json{{"records", records}};
}

core::Result<json> Indexed(const char* file) {
  auto reader = log::McapIndexedReader::Open(file);
  if (!reader) return tl::unexpected(reader.error());
  json messages = json::array();
  const auto done = reader->ReadMessages([&](const log::Channel&, const log::Message& message) {
    messages.push_back(ToJson(message));
    return true;
  });
  if (!done) return tl::unexpected(done.error());
  json schemas = json::array();
  for (const auto& [id, schema] : reader->schemas()) schemas.push_back(ToJson(schema));
  json channels = json::array();
  for (const auto& [id, channel] : reader->channels()) channels.push_back(ToJson(channel));
  json statistics = json::array();
  if (reader->statistics()) statistics.push_back(ToJson(*reader->statistics()));
  return json{{"schemas", schemas}, {"channels", channels}, {"messages", messages}, {"statistics", statistics}};
}

template <class Number = std::uint64_t>
Number NumberOf(const json& fields, const char* name) {
  return static_cast<Number>(std::stoull(fields.at(name).get<std::string>()));
}
log::Bytes BytesOf(const json& list) {
  log::Bytes bytes;
  for (const json& byte : list) bytes.push_back(static_cast<std::uint8_t>(std::stoul(byte.get<std::string>())));
  return bytes;
}

// Schemas count from 1 and channels from 0, in the order of the case; "Flush" ends a chunk.
core::Result<void> Write(const char* file, const json& records) {
  auto writer = log::McapWriter::Create(file, {"", ""});
  if (!writer) return tl::unexpected(writer.error());
  for (const json& record : records) {
    const std::string type = record.at("type");
    const json& f = record.at("fields");
    core::Result<void> done;
    if (type == "Schema") {
      (*writer)->AddSchema(f.at("name"), f.at("encoding"), BytesOf(f.at("data")));
    } else if (type == "Channel") {
      (*writer)->AddChannel(NumberOf<std::uint16_t>(f, "schema_id"), f.at("topic"), f.at("message_encoding"),
                            f.at("metadata").get<log::TextMap>());
    } else if (type == "Message") {
      done = (*writer)->Write(log::Message{NumberOf<std::uint16_t>(f, "channel_id"),
                                           NumberOf<std::uint32_t>(f, "sequence"), NumberOf(f, "log_time"),
                                           NumberOf(f, "publish_time"), BytesOf(f.at("data"))});
    } else if (type == "Attachment") {
      done = (*writer)->Write(log::Attachment{NumberOf(f, "log_time"), NumberOf(f, "create_time"), f.at("name"),
                                              f.at("media_type"), BytesOf(f.at("data"))});
    } else if (type == "Metadata") {
      done = (*writer)->Write(log::Metadata{f.at("name"), f.at("metadata").get<log::TextMap>()});
    } else if (type == "Flush") {
      done = (*writer)->Flush();
    }
    if (!done) return done;
  }
  return (*writer)->Close();
}

int Complain(const std::string& what) {
  std::fprintf(stderr, "mcap_driver: %s\n", what.c_str());
  return 1;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 3) return Complain("streamed|indexed|write FILE...");
  if (std::strcmp(argv[1], "write") == 0) {
    const auto done = Write(argv[2], json::parse(std::cin));
    return done ? 0 : Complain(done.error().detail);
  }
  for (int i = 2; i < argc; ++i) {
    const auto found = std::strcmp(argv[1], "streamed") == 0 ? Streamed(argv[i]) : Indexed(argv[i]);
    if (!found) return Complain(found.error().detail);
    std::printf("%s\n", found->dump().c_str());
  }
  return 0;
}
