#include "bus/security/sealing.hpp"

#include <bit>
#include <cstring>

namespace bus::detail {
namespace {

static_assert(std::endian::native == std::endian::little, "counters are copied as they stand in memory");
static_assert(std::tuple_size_v<SenderKey> == crypto_aead_aes256gcm_KEYBYTES);
static_assert(std::tuple_size_v<SenderKey> == crypto_auth_hmacsha256_BYTES);
static_assert(std::tuple_size_v<SessionKey> == crypto_auth_hmacsha256_KEYBYTES);

constexpr std::size_t kTagBytes = crypto_aead_aes256gcm_ABYTES;
static_assert(kSealBytes == sizeof(std::uint64_t) + kTagBytes);

using Nonce = std::array<std::uint8_t, crypto_aead_aes256gcm_NPUBBYTES>;

std::uint32_t ChannelOf(TopicClass topic_class) {
  return topic_class == TopicClass::kLatest ? 0 : 1;
}

Nonce MakeNonce(TopicClass topic_class, std::uint64_t counter) {
  Nonce nonce;
  const std::uint32_t channel = ChannelOf(topic_class);
  std::memcpy(nonce.data(), &channel, sizeof(channel));
  std::memcpy(nonce.data() + sizeof(channel), &counter, sizeof(counter));
  return nonce;
}

// Length in the clear: envelope and stamps.
std::size_t HeadBytes(const std::uint8_t* datagram) {
  return kEnvelopeFixedBytes + kStampBytes * (std::size_t{datagram[28]} + datagram[29]);
}

Refusal RefusalOf(EnvelopeStatus status) {
  switch (status) {
    case EnvelopeStatus::kOk:
      return Refusal::kNone;
    case EnvelopeStatus::kTooShort:
    case EnvelopeStatus::kBadLength:
      return Refusal::kTruncated;
    case EnvelopeStatus::kSealed:
      return Refusal::kNotAuthentic;
    case EnvelopeStatus::kBadMagic:
    case EnvelopeStatus::kBadVersion:
    case EnvelopeStatus::kBadField:
    case EnvelopeStatus::kBadChecksum:
      break;
  }
  return Refusal::kGarbage;
}

}  // namespace

bool CanSeal() {
  static const bool can = sodium_init() >= 0 && crypto_aead_aes256gcm_is_available() == 1;
  return can;
}

SenderKey DeriveSenderKey(const SessionKey& session_key, std::uint64_t instance) {
  [[maybe_unused]] static const int initialized = sodium_init();  // picks the fastest code of this CPU
  constexpr char kPurpose[] = "VR-OOS datagram";
  std::array<std::uint8_t, sizeof(kPurpose) - 1 + sizeof(instance)> text;
  std::memcpy(text.data(), kPurpose, sizeof(kPurpose) - 1);
  std::memcpy(text.data() + sizeof(kPurpose) - 1, &instance, sizeof(instance));
  SenderKey key;
  crypto_auth_hmacsha256(key.data(), text.data(), text.size(), session_key.data());
  return key;
}

const char* NameOf(Refusal refusal) {
  constexpr std::array kNames = {"none",           "oversized",     "truncated", "garbage",       "wrong_session",
                                 "unknown_sender", "not_authentic", "replayed",  "unknown_topic", "bad_schema"};
  static_assert(kNames.size() == kNumRefusals);
  return kNames[static_cast<std::size_t>(refusal)];
}

std::uint64_t RefusalCounts::total() const {
  std::uint64_t sum = 0;
  for (const auto& count : counts_) sum += count.load(std::memory_order_relaxed);
  return sum;
}

void Sealer::SetKey(const SenderKey& key) {
  crypto_aead_aes256gcm_beforenm(&key_, key.data());
}

std::size_t Sealer::Seal(std::uint8_t* datagram, std::size_t size) noexcept {
  const std::uint64_t counter = counter_.fetch_add(1, std::memory_order_relaxed) + 1;
  const Nonce nonce = MakeNonce(static_cast<TopicClass>(datagram[5]), counter);
  const std::size_t head = HeadBytes(datagram);
  std::uint8_t* const body = datagram + head;
  MarkSealed(datagram);
  std::memcpy(datagram + size, &counter, sizeof(counter));
  crypto_aead_aes256gcm_encrypt_detached_afternm(body, datagram + size + sizeof(counter), nullptr, body, size - head,
                                                 datagram, head, nullptr, nonce.data(), &key_);
  return size + kSealBytes;
}

bool ReplayWindow::IsNew(std::uint64_t counter) const {
  if (counter > newest_) return true;
  const std::uint64_t behind = newest_ - counter;
  return behind < 64 && counter != 0 && (seen_ >> behind & 1) == 0;
}

void ReplayWindow::Take(std::uint64_t counter) {
  if (counter > newest_) {
    const std::uint64_t step = counter - newest_;
    seen_ = step < 64 ? seen_ << step : 0;
    newest_ = counter;
  }
  seen_ |= std::uint64_t{1} << (newest_ - counter);
}

void Opener::SetSenders(const KnownSenders& senders) noexcept {
  const auto is_listed = [&senders](const Sender& sender) {
    for (const KnownSender& known : senders) {
      if (known.node == sender.known.node && known.key == sender.known.key) return true;
    }
    return false;
  };
  std::size_t kept = 0;
  for (Sender& sender : senders_) {
    if (is_listed(sender)) senders_[kept++] = sender;
  }
  senders_.resize(kept);
  for (const KnownSender& known : senders) {
    bool is_here = false;
    for (std::size_t i = 0; i < kept; ++i) is_here = is_here || senders_[i].known.key == known.key;
    if (is_here) continue;
    Sender sender{.known = known, .key = {}, .windows = {}};
    crypto_aead_aes256gcm_beforenm(&sender.key, known.key.data());
    senders_.push_back(sender);
  }
}

Refusal Opener::Open(std::span<std::uint8_t> datagram, Envelope* envelope,
                     std::span<const std::uint8_t>* payload) noexcept {
  if (datagram.size() > max_bytes_) return Refusal::kOversized;
  if (!is_sealed_) {
    const Refusal refusal = RefusalOf(ReadEnvelope(datagram, envelope, payload));
    if (refusal != Refusal::kNone) return refusal;
    return envelope->session == session_ ? Refusal::kNone : Refusal::kWrongSession;
  }
  const Refusal refusal = RefusalOf(ReadEnvelopeFields(datagram, envelope, payload));
  if (refusal != Refusal::kNone) return refusal;
  if (envelope->session != session_) return Refusal::kWrongSession;
  if (!envelope->is_sealed) return Refusal::kNotAuthentic;
  Sender* sender = nullptr;
  for (Sender& candidate : senders_) {
    if (candidate.known.node == envelope->node) sender = &candidate;
  }
  if (sender == nullptr) return Refusal::kUnknownSender;
  std::uint64_t counter = 0;
  const std::size_t size = datagram.size() - kSealBytes;
  std::memcpy(&counter, datagram.data() + size, sizeof(counter));
  // Cheap first: a flood of old datagrams costs no decryption.
  ReplayWindow& window = sender->windows[ChannelOf(envelope->topic_class)];
  if (!window.IsNew(counter)) return Refusal::kReplayed;
  const Nonce nonce = MakeNonce(envelope->topic_class, counter);
  const std::size_t head = HeadBytes(datagram.data());
  std::uint8_t* const body = datagram.data() + head;
  if (crypto_aead_aes256gcm_decrypt_detached_afternm(body, nullptr, body, size - head,
                                                     datagram.data() + size + sizeof(counter), datagram.data(), head,
                                                     nonce.data(), &sender->key) != 0) {
    return Refusal::kNotAuthentic;
  }
  window.Take(counter);
  return Refusal::kNone;
}

}  // namespace bus::detail
