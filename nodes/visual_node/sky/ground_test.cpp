#include "nodes/visual_node/sky/ground.hpp"

#include <gtest/gtest.h>

namespace visual_node {
namespace {

const std::uint8_t* At(const picture::Image& map, double longitude_deg, double latitude_deg) {
  return map.Pixel(static_cast<int>((longitude_deg + 180.0) / 360.0 * map.width),
                   static_cast<int>((90.0 - latitude_deg) / 180.0 * map.height));
}
bool IsLand(const Ground& ground, double longitude_deg, double latitude_deg) {
  return At(ground.colors, longitude_deg, latitude_deg)[3] == 255;
}

TEST(Ground, HasLandAndWaterWhereTheyAre) {
  const auto ground = ReadGround();
  ASSERT_TRUE(ground) << ground.error().detail;
  EXPECT_TRUE(IsLand(*ground, 10.0, 22.0)) << "Sahara";
  EXPECT_TRUE(IsLand(*ground, 134.0, -25.0)) << "Australia";
  EXPECT_TRUE(IsLand(*ground, -60.0, -5.0)) << "Amazonia";
  EXPECT_FALSE(IsLand(*ground, -150.0, 0.0)) << "Pacific";
  EXPECT_FALSE(IsLand(*ground, 18.0, 35.0)) << "Mediterranean";
  EXPECT_FALSE(IsLand(*ground, 50.5, 42.0)) << "Caspian Sea";
}

TEST(Ground, IsBrightInDesertsGreenInForestsAndWhiteInIce) {
  const auto ground = ReadGround();
  ASSERT_TRUE(ground);
  const std::uint8_t* desert = At(ground->colors, 10.0, 22.0);
  const std::uint8_t* forest = At(ground->colors, -60.0, -5.0);
  const std::uint8_t* ice = At(ground->colors, 60.0, -80.0);
  EXPECT_GT(desert[0], forest[0] + 80);
  EXPECT_GT(forest[1], forest[0]);
  EXPECT_GT(forest[1], forest[2]);
  EXPECT_GT(ice[2], 200);
}

TEST(Ground, HasLightsInTownsAndNoneInDesertsOrIce) {
  const auto ground = ReadGround();
  ASSERT_TRUE(ground);
  EXPECT_GT(At(ground->lights, -74.0, 40.7)[0], 60) << "New York";
  EXPECT_GT(At(ground->lights, 7.0, 51.5)[0], 60) << "Ruhr";
  EXPECT_EQ(At(ground->lights, 10.0, 22.0)[0], 0) << "Sahara";
  EXPECT_EQ(At(ground->lights, 60.0, -80.0)[0], 0) << "Antarctica";
}

}  // namespace
}  // namespace visual_node
