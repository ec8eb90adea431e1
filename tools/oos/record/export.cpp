#include <cinttypes>
#include <cstdio>

#include "bus/log/channel_copier.hpp"
#include "bus/log/mcap_indexed_reader.hpp"
#include "collision/resolution/choose_resolutions.hpp"
#include "tools/oos/pictures/picture_source.hpp"
#include "tools/oos/record/verbs.hpp"
#include "tools/oos/record/view_export.hpp"

namespace oos {
namespace {

core::Result<std::uint64_t> Export(bus::log::McapIndexedReader* reader, const scene::Scenario& scenario,
                                   const std::string& to) {
  auto writer = bus::log::McapWriter::Create(to, {"", "vr-oos"});
  if (!writer) return tl::unexpected(writer.error());
  const auto metadata = reader->ReadMetadata();
  if (!metadata) return tl::unexpected(metadata.error());
  for (const bus::log::Metadata& record : *metadata) {
    if (auto done = (*writer)->Write(record); !done) return tl::unexpected(done.error());
  }
  const auto attachments = reader->ReadAttachments();
  if (!attachments) return tl::unexpected(attachments.error());
  for (const bus::log::Attachment& attachment : *attachments) {
    if (auto done = (*writer)->Write(attachment); !done) return tl::unexpected(done.error());
  }
  ViewExport view(scenario, writer->get());
  bus::log::ChannelCopier copier(writer->get());
  core::Result<void> done;
  bool has_begun = false;
  const auto read = reader->ReadMessages([&](const bus::log::Channel& channel, const bus::log::Message& message) {
    if (!has_begun) done = view.Begin(static_cast<std::int64_t>(message.log_time_ns));
    has_begun = true;
    if (done) {
      const auto schema = reader->schemas().find(channel.schema_id);
      done = copier.Copy(0, channel, schema == reader->schemas().end() ? nullptr : &schema->second, message);
    }
    if (done) done = view.Take(channel, message);
    return done.has_value();
  });
  if (!read) return tl::unexpected(read.error());
  if (!done) return tl::unexpected(done.error());
  if (auto closed = (*writer)->Close(); !closed) return tl::unexpected(closed.error());
  return view.num_messages();
}

int RunExport(const Arguments& arguments) {
  const std::string& from = arguments.positional()[0];
  const std::string& to = arguments.positional()[1];
  auto reader = bus::log::McapIndexedReader::Open(from);
  if (!reader) return Complain("export", reader.error().detail, kBadUsage);
  std::filesystem::path file = arguments.text("--scenario");
  if (file.empty()) {
    const auto recorded = RecordedScenarioFile(from);
    if (!recorded) return Complain("export", recorded.error().detail, kBadUsage);
    file = *recorded;
  }
  if (file.empty()) {
    return Complain("export", from + " does not name its scenario; give it with --scenario", kBadUsage);
  }
  const auto scenario = collision::LoadResolvedScenario(file);
  if (!scenario) {
    for (const scene::Diagnostic& diagnostic : scenario.error()) {
      Complain("export", scene::Format(diagnostic), kBadUsage);
    }
    return kBadUsage;
  }
  const auto derived = Export(&*reader, *scenario, to);
  if (!derived) return Complain("export", derived.error().detail, kBadUsage);
  std::printf("%s: %" PRIu64 " messages derived for 3D viewers, beside the recorded ones\n", to.c_str(), *derived);
  return kHolds;
}

}  // namespace

Verb ExportVerb() {
  return {
      "export",
      "adds a moving 3D scene for Foxglove and Lichtblick to a recording",
      "IN OUT",
      2,
      2,
      {{"--scenario", "FILE", "scenario of the run; default: the one that the recording names"}},
      RunExport,
      "OUT contains all of IN, and the channels that those viewers expect: /scene/... and /tf (show the 3D panel with\n"
      "'world' as its frame) and /log. Meshes are embedded: OUT needs no other file."};
}

}  // namespace oos
