#include "tools/oos/attach/places.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstdlib>
#include <fstream>
#include <iterator>

namespace oos {
namespace {

namespace fs = std::filesystem;

constexpr const char* kNote = R"({"registry": "tcp://127.0.0.1:1"})";

class SessionNotes : public testing::Test {
 protected:
  void SetUp() override {
    std::string name = testing::TempDir() + "places-XXXXXX";
    ASSERT_NE(mkdtemp(name.data()), nullptr);
    root_ = name;
    if (const char* before = std::getenv("XDG_RUNTIME_DIR")) before_ = before;
    setenv("XDG_RUNTIME_DIR", root_.c_str(), 1);
  }
  void TearDown() override {
    if (before_.empty()) {
      unsetenv("XDG_RUNTIME_DIR");
    } else {
      setenv("XDG_RUNTIME_DIR", before_.c_str(), 1);
    }
    fs::remove_all(root_);
  }
  static void ExpectRefused() {
    const auto written = WriteSessionNote(kNote);
    ASSERT_FALSE(written.has_value());
    EXPECT_NE(written.error().detail.find("vr_oos is not a directory (no link) of this user alone"), std::string::npos)
        << written.error().detail;
    const auto read = ReadSessionNote();
    ASSERT_FALSE(read.has_value());
    EXPECT_EQ(read.error().detail, written.error().detail);
  }
  static mode_t ModeOf(const fs::path& path) {
    struct stat info {};
    stat(path.c_str(), &info);
    return info.st_mode & 0777;
  }
  static std::string TextOf(const fs::path& path) {
    std::ifstream file(path);
    return {std::istreambuf_iterator<char>(file), {}};
  }
  fs::path root_;
  std::string before_;
};

TEST_F(SessionNotes, AreThisUsersAlone) {
  EXPECT_EQ(ReadSessionNote().error().code, core::ErrorCode::kNotFound);
  ASSERT_TRUE(WriteSessionNote("an older one, and longer than the next").has_value());
  const auto written = WriteSessionNote(kNote);
  ASSERT_TRUE(written.has_value()) << written.error().detail;
  EXPECT_EQ(ReadSessionNote().value(), kNote);
  EXPECT_EQ(ModeOf(SessionFolder()), 0700u);
  EXPECT_EQ(ModeOf(SessionFile()), 0600u);
  EXPECT_EQ(std::distance(fs::directory_iterator(SessionFolder()), fs::directory_iterator()), 1);
}

TEST_F(SessionNotes, AreNotLeftWhereOthersMayWrite) {
  fs::create_directory(SessionFolder());
  fs::permissions(SessionFolder(), fs::perms(0770));
  ExpectRefused();
}

TEST_F(SessionNotes, CloseAFolderThatAnEarlierVersionLeftOpen) {
  fs::create_directory(SessionFolder());
  fs::permissions(SessionFolder(), fs::perms(0755));
  EXPECT_EQ(ReadSessionNote().error().code, core::ErrorCode::kInvalidInput);
  ASSERT_TRUE(WriteSessionNote(kNote).has_value());
  EXPECT_EQ(ModeOf(SessionFolder()), 0700u);
  EXPECT_EQ(ReadSessionNote().value(), kNote);
}

TEST_F(SessionNotes, DoNotFollowALinkInTheFoldersPlace) {
  fs::create_directory(root_ / "elsewhere");
  fs::permissions(root_ / "elsewhere", fs::perms(0700));
  fs::create_symlink("elsewhere", SessionFolder());
  ExpectRefused();
  EXPECT_TRUE(fs::is_empty(root_ / "elsewhere"));
}

TEST_F(SessionNotes, DoNotFollowALinkInTheFilesPlace) {
  std::ofstream(root_ / "precious") << "precious";
  ASSERT_EQ(mkdir(SessionFolder().c_str(), 0700), 0);
  fs::create_symlink(root_ / "precious", SessionFile());
  const fs::path fresh = SessionFile().string() + "." + std::to_string(getpid());
  fs::create_symlink(root_ / "precious", fresh);
  ASSERT_TRUE(WriteSessionNote(kNote).has_value());
  EXPECT_EQ(TextOf(root_ / "precious"), "precious");
  EXPECT_EQ(ReadSessionNote().value(), kNote);
}

TEST_F(SessionNotes, AreNotLeftInAnotherUsersFolder) {
  if (geteuid() != 0) GTEST_SKIP() << "only root can give a folder away";
  constexpr uid_t kStranger = 65534;
  ASSERT_EQ(mkdir(SessionFolder().c_str(), 0700), 0);
  ASSERT_EQ(chown(SessionFolder().c_str(), kStranger, kStranger), 0);
  ExpectRefused();
}

}  // namespace
}  // namespace oos
