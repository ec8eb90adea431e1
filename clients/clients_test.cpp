// The clients' tables and test vectors against the bus in C++: topics.json is a copy of libs/bus/topics.hpp;
// vectors/envelopes.json holds messages that every implementation must read and write alike.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "bus/security/sealing.hpp"
#include "bus/wire/envelope.hpp"
#include "bus/wire/schema.hpp"

namespace {

using nlohmann::json;

json ReadJson(const std::string& name) {
  std::ifstream file(std::string(VR_OOS_SOURCE_DIR) + "/clients/" + name);
  return json::parse(file);
}

std::vector<std::uint8_t> FromHex(const std::string& hex) {
  std::vector<std::uint8_t> bytes;
  for (std::size_t i = 0; i + 1 < hex.size(); i += 2) {
    bytes.push_back(static_cast<std::uint8_t>(std::stoul(hex.substr(i, 2), nullptr, 16)));
  }
  return bytes;
}

std::string ToHex(std::span<const std::uint8_t> bytes) {
  constexpr char kDigits[] = "0123456789abcdef";
  std::string hex;
  for (const std::uint8_t byte : bytes) {
    hex += kDigits[byte >> 4];
    hex += kDigits[byte & 0xf];
  }
  return hex;
}

TEST(ClientTopics, EqualTheTopicTableOfTheBus) {
  json rules = json::array();
  for (const bus::TopicRule& rule : bus::kTopicRules) {
    rules.push_back({{"pattern", rule.pattern},
                     {"class", static_cast<int>(rule.topic_class)},
                     {"message_type", static_cast<int>(rule.type)},
                     {"type", bus::SchemaOf(rule.type).name},
                     {"max_age_ms", rule.max_age_ns / 1'000'000}});
  }
  EXPECT_EQ(ReadJson("topics.json").at("rules"), rules) << "clients/topics.json should be:\n" << rules.dump(1);
}

TEST(ClientVectors, DigestsAndIdsEqualThoseOfTheBus) {
  const json vectors = ReadJson("vectors/hashes.json");
  for (const json& topic : vectors.at("topics")) {
    EXPECT_EQ(bus::TopicId(topic.at("name").get<std::string>()), topic.at("id")) << topic;
  }
  ASSERT_GE(vectors.at("schemas").size(), 12U);
  for (const json& row : vectors.at("schemas")) {
    const auto& schema = bus::SchemaOf(static_cast<bus::MessageType>(row.at("message_type").get<int>()));
    const std::string canonical = row.at("canonical");
    EXPECT_EQ(row.at("type"), schema.name);
    EXPECT_TRUE((schema.canonical + " ").starts_with(canonical + " ")) << schema.name;  // fields may have been added
    EXPECT_EQ(row.at("digest"), bus::TopicId(canonical)) << "the same hash";
  }
}

TEST(ClientVectors, EnvelopesAreReadAndWrittenAlike) {
  const json vectors = ReadJson("vectors/envelopes.json");
  for (const json& row : vectors.at("sound")) {
    const std::vector<std::uint8_t> bytes = FromHex(row.at("bytes"));
    bus::Envelope envelope;
    std::span<const std::uint8_t> payload;
    ASSERT_EQ(bus::ReadEnvelope(bytes, &envelope, &payload), bus::EnvelopeStatus::kOk) << row.at("name");
    EXPECT_EQ(static_cast<int>(envelope.topic_class), row.at("class"));
    EXPECT_EQ(envelope.part, row.at("part"));
    EXPECT_EQ(envelope.num_parts, row.at("parts"));
    EXPECT_EQ(envelope.topic, row.at("topic"));
    EXPECT_EQ(envelope.schema_digest, row.at("digest"));
    EXPECT_EQ(std::to_string(envelope.session), row.at("session"));
    EXPECT_EQ(envelope.node, row.at("node"));
    EXPECT_EQ(std::to_string(envelope.boot), row.at("boot"));
    EXPECT_EQ(std::to_string(envelope.header.sequence), row.at("sequence"));
    EXPECT_EQ(std::to_string(envelope.header.publish_ns), row.at("publish_ns"));
    EXPECT_EQ(ToHex(payload), row.at("payload"));
    std::vector<std::uint8_t> again(bytes.size());
    const auto head = static_cast<std::ptrdiff_t>(bus::EnvelopeBytes(envelope.header));
    std::copy(bytes.begin() + head, bytes.end(), again.begin() + head);
    ASSERT_EQ(bus::WriteEnvelope(envelope, payload.size(), again.data()), bytes.size());
    EXPECT_EQ(ToHex(again), row.at("bytes")) << row.at("name");
  }
  for (const json& row : vectors.at("refused")) {
    bus::Envelope envelope;
    std::span<const std::uint8_t> payload;
    EXPECT_NE(bus::ReadEnvelope(FromHex(row.at("bytes")), &envelope, &payload), bus::EnvelopeStatus::kOk)
        << row.at("name");
  }
}

TEST(ClientVectors, SealedDatagramsAreOpenedAndSealedAlike) {
  const json vectors = ReadJson("vectors/envelopes.json");
  const std::vector<std::uint8_t> session_key = FromHex(vectors.at("session_key"));
  bus::detail::SessionKey session;
  ASSERT_EQ(session_key.size(), session.size());
  std::copy(session_key.begin(), session_key.end(), session.begin());
  const auto key = bus::detail::DeriveSenderKey(session, std::stoull(vectors.at("instance").get<std::string>()));
  EXPECT_EQ(ToHex(key), vectors.at("sender_key"));
  for (const json& row : vectors.at("sealed")) {
    std::vector<std::uint8_t> bytes = FromHex(row.at("bytes"));
    bus::detail::KnownSenders senders;
    senders.push_back({row.at("node").get<std::uint32_t>(), key});
    bus::detail::Opener opener(std::stoull(row.at("session").get<std::string>()), true);
    opener.SetSenders(senders);
    bus::Envelope envelope;
    std::span<const std::uint8_t> payload;
    ASSERT_EQ(opener.Open(bytes, &envelope, &payload), bus::detail::Refusal::kNone) << row.at("name");
    EXPECT_EQ(ToHex(payload), row.at("payload"));
    EXPECT_EQ(ToHex({payload.data() + payload.size(), envelope.history_bytes}), row.at("history"));
    bytes = FromHex(row.at("bytes"));
    EXPECT_EQ(opener.Open(bytes, &envelope, &payload), bus::detail::Refusal::kReplayed);
  }
}

}  // namespace
