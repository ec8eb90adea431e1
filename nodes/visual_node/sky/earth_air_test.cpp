#include "nodes/visual_node/sky/earth_air.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <thread>

namespace visual_node {
namespace {

class EarthAir : public testing::Test {
 protected:
  void SetUp() override {
    if (const char* before = std::getenv("VR_OOS_CACHE")) before_ = before;
    std::filesystem::remove_all(folder_);
    setenv("VR_OOS_CACHE", folder_.c_str(), 1);
  }
  void TearDown() override {
    std::filesystem::remove_all(folder_);
    before_.empty() ? unsetenv("VR_OOS_CACHE") : setenv("VR_OOS_CACHE", before_.c_str(), 1);
  }

  std::filesystem::path folder_ = std::filesystem::path(testing::TempDir()) / "earth_air_test";
  std::string before_;
  space::AirTableSizes small_{16, 8, 4, 16, 8, 4, 8, 4, 2};
};

TEST_F(EarthAir, IsComputedInTheBackgroundAndIsInTheCacheThen) {
  const auto missing = CachedAir(small_);
  ASSERT_FALSE(missing);
  EXPECT_NE(missing.error().detail.find("oos atmosphere"), std::string::npos) << missing.error().detail;
  AirInWork work(small_);
  auto air = work.Take();
  while (!air) {
    std::this_thread::yield();
    air = work.Take();
  }
  EXPECT_FALSE(work.Take());
  const auto cached = CachedAir(small_);
  ASSERT_TRUE(cached) << cached.error().detail;
  EXPECT_EQ(cached->scattering, air->scattering);
  EXPECT_EQ(cached->ground_light, air->ground_light);
}

TEST_F(EarthAir, AViewerThatEndsDoesNotWaitForTheWholeWork) {
  const auto begin = std::chrono::steady_clock::now();
  { const AirInWork work; }  // of the full size: half a minute
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(15));
  EXPECT_FALSE(CachedAir());
}

}  // namespace
}  // namespace visual_node
