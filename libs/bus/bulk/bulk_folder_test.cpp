#include "bus/bulk/bulk_folder.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>

#include "bus/testing/make_node.hpp"

namespace bus {
namespace {

namespace fs = std::filesystem;

class BulkFolder : public ::testing::Test {
 protected:
  void SetUp() override {
    fs::create_directories(root_ / "from/meshes");
    Write("from/scenario.xml", "<scenario/>");
    Write("from/meshes/module.obj", std::string(200'000, 'v'));
    Write("from/meshes/empty.obj", "");
    registry_ = testing::MakeRegistry();
    owner_options_ = Options("logic_node");
    owner_ = std::move(*Node::Create(owner_options_));
    server_ = std::move(*BulkServer::Create(owner_.get(), owner_options_));
    ASSERT_TRUE(owner_->Start().has_value());
    reader_options_ = Options("viewer");
    reader_ = std::move(*Node::Create(reader_options_));
    offers_ = &reader_->ReadState<BulkOffer>(BulkTopic("logic_node"));
    ASSERT_TRUE(reader_->Start().has_value());
  }
  void TearDown() override {
    testing::ExpectAccountsClose({owner_.get(), reader_.get()});
    fs::remove_all(root_);
  }
  NodeOptions Options(const std::string& name) const {
    NodeOptions options;
    options.name = name;
    options.registry = registry_->endpoint();
    options.session = 7;
    options.is_encrypted = false;
    return options;
  }
  void Write(const std::string& path, const std::string& text) const { std::ofstream(root_ / path) << text; }
  std::string Read(const std::string& path) const {
    std::ifstream file(root_ / path);
    return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  }
  core::Result<std::size_t> Fetch(std::int64_t timeout_ns = testing::kLong_ns) {
    return FetchFolder(reader_.get(), *offers_, reader_options_, "logic_node", "scenario", root_ / "to", timeout_ns);
  }
  const fs::path root_ = fs::temp_directory_path() / ("bulk_folder_" + std::to_string(getpid()));
  std::unique_ptr<Registry> registry_;
  NodeOptions owner_options_, reader_options_;
  std::unique_ptr<Node> owner_, reader_;
  std::unique_ptr<BulkServer> server_;
  const StateReader<BulkOffer>* offers_ = nullptr;
};

TEST_F(BulkFolder, ArrivesUnchangedAndTransfersOnlyMissingFiles) {
  ASSERT_TRUE(OfferFolder(root_ / "from", "scenario", server_.get()).has_value());
  const auto fetched = Fetch();
  ASSERT_TRUE(fetched.has_value()) << fetched.error().detail;
  EXPECT_EQ(*fetched, 3u);
  for (const std::string file : {"scenario.xml", "meshes/module.obj", "meshes/empty.obj"}) {
    EXPECT_TRUE(fs::exists(root_ / "to" / file));
    EXPECT_EQ(Read("to/" + file), Read("from/" + file)) << file;
  }
  const std::uint64_t before = server_->num_chunks();
  Write("to/scenario.xml", "damaged");
  ASSERT_TRUE(Fetch().has_value());
  EXPECT_EQ(Read("to/scenario.xml"), "<scenario/>");
  EXPECT_EQ(server_->num_chunks(), before + 2);  // the list, and the one file
}

TEST_F(BulkFolder, APathThatLeavesTheFolderIsRefused) {
  for (const std::string path : {"../outside", "/tmp/outside", "meshes/../../outside"}) {
    const std::string list = path + "\n";
    ASSERT_TRUE(server_->Offer("scenario/" + path, {1, 2, 3}).has_value());
    ASSERT_TRUE(server_->Offer("scenario", {list.begin(), list.end()}).has_value());
    const std::string hash = BulkHash({reinterpret_cast<const std::uint8_t*>(list.data()), list.size()});
    ASSERT_TRUE(testing::Until([&] {
      testing::WaitBriefly(*reader_);
      return offers_->values().count("scenario") == 1 && offers_->values().at("scenario").hash == hash;
    }));
    const auto fetched = Fetch();
    ASSERT_FALSE(fetched.has_value());
    EXPECT_NE(fetched.error().detail.find("leaves its folder"), std::string::npos) << fetched.error().detail;
  }
}

TEST_F(BulkFolder, AMissingOfferIsNamed) {
  const auto fetched = Fetch(core::kNanosecondsPerSecond / 10);
  ASSERT_FALSE(fetched.has_value());
  EXPECT_NE(fetched.error().detail.find("does not offer 'scenario'"), std::string::npos) << fetched.error().detail;
}

}  // namespace
}  // namespace bus
