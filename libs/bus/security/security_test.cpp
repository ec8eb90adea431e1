// CURVE on every ZeroMQ link: a peer without a listed key is refused and counted, and disturbs nobody.

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <functional>
#include <random>
#include <zmq.hpp>

#include "bus/bulk/bulk.hpp"
#include "bus/latest/udp_socket.hpp"
#include "bus/security/gate.hpp"
#include "bus/security/keys.hpp"
#include "bus/testing/make_node.hpp"
#include "bus/wire/control.hpp"
#include "proto/bus.pb.h"

namespace bus {
namespace {

using testing::kLong_ns;
using testing::Until;

// A raw TCP connection, without libzmq.
class RawConnection {
 public:
  RawConnection(const std::string& endpoint, const std::string& bytes) : fd_(socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in address{};
    EXPECT_TRUE(detail::ParseEndpoint(endpoint.substr(endpoint.find("//") + 2), &address));
    EXPECT_EQ(connect(fd_, reinterpret_cast<const sockaddr*>(&address), sizeof(address)), 0);
    if (!bytes.empty()) send(fd_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
  }
  RawConnection(const RawConnection&) = delete;
  RawConnection& operator=(const RawConnection&) = delete;
  ~RawConnection() { close(fd_); }

 private:
  int fd_;
};

// ZMTP 3.1 greeting [ZeroMQ RFC 37], then whatever follows.
std::string Greeting(const std::string& mechanism) {
  std::string bytes = "\xff" + std::string(8, '\0') + "\x7f\x03\x01" + mechanism;
  bytes.resize(64, '\0');
  return bytes;
}

// A registry and two nodes with keys: one writes 'logic/status', the other reads it.
class KeyedRun : public ::testing::Test {
 protected:
  void SetUp() override {
    std::string name = ::testing::TempDir() + "run-XXXXXX";
    ASSERT_NE(mkdtemp(name.data()), nullptr);
    folder_ = name;
    keys_ = folder_ / "keys";
    ASSERT_TRUE(MakeKeys(keys_, {"logic_node", "visual_node", "oos"}).has_value());
    auto registry = Registry::Create({"tcp://127.0.0.1:0", 7, keys_});
    ASSERT_TRUE(registry.has_value()) << registry.error().detail;
    registry_ = std::move(*registry);
    logic_ = Make("logic_node");
    visual_ = Make("visual_node");
    ASSERT_TRUE(logic_ != nullptr && visual_ != nullptr);
    status_ = logic_->WriteState<core::LogicStatus>(kLogicStatusTopic);
    auto bulk = BulkServer::Create(logic_.get(), OptionsFor("logic_node", keys_));
    ASSERT_TRUE(bulk.has_value()) << bulk.error().detail;
    bulk_ = std::move(*bulk);
    shown_ = &visual_->ReadState<core::LogicStatus>(kLogicStatusTopic);
    for (Node* node : {logic_.get(), visual_.get()}) {
      const auto started = node->Start(kLong_ns);
      ASSERT_TRUE(started.has_value()) << started.error().detail;
    }
    ASSERT_TRUE(visual_->WaitForPeers({"logic_node"}, kLong_ns).has_value());
    for (const PeerStatus& peer : visual_->Peers()) router_ = peer.router_endpoint;
    const auto offer = bulk_->Offer("block", {1, 2, 3});
    ASSERT_TRUE(offer.has_value()) << offer.error().detail;
    offer_ = *offer;
  }
  void TearDown() override {
    testing::ExpectAccountsClose({logic_.get(), visual_.get()});
    std::filesystem::remove_all(folder_);
  }

  NodeOptions OptionsFor(const std::string& name, const std::string& keys) const {
    NodeOptions options;
    options.name = name;
    options.registry = registry_->endpoint();
    options.session = 7;
    options.keys = keys;
    options.is_encrypted = !keys.empty();
    return options;
  }
  std::unique_ptr<Node> Make(const std::string& name) const {
    auto node = Node::Create(OptionsFor(name, keys_));
    EXPECT_TRUE(node.has_value()) << node.error().detail;
    return node ? std::move(*node) : nullptr;
  }
  // The run goes on: a change of state arrives.
  void ExpectDataFlows() {
    core::LogicStatus status;
    status.step = "step " + std::to_string(++num_steps_);
    ASSERT_TRUE(status_.Set(status));
    EXPECT_TRUE(Until([&] {
      visual_->Wait(core::MonotonicNow_ns() + core::kTick_ns);
      return shown_->value().step == status.step;
    }));
  }
  // By the node's router, not by its BULK socket.
  std::uint64_t RefusedByRouter() const {
    std::uint64_t count = 0;
    for (const RefusalCount& refusal : logic_->counters().refusals) {
      count += refusal.reason == "connection" || refusal.reason == "message" ? refusal.count : 0;
    }
    return count;
  }
  // One more connection is refused by the registry, by a node's router and by its BULK socket.
  void ExpectAllRefuse(const std::function<void(const std::string& endpoint)>& disturb) {
    const std::uint64_t before_registry = registry_->num_refused();
    const std::uint64_t before_node = RefusedByRouter();
    const std::uint64_t before_bulk = bulk_->num_refused();
    disturb(registry_->endpoint());
    disturb(router_);
    disturb(offer_.endpoint);
    EXPECT_TRUE(Until([&] { return registry_->num_refused() > before_registry; }));
    EXPECT_TRUE(Until([&] { return RefusedByRouter() > before_node; }));
    EXPECT_TRUE(Until([&] { return bulk_->num_refused() > before_bulk; }));
    ExpectDataFlows();
    const auto fetched = BulkFetch(offer_, "logic_node", OptionsFor("visual_node", keys_)).Run(kLong_ns);
    EXPECT_TRUE(fetched.has_value()) << fetched.error().detail;
  }

  std::filesystem::path folder_, keys_;
  std::unique_ptr<Registry> registry_;
  std::unique_ptr<Node> logic_, visual_;
  std::unique_ptr<BulkServer> bulk_;
  BulkOffer offer_;
  StateWriter<core::LogicStatus> status_;
  StateReader<core::LogicStatus>* shown_ = nullptr;
  std::string router_;
  int num_steps_ = 0;
};

TEST_F(KeyedRun, DataFlowsAndNobodyIsRefused) {
  ExpectDataFlows();
  const auto tool = Make("oos-top-4711");  // with the key "oos"
  const auto started = tool->Start(kLong_ns);
  EXPECT_TRUE(started.has_value()) << started.error().detail;
  EXPECT_TRUE(tool->WaitForPeers({"logic_node", "visual_node"}, kLong_ns).has_value());
  EXPECT_EQ(registry_->num_refused(), 0u);
}

TEST_F(KeyedRun, AKeyMustBeGivenOrDeclinedExplicitly) {
  auto options = OptionsFor("visual_node-2", "");
  options.is_encrypted = true;
  const auto node = Node::Create(options);
  ASSERT_FALSE(node.has_value());
  EXPECT_NE(node.error().detail.find("--no_encryption"), std::string::npos) << node.error().detail;
  EXPECT_FALSE(Registry::Create({"tcp://127.0.0.1:0", 7, ""}).has_value());
}

TEST_F(KeyedRun, APeerWithoutAKeyIsRefused) {
  auto stranger = std::move(*Node::Create(OptionsFor("visual_node-2", "")));
  const auto started = stranger->Start(core::kNanosecondsPerSecond);
  ASSERT_FALSE(started.has_value());
  EXPECT_NE(started.error().detail.find("encryption and a key"), std::string::npos) << started.error().detail;
  ExpectAllRefuse([](const std::string& endpoint) {
    zmq::context_t context;
    zmq::socket_t dealer(context, zmq::socket_type::dealer);
    dealer.set(zmq::sockopt::linger, 0);
    zmq::socket_t monitor(context, zmq::socket_type::pair);
    ASSERT_EQ(zmq_socket_monitor(dealer.handle(), "inproc://end", ZMQ_EVENT_DISCONNECTED), 0);
    monitor.connect("inproc://end");
    dealer.connect(endpoint);
    dealer.send(zmq::str_buffer("let me in"), zmq::send_flags::none);
    zmq::message_t event;
    ASSERT_TRUE(monitor.recv(event));
  });
}

TEST_F(KeyedRun, AKeyThatIsNotListedIsRefusedByName) {
  const auto others = folder_ / "other_run";
  ASSERT_TRUE(MakeKeys(others, {"visual_node"}).has_value());
  // It knows the registry's public key, which is no secret, but its own key is of another run.
  std::filesystem::remove(others / "allowed");
  std::filesystem::copy(keys_ / "allowed", others / "allowed");
  const std::uint64_t before = registry_->num_refused();
  auto stranger = std::move(*Node::Create(OptionsFor("visual_node-2", others)));
  const auto started = stranger->Start(kLong_ns);
  ASSERT_FALSE(started.has_value());
  EXPECT_NE(started.error().detail.find("does not know the key of visual_node"), std::string::npos)
      << started.error().detail;
  EXPECT_TRUE(Until([&] { return registry_->num_refused() > before; }));
  ExpectAllRefuse([&](const std::string& endpoint) {
    zmq::context_t context;
    zmq::socket_t dealer(context, zmq::socket_type::dealer);
    zmq::socket_t monitor(context, zmq::socket_type::pair);
    ASSERT_EQ(zmq_socket_monitor(dealer.handle(), "inproc://end", ZMQ_EVENT_HANDSHAKE_FAILED_AUTH), 0);
    monitor.connect("inproc://end");
    const auto mine = LoadKeys(others, "visual_node");
    dealer.set(zmq::sockopt::linger, 0);
    dealer.set(zmq::sockopt::curve_serverkey,
               mine->PublicKeyOf(endpoint == registry_->endpoint() ? kRegistryKeyName : "logic_node"));
    dealer.set(zmq::sockopt::curve_publickey, mine->own.public_key);
    dealer.set(zmq::sockopt::curve_secretkey, mine->own.secret_key);
    dealer.connect(endpoint);
    zmq::message_t event;
    ASSERT_TRUE(monitor.recv(event));
  });
}

TEST_F(KeyedRun, ARegistryWithAnotherKeyIsRejected) {
  const auto others = folder_ / "other_run";
  ASSERT_TRUE(MakeKeys(others, {"visual_node"}).has_value());
  auto impostor = std::move(*Registry::Create({"tcp://127.0.0.1:0", 7, others}));
  auto options = OptionsFor("visual_node-2", keys_);
  options.registry = impostor->endpoint();
  auto node = std::move(*Node::Create(options));
  const auto started = node->Start(core::kNanosecondsPerSecond / 5);
  ASSERT_FALSE(started.has_value());
  EXPECT_NE(started.error().detail.find("handshake fails"), std::string::npos) << started.error().detail;
  EXPECT_TRUE(impostor->Names().empty());
}

TEST_F(KeyedRun, AListedKeyIsGoodForItsOwnNameOnly) {
  const auto others = folder_ / "copy";
  std::filesystem::copy(keys_, others);
  std::filesystem::rename(others / "oos.key", others / "physics_node.key");
  std::filesystem::permissions(others, std::filesystem::perms::owner_all);
  auto impostor = std::move(*Node::Create(OptionsFor("physics_node", others)));
  const auto started = impostor->Start(kLong_ns);
  ASSERT_FALSE(started.has_value());
  EXPECT_NE(started.error().detail.find("the key of oos is not good for a node called physics_node"), std::string::npos)
      << started.error().detail;
  ExpectDataFlows();
}

TEST_F(KeyedRun, GarbageOnThePortIsRefused) {
  std::mt19937_64 random(5);
  std::vector<std::string> garbage = {"GET / HTTP/1.0\r\n\r\n", std::string(100, '\0'), Greeting("NULL"),
                                      Greeting("PLAIN"), Greeting("CURVE") + std::string(300, 'x')};
  for (int i = 0; i < 10; ++i) {
    std::string noise(1 + random() % 500, '\0');
    for (char& byte : noise) byte = static_cast<char>(random());
    noise[0] = static_cast<char>(noise[0] & 0x7f);
    garbage.push_back(std::move(noise));
  }
  for (const std::string& bytes : garbage) {
    ExpectAllRefuse([&](const std::string& endpoint) { const RawConnection raw(endpoint, bytes); });
  }
}

TEST_F(KeyedRun, AnOversizedFrameBeforeTheHandshakeIsRefused) {
  ExpectAllRefuse([](const std::string& endpoint) {
    // A command of 2^62 bytes.
    const RawConnection raw(endpoint, Greeting("CURVE") + "\x06\x40" + std::string(7, '\0') + std::string(1000, 'x'));
  });
}

// A misbehaving member: too long a message is refused; a frame above kMaxFrameBytes closes its connection.
TEST_F(KeyedRun, AnOversizedFrameOfAMemberClosesItsConnection) {
  const auto mine = LoadKeys(keys_, "oos");
  ASSERT_TRUE(mine.has_value());
  zmq::context_t context;
  zmq::socket_t dealer(context, zmq::socket_type::dealer);
  zmq::socket_t monitor(context, zmq::socket_type::pair);
  ASSERT_EQ(zmq_socket_monitor(dealer.handle(), "inproc://end", ZMQ_EVENT_DISCONNECTED), 0);
  monitor.connect("inproc://end");
  dealer.set(zmq::sockopt::linger, 0);
  dealer.set(zmq::sockopt::routing_id, "oos-1#1");
  dealer.set(zmq::sockopt::curve_serverkey, mine->PublicKeyOf("logic_node"));
  dealer.set(zmq::sockopt::curve_publickey, mine->own.public_key);
  dealer.set(zmq::sockopt::curve_secretkey, mine->own.secret_key);
  dealer.connect(router_);
  const std::uint64_t before = logic_->counters().refused;
  dealer.send(zmq::str_buffer("no envelope"), zmq::send_flags::none);
  EXPECT_TRUE(Until([&] { return logic_->counters().refused == before + 1; }));
  const std::vector<char> large(detail::kMaxMessageBytes + 1);
  dealer.send(zmq::buffer(large), zmq::send_flags::none);
  EXPECT_TRUE(Until([&] { return logic_->counters().refused == before + 2; }));
  const std::vector<char> larger(static_cast<std::size_t>(detail::kMaxFrameBytes) + 1);
  dealer.send(zmq::buffer(larger), zmq::send_flags::none);
  zmq::message_t event;
  EXPECT_TRUE(monitor.recv(event));
  ExpectDataFlows();
}

// A sender chooses its routing id freely; a member that takes another's is refused.
TEST_F(KeyedRun, AMemberCannotSpeakInAnothersName) {
  const auto mine = LoadKeys(keys_, "oos");
  zmq::context_t context;
  zmq::socket_t dealer(context, zmq::socket_type::dealer);
  dealer.set(zmq::sockopt::linger, 0);
  dealer.set(zmq::sockopt::routing_id, "visual_node#4711");
  dealer.set(zmq::sockopt::curve_serverkey, mine->PublicKeyOf("logic_node"));
  dealer.set(zmq::sockopt::curve_publickey, mine->own.public_key);
  dealer.set(zmq::sockopt::curve_secretkey, mine->own.secret_key);
  dealer.connect(router_);
  oos::Control control;
  control.mutable_subscribe()->set_name("visual_node");
  control.mutable_subscribe()->set_instance(4711);
  control.mutable_subscribe()->set_wants_state(true);
  const detail::Identity identity{7, TopicId("visual_node"), 1};
  const auto bytes = detail::EncodeControl(identity, TopicClass::kState, control);
  const std::uint64_t before = logic_->counters().refused;
  dealer.send(zmq::buffer(bytes), zmq::send_flags::none);
  EXPECT_TRUE(Until([&] { return logic_->counters().refused == before + 1; }));
  ExpectDataFlows();
}

TEST_F(KeyedRun, AnOversizedMessageToTheRegistryIsRefused) {
  const auto mine = LoadKeys(keys_, "oos");
  zmq::context_t context;
  zmq::socket_t dealer(context, zmq::socket_type::dealer);
  dealer.set(zmq::sockopt::linger, 0);
  dealer.set(zmq::sockopt::routing_id, "oos-1#1");
  detail::GuardConnection(&dealer, *mine, mine->PublicKeyOf(kRegistryKeyName));
  dealer.connect(registry_->endpoint());
  // It would be a HELLO if it were shorter.
  oos::Control control;
  control.mutable_hello()->mutable_node()->set_name("oos-1");
  control.mutable_hello()->mutable_node()->set_session(7);
  control.mutable_hello()->mutable_node()->add_observed_patterns(std::string(detail::kMaxMessageBytes, '*'));
  const auto bytes = detail::EncodeControl({7, TopicId("oos-1"), 1}, TopicClass::kControl, control);
  const std::uint64_t before = registry_->num_refused();
  dealer.send(zmq::buffer(bytes), zmq::send_flags::none);
  EXPECT_TRUE(Until([&] { return registry_->num_refused() > before; }));
  EXPECT_EQ(registry_->Refusals().size(), 0u) << "it was not parsed";
  ExpectDataFlows();
}

TEST_F(KeyedRun, ConnectionsAreLimited) {
  std::vector<std::unique_ptr<RawConnection>> crowd;
  const std::uint64_t before = registry_->num_refused();
  for (std::size_t i = 0; i < detail::kMaxConnections + 10; ++i) {
    crowd.push_back(std::make_unique<RawConnection>(registry_->endpoint(), "\xff"));
  }
  EXPECT_TRUE(Until([&] { return registry_->num_refused() >= before + 10; }));
  ExpectDataFlows();
  crowd.clear();
  const auto late = Make("oos-late");
  EXPECT_TRUE(late->Start(kLong_ns).has_value());
}

}  // namespace
}  // namespace bus
