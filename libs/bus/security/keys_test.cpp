#include "bus/security/keys.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <fstream>

#include "bus/security/session_key.hpp"

namespace bus {
namespace {

class KeyDirectory : public ::testing::Test {
 protected:
  void SetUp() override {
    std::string name = ::testing::TempDir() + "keys-XXXXXX";
    ASSERT_NE(mkdtemp(name.data()), nullptr);
    folder_ = name;
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  static mode_t ModeOf(const std::filesystem::path& path) {
    struct stat info {};
    stat(path.c_str(), &info);
    return info.st_mode & 0777;
  }
  std::filesystem::path folder_;
};

TEST_F(KeyDirectory, IsPrivateAndGivesEveryMemberItsOwnKey) {
  const auto keys = folder_ / "run" / "keys";
  ASSERT_TRUE(MakeKeys(keys, {"physics_node", "oos"}).has_value());
  EXPECT_EQ(ModeOf(keys), 0700u);
  for (const char* file : {"allowed", "registry.key", "physics_node.key", "oos.key"})
    EXPECT_EQ(ModeOf(keys / file), 0600u);
  const auto registry = LoadKeys(keys, "registry");
  const auto physics = LoadKeys(keys, "physics_node");
  ASSERT_TRUE(registry.has_value() && physics.has_value());
  EXPECT_EQ(registry->allowed.size(), 3u);
  EXPECT_EQ(registry->allowed, physics->allowed);
  EXPECT_EQ(physics->PublicKeyOf("registry"), registry->own.public_key);
  EXPECT_NE(physics->own.secret_key, registry->own.secret_key);
}

TEST_F(KeyDirectory, KeepsTheKeysThatAreThereWhenMembersAreAdded) {
  const auto keys = folder_ / "keys";
  ASSERT_TRUE(MakeKeys(keys, {"a"}).has_value());
  const auto before = LoadKeys(keys, "a");
  ASSERT_TRUE(MakeKeys(keys, {"a", "b"}).has_value());
  const auto after = LoadKeys(keys, "a");
  ASSERT_TRUE(before.has_value() && after.has_value());
  EXPECT_EQ(after->own.secret_key, before->own.secret_key);
  EXPECT_EQ(after->allowed.size(), 3u);
}

TEST_F(KeyDirectory, ANameMayHaveASuffixAfterADash) {
  const auto keys = folder_ / "keys";
  ASSERT_TRUE(MakeKeys(keys, {"oos"}).has_value());
  const auto found = LoadKeys(keys, "oos-topic-echo-4711");
  ASSERT_TRUE(found.has_value()) << found.error().detail;
  EXPECT_EQ(found->own_name, "oos");
  EXPECT_TRUE(IsKeyFor("oos", "oos"));
  EXPECT_TRUE(IsKeyFor("oos", "oos-top-1"));
  EXPECT_FALSE(IsKeyFor("oos", "oosphere"));
  EXPECT_FALSE(IsKeyFor("oos-top", "oos"));
  const auto missing = LoadKeys(keys, "physics_node");
  ASSERT_FALSE(missing.has_value());
  EXPECT_NE(missing.error().detail.find("physics_node.key"), std::string::npos) << missing.error().detail;
}

TEST_F(KeyDirectory, IsRefusedWhenOthersCanReadIt) {
  const auto keys = folder_ / "keys";
  ASSERT_TRUE(MakeKeys(keys, {"a"}).has_value());
  for (const auto& path : {keys, keys / "allowed", keys / "a.key"}) {
    const mode_t before = ModeOf(path);
    chmod(path.c_str(), before | 040);
    const auto loaded = LoadKeys(keys, "a");
    ASSERT_FALSE(loaded.has_value()) << path;
    EXPECT_NE(loaded.error().detail.find("can be read by others"), std::string::npos) << loaded.error().detail;
    chmod(path.c_str(), before);
  }
  EXPECT_TRUE(LoadKeys(keys, "a").has_value());
}

TEST_F(KeyDirectory, IsRefusedWhenItBelongsToAnotherUser) {
  if (geteuid() != 0) {  // without root: "/" belongs to another user
    const auto loaded = LoadKeys("/", "a");
    ASSERT_FALSE(loaded.has_value());
    EXPECT_NE(loaded.error().detail.find("belongs to user 0"), std::string::npos) << loaded.error().detail;
    return;
  }
  constexpr uid_t kStranger = 65534;
  const auto keys = folder_ / "keys";
  ASSERT_TRUE(MakeKeys(keys, {"a"}).has_value());
  for (const auto& path : {keys, keys / "allowed", keys / "a.key"}) {
    ASSERT_EQ(chown(path.c_str(), kStranger, kStranger), 0);
    const auto loaded = LoadKeys(keys, "a");
    ASSERT_FALSE(loaded.has_value()) << path;
    EXPECT_NE(loaded.error().detail.find(path.string() + " belongs to user 65534"), std::string::npos)
        << loaded.error().detail;
    ASSERT_EQ(chown(path.c_str(), 0, 0), 0);
  }
  EXPECT_TRUE(LoadKeys(keys, "a").has_value());
}

TEST_F(KeyDirectory, DamagedFilesAreNamed) {
  const auto keys = folder_ / "keys";
  ASSERT_TRUE(MakeKeys(keys, {"a"}).has_value());
  std::ofstream(keys / "a.key") << "too short\n";
  const auto loaded = LoadKeys(keys, "a");
  ASSERT_FALSE(loaded.has_value());
  EXPECT_NE(loaded.error().detail.find("a.key is damaged"), std::string::npos) << loaded.error().detail;
  std::ofstream(keys / "allowed", std::ios::app) << "not a key\n";
  const auto listed = LoadKeys(keys, "registry");
  ASSERT_FALSE(listed.has_value());
  EXPECT_NE(listed.error().detail.find("allowed is damaged"), std::string::npos) << listed.error().detail;
}

// Computed with Python: hmac.new(bytes(32), b"VR-OOS session" + (7).to_bytes(8, "little"), "sha256").
TEST(SessionKey, IsAnHmacThatOthersCanCompute) {
  const std::string zero_key(40, '0');
  const std::string key = detail::DeriveSessionKey(zero_key, 7);
  std::string hex;
  for (const char byte : key) {
    constexpr const char* kDigits = "0123456789abcdef";
    hex += kDigits[(static_cast<unsigned char>(byte)) >> 4];
    hex += kDigits[static_cast<unsigned char>(byte) & 15];
  }
  EXPECT_EQ(hex, "8e1b9ab39f4b987a4f4de7d6b054a6cb9dd1cd8bbeb47e28113dfb18fbb06a1a");
  EXPECT_NE(detail::DeriveSessionKey(zero_key, 8), key);
}

}  // namespace
}  // namespace bus
