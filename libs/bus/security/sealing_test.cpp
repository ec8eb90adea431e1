#include "bus/security/sealing.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <random>
#include <set>
#include <string>
#include <vector>

namespace bus::detail {
namespace {

constexpr std::uint64_t kSealedSession = 7;
constexpr std::uint64_t kInstance = 0x1122334455667788;

SessionKey MakeSessionKey() {
  SessionKey key;
  for (std::size_t i = 0; i < key.size(); ++i) key[i] = static_cast<std::uint8_t>(i);
  return key;
}

Envelope EnvelopeToSeal() {
  Envelope envelope;
  envelope.topic = 0xaabbccdd;
  envelope.schema_digest = 77;
  envelope.session = kSealedSession;
  envelope.node = 5;
  envelope.boot = 9;
  envelope.header.sequence = 1234;
  envelope.header.publish_ns = 5'000'000'123;
  return envelope;
}

struct Ends {
  Sealer sealer;
  Opener opener{kSealedSession, true};
  Ends() {
    const SenderKey key = DeriveSenderKey(MakeSessionKey(), kInstance);
    sealer.SetKey(key);
    KnownSenders senders;
    senders.push_back({5, key});
    opener.SetSenders(senders);
  }

  std::vector<std::uint8_t> Make(const std::string& text, const Envelope& envelope = EnvelopeToSeal()) {
    const std::size_t head = EnvelopeBytes(envelope.header);
    std::vector<std::uint8_t> bytes(head + text.size() + kSealBytes);
    std::memcpy(bytes.data() + head, text.data(), text.size());
    EXPECT_EQ(sealer.Seal(bytes.data(), WriteEnvelope(envelope, text.size(), bytes.data())), bytes.size());
    return bytes;
  }

  Refusal Open(std::vector<std::uint8_t> bytes, std::string* text = nullptr) {
    Envelope envelope;
    std::span<const std::uint8_t> payload;
    const Refusal refusal = opener.Open(bytes, &envelope, &payload);
    if (refusal == Refusal::kNone && text != nullptr) text->assign(payload.begin(), payload.end());
    return refusal;
  }
};

std::string Hex(std::span<const std::uint8_t> bytes) {
  std::string text;
  for (const std::uint8_t byte : bytes) {
    text += "0123456789abcdef"[byte >> 4];
    text += "0123456789abcdef"[byte & 15];
  }
  return text;
}

// The expected bytes were computed with Python's packages hmac and cryptography.
TEST(Sealing, MatchesAnIndependentImplementation) {
  EXPECT_EQ(Hex(DeriveSenderKey(MakeSessionKey(), kInstance)),
            "5e92f5e22635a13b69341822fcfd655e6879d304a1f50e483003c4af7b2092e0");
  Ends ends;
  const auto bytes = ends.Make("hello");
  EXPECT_EQ(Hex(std::span(bytes).subspan(kEnvelopeFixedBytes)),
            "5e1d0d801e"
            "0100000000000000"
            "f9d23bbb163b9cdbd2f905e6bd9d73e6");
}

TEST(Sealing, RoundTripsAndHidesThePayload) {
  Ends ends;
  const auto bytes = ends.Make("where the hand is");
  EXPECT_EQ(std::search(bytes.begin(), bytes.end(), "hand", "hand" + 4), bytes.end());
  std::string text;
  EXPECT_EQ(ends.Open(bytes, &text), Refusal::kNone);
  EXPECT_EQ(text, "where the hand is");
}

TEST(Sealing, RefusesEveryFlippedBitAndEveryTruncation) {
  Ends ends;
  const auto bytes = ends.Make("hello");
  for (std::size_t bit = 0; bit < bytes.size() * 8; ++bit) {
    auto damaged = bytes;
    damaged[bit / 8] ^= static_cast<std::uint8_t>(1 << (bit % 8));
    EXPECT_NE(ends.Open(damaged), Refusal::kNone) << "bit " << bit;
  }
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    EXPECT_EQ(ends.Open({bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size)}), Refusal::kTruncated);
  }
  EXPECT_EQ(ends.Open(bytes), Refusal::kNone);  // none of the forgeries has used its counter up
}

TEST(Sealing, NamesTheReasonOfARefusal) {
  Ends ends;
  EXPECT_EQ(ends.Open(std::vector<std::uint8_t>(kMaxDatagramBytes + 1)), Refusal::kOversized);
  EXPECT_EQ(ends.Open(std::vector<std::uint8_t>(200)), Refusal::kGarbage);
  EXPECT_EQ(ends.Open({1, 2, 3}), Refusal::kTruncated);
  Envelope envelope = EnvelopeToSeal();
  envelope.session = kSealedSession + 1;
  EXPECT_EQ(ends.Open(ends.Make("x", envelope)), Refusal::kWrongSession);
  envelope = EnvelopeToSeal();
  envelope.node = 6;
  EXPECT_EQ(ends.Open(ends.Make("x", envelope)), Refusal::kUnknownSender);
  auto forged = ends.Make("x");
  forged.back() ^= 1;
  EXPECT_EQ(ends.Open(forged), Refusal::kNotAuthentic);
  const auto sound = ends.Make("x");
  EXPECT_EQ(ends.Open(sound), Refusal::kNone);
  EXPECT_EQ(ends.Open(sound), Refusal::kReplayed);
}

TEST(Sealing, SealedAndClearReceiversRefuseEachOthersDatagrams) {
  Ends ends;
  std::vector<std::uint8_t> clear(kEnvelopeFixedBytes);
  WriteEnvelope(EnvelopeToSeal(), 0, clear.data());
  EXPECT_EQ(ends.Open(clear), Refusal::kNotAuthentic);
  auto sealed = ends.Make("x");
  Opener without_keys(kSealedSession, false);
  Envelope envelope;
  std::span<const std::uint8_t> payload;
  EXPECT_EQ(without_keys.Open(sealed, &envelope, &payload), Refusal::kNotAuthentic);
  EXPECT_EQ(without_keys.Open(clear, &envelope, &payload), Refusal::kNone);
}

TEST(Sealing, AKeyOfAnotherSessionOrInstanceOpensNothing) {
  Ends ends;
  SessionKey other = MakeSessionKey();
  other[31] ^= 1;
  for (const SenderKey& key : {DeriveSenderKey(other, kInstance), DeriveSenderKey(MakeSessionKey(), kInstance + 1)}) {
    Ends forger;
    forger.sealer.SetKey(key);
    EXPECT_EQ(ends.Open(forger.Make("x")), Refusal::kNotAuthentic);
  }
}

TEST(Sealing, ADatagramOfOneSocketIsNotTakenForOneOfTheOther) {
  Ends ends;
  auto bytes = ends.Make("x");
  bytes[5] = static_cast<std::uint8_t>(TopicClass::kControl);
  EXPECT_EQ(ends.Open(bytes), Refusal::kNotAuthentic);
}

TEST(Sealing, ANewRosterKeepsTheReplayWindowsOfThoseWhoStay) {
  Ends ends;
  const auto bytes = ends.Make("x");
  EXPECT_EQ(ends.Open(bytes), Refusal::kNone);
  KnownSenders senders;
  senders.push_back({6, DeriveSenderKey(MakeSessionKey(), 1)});
  senders.push_back({5, DeriveSenderKey(MakeSessionKey(), kInstance)});
  ends.opener.SetSenders(senders);
  EXPECT_EQ(ends.Open(bytes), Refusal::kReplayed);
  EXPECT_EQ(ends.Open(ends.Make("y")), Refusal::kNone);
  senders.resize(1);
  ends.opener.SetSenders(senders);
  EXPECT_EQ(ends.Open(ends.Make("z")), Refusal::kUnknownSender);
}

TEST(ReplayWindow, TakesEachCounterOfTheLast64OnceAndNothingOlder) {
  ReplayWindow window;
  std::set<std::uint64_t> taken;
  std::uint64_t newest = 0;
  std::mt19937_64 random(3);
  for (int round = 0; round < 100'000; ++round) {
    const std::uint64_t base = newest > 80 ? newest - 80 : 0;
    const std::uint64_t counter = base + random() % (round % 100 == 0 ? 400 : 84);
    const bool is_new = counter != 0 && counter + 64 > newest && taken.count(counter) == 0;
    ASSERT_EQ(window.IsNew(counter), is_new) << counter << " with newest " << newest;
    if (!is_new) continue;
    window.Take(counter);
    taken.insert(counter);
    newest = std::max(newest, counter);
  }
}

}  // namespace
}  // namespace bus::detail
