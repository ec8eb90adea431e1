// Forged datagrams: out of order, of another life, of another session, garbage.

#include <gtest/gtest.h>

#include <random>
#include <vector>

#include "bus/latest/udp_socket.hpp"
#include "bus/testing/make_node.hpp"
#include "bus/wire/codec.hpp"
#include "bus/wire/envelope.hpp"
#include "bus/wire/schema.hpp"

namespace bus {
namespace {

using testing::kLong_ns;
using testing::MakeNode;
using testing::MakeRegistry;

// Sends forged datagrams to a node's data socket.
class Forger {
 public:
  Forger(const std::string& endpoint, const std::string& topic) : socket_(*detail::UdpSocket::Bind("127.0.0.1")) {
    EXPECT_TRUE(detail::ParseEndpoint(endpoint, &to_));
    envelope_.topic = TopicId(topic);
    envelope_.session = 7;
  }
  void Send(std::uint64_t boot, std::uint64_t sequence, std::uint32_t digest, std::uint64_t session = 7) {
    core::HapticProxy proxy;
    proxy.cycle = sequence;
    envelope_.boot = boot;
    envelope_.header.sequence = sequence;
    envelope_.schema_digest = digest;
    envelope_.session = session;
    std::vector<std::uint8_t> bytes(1200);
    const std::size_t payload = codec_.Encode(proxy, 0, 1000, bytes.data() + kEnvelopeFixedBytes, 1000);
    bytes.resize(WriteEnvelope(envelope_, payload, bytes.data()));
    SendRaw(bytes);
  }
  void SendRaw(const std::vector<std::uint8_t>& bytes) { EXPECT_TRUE(socket_.Send(to_, bytes.data(), bytes.size())); }

 private:
  detail::UdpSocket socket_;
  sockaddr_in to_{};
  Envelope envelope_;
  LatestCodec<core::HapticProxy> codec_;
};

class ForgedTraffic : public ::testing::Test {
 protected:
  void SetUp() override {
    registry_ = MakeRegistry();
    watcher_ = MakeNode("watcher", registry_->endpoint());
    node_ = MakeNode("physics_node", registry_->endpoint());
    reader_ = &node_->ReadLatest<core::HapticProxy>(HapticProxyTopic("right"));
    ASSERT_TRUE(node_->Start().has_value());
    ASSERT_TRUE(watcher_->Start().has_value());
    ASSERT_TRUE(watcher_->WaitForPeers({"physics_node"}, kLong_ns).has_value());
    ASSERT_TRUE(node_->WaitForPeers({"watcher"}, kLong_ns).has_value());
    refused_before_ = node_->counters().refused;  // the watcher may have sent before it was known
    forger_ = std::make_unique<Forger>(watcher_->Peers()[0].udp_endpoint, HapticProxyTopic("right"));
  }
  void TearDown() override { testing::ExpectAccountsClose({watcher_.get(), node_.get()}); }
  // Loopback delivers before sendto returns, so one poll is enough.
  const TopicCounters& Take() {
    node_->Wait(core::MonotonicNow_ns() + kLong_ns);
    counters_ = node_->counters();
    return counters_.topics[0];
  }
  std::unique_ptr<Registry> registry_;
  std::unique_ptr<Node> watcher_, node_;
  LatestReader<core::HapticProxy>* reader_ = nullptr;
  std::unique_ptr<Forger> forger_;
  Counters counters_;
  std::uint64_t refused_before_ = 0;
  std::uint32_t digest_ = SchemaOf(MessageType::kHapticProxy).digest;
};

TEST_F(ForgedTraffic, NewestWinsAndEveryLossIsCounted) {
  for (const std::uint64_t sequence : {10, 11, 14, 13, 12, 20, 20, 14}) forger_->Send(5, sequence, digest_);
  const TopicCounters& topic = Take();
  EXPECT_EQ(reader_->value().cycle, 20u);
  EXPECT_EQ(topic.received, 6u);
  EXPECT_EQ(topic.reordered, 2u);  // 13, 12
  EXPECT_EQ(topic.repeated, 2u);   // 20, 14
  EXPECT_EQ(topic.dropped, 5u);    // 15 to 19
}

TEST_F(ForgedTraffic, ALaterBootWinsOverAHigherSequence) {
  forger_->Send(5, 1000, digest_);
  forger_->Send(6, 1, digest_);
  forger_->Send(5, 1001, digest_);  // a straggler from before the restart
  const TopicCounters& topic = Take();
  EXPECT_EQ(reader_->value().cycle, 1u);
  EXPECT_EQ(reader_->restarts(), 1u);
  EXPECT_EQ(topic.received, 2u);
  EXPECT_EQ(topic.reordered, 1u);
  EXPECT_EQ(topic.dropped, 0u);
}

TEST_F(ForgedTraffic, GarbageAndForeignDatagramsAreRefusedAndCounted) {
  forger_->Send(5, 1, digest_);
  forger_->Send(5, 2, digest_ + 1);  // another schema
  forger_->Send(5, 3, digest_, 8);   // another session
  std::mt19937_64 random(1);
  for (int i = 0; i < 100; ++i) {
    std::vector<std::uint8_t> noise(random() % 1400);
    for (std::uint8_t& byte : noise) byte = static_cast<std::uint8_t>(random());
    forger_->SendRaw(noise);
  }
  Take();
  EXPECT_EQ(reader_->value().cycle, 1u);
  EXPECT_EQ(counters_.refused - refused_before_, 102u);
  EXPECT_EQ(counters_.received, 1u);
}

}  // namespace
}  // namespace bus
