// A registry and one node, "peer", for the tests of the clients in other languages: clients_peer [KEY DIRECTORY]. With
// a key directory, it makes keys there and everything is encrypted. Standard output has one line for the registry's
// address (JSON) and one for each thing the client does. Exit status 0: the client did all that it must.

#include <unistd.h>

#include <cstdio>
#include <set>
#include <string>

#include "bus/membership/registry.hpp"
#include "bus/node.hpp"
#include "bus/security/keys.hpp"
#include "bus/wire/schema.hpp"
#include "core/clock.hpp"
#include "core/hash.hpp"
#include "core/messages/device.hpp"
#include "core/messages/haptic.hpp"
#include "core/messages/physics.hpp"

namespace {

constexpr std::int64_t kPeriod_ns = 5'000'000;
constexpr std::int64_t kPatience_ns = 100'000'000'000;
constexpr int kNumBodies = 40;  // enough that one message takes several datagrams

void Say(const std::string& line) {
  std::printf("%s\n", line.c_str());
  std::fflush(stdout);
}

// What the client has to have done before it leaves.
class Deeds {
 public:
  void Add(const std::string& deed) {
    if (done_.insert(deed).second) Say("client: " + deed);
  }
  [[nodiscard]] bool has(const std::string& deed) const { return done_.count(deed) != 0; }
  [[nodiscard]] int Judge() const {
    int status = 0;
    for (const char* deed : {"device state", "event", "parameter", "second parameter refused", "goodbye"}) {
      if (has(deed)) continue;
      Say(std::string("missing: ") + deed);
      status = 1;
    }
    return status;
  }

 private:
  std::set<std::string> done_;
};

// As JSON: the schema digest of every message type by its name.
std::string Digests() {
  std::string text;
  for (int i = 1; i <= static_cast<int>(bus::kLastMessageType); ++i) {
    const bus::PayloadSchema& schema = bus::SchemaOf(static_cast<bus::MessageType>(i));
    text += (i == 1 ? "\"" : ", \"") + schema.name + "\": " + std::to_string(schema.digest);
  }
  return "{" + text + "}";
}

core::PhysicsState StateOfTick(std::uint64_t tick) {
  core::PhysicsState state;
  state.tick = tick;
  for (std::uint16_t i = 0; i < kNumBodies; ++i) {
    core::BodyState body;
    body.object = i;
    body.X_WO.translation = {i, 0.5 * static_cast<double>(tick % 100), -1.0};
    state.bodies.push_back(body);
  }
  return state;
}

int Fail(const std::string& why) {
  Say("error: " + why);
  return 2;
}

}  // namespace

int main(int argc, char** argv) {
  const std::string keys = argc > 1 ? argv[1] : "";
  if (!keys.empty()) {
    if (const auto made = bus::MakeKeys(keys, {"peer", "client"}); !made) return Fail(made.error().detail);
  }
  const std::int64_t seed[] = {core::MonotonicNow_ns(), getpid()};
  const std::uint64_t session = core::Hash64(seed, sizeof(seed)) | std::uint64_t{1} << 63;
  const auto registry = bus::Registry::Create({"tcp://127.0.0.1:0", session, keys, !keys.empty()});
  if (!registry) return Fail(registry.error().detail);
  bus::NodeOptions options;
  options.name = "peer";
  options.registry = (*registry)->endpoint();
  options.session = session;
  options.keys = keys;
  options.is_encrypted = !keys.empty();
  options.tcp_topics = {"haptic/*"};
  const auto created = bus::Node::Create(options);
  if (!created) return Fail(created.error().detail);
  bus::Node& node = **created;
  auto physics = node.WriteLatest<core::PhysicsState>(bus::kPhysicsStateTopic);
  auto proxies = node.WriteLatest<core::HapticProxy>(bus::HapticProxyTopic("right"));  // by ZeroMQ
  auto status = node.WriteState<core::LogicStatus>(bus::kLogicStatusTopic);
  const auto& hand = node.ReadLatest<core::DeviceState>(bus::DeviceStateTopic("right"));
  node.ReadEvents();
  node.OwnParameters({"gain"});
  if (const auto started = node.Start(); !started) return Fail(started.error().detail);
  core::LogicStatus logic;
  logic.step = "before the client joined";
  status.Set(logic);
  Say(R"({"registry": ")" + options.registry + R"(", "session": ")" + std::to_string(session) + R"(", "keys": ")" +
      keys + "\", \"digests\": " + Digests() + "}");

  Deeds deeds;
  const std::int64_t end_ns = core::MonotonicNow_ns() + kPatience_ns;
  for (std::uint64_t tick = 1; !deeds.has("goodbye") && core::MonotonicNow_ns() < end_ns; ++tick) {
    node.Wait(core::MonotonicNow_ns() + kPeriod_ns);
    core::PhysicsState state = StateOfTick(tick);
    physics.Send(state);
    core::HapticProxy proxy;
    proxy.cycle = tick;
    proxies.Send(proxy);
    if (hand.is_fresh() && hand.value().X_WD.translation == glm::dvec3(0.1, 0.2, 0.3) && hand.value().is_engaged &&
        !deeds.has("device state")) {
      deeds.Add("device state");
      node.Emit({core::MonotonicNow_ns(), "peer", "hand_seen", ""});
    }
    core::Event event;
    while (node.PollEvent(&event)) {
      if (event.source == "client" && event.name == "greeting" && event.detail == "hello") {
        deeds.Add("event");
        logic.step = "greeted";
        status.Set(logic);
        node.Emit({core::MonotonicNow_ns(), "peer", "greeting", "hello, " + event.source});
      }
      if (event.name == "node_left" && event.detail == "client") deeds.Add("goodbye");
      if (event.name == "node_lost")
        Say("lost " + event.detail);  // no failure: a busy machine may delay its heartbeats
    }
    core::ParameterChange change;
    std::uint64_t ticket = 0;
    while (node.PollParameter(&change, &ticket)) {
      const bool is_good = change.value == 2.5;
      deeds.Add(is_good ? "parameter" : "second parameter refused");
      node.AckParameter(ticket, tick, is_good, is_good ? "" : "gain is out of range");
    }
  }
  return deeds.Judge();
}
