#include "tiles/frame.hpp"

#include <gtest/gtest.h>

#include "scene/load_scenario.hpp"
#include "view/scene_digest.hpp"
#include "view/scene_mirror.hpp"
#include "view/stereo.hpp"

namespace tiles {
namespace {

class FrameTest : public testing::Test {
 protected:
  void SetUp() override {
    const auto scenario =
        scene::LoadScenario(std::filesystem::path(VR_OOS_SOURCE_DIR) / "scenarios/module_replacement");
    ASSERT_TRUE(scenario);
    rest_ = view::SceneMirror(*scenario).scene();
    moved_ = rest_;
    for (std::size_t i = 0; i < moved_.instances.size(); ++i) {
      moved_.instances[i].X_WM.translation += glm::dvec3(1e-9 * static_cast<double>(i), 0.25, -0.125);
      moved_.instances[i].is_visible = i % 3 != 0;
      moved_.instances[i].material.emissive = glm::vec3(0.5f);
    }
    for (view::Sheet& sheet : moved_.sheets) {
      for (glm::vec3& p_W : sheet.p_W) p_W += glm::vec3(0.5f);
    }
    for (view::Lamp& lamp : moved_.lamps) lamp.color = glm::vec3(0.75f, 0.5f, 0.25f);
    view::MoveSkins(&moved_);
  }
  [[nodiscard]] static core::RayFrame FrameOf(const view::Scene& scene) {
    return EncodeFrame(scene, view::LightOf(scene.space), view::PlaceCamera(scene.assets->cameras[0], scene), 320, 180);
  }

  view::Scene rest_, moved_;
};

TEST_F(FrameTest, PutsThingsExactlyWhereTheyWere) {
  view::Scene scene = rest_;
  ASSERT_FALSE(rest_.sheets.empty());
  ASSERT_TRUE(ApplyFrame(FrameOf(moved_), &scene));
  EXPECT_EQ(view::SceneDigest(scene), view::SceneDigest(moved_));
  for (std::size_t i = 0; i < scene.instances.size(); ++i) {
    EXPECT_EQ(scene.instances[i].X_WM.translation, moved_.instances[i].X_WM.translation) << "not rounded";
    EXPECT_EQ(scene.instances[i].is_visible, moved_.instances[i].is_visible);
    EXPECT_EQ(scene.instances[i].material.emissive, moved_.instances[i].material.emissive);
  }
  EXPECT_EQ(LightOf(FrameOf(moved_)), view::LightOf(moved_.space));
}

// Both eyes before a wall: neither axis goes through the middle of the picture.
TEST_F(FrameTest, KeepsWhatEachEyeSees) {
  view::Viewing viewing;
  viewing.stereo = view::Stereo::kTopBottom;
  viewing.screen_R = view::Screen{{-1.0, 1.0, -0.5}, {0.5, 1.2, -0.5}, {-1.0, 1.0, 1.0}};
  const auto eyes = view::FrustaOf(viewing, view::PlaceCamera(rest_.assets->cameras[0], rest_), 320, 180);
  const std::vector<Tile> places = StackParts({{320, 90}, {160, 90}});
  EXPECT_EQ(places, (std::vector<Tile>{{0, 0, 320, 90}, {0, 90, 160, 90}}));
  const core::RayFrame frame =
      EncodeFrame(rest_, view::LightOf(rest_.space), {{eyes[0], places[0]}, {eyes[1], places[1]}});
  EXPECT_EQ(frame.width, 320u);
  EXPECT_EQ(frame.height, 180u);
  const std::vector<SeenPart> parts = PartsOf(frame);
  ASSERT_EQ(parts.size(), 2u);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(parts[i].at, places[i]);
    const glm::dvec3 p_W = eyes[i].eye_W + eyes[i].R_WE * glm::dvec3(0.3, -0.2, -2.0);
    const glm::dvec3 expected = view::ProjectToPixel(eyes[i], 320, 90, p_W);
    EXPECT_LT(glm::distance(view::ProjectToPixel(parts[i].eye, 320, 90, p_W), expected), 1e-4);
  }
}

TEST_F(FrameTest, APartOutsideThePictureIsRefused) {
  core::RayFrame frame = FrameOf(moved_);
  frame.eyes[0].x_px = 1;
  view::Scene scene = rest_;
  EXPECT_FALSE(ApplyFrame(frame, &scene));
  frame.eyes[0].x_px = 0;
  frame.eyes[0].right = frame.eyes[0].left;
  EXPECT_FALSE(ApplyFrame(frame, &scene)) << "no width";
  EXPECT_EQ(view::SceneDigest(scene), view::SceneDigest(rest_)) << "unchanged";
}

TEST_F(FrameTest, GoesBackToAnEarlierFrame) {
  view::Scene scene = rest_;
  ASSERT_TRUE(ApplyFrame(FrameOf(moved_), &scene));
  ASSERT_TRUE(ApplyFrame(FrameOf(rest_), &scene));
  EXPECT_EQ(view::SceneDigest(scene), view::SceneDigest(rest_));
}

TEST_F(FrameTest, OfAnotherScenarioIsRefused) {
  view::Scene other = moved_;
  other.instances.pop_back();
  view::Scene scene = rest_;
  EXPECT_FALSE(ApplyFrame(FrameOf(other), &scene));
  core::RayFrame frame = FrameOf(moved_);
  frame.nodes_W.pop_back();
  EXPECT_FALSE(ApplyFrame(frame, &scene));
  frame = FrameOf(moved_);
  frame.lamps.push_back({static_cast<std::uint32_t>(moved_.instances.size()), glm::vec3(1.0f)});
  EXPECT_FALSE(ApplyFrame(frame, &scene));
  EXPECT_EQ(view::SceneDigest(scene), view::SceneDigest(rest_));
}

TEST_F(FrameTest, DigestsDifferWhereAPictureDoes) {
  const std::uint64_t digest = FrameDigest(FrameOf(rest_));
  EXPECT_EQ(FrameDigest(FrameOf(rest_)), digest);
  EXPECT_NE(FrameDigest(FrameOf(moved_)), digest);
  view::Scene lit = rest_;
  ASSERT_FALSE(lit.lamps.empty());
  lit.lamps[0].color += glm::vec3(0.1f);
  EXPECT_NE(FrameDigest(FrameOf(lit)), digest);
  core::RayFrame numbered = FrameOf(rest_);
  numbered.frame = 77;
  numbered.sample = 5;
  EXPECT_EQ(FrameDigest(numbered), digest) << "the same picture, again";
}

}  // namespace
}  // namespace tiles
