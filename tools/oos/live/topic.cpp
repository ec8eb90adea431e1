#include <cstdio>
#include <map>
#include <set>

#include "bus/accounts/reported_accounts.hpp"
#include "bus/wire/schema.hpp"
#include "core/clock.hpp"
#include "tools/oos/attach/attach.hpp"
#include "tools/oos/live/heard_topic.hpp"
#include "tools/oos/live/verbs.hpp"

namespace oos {
namespace {

constexpr std::int64_t kPoll_ns = 50'000'000;
constexpr std::int64_t kStart_ns = 5'000'000'000;

enum class What { kList, kInfo, kEcho, kHz, kBw, kDelay, kAccounts };

std::optional<What> Parse(const std::string& word) {
  static const std::map<std::string, What> words = {
      {"list", What::kList}, {"info", What::kInfo},   {"echo", What::kEcho},        {"hz", What::kHz},
      {"bw", What::kBw},     {"delay", What::kDelay}, {"accounts", What::kAccounts}};
  const auto found = words.find(word);
  return found == words.end() ? std::nullopt : std::optional(found->second);
}

// The nodes that have declared a topic.
struct Ends {
  bus::TopicClass topic_class = bus::TopicClass::kLatest;
  std::set<std::string> writers, readers;
};

std::string Join(const std::set<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
  return text.empty() ? "none" : text;
}

std::map<std::string, Ends> Declared(const std::vector<bus::PeerStatus>& peers, const std::string& pattern) {
  std::map<std::string, Ends> topics;
  for (const bus::PeerStatus& peer : peers) {
    if (peer.is_observer) continue;
    for (const bus::TopicCounters& topic : peer.counters.topics) {
      if (!bus::MatchesPattern(pattern, topic.topic)) continue;
      Ends& ends = topics[topic.topic];
      ends.topic_class = topic.topic_class;
      (topic.is_written ? ends.writers : ends.readers).insert(peer.name);
    }
    // Every node may emit events and set parameters; their readers appear in the accounts.
    for (const bus::ReportedAccount& account : peer.accounts) {
      const bus::TopicRule* rule = bus::FindTopicRule(account.topic);
      if (rule == nullptr || account.peer.empty() || !bus::MatchesPattern(pattern, account.topic)) continue;
      Ends& ends = topics[account.topic];
      ends.topic_class = rule->topic_class;
      (account.is_writer ? ends.writers : ends.readers).insert(peer.name);
    }
  }
  return topics;
}

void ShowList(const std::map<std::string, Ends>& topics) {
  for (const auto& [topic, ends] : topics) {
    std::printf("%-7s %-44s %s -> %s\n", std::string(bus::NameOf(ends.topic_class)).c_str(), topic.c_str(),
                Join(ends.writers).c_str(), Join(ends.readers).c_str());
  }
}

// Prints the messages from each writer to each reader as the readers count them, over all restarts of the writer, and
// where a writer's own count differs (bus/accounts/reported_accounts.hpp). False if one differs, or if a reader counts
// more than was sent.
bool ShowAccounts(const std::vector<bus::PeerStatus>& peers, const std::string& pattern,
                  const bus::ReportedAccounts& joined) {
  bool do_close = true;
  std::printf("%-40s %-16s %-16s %12s %12s %10s %8s\n", "topic", "from", "to", "sent", "received", "dropped", "open");
  for (const bus::PeerStatus& reader : peers) {
    for (const bus::ReportedAccount& account : reader.accounts) {
      if (account.is_writer || reader.is_observer || !bus::MatchesPattern(pattern, account.topic)) continue;
      const auto open = static_cast<long long>(account.sent - account.received - account.dropped);
      do_close = do_close && open >= 0;
      std::printf("%-40s %-16s %-16s %12llu %12llu %10llu %8lld\n", account.topic.c_str(),
                  account.peer.empty() ? "(earlier)" : account.peer.c_str(), reader.name.c_str(),
                  static_cast<unsigned long long>(account.sent), static_cast<unsigned long long>(account.received),
                  static_cast<unsigned long long>(account.dropped), open);
    }
  }
  const std::vector<std::string> faults = joined.Disagreements();
  for (const std::string& fault : faults) std::printf("%s\n", fault.c_str());
  std::printf("%zu accounts compared with their writers' own counts, %zu disagree\n", joined.num_compared(),
              faults.size());
  return do_close && faults.empty();
}

void ShowInfo(const std::string& topic, const Ends& ends, const HeardTopics& heard) {
  const bus::TopicRule* rule = bus::FindTopicRule(topic);
  std::printf("%s\n  class    %s\n", topic.c_str(), std::string(bus::NameOf(ends.topic_class)).c_str());
  if (rule != nullptr) {
    const bus::PayloadSchema& schema = bus::SchemaOf(rule->type);
    std::printf("  carries  %s, digest %08x\n", schema.name.c_str(), schema.digest);
    if (rule->max_age_ns > 0) std::printf("  stale    after %.0f ms\n", static_cast<double>(rule->max_age_ns) * 1e-6);
  }
  std::printf("  from     %s\n  to       %s\n", Join(ends.writers).c_str(), Join(ends.readers).c_str());
  const auto found = heard.all().find(topic);
  if (found == heard.all().end()) {
    std::printf("  heard    nothing meanwhile\n");
    return;
  }
  std::printf("  heard    %.1f Hz, %.0f B a message\n", found->second.rate_Hz(), found->second.mean_bytes());
}

void ShowRates(const HeardTopics& heard) {
  std::printf("%-44s %9s %12s %10s\n", "topic", "Hz", "longest ms", "messages");
  for (const auto& [topic, seen] : heard.all()) {
    std::printf("%-44s %9.1f %12.2f %10llu\n", topic.c_str(), seen.rate_Hz(), seen.longest_gap_ms(),
                static_cast<unsigned long long>(seen.num_messages()));
  }
}

void ShowBandwidths(const HeardTopics& heard, double seconds) {
  std::printf("%-44s %10s %9s %9s %9s\n", "topic", "kB/s", "mean B", "least B", "most B");
  double sum = 0.0;
  for (const auto& [topic, seen] : heard.all()) {
    const double kB_per_s = static_cast<double>(seen.num_bytes()) / seconds * 1e-3;
    sum += kB_per_s;
    std::printf("%-44s %10.1f %9.0f %9llu %9llu\n", topic.c_str(), kB_per_s, seen.mean_bytes(),
                static_cast<unsigned long long>(seen.smallest_bytes()),
                static_cast<unsigned long long>(seen.largest_bytes()));
  }
  std::printf("%-44s %10.1f\n", "to one reader of all, in all", sum);
}

void ShowDelays(const HeardTopics& heard) {
  std::printf("%-44s %8s %9s %9s %9s %9s %9s\n", "topic, ms from publishing to here", "n", "least", "p50", "p99",
              "most", "+-");
  for (const auto& [topic, seen] : heard.all()) {
    if (seen.topic_class() != bus::TopicClass::kLatest) continue;
    const HeardTopic::Delay delay = seen.delay();
    if (delay.num == 0) {
      std::printf("%-44s %8s the writer's clock has not been compared yet\n", topic.c_str(), "0");
      continue;
    }
    std::printf("%-44s %8zu %9.3f %9.3f %9.3f %9.3f %9.3f\n", topic.c_str(), delay.num, delay.smallest_ms,
                delay.median_ms, delay.p99_ms, delay.largest_ms, delay.bound_ms);
  }
}

// The age of a message by this machine's clock, with the bound of the clock difference for other machines.
std::string AgeText(const bus::Observation& observation, const std::vector<bus::PeerStatus>& peers) {
  HeardTopics one(true);
  bus::Observation alone = observation;
  alone.part = 0;
  alone.topic_class = bus::TopicClass::kLatest;
  one.Add(alone, peers);
  const HeardTopic::Delay delay = one.all().begin()->second.delay();
  if (delay.num == 0) return ", age not known: its clock has not been compared yet";
  char text[64];
  if (delay.bound_ms == 0.0) {
    std::snprintf(text, sizeof text, ", %.3f ms old", delay.largest_ms);
  } else {
    std::snprintf(text, sizeof text, ", %.3f +- %.3f ms old", delay.largest_ms, delay.bound_ms);
  }
  return text;
}

void Echo(const bus::Observation& observation, const std::vector<bus::PeerStatus>& peers) {
  std::printf("--- %s #%llu from %s, %zu bytes", observation.topic.c_str(),
              static_cast<unsigned long long>(observation.sequence), observation.writer.c_str(), observation.num_bytes);
  // Only a LATEST message says when it was published.
  if (observation.publish_ns > 0) std::printf("%s", AgeText(observation, peers).c_str());
  std::printf("\n%s\n", observation.Text().c_str());
  std::fflush(stdout);
}

// echo continues until Ctrl-C; the others observe for this time.
double DefaultSeconds(What what) {
  switch (what) {
    case What::kEcho:
      return 1e9;
    case What::kHz:
    case What::kBw:
    case What::kDelay:
      return 5.0;
    case What::kAccounts:  // a second until all have sent theirs, and two comparisons
      return 3.0;
    default:
      return 2.0;
  }
}

int Show(What what, const bus::Node& node, const std::string& pattern, const HeardTopics& heard,
         const bus::ReportedAccounts& joined, double seconds) {
  const std::vector<bus::PeerStatus> peers = node.Peers();
  const std::map<std::string, Ends> topics = Declared(peers, pattern);
  switch (what) {
    case What::kList:
    case What::kInfo:
      if (topics.empty()) return Complain("topic", "no node writes or reads '" + pattern + "'", kDoesNotHold);
      if (what == What::kList) ShowList(topics);
      if (what == What::kInfo) {
        for (const auto& [topic, ends] : topics) ShowInfo(topic, ends, heard);
      }
      return kHolds;
    case What::kAccounts:
      return ShowAccounts(peers, pattern, joined)
                 ? kHolds
                 : Complain("topic", "writers and readers disagree by more than the messages under way", kDoesNotHold);
    case What::kHz:
      ShowRates(heard);
      break;
    case What::kBw:
      ShowBandwidths(heard, seconds);
      break;
    case What::kDelay:
      ShowDelays(heard);
      break;
    case What::kEcho:
      break;
  }
  return heard.all().empty() ? Complain("topic", "no message was received of '" + pattern + "'", kDoesNotHold) : kHolds;
}

int RunTopic(const Arguments& arguments) {
  const std::optional<What> what = Parse(arguments.positional()[0]);
  const bool has_pattern = arguments.positional().size() == 2;
  if (!what) {
    return Complain("topic", "'" + arguments.positional()[0] + "' is none of list, info, echo, hz, bw, delay, accounts",
                    kBadUsage);
  }
  if ((*what == What::kEcho || *what == What::kInfo) && !has_pattern) {
    return Complain("topic", arguments.positional()[0] + " needs a topic, e.g. logic/status", kBadUsage);
  }
  const auto count = arguments.number("--count");
  const auto seconds = arguments.number("--seconds");
  if (!count) return Complain("topic", count.error().detail, kBadUsage);
  if (!seconds) return Complain("topic", seconds.error().detail, kBadUsage);

  auto node = Attach(arguments, "topic");
  if (!node) return Complain("topic", node.error().detail, kDoesNotHold);
  const std::string pattern = has_pattern ? arguments.positional()[1] : "*";
  (*node)->Observe(pattern);
  if (const auto started = (*node)->Start(kStart_ns); !started) {
    return Complain("topic", started.error().detail, kDoesNotHold);
  }
  const std::atomic<int>& interrupted = CatchInterrupt();
  const auto limit_messages = static_cast<std::uint64_t>(count->value_or(1e18));
  const double limit_s = std::min(seconds->value_or(DefaultSeconds(*what)), 1e9);
  const std::int64_t begin_ns = core::MonotonicNow_ns();
  const std::int64_t end_ns = begin_ns + static_cast<std::int64_t>(limit_s * 1e9);
  HeardTopics heard(*what == What::kDelay);
  bus::ReportedAccounts joined(pattern);
  std::uint64_t num_messages = 0;
  bus::Observation observation;
  while (interrupted.load() == 0 && core::MonotonicNow_ns() < end_ns && num_messages < limit_messages) {
    (*node)->Wait(core::MonotonicNow_ns() + kPoll_ns);
    const std::vector<bus::PeerStatus> peers = (*node)->Peers();
    joined.Update(peers);
    while (num_messages < limit_messages && (*node)->PollObservation(&observation)) {
      ++num_messages;
      heard.Add(observation, peers);
      if (*what == What::kEcho) Echo(observation, peers);
    }
  }
  return Show(*what, **node, pattern, heard, joined, static_cast<double>(core::MonotonicNow_ns() - begin_ns) * 1e-9);
}

}  // namespace

Verb TopicVerb() {
  std::vector<Option> options = AttachOptions();
  options.push_back({"--count", "N", "stop after N messages"});
  options.push_back(
      {"--seconds", "S", "observe for S seconds (list, info: 2, accounts: 3, hz, bw, delay: 5, echo: until Ctrl-C)"});
  return {"topic",
          "observes topics of the running session: content, rate, bandwidth, delay and losses",
          "list|info|echo|hz|bw|delay|accounts [PATTERN]",
          1,
          2,
          options,
          RunTopic};
}

}  // namespace oos
