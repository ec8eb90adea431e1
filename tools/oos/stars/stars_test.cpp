#include <gtest/gtest.h>

#include <filesystem>

#include "tools/oos/stars/verbs.hpp"

namespace oos {
namespace {

TEST(Stars, WithoutThePackageItSaysWhatIsMissing) {
  const std::filesystem::path out = std::filesystem::path(testing::TempDir()) / "none.stars";
  testing::internal::CaptureStderr();
  EXPECT_EQ(RunVerbs({StarsVerb()}, {"stars", "--index", "/nowhere/index.fits", "--out", out.string()}), kBadUsage);
  const std::string complaint = testing::internal::GetCapturedStderr();
  EXPECT_NE(complaint.find("apt-get install astrometry-data-tycho2-07-littleendian"), std::string::npos) << complaint;
  EXPECT_FALSE(std::filesystem::exists(out));
}

}  // namespace
}  // namespace oos
