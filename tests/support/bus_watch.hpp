#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <filesystem>
#include <mutex>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "bus/node.hpp"

namespace system_tests {

// Observes a launched run from a thread in another network namespace than the test. Times are by the test's clock.
class BusWatch {
 public:
  // `network`: /proc/PID/ns/net of the launcher; `bind`: an address there; `role`: the device whose force is observed.
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
  // An event that a node emitted, or that the registry emitted about it.
  [[nodiscard]] bool HasHeard(const std::string& event, const std::string& node) const;
  // Seconds from the node's last event `from` to its last event `to`.
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

}  // namespace system_tests
