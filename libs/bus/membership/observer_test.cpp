// An observer, too, gets lost messages restored from copies in later datagrams.

#include <gtest/gtest.h>
#include <sys/socket.h>

#include <vector>

#include "bus/latest/latest_io.hpp"
#include "bus/testing/make_node.hpp"

namespace bus {
namespace {

using testing::kLong_ns;
using testing::MakeNode;
using testing::MakeRegistry;
using testing::Until;
using testing::WaitBriefly;

using Bytes = std::vector<std::uint8_t>;

// A writer's end whose datagrams the test delivers, or does not.
class Observer : public ::testing::Test {
 protected:
  void SetUp() override {
    registry_ = MakeRegistry();
    writer_ = MakeNode("haptic_node", registry_->endpoint());
    writer_->WriteLatest<core::HapticProxy>(HapticProxyTopic("right"));
    watcher_ = MakeNode("watcher", registry_->endpoint());
    watcher_->Observe("haptic/*");
    ASSERT_TRUE(writer_->Start().has_value() && watcher_->Start().has_value());
    ASSERT_TRUE(watcher_->WaitForPeers({"haptic_node"}, kLong_ns).has_value());
    ASSERT_TRUE(writer_->WaitForPeers({"watcher"}, kLong_ns).has_value());
    ASSERT_TRUE(detail::ParseEndpoint(writer_->Peers()[0].udp_endpoint, &watcher_address_));
    sockaddr_in own{};
    ASSERT_TRUE(detail::ParseEndpoint(wire_.endpoint(), &own));
    sender_.socket = &wire_;
    sender_.guard = &guard_;
    sender_.envelope.session = 7;
    sender_.envelope.boot = 9;
    detail::Subscribers readers;
    readers.push_back({own, 1, 0, true});
    sender_.SetReaders(readers);
  }
  void TearDown() override { testing::ExpectAccountsClose({writer_.get(), watcher_.get()}); }

  Bytes Send() {
    core::HapticProxy proxy;
    proxy.cycle = sender_.sequence + 1;
    EXPECT_EQ(sender_.Send(&proxy), 1);
    Bytes bytes(kMaxDatagramBytes);
    const ssize_t size = recv(wire_.fd(), bytes.data(), bytes.size(), MSG_DONTWAIT);  // loopback has it already
    EXPECT_GT(size, 0);
    bytes.resize(static_cast<std::size_t>(std::max<ssize_t>(size, 0)));
    published_ns_.push_back(sender_.envelope.header.publish_ns);
    Envelope envelope;
    std::span<const std::uint8_t> payload;
    EXPECT_EQ(ReadEnvelope(bytes, &envelope, &payload), EnvelopeStatus::kOk);
    payloads_.emplace_back(payload.begin(), payload.end());
    return bytes;
  }
  // The sequences that the observer gets, in its order.
  std::vector<std::uint64_t> Deliver(const Bytes& bytes) {
    EXPECT_TRUE(wire_.Send(watcher_address_, bytes.data(), bytes.size()));
    EXPECT_TRUE(Until([&] { return watcher_->Wait(core::MonotonicNow_ns() + core::kTick_ns).datagrams > 0; }));
    Envelope envelope;
    std::span<const std::uint8_t> payload;
    EXPECT_EQ(ReadEnvelope(bytes, &envelope, &payload), EnvelopeStatus::kOk);
    std::vector<std::uint64_t> sequences;
    Observation seen;
    while (watcher_->PollObservation(&seen)) {
      sequences.push_back(seen.sequence);
      if (seen.sequence - 1 >= payloads_.size()) continue;
      EXPECT_EQ(seen.payload, payloads_[seen.sequence - 1]);
      EXPECT_EQ(seen.publish_ns, published_ns_[seen.sequence - 1]);
      EXPECT_EQ(seen.num_bytes, seen.sequence == envelope.header.sequence ? bytes.size() : 0u);
      EXPECT_EQ(seen.writer, "haptic_node");
    }
    return sequences;
  }

  std::unique_ptr<Registry> registry_;
  std::unique_ptr<Node> writer_, watcher_;
  sockaddr_in watcher_address_{};
  detail::UdpSocket wire_ = std::move(*detail::UdpSocket::Bind("127.0.0.1"));
  detail::DatagramGuard guard_{7, false};
  detail::TypedSender<core::HapticProxy> sender_{HapticProxyTopic("right")};
  std::vector<std::string> payloads_;
  std::vector<std::int64_t> published_ns_;
};

using Sequences = std::vector<std::uint64_t>;

TEST_F(Observer, GetsLostMessagesFromLaterCopiesOnceAndInOrder) {
  EXPECT_EQ(Deliver(Send()), (Sequences{1}));
  const Bytes second = Send();
  EXPECT_EQ(Deliver(Send()), (Sequences{2, 3}));
  EXPECT_EQ(Deliver(second), Sequences());  // late, when its copy had come
  Send();
  Send();
  EXPECT_EQ(Deliver(Send()), (Sequences{4, 5, 6}));
  const Bytes seventh = Send();
  Send();
  Send();
  EXPECT_EQ(Deliver(Send()), (Sequences{8, 9, 10}));
  EXPECT_EQ(Deliver(seventh), (Sequences{7}));  // late, and no copy of it had come
}

TEST_F(Observer, GetsNothingTwiceAfterAWriterRestart) {
  for (std::uint64_t i = 1; i <= 3; ++i) EXPECT_EQ(Deliver(Send()), (Sequences{i}));
  sender_.envelope.boot = 10;
  sender_.sequence = 0;
  sender_.earlier.Forget();
  payloads_.clear();
  published_ns_.clear();
  EXPECT_EQ(Deliver(Send()), (Sequences{1}));
  Send();
  EXPECT_EQ(Deliver(Send()), (Sequences{2, 3}));
}

}  // namespace
}  // namespace bus
