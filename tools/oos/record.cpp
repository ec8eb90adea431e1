#include <algorithm>
#include <cstdio>
#include <filesystem>

#include "bus/log/node_recording.hpp"
#include "bus/log/recorder.hpp"
#include "core/clock.hpp"
#include "tools/oos/attach.hpp"
#include "tools/oos/verb.hpp"

namespace oos {
namespace {

constexpr std::int64_t kPoll_ns = 5'000'000;

std::uint64_t NumDropped(const bus::Node& node) {
  for (const bus::TopicCounters& topic : node.counters().topics) {
    if (topic.topic == "(observed)") return topic.dropped;
  }
  return 0;
}

core::Result<void> RecordUntil(std::int64_t end_ns, bus::Node* node, bus::log::Recorder* recorder) {
  const std::atomic<int>& interrupted = CatchInterrupt();
  bus::Observation observation;
  while (interrupted.load() == 0 && core::MonotonicNow_ns() < end_ns) {
    node->Wait(core::MonotonicNow_ns() + kPoll_ns);
    while (node->PollObservation(&observation)) {
      if (auto done = recorder->Add(observation); !done) return done;
    }
    if (auto done = recorder->Tick(core::MonotonicNow_ns(), NumDropped(*node)); !done) return done;
  }
  return recorder->Close(core::MonotonicNow_ns(), NumDropped(*node));
}

// What an earlier life left stays: FILE, FILE-2, FILE-3, ...
std::string NextName(const std::filesystem::path& file) {
  std::filesystem::path next = file;
  for (int number = 2; std::filesystem::exists(next); ++number) {
    next = file.parent_path() / (file.stem().string() + "-" + std::to_string(number) + file.extension().string());
  }
  return next.string();
}

int Run(const Arguments& arguments) {
  const std::string file = arguments.has("--next") ? NextName(arguments.positional()[0]) : arguments.positional()[0];
  const std::string pattern = arguments.positional().size() == 2 ? arguments.positional()[1] : "*";
  const auto seconds = arguments.number("--seconds");
  if (!seconds) return Complain("record", seconds.error().detail, kBadUsage);
  auto node = Attach(arguments, "record");
  if (!node) return Complain("record", node.error().detail, kDoesNotHold);
  (*node)->Observe(pattern);
  if (const auto started = (*node)->Start(5'000'000'000); !started) {
    return Complain("record", started.error().detail, kDoesNotHold);
  }
  auto recorder = bus::log::Recorder::Create(
      file, {{"session", std::to_string((*node)->session())}, {"topics", pattern}, {"clock", "CLOCK_MONOTONIC"}},
      bus::log::DescribeProvenance("oos record"));
  if (!recorder) return Complain("record", recorder.error().detail, kBadUsage);
  const auto duration_ns = static_cast<std::int64_t>(std::min(seconds->value_or(1e9), 1e9) * 1e9);
  if (auto done = RecordUntil(core::MonotonicNow_ns() + duration_ns, node->get(), recorder->get()); !done) {
    return Complain("record", done.error().detail, kDoesNotHold);
  }
  std::printf("%s: %llu messages, %.1f MB, %llu dropped\n", file.c_str(),
              static_cast<unsigned long long>((*recorder)->num_messages()),
              static_cast<double>((*recorder)->num_bytes()) * 1e-6,
              static_cast<unsigned long long>(NumDropped(**node)));
  if ((*recorder)->num_messages() == 0) return Complain("record", "nothing was heard", kDoesNotHold);
  return kHolds;
}

}  // namespace

Verb RecordVerb() {
  std::vector<Option> options = AttachOptions();
  options.push_back({"--seconds", "S", "stop after S seconds; default: on Ctrl-C"});
  options.push_back({"--next", "", "when FILE is there already, FILE-2 and so on beside it; for a supervisor"});
  return {
      "record",
      "topics of the running session into an MCAP file",
      "FILE [PATTERN]",
      1,
      2,
      options,
      Run,
      "The file holds the payloads with their descriptors: Foxglove, Lichtblick and PlotJuggler open it. Killed, it\n"
      "keeps all but the last 100 ms; 'oos recover' then gives it its index."};
}

}  // namespace oos
