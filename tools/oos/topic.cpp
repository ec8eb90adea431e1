#include <algorithm>
#include <cstdio>
#include <map>

#include "core/clock.hpp"
#include "tools/oos/attach.hpp"
#include "tools/oos/verb.hpp"

namespace oos {
namespace {

constexpr std::int64_t kPoll_ns = 50'000'000;

struct Seen {
  bus::TopicClass topic_class = bus::TopicClass::kLatest;
  std::string writer;
  std::uint64_t messages = 0;
  std::uint64_t bytes = 0;
  std::int64_t first_ns = 0;
  std::int64_t last_ns = 0;
  std::int64_t longest_gap_ns = 0;
};

void Note(const bus::Observation& observation, std::map<std::string, Seen>* all) {
  Seen& seen = (*all)[observation.topic];
  seen.topic_class = observation.topic_class;
  seen.writer = observation.writer;
  if (seen.messages == 0) {
    seen.first_ns = observation.received_ns;
  } else {
    seen.longest_gap_ns = std::max(seen.longest_gap_ns, observation.received_ns - seen.last_ns);
  }
  seen.last_ns = observation.received_ns;
  ++seen.messages;
  seen.bytes += observation.num_bytes;
}

double Rate_Hz(const Seen& seen) {
  const double span_s = static_cast<double>(seen.last_ns - seen.first_ns) * 1e-9;
  return span_s > 0.0 ? static_cast<double>(seen.messages - 1) / span_s : 0.0;
}

// What went from whom to whom, as the readers count it: whatever has arrived or is known to be lost adds up to what the
// writers say they have sent. False: somewhere more is missing than can be on its way.
bool ShowAccounts(const bus::Node& node, const std::string& pattern) {
  bool do_close = true;
  std::printf("%-40s %-16s %-16s %12s %12s %10s %8s\n", "topic", "from", "to", "sent", "received", "dropped", "open");
  for (const bus::PeerStatus& reader : node.Peers()) {
    for (const bus::ToldAccount& account : reader.accounts) {
      if (account.is_writer || reader.is_observer || !bus::MatchesPattern(pattern, account.topic)) continue;
      const auto open = static_cast<long long>(account.sent - account.received - account.dropped);
      do_close = do_close && open >= 0;
      std::printf("%-40s %-16s %-16s %12llu %12llu %10llu %8lld\n", account.topic.c_str(),
                  account.peer.empty() ? "(earlier)" : account.peer.c_str(), reader.name.c_str(),
                  static_cast<unsigned long long>(account.sent), static_cast<unsigned long long>(account.received),
                  static_cast<unsigned long long>(account.dropped), open);
    }
  }
  return do_close;
}

// By this machine's clock; a message from another machine is as old as the clocks' difference is known.
std::string AgeText(const bus::Observation& observation, const std::vector<bus::PeerStatus>& peers) {
  std::int64_t offset_ns = 0, bound_ns = INT64_MAX;
  for (const bus::PeerStatus& peer : peers) {
    if (peer.name != observation.writer) continue;
    offset_ns = peer.clock_offset_ns;
    bound_ns = peer.clock_bound_ns;
  }
  if (bound_ns == INT64_MAX) return ", age not known: its clock has not been compared yet";
  const std::int64_t age_ns = observation.received_ns - (observation.publish_ns - offset_ns);
  char text[64];
  if (bound_ns == 0) {
    std::snprintf(text, sizeof text, ", %.3f ms old", static_cast<double>(age_ns) * 1e-6);
  } else {
    std::snprintf(text, sizeof text, ", %.3f +- %.3f ms old", static_cast<double>(age_ns) * 1e-6,
                  static_cast<double>(bound_ns) * 1e-6);
  }
  return text;
}

int Run(const Arguments& arguments) {
  const std::string& what = arguments.positional()[0];
  const bool has_pattern = arguments.positional().size() == 2;
  if (what != "list" && what != "echo" && what != "hz" && what != "accounts") {
    return Complain("topic", "'" + what + "' is none of list, echo, hz, accounts", kBadUsage);
  }
  if (what == "echo" && !has_pattern) return Complain("topic", "echo needs a topic, e.g. logic/status", kBadUsage);
  const auto count = arguments.number("--count");
  const auto seconds = arguments.number("--seconds");
  if (!count) return Complain("topic", count.error().detail, kBadUsage);
  if (!seconds) return Complain("topic", seconds.error().detail, kBadUsage);

  auto node = Attach(arguments, "topic");
  if (!node) return Complain("topic", node.error().detail, kDoesNotHold);
  const std::string pattern = has_pattern ? arguments.positional()[1] : "*";
  (*node)->Observe(pattern);
  if (const auto started = (*node)->Start(5'000'000'000); !started) {
    return Complain("topic", started.error().detail, kDoesNotHold);
  }
  const std::atomic<int>& interrupted = CatchInterrupt();
  // echo goes on until Ctrl-C unless limited; list and hz look for a while.
  const double limit_s = seconds->value_or(what == "echo" ? 1e12 : what == "hz" ? 5.0 : 2.0);
  const auto limit_messages = static_cast<std::uint64_t>(count->value_or(1e18));
  const std::int64_t end_ns = core::MonotonicNow_ns() + static_cast<std::int64_t>(std::min(limit_s, 1e9) * 1e9);
  std::map<std::string, Seen> all;
  std::uint64_t num_messages = 0;
  bus::Observation observation;
  while (interrupted.load() == 0 && core::MonotonicNow_ns() < end_ns && num_messages < limit_messages) {
    (*node)->Wait(core::MonotonicNow_ns() + kPoll_ns);
    while (num_messages < limit_messages && (*node)->PollObservation(&observation)) {
      ++num_messages;
      Note(observation, &all);
      if (what != "echo") continue;
      std::printf("--- %s #%llu from %s, %zu bytes", observation.topic.c_str(),
                  static_cast<unsigned long long>(observation.sequence), observation.writer.c_str(),
                  observation.num_bytes);
      // Only a LATEST message says when it was published.
      if (observation.publish_ns > 0) {
        std::printf("%s", AgeText(observation, (*node)->Peers()).c_str());
      }
      std::printf("\n%s\n", observation.Text().c_str());
      std::fflush(stdout);
    }
  }
  if (what == "accounts") {
    if (!ShowAccounts(**node, pattern)) return Complain("topic", "more arrived than was sent", kDoesNotHold);
  } else if (what == "list") {
    for (const auto& [topic, seen] : all) {
      std::printf("%-7s %-44s %s\n", std::string(bus::NameOf(seen.topic_class)).c_str(), topic.c_str(),
                  seen.writer.c_str());
    }
  } else if (what == "hz") {
    std::printf("%-44s %9s %12s %10s\n", "topic", "Hz", "longest ms", "kB/s");
    for (const auto& [topic, seen] : all) {
      const double rate_Hz = Rate_Hz(seen);
      std::printf("%-44s %9.1f %12.2f %10.1f\n", topic.c_str(), rate_Hz,
                  static_cast<double>(seen.longest_gap_ns) * 1e-6,
                  rate_Hz * static_cast<double>(seen.bytes) / static_cast<double>(seen.messages) * 1e-3);
    }
  }
  if (num_messages == 0) return Complain("topic", "nothing was heard", kDoesNotHold);
  return kHolds;
}

}  // namespace

Verb TopicVerb() {
  std::vector<Option> options = AttachOptions();
  options.push_back({"--count", "N", "stop after N messages"});
  options.push_back({"--seconds", "S", "look for S seconds (list, accounts: 2, hz: 5, echo: until Ctrl-C)"});
  return {"topic",
          "topics of the running session: which, what they say, how often, and what of it arrived",
          "list|echo|hz|accounts [PATTERN]",
          1,
          2,
          options,
          Run};
}

}  // namespace oos
