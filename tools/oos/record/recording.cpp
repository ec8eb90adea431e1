#include <algorithm>
#include <cinttypes>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "bus/log/mcap_reader.hpp"
#include "bus/log/payload_decoder.hpp"
#include "bus/topics.hpp"
#include "tools/oos/record/recording_memory.hpp"
#include "tools/oos/record/verbs.hpp"

namespace oos {
namespace {

namespace log = bus::log;

struct Heard {
  std::uint64_t messages = 0, bytes = 0;
  std::uint64_t lost = 0;  // sequence numbers that are missing in between
  std::uint32_t last_sequence = 0;
  std::uint64_t first_ns = 0, last_ns = 0;

  void Add(const log::Message& message) {
    // Parts of a split message share their number; a writer that starts again begins anew.
    if (messages > 0 && message.sequence > last_sequence) lost += message.sequence - last_sequence - 1;
    if (messages == 0) first_ns = message.log_time_ns;
    last_sequence = message.sequence;
    last_ns = std::max(last_ns, message.log_time_ns);
    ++messages;
    bytes += message.data.size();
  }
};

int Info(const Arguments& arguments) {
  std::map<std::uint16_t, Heard> heard;
  const auto contents =
      log::ReadMcap(arguments.positional()[0],
                    [&](const log::Channel& channel, const log::Message& message) { heard[channel.id].Add(message); });
  if (!contents) return Complain("info", contents.error().detail, kBadUsage);
  const log::Statistics& all = contents->statistics;
  std::printf("%s: %" PRIu64 " messages in %.3f s, %u chunks, %s\n", arguments.positional()[0].c_str(),
              all.message_count, static_cast<double>(all.last_ns - all.first_ns) * 1e-9, all.chunk_count,
              contents->has_summary ? "complete" : "NOT closed: its writer died; 'oos recover' gives it an index");
  for (const log::Metadata& metadata : contents->metadata) {
    if (metadata.name == "topics") continue;  // the table below shows the same for the topics in the file
    std::printf("%s:", metadata.name.c_str());
    for (const auto& [key, value] : metadata.entries) std::printf(" %s=%s", key.c_str(), value.c_str());
    std::printf("\n");
  }
  std::printf("%-44s %-16s %-7s %9s %9s %9s %7s  %s\n", "topic", "node", "class", "messages", "Hz", "kB", "lost",
              "schema");
  for (const auto& [id, channel] : contents->channels) {
    const Heard& h = heard[id];
    const double span_s = static_cast<double>(h.last_ns - h.first_ns) * 1e-9;
    const auto text = [&metadata = channel.metadata](const char* key) {
      const auto found = metadata.find(key);
      return found == metadata.end() ? std::string("-") : found->second;
    };
    const auto schema = contents->schemas.find(channel.schema_id);
    const std::string topic =
        channel.metadata.count("key") == 0 ? channel.topic : channel.topic + " [" + text("key") + "]";
    const std::string node = text(channel.metadata.count("reader") == 0 ? "writer" : "reader");
    std::printf("%-44s %-16s %-7s %9" PRIu64 " %9.1f %9.1f %7" PRIu64 "  %s\n", topic.c_str(), node.c_str(),
                text("class").c_str(), h.messages, span_s > 0.0 ? static_cast<double>(h.messages - 1) / span_s : 0.0,
                static_cast<double>(h.bytes) * 1e-3, h.lost,
                schema == contents->schemas.end() ? "-" : schema->second.name.c_str());
  }
  return kHolds;
}

int Cat(const Arguments& arguments) {
  const std::string pattern = arguments.positional().size() == 2 ? arguments.positional()[1] : "*";
  // In the reader's order a schema may come after its messages, so all schemas are read first.
  const auto contents = log::ReadMcap(arguments.positional()[0], [](const log::Channel&, const log::Message&) {});
  if (!contents) return Complain("cat", contents.error().detail, kBadUsage);
  log::PayloadDecoder decoder;
  std::string failure;
  (void)log::ReadMcap(arguments.positional()[0], [&](const log::Channel& channel, const log::Message& message) {
    if (!failure.empty() || !bus::MatchesPattern(pattern, channel.topic)) return;
    const auto schema = contents->schemas.find(channel.schema_id);
    const auto json = schema == contents->schemas.end() ? core::Result<std::string>("null")
                                                        : decoder.ToJson(schema->second, message.data);
    if (!json) {
      failure = json.error().detail;
      return;
    }
    std::printf("{\"topic\":%s,\"sequence\":%" PRIu32 ",\"log_time_ns\":%" PRIu64 ",\"publish_time_ns\":%" PRIu64
                ",\"data\":%s}\n",
                nlohmann::json(channel.topic).dump().c_str(), message.sequence, message.log_time_ns,
                message.publish_time_ns, json->c_str());
  });
  if (!failure.empty()) return Complain("cat", arguments.positional()[0] + ": " + failure, kBadUsage);
  return kHolds;
}

int Recover(const Arguments& arguments) {
  const auto done = log::RecoverMcap(arguments.positional()[0], arguments.positional()[1]);
  if (!done) return Complain("recover", done.error().detail, kBadUsage);
  std::printf("%s: %" PRIu64 " messages", arguments.positional()[1].c_str(), done->num_messages);
  if (done->was_whole) {
    std::printf("; the file was whole\n");
  } else {
    std::printf("; left out: %" PRIu64 " damaged chunks, %" PRIu64 " bytes between records; read again and complete\n",
                done->num_damaged_chunks, done->num_skipped_bytes);
  }
  return done->num_damaged_chunks == 0 ? kHolds : kDoesNotHold;
}

}  // namespace

Verb InfoVerb() {
  return {"info",
          "shows what a recording contains: topics, rates, losses",
          "FILE",
          1,
          1,
          {},
          [](const Arguments& arguments) { return WithinMemory("info", arguments, Info); }};
}

Verb CatVerb() {
  return {"cat",
          "prints the messages of a recording, one line of JSON each",
          "FILE [PATTERN]",
          1,
          2,
          {},
          [](const Arguments& arguments) { return WithinMemory("cat", arguments, Cat); }};
}

Verb RecoverVerb() {
  return {"recover",
          "saves the readable part of a truncated or damaged recording",
          "FROM TO",
          2,
          2,
          {},
          [](const Arguments& arguments) { return WithinMemory("recover", arguments, Recover); },
          "Exit status 0: every chunk was sound, 1: some were left out, 2: nothing could be saved."};
}

}  // namespace oos
