#pragma once

#include <sodium.h>

#include <array>
#include <atomic>
#include <cstdint>
#include <span>

#include "bus/wire/envelope.hpp"
#include "core/fixed_vector.hpp"

namespace bus::detail {

// Authenticated encryption of UDP datagrams: AES-256-GCM [NIST SP 800-38D]. With the processor's AES instructions it
// takes a quarter of the time of ChaCha20-Poly1305.
//
// The registry hands one secret to every node of a session, over CURVE. Each sender seals with a key of its own,
//
//   key = HMAC-SHA-256(session key, "VR-OOS datagram" | u64 instance),
//
// so a counter that restarts with the process is never used twice with one key. A sealed datagram is
//
//   envelope and stamps (in the clear, authenticated) | encrypted payload and history | u64 counter | 16 bytes of tag
//
// with the nonce u32 channel | u64 counter, all little endian. A node's two sockets count separately (channel 0: class
// LATEST, 1: everything else), and a receiver accepts each counter once.
using SessionKey = std::array<std::uint8_t, 32>;
using SenderKey = std::array<std::uint8_t, 32>;
using ExpandedKey = crypto_aead_aes256gcm_state;  // the precomputed key schedule

// Whether this processor has AES instructions.
bool CanSeal();
// Not real-time (the first call sets the library up).
SenderKey DeriveSenderKey(const SessionKey& session_key, std::uint64_t instance);

// Why a datagram was refused. The order is on the wire, in published figures: append only.
enum class Refusal : std::uint8_t {
  kNone,
  kOversized,      // longer than any datagram of the bus
  kTruncated,      // length differs from the length written inside
  kGarbage,        // not an envelope, or a wrong checksum
  kWrongSession,   // of another run
  kUnknownSender,  // not in the roster
  kNotAuthentic,   // wrong tag (also of an earlier life of the sender), or not sealed exactly where it must be
  kReplayed,       // received before, or too old for the window
  kUnknownTopic,   // not read by this node
  kBadSchema,      // the payload is not of the topic's schema
};
constexpr std::size_t kNumRefusals = 10;
const char* NameOf(Refusal refusal);

// Counts by reason: two threads add, any thread reads.
class RefusalCounts {
 public:
  void Add(Refusal refusal) noexcept {
    counts_[static_cast<std::size_t>(refusal)].fetch_add(1, std::memory_order_relaxed);
  }
  [[nodiscard]] std::uint64_t of(Refusal refusal) const {
    return counts_[static_cast<std::size_t>(refusal)].load(std::memory_order_relaxed);
  }
  [[nodiscard]] std::uint64_t total() const;

 private:
  std::array<std::atomic<std::uint64_t>, kNumRefusals> counts_{};
};

// The sending end of one socket. SetKey once, before the first Seal, from any thread.
class Sealer {
 public:
  void SetKey(const SenderKey& key);
  // `datagram` holds an envelope with its payload and history, `size` bytes, and has kSealBytes of room behind. Returns
  // the sealed size. Any thread; no lock.
  std::size_t Seal(std::uint8_t* datagram, std::size_t size) noexcept;

 private:
  ExpandedKey key_{};
  std::atomic<std::uint64_t> counter_{0};
};

// A sliding window over a sender's counters: which of the newest and the 63 before it have arrived.
class ReplayWindow {
 public:
  [[nodiscard]] bool IsNew(std::uint64_t counter) const;
  void Take(std::uint64_t counter);  // only after IsNew

 private:
  std::uint64_t newest_ = 0;
  std::uint64_t seen_ = 0;  // bit i: newest - i has arrived
};

// In fixed memory; twice the connections that a node accepts (kMaxConnections).
constexpr std::size_t kMaxSenders = 128;
struct KnownSender {
  std::uint32_t node = 0;  // as in the envelope
  SenderKey key{};         // of its present life
};
using KnownSenders = core::FixedVector<KnownSender, kMaxSenders>;

// Receiving end of one socket, for its thread. No allocation, no lock.
class Opener {
 public:
  // `is_sealed`: accepts sealed datagrams only; otherwise clear ones only.
  Opener(std::uint64_t session, bool is_sealed, std::size_t max_bytes = kMaxDatagramBytes)
      : session_(session), is_sealed_(is_sealed), max_bytes_(max_bytes) {}
  // Senders that are kept keep their replay window.
  void SetSenders(const KnownSenders& senders) noexcept;
  // Decrypts in place. Refusal::kNone: envelope and payload are authentic, and have not been accepted before.
  Refusal Open(std::span<std::uint8_t> datagram, Envelope* envelope, std::span<const std::uint8_t>* payload) noexcept;

 private:
  struct Sender {
    KnownSender known;
    ExpandedKey key;
    std::array<ReplayWindow, 2> windows;  // by channel
  };
  std::uint64_t session_;
  bool is_sealed_;
  std::size_t max_bytes_;
  core::FixedVector<Sender, kMaxSenders> senders_;
};

}  // namespace bus::detail
