#include "bus/log/node_recording.hpp"

#include <gnu/libc-version.h>
#include <google/protobuf/stubs/common.h>
#include <sys/utsname.h>
#include <unistd.h>
#include <zlib.h>
#include <zmq.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <thread>

#include "bus/log/recorder.hpp"
#include "bus/log/source_version.hpp"
#include "bus/wire/schema.hpp"

namespace bus::log {
namespace {

// Scenarios and procedures are a few KiB; larger files are not texts and are not attached.
constexpr std::uintmax_t kMaxScenarioBytes = 1 << 20;

std::string FirstLine(const std::filesystem::path& file) {
  std::ifstream in(file);
  std::string line;
  std::getline(in, line);
  return line;
}

// "model name : Intel ..." of /proc/cpuinfo.
std::string CpuName() {
  std::ifstream in("/proc/cpuinfo");
  for (std::string line; std::getline(in, line);) {
    if (line.rfind("model name", 0) == 0) return line.substr(std::min(line.size(), line.find(':') + 2));
  }
  return "unknown";
}

// Nodes of one machine share a clock. Where network namespaces stand for machines, they share the kernel's boot id, so
// the id can be given.
std::string MachineId() {
  const char* given = std::getenv("OOS_MACHINE_ID");
  return given != nullptr && *given != '\0' ? given : FirstLine("/proc/sys/kernel/random/boot_id");
}

TextMap Host() {
  utsname system{};
  uname(&system);
  char name[256] = {};
  gethostname(name, sizeof name - 1);
  return {{"name", name},
          {"system", std::string(system.sysname) + " " + system.release + " " + system.version},
          {"architecture", system.machine},
          {"cpu", CpuName()},
          {"cores", std::to_string(std::thread::hardware_concurrency())},
          {"machine_id", FirstLine("/etc/machine-id")},
          {"clock_id", MachineId()}};
}

TextMap Versions() {
  int major = 0, minor = 0, patch = 0;
  zmq_version(&major, &minor, &patch);
  return {{"vr_oos", SourceVersion()},
          {"compiler", __VERSION__},
          {"libc", gnu_get_libc_version()},
          {"zmq", std::to_string(major) + "." + std::to_string(minor) + "." + std::to_string(patch)},
          {"protobuf", google::protobuf::internal::VersionString(GOOGLE_PROTOBUF_VERSION)},
          {"zlib", zlibVersion()}};
}

TextMap Topics() {
  TextMap table;
  for (const TopicRule& rule : kTopicRules) {
    std::string text = std::string(NameOf(rule.topic_class)) + " " + SchemaOf(rule.type).name;
    if (rule.max_age_ns > 0) text += ", stale after " + std::to_string(rule.max_age_ns / 1'000'000) + " ms";
    table[std::string(rule.pattern)] = text;
  }
  return table;
}

// The scenario and the procedure beside it.
std::vector<Attachment> Texts(const std::filesystem::path& scenario) {
  std::vector<Attachment> texts;
  std::error_code error;
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(scenario.parent_path(), error)) {
    const std::filesystem::path& file = entry.path();
    const bool is_text = file.extension() == ".scxml" || file.filename() == scenario.filename();
    if (is_text && entry.is_regular_file(error) && entry.file_size(error) <= kMaxScenarioBytes) files.push_back(file);
  }
  std::sort(files.begin(), files.end());
  for (const auto& file : files) {
    std::ifstream in(file, std::ios::binary);
    texts.push_back({0, 0, file.filename().string(), "application/xml",
                     Bytes((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>())});
  }
  return texts;
}

}  // namespace

std::vector<Metadata> DescribeProvenance(const std::string& node) {
  std::vector<Metadata> records = {{"host", Host()}, {"versions", Versions()}, {"topics", Topics()}};
  for (Metadata& record : records) record.entries["node"] = node;
  return records;
}

core::Result<std::unique_ptr<TapRecorder>> StartRecording(const std::string& node, const RecordingOptions& options,
                                                          std::vector<Metadata> more) {
  if (options.file.empty()) return std::unique_ptr<TapRecorder>();
  TapFile file;
  file.path = options.file;
  file.node = node;
  const auto split = ReadSplit(options.split_MB, options.split_s);
  if (!split) return tl::unexpected(split.error());
  file.split_bytes = split->bytes;
  file.split_ns = split->age_ns;
  file.metadata = DescribeProvenance(node);
  for (Metadata& metadata : more) {
    metadata.entries["node"] = node;
    file.metadata.push_back(std::move(metadata));
  }
  if (!options.scenario.empty()) {
    const std::filesystem::path scenario = std::filesystem::absolute(options.scenario);
    file.metadata.push_back({"scenario", {{"node", node}, {"file", scenario.string()}}});
    file.attachments = Texts(scenario);
  }
  std::error_code error;
  if (!file.path.parent_path().empty()) std::filesystem::create_directories(file.path.parent_path(), error);
  return TapRecorder::Create(std::move(file));
}

core::Result<void> StopRecording(TapRecorder* recorder) {
  return recorder == nullptr ? core::Result<void>() : recorder->Stop();
}

}  // namespace bus::log
