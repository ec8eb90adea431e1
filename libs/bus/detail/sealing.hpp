#pragma once

#include <sodium.h>

#include <array>
#include <atomic>
#include <cstdint>
#include <span>

#include "bus/envelope.hpp"
#include "core/fixed_vector.hpp"

namespace bus::detail {

// Authenticated encryption of UDP datagrams: AES-256-GCM [NIST SP 800-38D], which processors have instructions for: a
// datagram is sealed and opened in a quarter of what ChaCha20-Poly1305 takes.
//
// The registry hands one secret to every node of a session, over CURVE. Each sender seals with a key of its own,
//
//   key = HMAC-SHA-256(session key, "VR-OOS datagram" | u64 instance),
//
// so a counter that starts again with the process never meets the same key twice. A sealed datagram is
//
//   envelope and stamps (in the clear, authenticated) | encrypted payload and history | u64 counter | 16 bytes of tag
//
// with the nonce u32 channel | u64 counter, all little endian. A node's two sockets count apart (channel 0: class
// LATEST, 1: everything else), and a receiver takes each counter once.
using SessionKey = std::array<std::uint8_t, 32>;
using SenderKey = std::array<std::uint8_t, 32>;
using ExpandedKey = crypto_aead_aes256gcm_state;  // what can be computed of a key beforehand

// Whether this processor has the instructions.
bool CanSeal();
// Not real-time (the first call sets the library up).
SenderKey DeriveSenderKey(const SessionKey& session_key, std::uint64_t instance);

// Why a datagram was not taken. The order is on the wire of figures: append only.
enum class Refusal : std::uint8_t {
  kNone,
  kOversized,      // longer than any datagram of the bus
  kTruncated,      // length differs from the length written inside
  kGarbage,        // not an envelope, or its checksum differs
  kWrongSession,   // of another run
  kUnknownSender,  // not in the roster
  kNotAuthentic,   // tag differs (also from an earlier life of the sender), or the one is sealed and the other is not
  kReplayed,       // came before, or too old to know
  kUnknownTopic,   // nobody here reads it
  kBadSchema,      // payload is not what the topic carries
};
constexpr std::size_t kNumRefusals = 10;
const char* NameOf(Refusal refusal);

// Two threads count into one, any thread reads.
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

// One sender's socket. SetKey before the first Seal, from whichever thread; then one key for life.
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

// Which of a sender's counters have come: the newest and the 63 before it.
class ReplayWindow {
 public:
  [[nodiscard]] bool IsNew(std::uint64_t counter) const;
  void Take(std::uint64_t counter);  // is new

 private:
  std::uint64_t newest_ = 0;
  std::uint64_t seen_ = 0;  // bit i: newest - i has come
};

constexpr std::size_t kMaxSenders = 128;
struct KnownSender {
  std::uint32_t node = 0;  // as in the envelope
  SenderKey key{};         // of its present life
};
using KnownSenders = core::FixedVector<KnownSender, kMaxSenders>;

// Receiving end of one socket, for its thread. No allocation, no lock.
class Opener {
 public:
  // `is_sealed`: nothing else is taken. Otherwise only what is in the clear.
  Opener(std::uint64_t session, bool is_sealed, std::size_t max_bytes = kMaxDatagramBytes)
      : session_(session), is_sealed_(is_sealed), max_bytes_(max_bytes) {}
  // Senders that stay keep their replay window.
  void SetSenders(const KnownSenders& senders) noexcept;
  // Decrypts in place. With kNone, envelope and payload are as its sender wrote them, once.
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
