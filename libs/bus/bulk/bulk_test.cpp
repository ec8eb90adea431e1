#include "bus/bulk/bulk.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <numeric>
#include <zmq.hpp>

#include "bus/security/gate.hpp"
#include "bus/security/keys.hpp"
#include "bus/testing/make_node.hpp"
#include "bus/wire/control.hpp"

namespace bus {
namespace {

using testing::kLong_ns;
using testing::Until;
using testing::WaitBriefly;

std::vector<std::uint8_t> MakeBytes(std::size_t size) {
  std::vector<std::uint8_t> bytes(size);
  for (std::size_t i = 0; i < size; ++i) bytes[i] = static_cast<std::uint8_t>((i * 2'654'435'761u) >> 24);
  return bytes;
}

// With keys and without.
class Bulk : public ::testing::TestWithParam<bool> {
 protected:
  NodeOptions Options(const std::string& name) const {
    NodeOptions options;
    options.name = name;
    options.registry = registry_->endpoint();
    options.session = 7;
    options.is_encrypted = GetParam();
    options.keys = keys_;
    return options;
  }
  void SetUp() override {
    if (GetParam()) {
      folder_ = std::filesystem::path(::testing::TempDir()) / ("bulk-" + std::to_string(getpid()));
      ASSERT_TRUE(MakeKeys(folder_, {"logic_node", "viewer"}).has_value());
      keys_ = folder_.string();
    }
    auto registry = Registry::Create({"tcp://127.0.0.1:0", 7, keys_, GetParam()});
    ASSERT_TRUE(registry.has_value()) << registry.error().detail;
    registry_ = std::move(*registry);
    owner_options_ = Options("logic_node");
    reader_options_ = Options("viewer");
    StartOwner();
  }
  void TearDown() override {
    testing::ExpectAccountsClose({owner_.get()});
    if (!folder_.empty()) std::filesystem::remove_all(folder_);
  }
  void StartOwner() {
    owner_ = std::move(*Node::Create(owner_options_));
    auto server = BulkServer::Create(owner_.get(), owner_options_);
    ASSERT_TRUE(server.has_value()) << server.error().detail;
    server_ = std::move(*server);
    ASSERT_TRUE(owner_->Start().has_value());
  }
  // Keys of a member; none without encryption.
  std::optional<Keys> KeysOf(const std::string& name) const {
    return GetParam() ? std::optional<Keys>(*LoadKeys(keys_, name)) : std::nullopt;
  }

  std::filesystem::path folder_;
  std::string keys_;
  std::unique_ptr<Registry> registry_;
  NodeOptions owner_options_, reader_options_;
  std::unique_ptr<Node> owner_;
  std::unique_ptr<BulkServer> server_;
  const std::vector<std::uint8_t> bytes_ = MakeBytes(3'000'001);  // 46 chunks
};

TEST_P(Bulk, AnOfferIsFoundByNameAndFetchedByContentHash) {
  ASSERT_TRUE(server_->Offer("mesh", bytes_).has_value());
  ASSERT_TRUE(server_->Offer("nothing", {}).has_value());
  auto reader = std::move(*Node::Create(reader_options_));
  const auto& offers = reader->ReadState<BulkOffer>(BulkTopic("logic_node"));
  ASSERT_TRUE(reader->Start().has_value());
  ASSERT_TRUE(Until([&] {
    WaitBriefly(*reader);
    return offers.values().size() == 2;
  }));
  BulkFetch mesh(offers.values().at("mesh"), "logic_node", reader_options_);
  const auto fetched = mesh.Run(kLong_ns);
  ASSERT_TRUE(fetched.has_value()) << fetched.error().detail;
  EXPECT_EQ(*fetched, bytes_);
  EXPECT_TRUE(mesh.account().is_settled()) << Describe(mesh.account());
  EXPECT_EQ(mesh.account().received, 46u);
  BulkFetch nothing(offers.values().at("nothing"), "logic_node", reader_options_);
  EXPECT_TRUE(nothing.Run(kLong_ns).has_value());
  EXPECT_TRUE(nothing.account().is_settled()) << Describe(nothing.account());
  testing::ExpectAccountsClose({owner_.get(), reader.get()});
}

TEST_P(Bulk, ResumesAfterTheOwnerRestarts) {
  const auto offer = server_->Offer("mesh", bytes_);
  ASSERT_TRUE(offer.has_value());
  BulkFetch fetch(*offer, "logic_node", reader_options_);
  ASSERT_TRUE(Until([&] {
    EXPECT_FALSE(fetch.Run(1'000).has_value() && fetch.account().received < 46u);
    return fetch.account().received >= 5;
  }));
  server_.reset();
  owner_.reset();
  const auto orphaned = fetch.Run(core::kNanosecondsPerSecond / 10);
  const std::uint64_t before = fetch.account().received;
  if (before < 46) {
    ASSERT_FALSE(orphaned.has_value());
    EXPECT_NE(orphaned.error().detail.find(std::to_string(before) + " of 46 chunks"), std::string::npos)
        << orphaned.error().detail;
  }
  StartOwner();
  const auto again = server_->Offer("mesh", bytes_);
  ASSERT_TRUE(again.has_value());
  EXPECT_EQ(again->hash, offer->hash);
  fetch.MoveTo(again->endpoint);
  const auto fetched = fetch.Run(kLong_ns);
  ASSERT_TRUE(fetched.has_value()) << fetched.error().detail;
  EXPECT_EQ(*fetched, bytes_);
  EXPECT_EQ(fetch.account().received, 46u) << "nothing that was here is fetched again";
  EXPECT_LE(server_->num_chunks(), 46 - before + 8);
  EXPECT_TRUE(fetch.account().is_settled()) << Describe(fetch.account());
}

TEST_P(Bulk, ContentThatDoesNotMatchItsHashIsRefused) {
  auto offer = server_->Offer("mesh", bytes_);
  ASSERT_TRUE(offer.has_value());
  BulkOffer other = *offer;
  other.hash = BulkHash(MakeBytes(10));
  const auto unknown = BulkFetch(other, "logic_node", reader_options_).Run(kLong_ns);
  ASSERT_FALSE(unknown.has_value());
  EXPECT_EQ(unknown.error().detail, "mesh of logic_node: logic_node does not offer it (any more)");
  BulkOffer shorter = *offer;  // the first part of it only
  shorter.size = 2 * 65'536;
  const auto cut = BulkFetch(shorter, "logic_node", reader_options_).Run(kLong_ns);
  ASSERT_FALSE(cut.has_value());
  EXPECT_NE(cut.error().detail.find("does not match its hash"), std::string::npos) << cut.error().detail;
  BulkOffer huge = *offer;
  huge.size = kMaxBulkBytes + 1;
  EXPECT_FALSE(BulkFetch(huge, "logic_node", reader_options_).Run(kLong_ns).has_value());
  // New content under an old name: the old is gone.
  ASSERT_TRUE(server_->Offer("mesh", MakeBytes(10)).has_value());
  EXPECT_FALSE(BulkFetch(*offer, "logic_node", reader_options_).Run(kLong_ns).has_value());
  // RFC 7693, appendix A is for 512 bits; this is the first 256-bit vector of the reference implementation's b2sum.
  EXPECT_EQ(BulkHash({}), "0e5751c026e543b2e8ab2eb06099daa1d1e5df47778f7787faab45cdf12fe3a8");
}

// A misbehaving member: all of its messages are refused and counted, and others are not disturbed.
TEST_P(Bulk, MalformedRequestsAreRefusedAndCountedByTheirNode) {
  const auto offer = server_->Offer("mesh", bytes_);
  ASSERT_TRUE(offer.has_value());
  const auto keys = KeysOf("viewer");
  zmq::context_t context;
  zmq::socket_t dealer(context, zmq::socket_type::dealer);
  dealer.set(zmq::sockopt::linger, 0);
  detail::GuardConnection(&dealer, keys, keys ? keys->PublicKeyOf("logic_node") : "");
  dealer.connect(offer->endpoint);
  dealer.send(zmq::str_buffer("no envelope"), zmq::send_flags::none);
  EXPECT_TRUE(Until([&] { return server_->num_refused() == 1; }));
  // Valid except for its length.
  const std::vector<char> large(detail::kMaxMessageBytes + 1);
  dealer.send(zmq::buffer(large), zmq::send_flags::none);
  EXPECT_TRUE(Until([&] { return server_->num_refused() == 2; }));
  BulkFetch fetch(*offer, "logic_node", reader_options_);
  EXPECT_TRUE(fetch.Run(kLong_ns).has_value());
  EXPECT_EQ(fetch.num_refused(), 0u);
  std::uint64_t num_refused = 0;
  for (const RefusalCount& refusal : owner_->counters().refusals)
    num_refused += refusal.reason == "bulk" ? refusal.count : 0;
  EXPECT_EQ(num_refused, 2u);
  EXPECT_GE(owner_->counters().refused, 2u);
}

TEST_P(Bulk, MalformedChunksAreRefusedAndReported) {
  const auto keys = KeysOf("logic_node");
  zmq::context_t context;
  zmq::socket_t owner(context, zmq::socket_type::router);
  owner.set(zmq::sockopt::linger, 0);
  if (keys) {
    owner.set(zmq::sockopt::curve_server, true);
    owner.set(zmq::sockopt::curve_secretkey, keys->own.secret_key);
  }
  owner.bind("tcp://127.0.0.1:*");
  BulkFetch fetch({"mesh", BulkHash(bytes_), bytes_.size(), owner.get(zmq::sockopt::last_endpoint)}, "logic_node",
                  reader_options_);
  std::string why;
  EXPECT_TRUE(Until([&] {
    const auto fetched = fetch.Run(1'000'000);
    if (!fetched) why = fetched.error().detail;
    zmq::message_t routing, request;
    while (owner.recv(routing, zmq::recv_flags::dontwait) && owner.recv(request, zmq::recv_flags::dontwait)) {
      owner.send(routing, zmq::send_flags::sndmore);
      owner.send(request, zmq::send_flags::none);  // the request itself comes back
    }
    return fetch.num_refused() >= 8 && !fetched;
  }));
  EXPECT_NE(why.find("were not chunks of a block"), std::string::npos) << why;
  EXPECT_EQ(fetch.account().received, 0u);
}

// A fetch accepts no connections, so it must not need the inproc address of an allow-list, which the previous one may
// still hold.
TEST_P(Bulk, AFetchMayChangeItsServerRepeatedly) {
  const auto offer = server_->Offer("mesh", bytes_);
  ASSERT_TRUE(offer.has_value());
  BulkFetch fetch(*offer, "logic_node", reader_options_);
  for (int i = 0; i < 200; ++i) {
    const auto fetched = fetch.Run(1);  // hardly time to connect
    if (!fetched) {
      ASSERT_NE(fetched.error().detail.find("chunks came within"), std::string::npos) << fetched.error().detail;
    }
    fetch.MoveTo(offer->endpoint);
  }
  const auto fetched = fetch.Run(kLong_ns);
  ASSERT_TRUE(fetched.has_value()) << fetched.error().detail;
  EXPECT_EQ(*fetched, bytes_);
}

INSTANTIATE_TEST_SUITE_P(Keys, Bulk, ::testing::Bool(),
                         [](const auto& with) { return with.param ? "Encrypted" : "InTheClear"; });

}  // namespace
}  // namespace bus
