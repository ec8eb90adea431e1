#include "bus/membership/registry.hpp"

#include <pthread.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <csignal>
#include <map>
#include <mutex>
#include <optional>
#include <thread>
#include <zmq.hpp>

#include "bus/node_core.hpp"
#include "bus/reliable/routed.hpp"
#include "bus/security/gate.hpp"
#include "bus/security/session_key.hpp"
#include "bus/wire/control.hpp"
#include "bus/wire/schema.hpp"
#include "core/clock.hpp"
#include "proto/bus.pb.h"

namespace bus {
namespace {

// Three HELLO periods of 0.5 s: a silent node is dropped from the roster.
constexpr std::int64_t kSilentAfter_ns = 1'500 * core::kMillisecond_ns;
// One HELLO period and 0.3 s of jitter: a silent node gives way to a newcomer that conflicts with it.
constexpr std::int64_t kYieldsAfter_ns = 800 * core::kMillisecond_ns;

struct Entry {
  oos::NodeRecord record;
  std::map<std::uint32_t, std::string> schemas;  // digest -> canonical text
  std::string routing;
  std::int64_t last_hello_ns = 0;
};

}  // namespace

struct Registry::Impl {
  RegistryOptions options;
  std::string endpoint;
  detail::Identity identity;
  std::optional<Keys> keys;
  std::string session_key;  // of UDP datagrams
  zmq::context_t context{1};
  detail::Gate gate;
  zmq::socket_t router;
  std::atomic<std::uint64_t> refused_messages{0};
  int wake_fd = -1;
  std::thread thread;
  std::atomic<bool> is_stopping{false};

  mutable std::mutex mutex;
  std::map<std::string, Entry> entries;  // by name
  std::vector<std::string> refusals;
  std::uint64_t version = 0;
  std::map<std::uint64_t, std::int64_t> first_request_ns;  // instance that conflicts with a node that may be dead
  std::map<std::uint64_t, std::string> fenced;             // superseded instance -> who took its place
  std::map<std::string, std::uint64_t> last_epoch;         // of each name and written topic

  ~Impl() {
    if (thread.joinable()) {
      is_stopping.store(true);
      const std::uint64_t one = 1;
      [[maybe_unused]] const ssize_t written = write(wake_fd, &one, sizeof(one));
      thread.join();
    }
    if (wake_fd >= 0) close(wake_fd);
  }

  void Run();
  void Receive();
  void TakeHello(const std::string& routing, const std::string& key_name, const oos::Hello& hello);
  std::string FindConflict(const oos::NodeRecord& record, const std::map<std::uint32_t, std::string>& schemas,
                           const Entry** other, bool* is_exclusive) const;
  void Supersede(const Entry& other, const std::string& by);
  std::uint64_t GrantEpoch(const oos::NodeRecord& record);
  void Refuse(const std::string& routing, const std::string& why, bool is_fenced = false);
  void Send(const std::string& routing, const oos::Control& control);
  void SendRoster(const Entry& entry, std::uint64_t known);
  void PushRoster();
};

Registry::Registry(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Registry::~Registry() = default;

core::Result<std::unique_ptr<Registry>> Registry::Create(const RegistryOptions& options) {
  auto impl = std::make_unique<Impl>();
  impl->options = options;
  if (options.is_encrypted) {
    if (options.keys.empty()) {
      return core::Fail(core::ErrorCode::kInvalidInput,
                        "the registry has no key directory; give one, or turn encryption off explicitly");
    }
    auto keys = LoadKeys(options.keys, kRegistryKeyName);
    if (!keys) return tl::unexpected(keys.error());
    impl->keys = std::move(*keys);
    impl->session_key = detail::DeriveSessionKey(impl->keys->own.secret_key, options.session);
  }
  impl->identity = {options.session, TopicId("registry"), static_cast<std::uint64_t>(core::MonotonicNow_ns())};
  impl->version = impl->identity.boot;  // differs from every version of an earlier registry
  try {
    impl->gate.Open(&impl->context, impl->keys);
    impl->router = zmq::socket_t(impl->context, zmq::socket_type::router);
    impl->gate.GuardListener(&impl->router);
    impl->router.set(zmq::sockopt::router_handover, true);
    impl->router.set(zmq::sockopt::router_mandatory, true);
    impl->router.set(zmq::sockopt::linger, 0);
    impl->router.bind(options.endpoint);
    impl->endpoint = impl->router.get(zmq::sockopt::last_endpoint);
  } catch (const zmq::error_t& error) {
    return core::Fail(core::ErrorCode::kIo, "registry at '" + options.endpoint + "': " + error.what() +
                                                "; use tcp://ADDRESS:PORT with a free port, or port 0 for any");
  }
  impl->wake_fd = eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC);
  if (impl->wake_fd < 0) return core::Fail(core::ErrorCode::kResource, "eventfd: too many open files");
  sigset_t all, before;
  sigfillset(&all);
  pthread_sigmask(SIG_SETMASK, &all, &before);
  impl->thread = std::thread([raw = impl.get()] { raw->Run(); });
  pthread_setname_np(impl->thread.native_handle(), "registry");
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
  return std::unique_ptr<Registry>(new Registry(std::move(impl)));
}

const std::string& Registry::endpoint() const {
  return impl_->endpoint;
}

std::vector<std::string> Registry::Names() const {
  const std::lock_guard lock(impl_->mutex);
  std::vector<std::string> names;
  for (const auto& [name, entry] : impl_->entries) names.push_back(name);
  return names;
}

std::uint64_t Registry::num_refused() const {
  return impl_->gate.refused() + impl_->refused_messages.load();
}

std::vector<std::string> Registry::Refusals() const {
  const std::lock_guard lock(impl_->mutex);
  return impl_->refusals;
}

void Registry::Impl::Run() {
  while (!is_stopping.load()) {
    std::vector<zmq::pollitem_t> items = {{router.handle(), 0, ZMQ_POLLIN, 0}, {nullptr, wake_fd, ZMQ_POLLIN, 0}};
    gate.AddPollItems(&items);
    zmq_poll(items.data(), static_cast<int>(items.size()), 100);
    gate.Serve();
    const std::lock_guard lock(mutex);
    Receive();
    const std::int64_t now = core::MonotonicNow_ns();
    const std::size_t dropped =
        std::erase_if(entries, [now](const auto& item) { return now - item.second.last_hello_ns > kSilentAfter_ns; });
    if (dropped > 0) PushRoster();
  }
  router.close();
  gate.Close();
}

void Registry::Impl::Receive() {
  zmq::message_t routing, message;
  while (detail::ReceiveRouted(&router, &routing, &message)) {
    // The session is checked below, by name: a HELLO of another session deserves an answer.
    Envelope envelope;
    std::span<const std::uint8_t> payload;
    oos::Control control;
    if (message.size() > detail::kMaxMessageBytes ||
        ReadEnvelope({message.data<std::uint8_t>(), message.size()}, &envelope, &payload) != EnvelopeStatus::kOk ||
        !control.ParseFromArray(payload.data(), static_cast<int>(payload.size())) || !control.has_hello()) {
      refused_messages.fetch_add(1);
      continue;
    }
    identity.session = envelope.session;  // the node reads only answers of its own session
    TakeHello(routing.to_string(), detail::Gate::KeyNameOf(message), control.hello());
    identity.session = options.session;
  }
}

void Registry::Impl::TakeHello(const std::string& routing, const std::string& key_name, const oos::Hello& hello) {
  const oos::NodeRecord& record = hello.node();
  const std::int64_t now = core::MonotonicNow_ns();
  if (keys && !IsKeyFor(key_name, record.name())) {
    Refuse(routing, "the key of " + key_name + " is not good for a node called " + record.name());
    return;
  }
  const auto known = entries.find(record.name());
  const bool is_same = known != entries.end() && known->second.record.instance() == record.instance();
  if (hello.is_goodbye()) {
    if (is_same) {
      entries.erase(known);
      PushRoster();
    }
    return;
  }
  if (record.session() != options.session) {
    Refuse(routing, record.name() + " belongs to session " + std::to_string(record.session()) +
                        ", this registry serves session " + std::to_string(options.session));
    return;
  }
  if (record.protocol_version() != detail::kProtocolVersion) {
    Refuse(routing, record.name() + " speaks bus protocol " + std::to_string(record.protocol_version()) +
                        ", this registry " + std::to_string(detail::kProtocolVersion) + "; build both from one source");
    return;
  }
  if (is_same) {
    known->second.last_hello_ns = now;
    known->second.routing = routing;
    SendRoster(known->second, hello.known_roster());
    return;
  }
  if (const auto by = fenced.find(record.instance()); by != fenced.end()) {
    Refuse(routing, record.name() + " is fenced off: " + by->second + " has taken its place", true);
    return;
  }
  std::map<std::uint32_t, std::string> schemas;
  for (const oos::Schema& schema : record.schemas()) schemas[schema.digest()] = schema.canonical();
  const Entry* other = nullptr;
  bool is_exclusive = false;
  const std::string conflict = FindConflict(record, schemas, &other, &is_exclusive);
  if (!conflict.empty()) {
    // Both were admitted: by different lives of the registry, or the other one while this one could not be heard.
    if (is_exclusive && hello.is_member() && record.boot() < other->record.boot()) {
      fenced[record.instance()] = other->record.name();
      Refuse(routing, record.name() + " is fenced off: " + other->record.name() + " has taken its place", true);
      return;
    }
    if (is_exclusive && (hello.is_member() || hello.takes_over())) {
      Supersede(*other, record.name());
      TakeHello(routing, key_name, hello);
      return;
    }
    // The other may have been killed a moment ago. A HELLO later than the newcomer's shows that it is alive; silence of
    // kYieldsAfter_ns shows that it is dead. Until either is known, the newcomer gets no answer and repeats its HELLO.
    const auto [first_request, is_first_time] = first_request_ns.try_emplace(record.instance(), now);
    if (other == nullptr || other->last_hello_ns > first_request->second) {
      first_request_ns.erase(first_request);
      Refuse(routing, conflict);
      return;
    }
    if (now - other->last_hello_ns < kYieldsAfter_ns) return;
    if (is_exclusive) {
      Supersede(*other, record.name());
    } else {
      entries.erase(std::string(other->record.name()));
    }
    TakeHello(routing, key_name, hello);  // there may be a second conflict
    return;
  }
  first_request_ns.erase(record.instance());
  const std::uint64_t epoch = GrantEpoch(record);
  if (hello.is_member() && epoch != record.boot()) {  // its successor has come and left
    fenced[record.instance()] = "a later instance";
    Refuse(routing, record.name() + " is fenced off: a later instance has had its place", true);
    return;
  }
  Entry& entry = entries[record.name()];
  entry.record = record;
  entry.record.set_boot(epoch);
  entry.record.clear_schemas();
  entry.record.set_public_key(keys ? keys->PublicKeyOf(key_name) : std::string());
  entry.schemas = std::move(schemas);
  entry.routing = routing;
  entry.last_hello_ns = now;
  PushRoster();
}

// Empty when the newcomer fits in. `other` is the node it conflicts with; null: with itself.
std::string Registry::Impl::FindConflict(const oos::NodeRecord& record,
                                         const std::map<std::uint32_t, std::string>& schemas, const Entry** other,
                                         bool* is_exclusive) const {
  for (const auto& [name, entry] : entries) {
    *other = &entry;
    *is_exclusive = true;
    if (name == record.name()) {
      return "a node called " + name + " (process " + std::to_string(entry.record.process_id()) +
             ") is running already; end it or choose another name";
    }
    for (const oos::TopicDeclaration& mine : record.topics()) {
      for (const oos::TopicDeclaration& theirs : entry.record.topics()) {
        if (mine.name() != theirs.name()) {
          if (TopicId(mine.name()) == TopicId(theirs.name())) {
            *is_exclusive = false;
            return "topics " + mine.name() + " of " + record.name() + " and " + theirs.name() + " of " + name +
                   " have the same id; rename one";
          }
          continue;
        }
        *is_exclusive = true;
        if (mine.is_written() && theirs.is_written()) {
          return "topic " + mine.name() + " is written by " + name + " already; " + record.name() +
                 " must not write it too";
        }
        *is_exclusive = false;
        if (mine.schema_digest() == theirs.schema_digest()) continue;
        const auto my_schema = schemas.find(mine.schema_digest());
        const auto their_schema = entry.schemas.find(theirs.schema_digest());
        std::string why = "its schema is not given";
        if (my_schema == schemas.end() || their_schema == entry.schemas.end() ||
            !AreCompatible(my_schema->second, their_schema->second, &why)) {
          return "topic " + mine.name() + ": the schema of " + record.name() + " contradicts the one of " + name +
                 " (" + why + "); build both from the same proto/";
        }
      }
    }
  }
  *other = nullptr;
  return {};
}

// `other` is in `entries`. Its connection stays, so that its next HELLO can be refused.
void Registry::Impl::Supersede(const Entry& other, const std::string& by) {
  fenced[other.record.instance()] = by;
  entries.erase(std::string(other.record.name()));
}

// The node proposes the time of its start; the granted epoch is later than that of every earlier holder.
std::uint64_t Registry::Impl::GrantEpoch(const oos::NodeRecord& record) {
  std::vector<std::string> places = {"node " + record.name()};
  for (const oos::TopicDeclaration& topic : record.topics()) {
    if (topic.is_written()) places.push_back("topic " + topic.name());
  }
  std::uint64_t highest = 0;
  for (const std::string& place : places) highest = std::max(highest, last_epoch[place]);
  const std::uint64_t epoch = record.boot() >= highest ? record.boot() : highest + 1;
  for (const std::string& place : places) last_epoch[place] = epoch;
  return epoch;
}

void Registry::Impl::Refuse(const std::string& routing, const std::string& why, bool is_fenced) {
  refused_messages.fetch_add(1);
  if (refusals.empty() || refusals.back() != why) refusals.push_back(why);
  oos::Control control;
  control.mutable_refusal()->set_why(why);
  control.mutable_refusal()->set_is_fenced(is_fenced);
  Send(routing, control);
}

void Registry::Impl::Send(const std::string& routing, const oos::Control& control) {
  const auto bytes = detail::EncodeControl(identity, TopicClass::kControl, control);
  try {
    if (router.send(zmq::buffer(routing), zmq::send_flags::sndmore | zmq::send_flags::dontwait)) {
      router.send(zmq::buffer(bytes), zmq::send_flags::dontwait);
    }
  } catch (const zmq::error_t&) {  // disconnected; it is dropped when its HELLOs stop
  }
}

void Registry::Impl::SendRoster(const Entry& to, std::uint64_t known) {
  oos::Control control;
  oos::Roster* roster = control.mutable_roster();
  roster->set_version(version);
  roster->set_is_unchanged(known == version);
  roster->set_session_key(session_key);
  roster->set_boot(to.record.boot());
  if (known != version) {
    for (const auto& [name, entry] : entries) *roster->add_nodes() = entry.record;
    for (const auto& [instance, by] : fenced) roster->add_fenced(instance);
  }
  Send(to.routing, control);
}

void Registry::Impl::PushRoster() {
  ++version;
  for (const auto& [name, entry] : entries) SendRoster(entry, 0);
}

}  // namespace bus
