#include <algorithm>
#include <cstring>
#include <vector>

#include "bus/latest/history.hpp"
#include "bus/security/sealing.hpp"
#include "tests/fuzz/claim.hpp"
#include "tests/fuzz/targets.hpp"

namespace fuzz {
namespace {

using namespace bus::detail;

constexpr std::uint64_t kSession = 7;
constexpr std::uint32_t kNode = 5;
constexpr std::size_t kFlagsAt = 30;

KnownSenders OneSender() {
  KnownSenders senders;
  senders.push_back({kNode, DeriveSenderKey(SessionKey{}, 9)});
  return senders;
}

// Reads the earlier samples behind a payload, block by block.
void WalkHistory(const bus::Envelope& envelope, Input payload) {
  Input blocks{payload.data() + payload.size(), envelope.history_bytes};
  EarlierSample sample;
  while (NextEarlierSample(envelope.header.sequence, &blocks, &sample)) {
    Claim(sample.header.sequence < envelope.header.sequence, "an earlier sample has a lower sequence number");
    Claim(sample.payload.data() >= payload.data() + payload.size(), "it lies behind the payload");
  }
}

}  // namespace

// The input as a datagram; sealed with the right key, as a member can send it; and that one a second time.
void FuzzSealed(Input input) {
  static const KnownSenders senders = OneSender();
  Opener opener(kSession, true);
  opener.SetSenders(senders);
  bus::Envelope envelope;
  Input payload;
  std::vector<std::uint8_t> raw(input.begin(), input.end());
  Claim(opener.Open(raw, &envelope, &payload) != Refusal::kNone, "a datagram without the key is refused");
  Opener in_the_clear(kSession, false);
  in_the_clear.SetSenders(senders);
  raw.assign(input.begin(), input.end());
  if (in_the_clear.Open(raw, &envelope, &payload) == Refusal::kNone) WalkHistory(envelope, payload);

  if (input.size() < bus::kEnvelopeFixedBytes || input.size() > bus::kMaxDatagramBytes - bus::kSealBytes) return;
  // A member may seal any bytes, but only behind the header and as many stamps as that counts.
  if (input.size() < bus::kEnvelopeFixedBytes + bus::kStampBytes * (std::size_t{input[28]} + input[29])) return;
  std::vector<std::uint8_t> sealed(input.begin(), input.end());
  sealed[kFlagsAt + 1] |= 0x80;
  sealed.resize(sealed.size() + bus::kSealBytes);
  Sealer sealer;
  sealer.SetKey(senders[0].key);
  Claim(sealer.Seal(sealed.data(), input.size()) == sealed.size(), "the seal adds its fixed size");
  std::vector<std::uint8_t> again = sealed;
  if (opener.Open(sealed, &envelope, &payload) != Refusal::kNone) return;
  WalkHistory(envelope, payload);
  Claim(opener.Open(again, &envelope, &payload) == Refusal::kReplayed, "a datagram is taken once");
}

}  // namespace fuzz
