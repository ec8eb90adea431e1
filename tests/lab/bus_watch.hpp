#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "bus/node.hpp"
#include "core/messages/logic.hpp"

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
  [[nodiscard]] std::set<std::string> hints() const;  // that the screen has shown so far
  [[nodiscard]] std::uint64_t physics_tick() const { return physics_tick_.load(); }
  [[nodiscard]] std::int64_t physics_heard_ns() const { return physics_heard_ns_.load(); }
  [[nodiscard]] std::vector<core::Event> events() const;
  [[nodiscard]] std::vector<bus::PeerStatus> peers() const;
  [[nodiscard]] const std::string& trouble() const { return trouble_; }  // why it cannot watch; empty: it does

 private:
  void Run(const std::filesystem::path& network, const std::string& bind, const std::string& role);

  mutable std::mutex mutex_;
  std::string step_;
  std::set<std::string> hints_;
  std::vector<core::Event> events_;
  std::vector<bus::PeerStatus> peers_;
  std::string trouble_;
  std::atomic<double> force_N_{0.0};
  std::atomic<std::uint64_t> physics_tick_{0};
  std::atomic<std::int64_t> physics_heard_ns_{0};
  std::atomic<bool> is_up_{false}, is_stopping_{false}, is_final_{false};
  std::thread thread_;
};

}  // namespace system_tests
