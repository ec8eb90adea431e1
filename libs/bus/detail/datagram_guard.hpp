#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "bus/detail/sealing.hpp"
#include "bus/rt/latest_value.hpp"

namespace bus::detail {

constexpr std::size_t kMaxHeartbeatBytes = 1472;  // one Ethernet frame

// Both UDP sockets of one node: what they seal with, whom they take datagrams from, and what they refused. The bus
// thread learns keys and peers; the step thread takes them over without a lock.
class DatagramGuard {
 public:
  // Not sealed: only when the node was told so explicitly.
  DatagramGuard(std::uint64_t session, bool is_sealed)
      : is_sealed_(is_sealed),
        data_opener_(session, is_sealed),
        control_opener_(session, is_sealed, kMaxHeartbeatBytes) {}

  [[nodiscard]] bool is_sealed() const { return is_sealed_; }

  // --- Bus thread. The session key first, once; it is the same from a registry that was started again. Nothing is sent
  // before: a node learns its readers with the key.
  void SetSessionKey(const SessionKey& key, std::uint64_t own_instance);
  [[nodiscard]] bool has_session_key() const { return has_session_key_; }
  [[nodiscard]] KnownSender Know(std::uint32_t node, std::uint64_t instance) const;  // with the key that it seals with
  void SetSenders(const KnownSenders& senders);
  // A heartbeat that is ready but for its seal.
  void SealControl(std::vector<std::uint8_t>* datagram) noexcept;
  Refusal OpenControl(std::span<std::uint8_t> datagram, Envelope* envelope,
                      std::span<const std::uint8_t>* payload) noexcept;

  // --- Step thread.
  std::size_t SealData(std::uint8_t* datagram, std::size_t size) noexcept { return data_sealer_.Seal(datagram, size); }
  // Before a batch of datagrams.
  void TakeSenders() noexcept {
    if (senders_.Update()) data_opener_.SetSenders(senders_.value());
  }
  Refusal OpenData(std::span<std::uint8_t> datagram, Envelope* envelope,
                   std::span<const std::uint8_t>* payload) noexcept {
    return data_opener_.Open(datagram, envelope, payload);
  }

  RefusalCounts refusals;

 private:
  bool is_sealed_;
  bool has_session_key_ = false;
  SessionKey session_key_{};
  Sealer data_sealer_, control_sealer_;
  Opener data_opener_, control_opener_;
  LatestValue<KnownSenders> senders_;  // bus thread -> step thread
};

}  // namespace bus::detail
