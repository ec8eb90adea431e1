#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "bus/codec.hpp"
#include "bus/ledger.hpp"
#include "bus/node.hpp"

// BULK: blocks of bytes that nobody waits for in real time (scenario files, meshes, pictures). A node lists by STATE
// what it has; a reader fetches a block by the hash of its content, over sockets that carry nothing else.
namespace bus {

using core::BulkOffer;

constexpr std::uint64_t kMaxBulkBytes = std::uint64_t{256} << 20;

// BLAKE2b-256 [RFC 7693], hexadecimal: names the content, so a block is the same wherever it came from.
std::string BulkHash(std::span<const std::uint8_t> bytes);

// What a node has to give. It owns a thread (bulk-io) and a socket.
class BulkServer {
 public:
  // Before node->Start(). `options` are the node's.
  static core::Result<std::unique_ptr<BulkServer>> Create(Node* node, const NodeOptions& options);
  ~BulkServer();
  BulkServer(const BulkServer&) = delete;
  BulkServer& operator=(const BulkServer&) = delete;

  // Step thread; not real-time. A name that is offered again has new content. Fails when the block is too large, or the
  // queue to the bus thread is full.
  core::Result<BulkOffer> Offer(const std::string& name, std::vector<std::uint8_t> bytes);
  [[nodiscard]] std::uint64_t num_chunks() const;  // sent so far
  // Connections and messages, as "bulk" among the node's own (Counters::refusals). Any thread.
  [[nodiscard]] std::uint64_t num_refused() const;

 private:
  struct Impl;
  explicit BulkServer(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

// One block on its way to us. It asks for a few chunks at a time (its credit), and again for those that do not come.
class BulkFetch {
 public:
  // `options` are the asking node's; `owner` is the name of the one that offers.
  BulkFetch(BulkOffer offer, const std::string& owner, const NodeOptions& options);
  ~BulkFetch();
  BulkFetch(const BulkFetch&) = delete;
  BulkFetch& operator=(const BulkFetch&) = delete;

  // Waits for the whole block and checks its hash. After a time-out it goes on where it was when it is called again.
  // Any one thread; not real-time.
  core::Result<std::vector<std::uint8_t>> Run(std::int64_t timeout_ns);
  // The same content is served elsewhere, e.g. by the owner's next life.
  void MoveTo(const std::string& endpoint);
  [[nodiscard]] const Account& account() const;     // chunks: asked for = received + lost
  [[nodiscard]] std::uint64_t num_refused() const;  // messages that are no chunk of a block

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace bus
