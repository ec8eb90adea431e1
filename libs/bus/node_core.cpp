#include "bus/node_core.hpp"

#include <unistd.h>

namespace bus::detail {
namespace {

// Reserves the strings, so that filling a slot does not allocate.
void PrepareEvent(core::Event& event) {
  for (std::string* text : {&event.source, &event.name, &event.detail}) text->reserve(kMaxEventText);
}
void PrepareState(StateItem& item) {
  item.key.reserve(64);
  item.bytes.reserve(4096);
}
void PrepareAnswer(ParameterAnswer& answer) {
  answer.why.reserve(kMaxEventText);
}
void PrepareCall(ParameterCall& call) {
  call.owner.reserve(64);
  call.change.name.reserve(kMaxEventText);
}
void PrepareParameter(ParameterItem& item) {
  item.change.name.reserve(kMaxEventText);
}
void PrepareAck(ParameterAck& ack) {
  ack.owner.reserve(64);
  ack.why.reserve(kMaxEventText);
}

}  // namespace

NodeCore::NodeCore()
    : events_out(256, PrepareEvent),
      states_out(64, PrepareState),
      answers_out(64, PrepareAnswer),
      calls_out(64, PrepareCall),
      events_in(256, PrepareEvent),
      states_in(64, PrepareState),
      parameters_in(64, PrepareParameter),
      acks_in(64, PrepareAck) {}

void NodeCore::Wake() const noexcept {
  const std::uint64_t one = 1;
  // It fails only when the counter is at its limit, and then the bus thread is awake anyway.
  [[maybe_unused]] const ssize_t written = write(wake_fd, &one, sizeof(one));
}

bool NodeCore::IsObserved(const std::string& topic) const {
  for (const std::string& pattern : observed_patterns) {
    if (MatchesPattern(pattern, topic)) return true;
  }
  return false;
}

void NodeCore::AddObservation(RawObservation observation) {
  if (observations.size() >= kMaxObservations) {
    observations.pop_front();
    observations_dropped.fetch_add(1, std::memory_order_relaxed);
  }
  observations.push_back(std::move(observation));
}

Counters NodeCore::CountAll() const {
  Counters counters;
  const auto refuse = [&counters](const char* reason, std::uint64_t count) {
    if (count != 0) counters.refusals.push_back({reason, count});
    counters.refused += count;
  };
  refuse("message", refused.load(std::memory_order_relaxed));
  refuse("connection", refused_connections.load(std::memory_order_relaxed));
  refuse("bulk", refused_bulk->load(std::memory_order_relaxed));
  refuse("fenced", refused_fenced.load(std::memory_order_relaxed));
  for (std::size_t i = 1; i < kNumRefusals; ++i) {
    refuse(NameOf(static_cast<Refusal>(i)), guard->refusals.of(static_cast<Refusal>(i)));
  }
  const auto add = [&counters](TopicCounters topic) {
    counters.sent += topic.sent;
    counters.received += topic.received;
    counters.dropped += topic.dropped;
    counters.topics.push_back(std::move(topic));
  };
  for (const auto& sender : senders) {
    add({sender->topic, TopicClass::kLatest, true, sender->sent.load(std::memory_order_relaxed), 0,
         sender->dropped.load(std::memory_order_relaxed), 0});
  }
  for (const auto& receiver : receivers) {
    const LatestCounts counts = receiver->Counts();
    add({receiver->topic, TopicClass::kLatest, false, 0, counts.received, counts.dropped, counts.reordered,
         counts.restored, counts.repeated});
  }
  for (const auto& sender : state_senders) {
    const std::uint64_t overflows = sender->overflows.load(std::memory_order_relaxed);
    const std::uint64_t oversize = sender->oversize.load(std::memory_order_relaxed);
    add({sender->topic, TopicClass::kState, true, sender->sent.load(std::memory_order_relaxed), 0, overflows + oversize,
         0, 0, 0, overflows, oversize});
  }
  for (const auto& receiver : state_receivers) {
    add({receiver->topic, TopicClass::kState, false, 0, receiver->received.load(std::memory_order_relaxed), 0, 0});
  }
  add({kEventTopic, TopicClass::kEvent, true, events_sent.load(std::memory_order_relaxed), 0,
       events_dropped.load(std::memory_order_relaxed) + events_out.overflows(), 0, 0, 0, events_out.overflows()});
  if (reads_events) {
    add({kEventTopic, TopicClass::kEvent, false, 0, events_received.load(std::memory_order_relaxed), 0, 0});
  }
  const auto add_service = [&add](bool is_call, std::uint64_t overflows) {
    add({kParameterTopic, TopicClass::kService, is_call, 0, 0, overflows, 0, 0, 0, overflows});
  };
  add_service(true, calls_out.overflows());
  if (!parameter_names.empty()) add_service(false, answers_out.overflows());
  if (!observed_patterns.empty()) {
    add({"(observed)", TopicClass::kLatest, false, 0, 0, observations_dropped.load(std::memory_order_relaxed), 0});
  }
  return counters;
}

}  // namespace bus::detail

#if defined(__SANITIZE_THREAD__)
// Debian's libzmq is not instrumented: the sanitizer does not see its locks, and would report its threads as races. All
// code compiled here stays checked. The environment variable TSAN_OPTIONS still applies.
extern "C" const char* __tsan_default_options() {  // NOLINT(bugprone-reserved-identifier): the sanitizer's name
  return "ignore_noninstrumented_modules=1:halt_on_error=0";
}
#endif
