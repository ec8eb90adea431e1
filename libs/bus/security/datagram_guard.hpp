#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "bus/rt/latest_value.hpp"
#include "bus/security/sealing.hpp"

namespace bus::detail {

constexpr std::size_t kMaxHeartbeatBytes = 1472;  // fits one Ethernet frame: 1500 - 20 (IP) - 8 (UDP)

// Seals and opens the datagrams of one node's two UDP sockets: keys, accepted senders and counts of refusals. The bus
// thread sets keys and senders; the step thread takes them over without a lock.
class DatagramGuard {
 public:
  // `is_sealed` false only where NodeOptions::is_encrypted is false.
  DatagramGuard(std::uint64_t session, bool is_sealed)
      : is_sealed_(is_sealed),
        data_opener_(session, is_sealed),
        control_opener_(session, is_sealed, kMaxHeartbeatBytes) {}

  [[nodiscard]] bool is_sealed() const { return is_sealed_; }

  // --- Bus thread. The session key comes first, once; a restarted registry gives the same one. Nothing is sent before,
  // because a node learns its readers together with the key.
  void SetSessionKey(const SessionKey& key, std::uint64_t own_instance);
  [[nodiscard]] bool has_session_key() const { return has_session_key_; }
  [[nodiscard]] KnownSender Know(std::uint32_t node, std::uint64_t instance) const;  // with its sealing key
  void SetSenders(const KnownSenders& senders);
  // Seals a complete heartbeat.
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
