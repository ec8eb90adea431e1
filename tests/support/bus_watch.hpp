#pragma once

#include <fcntl.h>
#include <sched.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "bus/node.hpp"
#include "bus/topics.hpp"
#include "core/clock.hpp"
#include "core/messages/device.hpp"
#include "core/messages/logic.hpp"
#include "core/messages/physics.hpp"
#include "tools/oos/attach/places.hpp"

namespace system_tests {

// An observer of a launched run, on a thread that stands in another network than the test. Its times are the test's.
class BusWatch {
 public:
  // `network`: /proc/PID/ns/net of the place that launched; `bind`: an address of it; `role`: whose force is watched.
  BusWatch(const std::filesystem::path& network, const std::string& bind, const std::string& role);
  ~BusWatch();
  BusWatch(const BusWatch&) = delete;
  BusWatch& operator=(const BusWatch&) = delete;

  [[nodiscard]] double force_N() const { return force_N_.load(); }  // of the newest command
  [[nodiscard]] std::string step() const;
  [[nodiscard]] bool is_final() const { return is_final_.load(); }
  [[nodiscard]] bool WaitUntilFinal(double patience_s) const;  // false: it is not
  [[nodiscard]] std::set<std::string> hints() const;           // that the screen has shown so far
  [[nodiscard]] std::uint64_t physics_tick() const { return physics_tick_.load(); }
  [[nodiscard]] std::int64_t physics_heard_ns() const { return physics_heard_ns_.load(); }
  struct Heard {
    core::Event event;
    std::int64_t time_ns = 0;
  };
  [[nodiscard]] std::vector<Heard> heard() const;
  // An event of a node, or about it.
  [[nodiscard]] bool HasHeard(const std::string& event, const std::string& node) const;
  // From the last `from` that names the node to the last `to` of it [s].
  [[nodiscard]] double SecondsBetween(const std::string& from, const std::string& to, const std::string& node) const;
  [[nodiscard]] std::vector<bus::PeerStatus> peers() const;
  [[nodiscard]] const std::string& trouble() const { return trouble_; }  // why it cannot watch; empty: it does

 private:
  void SetUp();  // it watches, or has found out that it cannot
  void Run(const std::filesystem::path& network, const std::string& bind, const std::string& role);

  mutable std::mutex mutex_;
  mutable std::condition_variable became_final_;
  std::string step_;
  std::set<std::string> hints_;
  std::vector<Heard> events_;
  std::vector<bus::PeerStatus> peers_;
  std::string trouble_;
  std::atomic<double> force_N_{0.0};
  std::atomic<std::uint64_t> physics_tick_{0};
  std::atomic<std::int64_t> physics_heard_ns_{0};
  std::atomic<bool> is_up_{false}, is_stopping_{false}, is_final_{false};
  std::thread thread_;
};

inline BusWatch::BusWatch(const std::filesystem::path& network, const std::string& bind, const std::string& role)
    : thread_([this, network, bind, role] {
        Run(network, bind, role);
        SetUp();
      }) {
  is_up_.wait(false);
}

inline void BusWatch::SetUp() {
  is_up_.store(true);
  is_up_.notify_all();
}

inline BusWatch::~BusWatch() {
  is_stopping_.store(true);
  thread_.join();
}

inline std::string BusWatch::step() const {
  const std::scoped_lock lock(mutex_);
  return step_;
}

inline bool BusWatch::WaitUntilFinal(double patience_s) const {
  std::unique_lock lock(mutex_);
  return became_final_.wait_for(lock, std::chrono::duration<double>(patience_s), [this] { return is_final(); });
}

inline std::set<std::string> BusWatch::hints() const {
  const std::scoped_lock lock(mutex_);
  return hints_;
}

inline std::vector<BusWatch::Heard> BusWatch::heard() const {
  const std::scoped_lock lock(mutex_);
  return events_;
}

inline bool BusWatch::HasHeard(const std::string& event, const std::string& node) const {
  for (const Heard& one : heard()) {
    if (one.event.name == event && (one.event.source == node || one.event.detail == node)) return true;
  }
  return false;
}

inline double BusWatch::SecondsBetween(const std::string& from, const std::string& to, const std::string& node) const {
  std::int64_t from_ns = 0, to_ns = 0;
  for (const Heard& one : heard()) {
    if (one.event.source != node && one.event.detail != node) continue;
    if (one.event.name == from) from_ns = one.time_ns;
    if (one.event.name == to) to_ns = one.time_ns;
  }
  return 1e-9 * static_cast<double>(to_ns - from_ns);
}

inline std::vector<bus::PeerStatus> BusWatch::peers() const {
  const std::scoped_lock lock(mutex_);
  return peers_;
}

inline void BusWatch::Run(const std::filesystem::path& network, const std::string& bind, const std::string& role) {
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
