#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "bus/accounts/ledger.hpp"
#include "bus/node.hpp"
#include "bus/wire/codec.hpp"

// BULK: blocks of bytes without real-time demands (scenario files, meshes, pictures). A node lists its blocks by STATE;
// a reader fetches a block by the hash of its content, over sockets that carry nothing else.
namespace bus {

using core::BulkOffer;

// A fetched block is held in memory.
constexpr std::uint64_t kMaxBulkBytes = std::uint64_t{256} << 20;

// BLAKE2b-256 [RFC 7693], hexadecimal: names the content, so any copy of a block will do.
std::string BulkHash(std::span<const std::uint8_t> bytes);

// Serves the blocks of a node. It owns a thread (bulk-io) and a socket.
class BulkServer {
 public:
  // Before node->Start(). `options` are the node's.
  static core::Result<std::unique_ptr<BulkServer>> Create(Node* node, const NodeOptions& options);
  ~BulkServer();
  BulkServer(const BulkServer&) = delete;
  BulkServer& operator=(const BulkServer&) = delete;

  // Step thread; not real-time. Offering a name again replaces its content. Errors: the block is too large, or the
  // queue to the bus thread is full.
  core::Result<BulkOffer> Offer(const std::string& name, std::vector<std::uint8_t> bytes);
  [[nodiscard]] std::uint64_t num_chunks() const;  // sent so far
  // Refused connections and messages; also "bulk" in the node's Counters::refusals. Any thread.
  [[nodiscard]] std::uint64_t num_refused() const;

 private:
  struct Impl;
  explicit BulkServer(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

// Fetches one block. It requests a few chunks at a time (its credit), and again those that do not arrive.
class BulkFetch {
 public:
  // `options` are the fetching node's; `owner` is the name of the offering node.
  BulkFetch(BulkOffer offer, const std::string& owner, const NodeOptions& options);
  ~BulkFetch();
  BulkFetch(const BulkFetch&) = delete;
  BulkFetch& operator=(const BulkFetch&) = delete;

  // Waits for the whole block and checks its hash. After kTimeout another call resumes where this one stopped.
  // Any one thread; not real-time.
  core::Result<std::vector<std::uint8_t>> Run(std::int64_t timeout_ns);
  // Continues from another server of the same content, e.g. the owner after a restart.
  void MoveTo(const std::string& endpoint);
  [[nodiscard]] const Account& account() const;     // in chunks: requested = received + lost
  [[nodiscard]] std::uint64_t num_refused() const;  // messages that are not chunks of a block

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace bus
