#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "bus/log/node_recording.hpp"
#include "bus/log/recorder.hpp"
#include "core/clock.hpp"
#include "replay/platform.hpp"
#include "tools/oos/attach/attach.hpp"
#include "tools/oos/record/record_scenario.hpp"
#include "tools/oos/record/verbs.hpp"

namespace oos {
namespace {

constexpr std::int64_t kPoll_ns = 5'000'000;

std::uint64_t NumDropped(const bus::Node& node) {
  for (const bus::TopicCounters& topic : node.counters().topics) {
    if (topic.topic == "(observed)") return topic.dropped;
  }
  return 0;
}

// Records the session's nodes and their hosts, again whenever a node joins.
class Hosts {
 public:
  core::Result<void> Write(const bus::Node& node, std::int64_t now_ns, bus::log::Recorder* recorder) {
    if (now_ns - checked_ns_ < kHostsPeriod_ns) return {};
    checked_ns_ = now_ns;
    for (const bus::PeerStatus& peer : node.Peers()) {
      std::uint64_t& known = instances_[peer.name];
      if (!peer.is_alive || known == peer.instance) continue;
      known = peer.instance;
      const bus::log::Metadata host{"hosts",
                                    {{"node", node.name()},
                                     {"peer", peer.name},
                                     {"instance", std::to_string(peer.instance)},
                                     {"process_id", std::to_string(peer.process_id)},
                                     {"udp", peer.udp_endpoint},
                                     {"reliable", peer.router_endpoint},
                                     {"heard_ns", std::to_string(now_ns)}}};
      if (auto done = recorder->Write(host); !done) return done;
    }
    return {};
  }

 private:
  static constexpr std::int64_t kHostsPeriod_ns = 100'000'000;
  std::map<std::string, std::uint64_t> instances_;
  std::int64_t checked_ns_ = 0;
};

core::Result<void> RecordUntil(std::int64_t end_ns, bus::Node* node, SessionScenario* scenario,
                               bus::log::Recorder* recorder) {
  const std::atomic<int>& interrupted = CatchInterrupt();
  Hosts hosts;
  bus::Observation observation;
  while (interrupted.load() == 0 && core::MonotonicNow_ns() < end_ns) {
    node->Wait(core::MonotonicNow_ns() + kPoll_ns);
    while (node->PollObservation(&observation)) {
      if (auto done = recorder->Add(observation); !done) return done;
    }
    const std::int64_t now_ns = core::MonotonicNow_ns();
    for (const bus::log::Attachment& text : scenario->Take(now_ns)) {
      if (auto done = recorder->Write(text); !done) return done;
      if (text.name != SessionScenario::kFile) continue;
      const bus::log::Metadata source{"scenario",
                                      {{"node", node->name()}, {"file", text.name}, {"from", SessionScenario::kOwner}}};
      if (auto done = recorder->Write(source); !done) return done;
    }
    if (auto done = hosts.Write(*node, now_ns, recorder); !done) return done;
    if (auto done = recorder->WriteClocks(*node, now_ns); !done) return done;
    if (auto done = recorder->Tick(now_ns, NumDropped(*node)); !done) return done;
  }
  return recorder->Close(core::MonotonicNow_ns(), NumDropped(*node));
}

// The first free name of FILE, FILE-2, FILE-3, ...: a restarted recorder keeps the earlier files.
std::string NextName(const std::filesystem::path& file) {
  std::filesystem::path next = file;
  for (int number = 2; std::filesystem::exists(next); ++number) {
    next = file.parent_path() / (file.stem().string() + "-" + std::to_string(number) + file.extension().string());
  }
  return next.string();
}

int RunRecord(const Arguments& arguments) {
  const std::string file = arguments.has("--next") ? NextName(arguments.positional()[0]) : arguments.positional()[0];
  const std::string pattern = arguments.positional().size() == 2 ? arguments.positional()[1] : "*";
  const auto seconds = arguments.number("--seconds");
  if (!seconds) return Complain("record", seconds.error().detail, kBadUsage);
  const auto split = bus::log::ReadSplit(arguments.text("--split_MB"), arguments.text("--split_s"));
  if (!split) return Complain("record", split.error().detail, kBadUsage);
  auto options = FindSession(arguments);
  if (!options) return Complain("record", options.error().detail, kDoesNotHold);
  options->name = "oos-record-" + std::to_string(getpid());
  options->is_observer = true;
  auto node = bus::Node::Create(*options);
  if (!node) return Complain("record", node.error().detail, kDoesNotHold);
  (*node)->Observe(pattern);
  SessionScenario scenario(node->get(), *options);
  if (const auto started = (*node)->Start(5'000'000'000); !started) {
    return Complain("record", started.error().detail, kDoesNotHold);
  }
  const std::string& name = (*node)->name();
  std::vector<bus::log::Metadata> more = bus::log::DescribeProvenance(name);
  more.push_back({"platform", replay::DescribePlatform()});
  more.back().entries["node"] = name;
  auto recorder = bus::log::Recorder::Create(file,
                                             {{"node", name},
                                              {"session", std::to_string((*node)->session())},
                                              {"topics", pattern},
                                              {"clock",
                                               "CLOCK_MONOTONIC of the recorder's machine; publish times are by their "
                                               "writers' clocks, clock/" +
                                                   name + " gives the offsets"}},
                                             more, *split);
  if (!recorder) return Complain("record", recorder.error().detail, kBadUsage);
  const auto duration_ns = static_cast<std::int64_t>(std::min(seconds->value_or(1e9), 1e9) * 1e9);
  if (auto done = RecordUntil(core::MonotonicNow_ns() + duration_ns, node->get(), &scenario, recorder->get()); !done) {
    return Complain("record", done.error().detail, kDoesNotHold);
  }
  const std::size_t num_files = (*recorder)->files().size();
  const std::string others = num_files == 1 ? "" : " and " + std::to_string(num_files - 1) + " more";
  std::printf("%s%s: %llu messages, %.1f MB, %llu dropped\n", file.c_str(), others.c_str(),
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
  options.push_back({"--split_MB", "N", "begin a new file, FILE.1.mcap and so on, at this size"});
  options.push_back({"--split_s", "N", "begin a new file at this age"});
  options.push_back({"--next", "", "if FILE exists, write FILE-2 and so on beside it; for supervisors"});
  return {"record",
          "records topics of the running session into an MCAP file",
          "FILE [PATTERN]",
          1,
          2,
          options,
          RunRecord,
          "The file contains the payloads and their descriptors: Foxglove, Lichtblick and PlotJuggler open it. If the\n"
          "recorder is killed, all but the last 100 ms are kept; 'oos recover' then adds the index."};
}

}  // namespace oos
