#include "bus/bulk.hpp"

#include <gtest/gtest.h>

#include <numeric>

#include "bus/bus_testing.hpp"

namespace bus {
namespace {

using testing::kLong_ns;
using testing::MakeRegistry;
using testing::Until;
using testing::WaitBriefly;

std::vector<std::uint8_t> MakeBytes(std::size_t size) {
  std::vector<std::uint8_t> bytes(size);
  for (std::size_t i = 0; i < size; ++i) bytes[i] = static_cast<std::uint8_t>((i * 2'654'435'761u) >> 24);
  return bytes;
}

class Bulk : public ::testing::Test {
 protected:
  static NodeOptions Options(const std::string& name, const std::string& registry) {
    NodeOptions options;
    options.name = name;
    options.registry = registry;
    options.session = 7;
    options.is_encrypted = false;
    return options;
  }
  void SetUp() override {
    registry_ = MakeRegistry();
    owner_options_ = Options("logic_node", registry_->endpoint());
    reader_options_ = Options("viewer", registry_->endpoint());
    StartOwner();
  }
  void TearDown() override { testing::ExpectAccountsClose({owner_.get()}); }
  void StartOwner() {
    owner_ = std::move(*Node::Create(owner_options_));
    auto server = BulkServer::Create(owner_.get(), owner_options_);
    ASSERT_TRUE(server.has_value()) << server.error().detail;
    server_ = std::move(*server);
    ASSERT_TRUE(owner_->Start().has_value());
  }
  std::unique_ptr<Registry> registry_;
  NodeOptions owner_options_, reader_options_;
  std::unique_ptr<Node> owner_;
  std::unique_ptr<BulkServer> server_;
  const std::vector<std::uint8_t> bytes_ = MakeBytes(3'000'001);  // 46 chunks
};

TEST_F(Bulk, WhatIsOfferedIsFoundByNameAndFetchedByContent) {
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

TEST_F(Bulk, GoesOnWhereItWasWithTheOwnersNextLife) {
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

TEST_F(Bulk, ContentIsWhatItsHashSaysOrRefused) {
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
  EXPECT_NE(cut.error().detail.find("not what its hash says"), std::string::npos) << cut.error().detail;
  BulkOffer huge = *offer;
  huge.size = kMaxBulkBytes + 1;
  EXPECT_FALSE(BulkFetch(huge, "logic_node", reader_options_).Run(kLong_ns).has_value());
  // New content under an old name: the old is gone.
  ASSERT_TRUE(server_->Offer("mesh", MakeBytes(10)).has_value());
  EXPECT_FALSE(BulkFetch(*offer, "logic_node", reader_options_).Run(kLong_ns).has_value());
  // RFC 7693, appendix A is for 512 bits; this is the first 256-bit vector of the reference implementation's b2sum.
  EXPECT_EQ(BulkHash({}), "0e5751c026e543b2e8ab2eb06099daa1d1e5df47778f7787faab45cdf12fe3a8");
}

}  // namespace
}  // namespace bus
