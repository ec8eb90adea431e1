#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "bus/membership/registry.hpp"
#include "bus/node.hpp"
#include "tools/transport/channel.hpp"

namespace transport {

// A registry and two nodes on loopback, with keys as in a run or without.
struct Link {
  static std::unique_ptr<Link> Make(bool is_encrypted);  // does not start it; null if this machine cannot
  Link() = default;
  ~Link();
  Link(const Link&) = delete;
  Link& operator=(const Link&) = delete;

  // Starts both nodes and waits until each knows the other; false if they do not meet.
  bool Start();

  bool is_encrypted = false;
  std::filesystem::path keys;
  std::unique_ptr<bus::Registry> registry;
  bus::NodeOptions near_options, far_options;
  std::unique_ptr<bus::Node> near, far;
};

// One topic between two nodes of its own. Null if it does not work on this machine.
std::unique_ptr<Channel> MakeLatest(std::size_t num_bytes, bool is_encrypted);
std::unique_ptr<Channel> MakeState(bool is_encrypted);  // 200 B
std::unique_ptr<Channel> MakeEvent(bool is_encrypted);  // 200 B

// Message sizes that MakeLatest offers [B]: a device's state, 20 contacts, a sheet in twelve datagrams.
constexpr std::size_t kSmallBytes = 215;
constexpr std::size_t kLargeBytes = 1050;
constexpr std::size_t kSheetBytes = 13'700;

// STATE, EVENT and answers are delivered in Wait, so a receiver sees them when it calls Wait again. The receivers here
// call it with this period.
constexpr std::int64_t kPollPeriod_ns = 50'000;

}  // namespace transport
