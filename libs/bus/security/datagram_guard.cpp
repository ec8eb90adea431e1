#include "bus/security/datagram_guard.hpp"

namespace bus::detail {

void DatagramGuard::SetSessionKey(const SessionKey& key, std::uint64_t own_instance) {
  if (has_session_key_) return;
  session_key_ = key;
  const SenderKey own = DeriveSenderKey(key, own_instance);
  data_sealer_.SetKey(own);
  control_sealer_.SetKey(own);
  has_session_key_ = true;
}

KnownSender DatagramGuard::Know(std::uint32_t node, std::uint64_t instance) const {
  return {node, DeriveSenderKey(session_key_, instance)};
}

void DatagramGuard::SetSenders(const KnownSenders& senders) {
  control_opener_.SetSenders(senders);
  senders_.Write(senders);
}

void DatagramGuard::SealControl(std::vector<std::uint8_t>* datagram) noexcept {
  if (!is_sealed_) return;
  const std::size_t size = datagram->size();
  datagram->resize(size + kSealBytes);
  control_sealer_.Seal(datagram->data(), size);
}

Refusal DatagramGuard::OpenControl(std::span<std::uint8_t> datagram, Envelope* envelope,
                                   std::span<const std::uint8_t>* payload) noexcept {
  const Refusal refusal = control_opener_.Open(datagram, envelope, payload);
  if (refusal != Refusal::kNone) refusals.Add(refusal);
  return refusal;
}

}  // namespace bus::detail
