#include "tests/support/bus_watch.hpp"

#include <fcntl.h>
#include <sched.h>
#include <unistd.h>

#include <chrono>
#include <fstream>
#include <nlohmann/json.hpp>

#include "bus/topics.hpp"
#include "core/clock.hpp"
#include "core/messages/device.hpp"
#include "core/messages/logic.hpp"
#include "core/messages/physics.hpp"
#include "tools/oos/attach/places.hpp"

namespace system_tests {

BusWatch::BusWatch(const std::filesystem::path& network, const std::string& bind, const std::string& role)
    : thread_([this, network, bind, role] {
        Run(network, bind, role);
        SetUp();
      }) {
  is_up_.wait(false);
}

void BusWatch::SetUp() {
  is_up_.store(true);
  is_up_.notify_all();
}

BusWatch::~BusWatch() {
  is_stopping_.store(true);
  thread_.join();
}

std::string BusWatch::step() const {
  const std::scoped_lock lock(mutex_);
  return step_;
}

bool BusWatch::WaitUntilFinal(double patience_s) const {
  std::unique_lock lock(mutex_);
  return became_final_.wait_for(lock, std::chrono::duration<double>(patience_s), [this] { return is_final(); });
}

std::set<std::string> BusWatch::hints() const {
  const std::scoped_lock lock(mutex_);
  return hints_;
}

std::vector<BusWatch::Heard> BusWatch::heard() const {
  const std::scoped_lock lock(mutex_);
  return events_;
}

bool BusWatch::HasHeard(const std::string& event, const std::string& node) const {
  for (const Heard& one : heard()) {
    if (one.event.name == event && (one.event.source == node || one.event.detail == node)) return true;
  }
  return false;
}

double BusWatch::SecondsBetween(const std::string& from, const std::string& to, const std::string& node) const {
  std::int64_t from_ns = 0, to_ns = 0;
  for (const Heard& one : heard()) {
    if (one.event.source != node && one.event.detail != node) continue;
    if (one.event.name == from) from_ns = one.time_ns;
    if (one.event.name == to) to_ns = one.time_ns;
  }
  return 1e-9 * static_cast<double>(to_ns - from_ns);
}

std::vector<bus::PeerStatus> BusWatch::peers() const {
  const std::scoped_lock lock(mutex_);
  return peers_;
}

void BusWatch::Run(const std::filesystem::path& network, const std::string& bind, const std::string& role) {
  const int there = open(network.c_str(), O_RDONLY | O_CLOEXEC);
  const bool is_there = there >= 0 && setns(there, CLONE_NEWNET) == 0;
  if (there >= 0) close(there);
  std::ifstream file(oos::SessionFile());
  const nlohmann::json note = nlohmann::json::parse(file, nullptr, false);
  if (!is_there || !note.is_object()) {
    trouble_ = is_there ? "no session was noted" : "cannot enter the network";
    return;
  }
  bus::NodeOptions options;
  options.registry = note["registry"].get<std::string>();
  options.session = std::stoull(note["session"].get<std::string>());
  options.keys = note["keys"].get<std::string>();
  options.bind_address = bind;
  options.name = "oos-watch-" + std::to_string(getpid());
  options.is_observer = true;
  auto node = bus::Node::Create(options);
  if (!node) {
    trouble_ = node.error().detail;
    return;
  }
  const auto& command = (*node)->ReadLatest<core::DeviceCommand>(bus::DeviceCommandTopic(role));
  const auto& physics = (*node)->ReadLatest<core::PhysicsState>(bus::kPhysicsStateTopic);
  const auto& status = (*node)->ReadState<core::LogicStatus>(bus::kLogicStatusTopic);
  (*node)->ReadEvents();
  if (const auto started = (*node)->Start(); !started) {
    trouble_ = started.error().detail;
    return;
  }
  SetUp();
  std::int64_t next_peers_ns = 0;
  while (!is_stopping_.load()) {
    const std::int64_t now_ns = core::MonotonicNow_ns();
    (*node)->Wait(now_ns + 2'000'000);
    if (command.is_fresh()) force_N_.store(glm::length(command.value().F_Do_W.force_N));
    if (physics.is_fresh()) {
      physics_tick_.store(physics.value().tick);
      physics_heard_ns_.store(physics.received_ns());
    }
    const std::scoped_lock lock(mutex_);
    if (status.has_value()) {
      step_ = status.value().step;
      hints_.insert(status.value().hint);
      is_final_.store(status.value().is_final);
      if (is_final()) became_final_.notify_all();
    }
    for (core::Event event; (*node)->PollEvent(&event);) events_.push_back({event, now_ns});
    if (now_ns < next_peers_ns) continue;
    next_peers_ns = now_ns + 100'000'000;
    peers_ = (*node)->Peers();
  }
}

}  // namespace system_tests
