#pragma once

#include <gtest/gtest.h>

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <tuple>
#include <vector>

#include "bus/ledger.hpp"
#include "bus/node.hpp"
#include "bus/registry.hpp"
#include "core/clock.hpp"

// What tests of the bus share.
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

inline std::unique_ptr<Node> MakeNode(const std::string& name, const std::string& registry, bool says_goodbye = true) {
  NodeOptions options;
  options.name = name;
  options.registry = registry;
  options.session = 7;
  options.is_encrypted = false;
  options.says_goodbye = says_goodbye;
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

// Takes events until that one comes; false: it is not there yet.
inline bool TakeEvent(Node& node, const std::string& name, const std::string& detail) {
  core::Event event;
  while (node.PollEvent(&event)) {
    if (event.name == name && event.detail == detail) return true;
  }
  return false;
}

// The reliable accounts of the nodes that do not close: of one end by itself, or because both ends of one connection
// disagree about what was sent, received or dropped. Empty: all close.
inline std::vector<std::string> OpenAccounts(const std::vector<Node*>& nodes) {
  std::vector<std::string> open;
  // An account is one connection: topic, writer, reader, both in one of their lives. Instances are only known for
  // peers, so a node's own is what the others call it.
  std::map<std::string, std::vector<Account>> books;
  for (const Node* node : nodes) books[node->name()] = node->Accounts();
  for (const auto& [name, book] : books) {
    for (const Account& mine : book) {
      if (!mine.is_settled()) open.push_back(name + ": " + Describe(mine));
      const auto other = books.find(mine.peer);
      if (other == books.end() || mine.topic_class == TopicClass::kService) continue;
      std::uint64_t instance = 0;  // of the peer, as it lives now
      for (const Node* node : nodes) {
        if (node->name() == mine.peer) instance = node->instance();
      }
      if (instance != mine.peer_instance) continue;
      std::uint64_t own_instance = 0;
      for (const Node* node : nodes) {
        if (node->name() == name) own_instance = node->instance();
      }
      bool is_found = false;
      for (const Account& theirs : other->second) {
        if (theirs.peer != name || theirs.peer_instance != own_instance || theirs.topic != mine.topic ||
            theirs.is_writer == mine.is_writer) {
          continue;
        }
        is_found = true;
        if (mine.topic_class == TopicClass::kLatest) {
          // The reader counts all lives of the writer together, the writer its own; whatever it meant is in there.
          const Account& written = mine.is_writer ? mine : theirs;
          const Account& read = mine.is_writer ? theirs : mine;
          if (read.sent < written.sent) open.push_back(name + ": " + Describe(mine) + "; but " + Describe(theirs));
          continue;
        }
        if (theirs.sent != mine.sent || theirs.received != mine.received ||
            theirs.dropped_in_all() != mine.dropped_in_all()) {
          open.push_back(name + ": " + Describe(mine) + "; but " + mine.peer + ": " + Describe(theirs));
        }
      }
      // A LATEST writer's account begins with the first message of its life; the reader's holds earlier lives too.
      if (mine.topic_class == TopicClass::kLatest && !mine.is_writer) continue;
      if (!is_found && mine.sent > 0) open.push_back(name + ": " + Describe(mine) + "; unknown to " + mine.peer);
    }
  }
  return open;
}

// At quiescence every account of these nodes closes exactly. Waits for what is on its way; nothing may be emitted.
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
