#include "bus/node.hpp"

#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <random>

#include "bus/accounts/accounts.hpp"
#include "bus/node_impl.hpp"
#include "bus/wire/schema.hpp"
#include "core/clock.hpp"

namespace bus {
namespace {

// Copies into a string whose room was reserved, cut to what fits.
void AssignCut(const std::string& text, std::string* slot) {
  slot->assign(text, 0, std::min(text.size(), detail::kMaxEventText));
}

std::uint64_t RandomInstance() {
  std::random_device device;
  return (static_cast<std::uint64_t>(device()) << 32) ^ device();
}

}  // namespace

Node::Node(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}

Node::~Node() {
  if (impl_->core.options.tap != nullptr) impl_->core.options.tap->SetClocks({});
  impl_->bus.Stop();
  if (impl_->core.wake_fd >= 0) close(impl_->core.wake_fd);
}

core::Result<std::unique_ptr<Node>> Node::Create(const NodeOptions& options) {
  if (options.name.empty()) return core::Fail(core::ErrorCode::kInvalidInput, "a node needs a name");
  auto impl = std::make_unique<Impl>();
  detail::NodeCore& core = impl->core;
  core.options = options;
  if (options.is_encrypted) {
    if (options.keys.empty()) {
      return core::Fail(core::ErrorCode::kInvalidInput,
                        "node " + options.name + " has no key directory; give --keys DIR or --no_encryption");
    }
    auto keys = LoadKeys(options.keys, options.name);
    if (!keys) return tl::unexpected(keys.error());
    core.keys = std::move(*keys);
  }
  core.tap.Attach(options.tap);
  core.instance = RandomInstance();
  core.identity.session = options.session;
  core.guard = std::make_unique<detail::DatagramGuard>(options.session, options.is_encrypted);
  core.identity.node = TopicId(options.name);
  // A proposal: the registry grants a later epoch if this machine's clock is behind.
  core.identity.boot =
      static_cast<std::uint64_t>(std::chrono::system_clock::now().time_since_epoch() / std::chrono::nanoseconds(1));
  for (detail::UdpSocket* socket : {&core.data_socket, &core.heartbeat_socket}) {
    auto bound = detail::UdpSocket::Bind(options.bind_address);
    if (!bound) return tl::unexpected(bound.error());
    *socket = std::move(*bound);
  }
  if (!options.multicast.empty()) {
    auto joined = detail::UdpSocket::Join(options.multicast, options.bind_address);
    if (!joined) return tl::unexpected(joined.error());
    core.group_socket = std::move(*joined);
    if (auto sends = core.data_socket.SendToGroupsBy(options.bind_address); !sends)
      return tl::unexpected(sends.error());
  }
  core.wake_fd = eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC);
  if (core.wake_fd < 0) return core::Fail(core::ErrorCode::kResource, "eventfd: too many open files");
  std::unique_ptr<Node> node(new Node(std::move(impl)));
  if (auto opened = node->impl_->bus.Open(); !opened) return tl::unexpected(opened.error());
  return node;
}

// --- Start

core::Result<void> Node::Start(std::int64_t timeout_ns) {
  detail::NodeCore& core = impl_->core;
  for (std::size_t i = 1; i < core.receivers.size(); ++i) {
    if (core.receivers[i - 1]->id == core.receivers[i]->id) {
      core.declaration_errors.push_back("topics '" + core.receivers[i - 1]->topic + "' and '" +
                                        core.receivers[i]->topic + "' have the same id; rename one");
    }
  }
  if (!core.declaration_errors.empty()) {
    std::string text = "node " + core.options.name + " cannot start:";
    for (const std::string& error : core.declaration_errors) text += "\n  " + error;
    return core::Fail(core::ErrorCode::kInvalidInput, text);
  }
  if (!impl_->bus.is_running()) impl_->bus.Start();
  if (core.options.tap != nullptr) core.options.tap->SetClocks([this] { return detail::ClocksOf(Peers()); });
  if (timeout_ns <= 0) return {};
  std::unique_lock lock(core.mutex);
  const bool is_answered = core.changed.wait_for(lock, std::chrono::nanoseconds(timeout_ns),
                                                 [&core] { return core.is_welcomed || !core.refusal.empty(); });
  if (core.is_welcomed) {
    for (const auto& sender : core.senders) sender->envelope.boot = core.identity.boot;
    return {};
  }
  if (is_answered) {
    return core::Fail(core::ErrorCode::kInvalidInput, "the registry " + core.options.registry + " refuses node " +
                                                          core.options.name + ": " + core.refusal);
  }
  return core::Fail(
      core::ErrorCode::kTimeout,
      "node " + core.options.name + ": no answer from the registry " + core.options.registry + " for " +
          std::to_string(timeout_ns / 1'000'000) + " ms; " +
          (core.registry_trouble.empty() ? "is `oos run` still there, and the port right?" : core.registry_trouble));
}

core::Result<void> Node::WaitForPeers(const std::vector<std::string>& names, std::int64_t timeout_ns) {
  detail::NodeCore& core = impl_->core;
  std::unique_lock lock(core.mutex);
  std::string missing;
  const auto are_there = [&] {
    missing.clear();
    for (const std::string& name : names) {
      const auto peer = core.peers.find(name);
      if (peer == core.peers.end() || !peer->second.is_alive) missing += (missing.empty() ? "" : ", ") + name;
    }
    return missing.empty();
  };
  if (core.changed.wait_for(lock, std::chrono::nanoseconds(timeout_ns), are_there)) return {};
  return core::Fail(core::ErrorCode::kTimeout,
                    core.options.name + " waited " + std::to_string(timeout_ns / 1'000'000) + " ms for: " + missing);
}

// --- EVENT

bool Node::Emit(const core::Event& event) {
  core::Event* slot = impl_->core.events_out.BeginPush();
  if (slot == nullptr) return false;
  slot->time_ns = event.time_ns;
  AssignCut(event.source, &slot->source);
  AssignCut(event.name, &slot->name);
  AssignCut(event.detail, &slot->detail);
  impl_->core.tap.Emitted(*slot);
  impl_->core.events_out.EndPush();
  impl_->core.Wake();
  return true;
}

bool Node::PollEvent(core::Event* event) {
  if (!impl_->core.events_in.Pop(event)) return false;
  impl_->core.tap.TookEvent(*event);
  return true;
}

// --- SERVICE

bool Node::PollParameter(core::ParameterChange* change, std::uint64_t* ticket) {
  detail::ParameterItem* item = impl_->core.parameters_in.Front();
  while (item != nullptr && item->deadline_ns != 0 && core::MonotonicNow_ns() > item->deadline_ns) {
    AckParameter(item->ticket, 0, false, "came too late; its caller has given up");
    impl_->core.parameters_in.EndPop();
    item = impl_->core.parameters_in.Front();
  }
  if (item == nullptr) return false;
  *change = item->change;
  *ticket = item->ticket;
  impl_->core.tap.TookParameter(*ticket, *change);
  impl_->core.parameters_in.EndPop();
  return true;
}

void Node::AckParameter(std::uint64_t ticket, std::uint64_t tick, bool is_accepted, const std::string& why,
                        double injected_J, bool is_pending) {
  detail::ParameterAnswer* slot = impl_->core.answers_out.BeginPush();
  if (slot == nullptr) return;  // the call then ends at its deadline
  slot->ticket = ticket;
  slot->tick = tick;
  slot->is_accepted = is_accepted;
  slot->injected_J = injected_J;
  slot->is_pending = is_pending;
  AssignCut(why, &slot->why);
  impl_->core.tap.Answered(*slot);
  impl_->core.answers_out.EndPush();
  impl_->core.Wake();
}

std::uint64_t Node::PostParameter(const std::string& owner, const core::ParameterChange& change,
                                  std::int64_t timeout_ns) {
  detail::ParameterCall* slot = impl_->core.calls_out.BeginPush();
  if (slot == nullptr) return 0;
  const std::uint64_t request = impl_->core.next_request.fetch_add(1);
  slot->request = request;
  slot->owner = owner;
  slot->change = change;
  slot->deadline_ns = core::MonotonicNow_ns() + timeout_ns;
  slot->is_waited_for = false;
  impl_->core.tap.Posted(request, owner, change);
  impl_->core.calls_out.EndPush();
  impl_->core.Wake();
  return request;
}

bool Node::PollAck(ParameterAck* ack) {
  if (!impl_->core.acks_in.Pop(ack)) return false;
  impl_->core.tap.TookAck(*ack);
  return true;
}

core::Result<ParameterAck> Node::SetParameter(const std::string& owner, const core::ParameterChange& change,
                                              std::int64_t timeout_ns) {
  detail::NodeCore& core = impl_->core;
  const std::uint64_t request = core.next_request.fetch_add(1);
  std::unique_lock lock(core.mutex);
  core.waiting_calls.push_back({request, owner, change, core::MonotonicNow_ns() + timeout_ns, true});
  core.Wake();
  // The bus thread ends every call at its deadline; the extra second covers a bus thread that is held up.
  const bool is_finished =
      core.changed.wait_for(lock, std::chrono::nanoseconds(timeout_ns + core::kNanosecondsPerSecond),
                            [&] { return core.finished_calls.count(request) != 0; });
  const std::string what = "parameter " + change.name;
  if (!is_finished)
    return core::Fail(core::ErrorCode::kTimeout, what + ": the bus thread of " + core.options.name + " hangs");
  const ParameterAck ack = core.finished_calls[request];
  core.finished_calls.erase(request);
  if (ack.is_accepted) return ack;
  return core::Fail(core::ErrorCode::kInvalidInput, what + " was not set: " + ack.why);
}

// --- Observing

bool Node::PollObservation(Observation* observation) {
  detail::RawObservation raw;
  {
    const std::lock_guard lock(impl_->core.mutex);
    if (impl_->core.observations.empty()) return false;
    raw = std::move(impl_->core.observations.front());
    impl_->core.observations.pop_front();
  }
  *observation = {raw.topic,     raw.topic_class, raw.writer, raw.sequence,  raw.publish_ns,        raw.received_ns,
                  raw.num_bytes, raw.type,        raw.part,   raw.num_parts, std::move(raw.payload)};
  return true;
}

std::string Observation::Text() const {
  const std::string note =
      num_parts > 1 ? "# part " + std::to_string(part + 1) + " of " + std::to_string(num_parts) + "\n" : "";
  return note + PayloadText(type, {reinterpret_cast<const std::uint8_t*>(payload.data()), payload.size()});
}

std::vector<PeerStatus> Node::Peers() const {
  const std::lock_guard lock(impl_->core.mutex);
  const std::int64_t now = core::MonotonicNow_ns();
  std::vector<PeerStatus> peers;
  for (const auto& [name, status] : impl_->core.peers) {
    peers.push_back(status);
    peers.back().age_ns = now - status.age_ns;
  }
  return peers;
}

bool Node::IsAlive(const std::string& peer) const {
  const std::lock_guard lock(impl_->core.mutex);
  const auto found = impl_->core.peers.find(peer);
  return found != impl_->core.peers.end() && found->second.is_alive;
}

Counters Node::counters() const {
  return impl_->core.CountAll();
}
std::vector<Account> Node::Accounts() const {
  const std::lock_guard lock(impl_->core.mutex);
  return detail::AllAccounts(impl_->core);
}
const std::string& Node::name() const {
  return impl_->core.options.name;
}
std::uint64_t Node::instance() const {
  return impl_->core.instance;
}
std::uint64_t Node::session() const {
  return impl_->core.identity.session;
}

}  // namespace bus
