#pragma once

#include <gtest/gtest.h>

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <tuple>
#include <vector>

#include "bus/accounts/ledger.hpp"
#include "bus/membership/registry.hpp"
#include "bus/node.hpp"
#include "core/clock.hpp"

// Helpers shared by the tests of the bus.
namespace bus::testing {

constexpr std::int64_t kLong_ns = 10 * core::kNanosecondsPerSecond;

inline std::unique_ptr<Registry> MakeRegistry(const std::string& endpoint = "tcp://127.0.0.1:0") {
  RegistryOptions options;
  options.endpoint = endpoint;
  options.session = 7;
  options.is_encrypted = false;
  auto registry = Registry::Create(options);
  EXPECT_TRUE(registry.has_value()) << registry.error().detail;
  return std::move(*registry);
}

inline std::unique_ptr<Node> MakeNode(const std::string& name, const std::string& registry, bool sends_goodbye = true) {
  NodeOptions options;
  options.name = name;
  options.registry = registry;
  options.session = 7;
  options.is_encrypted = false;
  options.sends_goodbye = sends_goodbye;
  auto node = Node::Create(options);
  EXPECT_TRUE(node.has_value()) << node.error().detail;
  return std::move(*node);
}

// Calls `step` until it is true or time is up. The steps wait by themselves (Node::Wait), nothing sleeps here.
inline bool Until(const std::function<bool()>& step, std::int64_t timeout_ns = kLong_ns) {
  const std::int64_t deadline = core::MonotonicNow_ns() + timeout_ns;
  while (core::MonotonicNow_ns() < deadline) {
    if (step()) return true;
  }
  return step();
}

inline WaitResult WaitBriefly(Node& node) {
  return node.Wait(core::MonotonicNow_ns() + core::kTick_ns);
}

// Takes events up to that one; false: it has not arrived yet.
inline bool TakeEvent(Node& node, const std::string& name, const std::string& detail) {
  core::Event event;
  while (node.PollEvent(&event)) {
    if (event.name == name && event.detail == detail) return true;
  }
  return false;
}

// The accounts of one node in its present life.
struct Book {
  std::uint64_t instance = 0;
  std::vector<Account> accounts;
};
using Books = std::map<std::string, Book>;  // by the node's name

// The disagreement between the two ends of one LATEST topic, both in their present lives; empty: none. The reader
// counts what arrived and what did not, the writer what it sent, each independently of the other.
inline std::string LatestFault(const Account& written, const Account& read) {
  const LatestLife& writer = written.life;
  const LatestLife& reader = read.life;
  if (reader.boot != writer.boot || reader.first != writer.first || reader.last != writer.last) {
    return "the last message sent has not been reported to the reader";
  }
  if (reader.on_the_way != 0) return std::to_string(reader.on_the_way) + " under way";
  if (reader.counted() == writer.reported()) return {};
  return "sent " + std::to_string(writer.reported()) + " from " + std::to_string(writer.first) + " on, but received " +
         std::to_string(reader.received) + " + restored " + std::to_string(reader.restored) + " + lost " +
         std::to_string(reader.lost) + ", " + std::to_string(reader.early) + " of them before";
}

// The accounts that do not close: of one end by itself, or because both ends of one connection disagree about what was
// sent, received or dropped. Empty: all close.
inline std::vector<std::string> OpenAccounts(const Books& books) {
  std::vector<std::string> open;
  // An account is one connection: topic, writer, reader, both in one of their lives. Instances are only known for
  // peers, so a node's own is what the others call it.
  for (const auto& [name, book] : books) {
    for (const Account& mine : book.accounts) {
      if (!mine.is_settled()) open.push_back(name + ": " + Describe(mine));
      const auto other = books.find(mine.peer);
      if (other == books.end() || mine.topic_class == TopicClass::kService) continue;
      if (other->second.instance != mine.peer_instance) continue;
      // The LATEST reader's holds earlier lives of the writer, too; it is compared from the writer's end.
      if (mine.topic_class == TopicClass::kLatest && !mine.is_writer) continue;
      bool is_found = false;
      for (const Account& theirs : other->second.accounts) {
        if (theirs.peer != name || theirs.peer_instance != book.instance || theirs.topic != mine.topic ||
            theirs.is_writer == mine.is_writer) {
          continue;
        }
        is_found = true;
        if (mine.topic_class == TopicClass::kLatest) {
          const std::string fault = LatestFault(mine, theirs);
          if (!fault.empty()) open.push_back(name + ": " + Describe(mine) + ": " + fault);
          continue;
        }
        if (theirs.sent != mine.sent || theirs.received != mine.received ||
            theirs.dropped_in_all() != mine.dropped_in_all()) {
          open.push_back(name + ": " + Describe(mine) + "; but " + mine.peer + ": " + Describe(theirs));
        }
      }
      if (!is_found && mine.sent > 0) open.push_back(name + ": " + Describe(mine) + "; unknown to " + mine.peer);
    }
  }
  return open;
}

inline std::vector<std::string> OpenAccounts(const std::vector<Node*>& nodes) {
  Books books;
  for (const Node* node : nodes) books[node->name()] = {node->instance(), node->Accounts()};
  return OpenAccounts(books);
}

// At quiescence every account of these nodes closes exactly. Waits for messages under way; nothing may be emitted.
inline void ExpectAccountsClose(const std::vector<Node*>& nodes, std::int64_t timeout_ns = kLong_ns) {
  std::vector<std::string> open;
  Until(
      [&] {
        core::Event event;
        for (Node* node : nodes) {
          WaitBriefly(*node);
          while (node->PollEvent(&event)) {
          }
        }
        open = OpenAccounts(nodes);
        return open.empty();
      },
      timeout_ns);
  for (const std::string& account : open) ADD_FAILURE() << account;
}

}  // namespace bus::testing
