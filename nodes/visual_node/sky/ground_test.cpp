#include "nodes/visual_node/sky/ground.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "nodes/visual_node/sky/fine_structure.hpp"

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

TEST(Ground, HasCloudsOverAFairShareOfTheEarthAndNoneOverTheSahara) {
  const auto ground = ReadGround();
  ASSERT_TRUE(ground);
  double hidden = 0.0, whole = 0.0;
  for (int row = 0; row < ground->clouds.height; ++row) {
    const double area = std::cos((0.5 - (row + 0.5) / ground->clouds.height) * std::numbers::pi);
    for (int column = 0; column < ground->clouds.width; ++column) {
      hidden += area * ground->clouds.Pixel(column, row)[0] / 255.0;
      whole += area;
    }
  }
  EXPECT_GT(hidden / whole, 0.1);
  EXPECT_LT(hidden / whole, 0.4);
  EXPECT_LT(At(ground->clouds, 10.0, 22.0)[0], 40);
}

TEST(Ground, HasFineStructureThatRepeatsWithoutASeamAndDarkensNothing) {
  const std::vector<std::uint8_t> bytes = FineStructure();
  const auto at = [&](int x, int y, int z, std::size_t channel) {
    const auto index =
        static_cast<std::size_t>((z % kFineSize * kFineSize + y % kFineSize) * kFineSize + x % kFineSize);
    return static_cast<int>(bytes[2 * index + channel]);
  };
  for (const std::size_t channel : {0u, 1u}) {
    double sum = 0.0, within = 0.0, across = 0.0;
    for (int z = 0; z < kFineSize; ++z) {
      for (int y = 0; y < kFineSize; ++y) {
        for (int x = 0; x < kFineSize; ++x) sum += at(x, y, z, channel);
        within += std::abs(at(31, y, z, channel) - at(32, y, z, channel));
        across += std::abs(at(kFineSize - 1, y, z, channel) - at(kFineSize, y, z, channel));
      }
    }
    EXPECT_NEAR(sum / std::pow(kFineSize, 3), 127.5, 2.0);
    EXPECT_LT(across, 1.5 * within);
  }
}

TEST(Ground, HalvedFineStructureHasTheMeansOfEightPoints) {
  std::vector<std::uint8_t> bytes;
  for (int i = 0; i < 4 * 4 * 4; ++i) {
    bytes.push_back(static_cast<std::uint8_t>(i % 2 == 0 ? 10 : 20));                         // changes along x
    bytes.push_back(static_cast<std::uint8_t>(i < 2 * 4 * 4 ? 100 : (i / 16 == 2 ? 0 : 7)));  // changes along z
  }
  const std::vector<std::uint8_t> halved = HalveFine(bytes, 4);
  ASSERT_EQ(halved.size(), 2u * 8u);
  for (std::size_t i = 0; i < 8; ++i) {
    EXPECT_EQ(halved[2 * i], 15);
    EXPECT_EQ(halved[2 * i + 1], i < 4 ? 100 : 4);
  }
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
