#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <functional>
#include <mutex>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "bus/topics.hpp"

namespace bus::log {

enum class TapKind : std::uint8_t {
  kSent = 1,   // this node published it
  kTaken = 2,  // its step thread received it (LATEST: one entry for each part, without its payload)
  kStep = 3,   // the node's own record of a step: earlier entries are the step's inputs
};

// Describes the entries of one slot.
struct TapTopic {
  TapKind kind = TapKind::kSent;
  std::string name;  // as on the bus
  TopicClass topic_class = TopicClass::kLatest;
  std::string schema;       // full name of the payload's protobuf message; empty: none
  std::string descriptors;  // FileDescriptorSet with that message
};

// A node's estimate of a peer's clock: peer's clock = own clock + offset, within the bound.
struct PeerClock {
  std::string peer;
  std::string machine;
  std::int64_t offset_ns = 0;
  std::int64_t bound_ns = 0;
  double drift = 0.0;  // s/s
};

struct TapHead {
  std::uint16_t slot = 0;
  std::uint16_t head_bytes = 0;  // LATEST: a bus::Envelope as in memory; else the key (STATE: the value's; acks: owner)
  std::uint32_t payload_bytes = 0;
  std::uint64_t sequence = 0;
  std::int64_t time_ns = 0;     // when it happened at this node; never decreases from one entry to the next
  std::int64_t publish_ns = 0;  // by its publisher's clock
};

// A node's sent and received messages, in the order in which its step thread handles them: a byte ring with one
// producer (the step thread) and one consumer (a TapRecorder's thread). Put does not wait, lock or allocate; entries
// that do not fit are counted by topic.
class Tap {
 public:
  static constexpr std::size_t kMaxTopics = 512;  // in fixed memory; a node declares some tens
  static constexpr std::uint16_t kNoSlot = 0xffff;

  // A power of two. The default holds about 3 s of a busy node.
  explicit Tap(std::size_t ring_bytes = std::size_t{8} << 20) : ring_(ring_bytes), mask_(ring_bytes - 1) {}
  Tap(const Tap&) = delete;
  Tap& operator=(const Tap&) = delete;

  // Producer; before the loop starts, as it allocates. kNoSlot: no slot left; entries to it are ignored.
  std::uint16_t AddTopic(TapTopic topic) {
    const std::size_t slot = num_topics_.load(std::memory_order_relaxed);
    if (slot == kMaxTopics) return kNoSlot;
    topics_[slot] = std::move(topic);
    num_topics_.store(slot + 1, std::memory_order_release);
    return static_cast<std::uint16_t>(slot);
  }

  // Producer.
  void Put(std::uint16_t slot, std::uint64_t sequence, std::int64_t time_ns, std::int64_t publish_ns,
           std::span<const std::uint8_t> head, std::span<const std::uint8_t> payload) noexcept {
    if (slot == kNoSlot) return;
    const std::size_t size = Padded(sizeof(TapHead) + head.size() + payload.size());
    const std::size_t tail = tail_.load(std::memory_order_relaxed);
    // An entry is contiguous: the rest of the ring is skipped when it is too short.
    const std::size_t to_end = ring_.size() - (tail & mask_);
    const std::size_t skipped = to_end < size ? to_end : 0;
    if (tail + skipped + size - head_.load(std::memory_order_acquire) > ring_.size()) {
      dropped_[slot].fetch_add(1, std::memory_order_relaxed);
      return;
    }
    const TapHead entry{slot,
                        static_cast<std::uint16_t>(head.size()),
                        static_cast<std::uint32_t>(payload.size()),
                        sequence,
                        time_ns,
                        publish_ns};
    if (skipped != 0) {
      TapHead skip;
      skip.slot = kNoSlot;
      std::memcpy(&ring_[tail & mask_], &skip, sizeof(std::uint16_t));
    }
    std::uint8_t* to = &ring_[(tail + skipped) & mask_];
    std::memcpy(to, &entry, sizeof entry);
    if (!head.empty()) std::memcpy(to + sizeof entry, head.data(), head.size());
    if (!payload.empty()) std::memcpy(to + sizeof entry + head.size(), payload.data(), payload.size());
    tail_.store(tail + skipped + size, std::memory_order_release);
  }

  // Consumer: visit(const TapHead&, span head, span payload) for every entry that is there; the spans are valid during
  // the call.
  template <class Visit>
  void Drain(Visit&& visit) {
    std::size_t head = head_.load(std::memory_order_relaxed);
    const std::size_t tail = tail_.load(std::memory_order_acquire);
    while (head != tail) {
      const std::uint8_t* from = &ring_[head & mask_];
      std::uint16_t slot = 0;
      std::memcpy(&slot, from, sizeof slot);
      if (slot == kNoSlot) {
        head += ring_.size() - (head & mask_);
      } else {
        TapHead entry;
        std::memcpy(&entry, from, sizeof entry);
        visit(entry, std::span(from + sizeof entry, entry.head_bytes),
              std::span(from + sizeof entry + entry.head_bytes, entry.payload_bytes));
        head += Padded(sizeof entry + entry.head_bytes + entry.payload_bytes);
      }
      head_.store(head, std::memory_order_release);
    }
  }

  // Source of the peers' clock estimates, called by the consumer; an empty function ends that. Not real-time.
  void SetClocks(std::function<std::vector<PeerClock>()> clocks) {
    const std::lock_guard lock(mutex_);
    clocks_ = std::move(clocks);
  }
  [[nodiscard]] std::vector<PeerClock> Clocks() const {
    const std::lock_guard lock(mutex_);
    return clocks_ ? clocks_() : std::vector<PeerClock>{};
  }

  // Any thread.
  [[nodiscard]] std::size_t num_topics() const { return num_topics_.load(std::memory_order_acquire); }
  [[nodiscard]] const TapTopic& topic(std::size_t slot) const { return topics_[slot]; }
  [[nodiscard]] std::uint64_t dropped(std::size_t slot) const { return dropped_[slot].load(std::memory_order_relaxed); }

 private:
  // Entries start at multiples of 8, so that a skip mark always fits.
  static constexpr std::size_t Padded(std::size_t size) { return (size + 7) / 8 * 8; }

  std::vector<std::uint8_t> ring_;
  std::size_t mask_;
  std::array<TapTopic, kMaxTopics> topics_;
  std::array<std::atomic<std::uint64_t>, kMaxTopics> dropped_{};
  std::atomic<std::size_t> num_topics_{0};
  mutable std::mutex mutex_;
  std::function<std::vector<PeerClock>()> clocks_;
  alignas(64) std::atomic<std::size_t> head_{0};  // bytes taken, ever
  alignas(64) std::atomic<std::size_t> tail_{0};  // bytes put, ever
};

}  // namespace bus::log
