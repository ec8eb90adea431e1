// Scenes and times as they were drawn when their pictures were stored (golden_views/). Made anew, when pictures change
// on purpose: VR_OOS_MAKE_GOLDEN_VIEWS=1 xvfb-run -a visual_node_lib_test --gtest_filter='*GoldenViews*'

#include <gtest/gtest.h>

#include <cstdlib>
#include <map>

#include "nodes/visual_node/renderer.hpp"
#include "nodes/visual_node/still.hpp"
#include "nodes/visual_node/testing/gl_test.hpp"
#include "nodes/visual_node/testing/read_png.hpp"
#include "picture/flip.hpp"
#include "scene/load_scenario.hpp"
#include "view/scene_mirror.hpp"

namespace visual_node {
namespace {

// Mean over all pixels. An object of another colour is above it (ConformanceTest.AnotherColourIsNoticed).
constexpr double kMostFlip = 0.02;

struct GoldenView {
  const char* scenario;
  const char* camera;  // empty: the first
  int minutes;         // after the scenario's epoch, of an orbit of about 92
};

std::string NameOf(const GoldenView& golden) {
  return std::string(golden.scenario) + (*golden.camera == '\0' ? "" : "_") + golden.camera + "_" +
         std::to_string(golden.minutes);
}

class GoldenViews : public GlTest, public testing::WithParamInterface<GoldenView> {
 protected:
  static void TearDownTestSuite() { renderers_.clear(); }

  core::Result<Image> DrawView() {
    const std::filesystem::path root = VR_OOS_SOURCE_DIR;
    auto scenario = scene::LoadScenario((root / "scenarios" / GetParam().scenario / "scenario.xml").string());
    if (!scenario) return core::Fail(core::ErrorCode::kInvalidInput, scenario.error().front().what);
    const view::SceneMirror mirror(*scenario);
    view::Scene scene = mirror.scene();
    // Only the surroundings move: parts stand as the scenario begins.
    scene.space = space::Observer(scenario->place).At(60.0 * GetParam().minutes);
    std::unique_ptr<Renderer>& renderer = renderers_[GetParam().scenario];
    if (renderer == nullptr) {
      auto made = Renderer::Create(scene, [](const std::filesystem::path& file) { return vps::LoadVisualMesh(file); });
      if (!made) return tl::unexpected(made.error());
      renderer = std::move(*made);
    }
    return RenderSmooth(*renderer, scene, view::CameraFor(*scene.assets, GetParam().camera, ""), 320, 180);
  }

  static inline std::map<std::string, std::unique_ptr<Renderer>> renderers_;  // by scenario
};

TEST_P(GoldenViews, LookAsTheyDidWhenTheyWereStored) {
  const auto image = DrawView();
  ASSERT_TRUE(image) << image.error().detail;
  const std::filesystem::path file = std::filesystem::path(VR_OOS_SOURCE_DIR) / "nodes" / "visual_node" /
                                     "golden_views" / (NameOf(GetParam()) + ".png");
  if (std::getenv("VR_OOS_MAKE_GOLDEN_VIEWS") != nullptr) {
    ASSERT_TRUE(WritePng(*image, file));
  }
  if (!std::filesystem::exists(file))
    GTEST_SKIP() << file << " is not stored; the head of this test says how it is made";
  const Image stored = ReadPng(file);
  ASSERT_EQ(stored.width, image->width) << file;
  const double flip = picture::Mean(picture::Flip(stored, *image));
  RecordProperty("flip", std::to_string(flip));
  EXPECT_LE(flip, kMostFlip);
}

INSTANTIATE_TEST_SUITE_P(
    Orbit, GoldenViews,
    testing::Values(GoldenView{"module_replacement", "overview", 0}, GoldenView{"module_replacement", "overview", 25},
                    GoldenView{"module_replacement", "overview", 50}, GoldenView{"module_replacement", "cavity", 0},
                    GoldenView{"module_replacement", "switch_off", 50}, GoldenView{"service_robot", "", 0},
                    GoldenView{"service_robot", "", 25}, GoldenView{"peg_in_hole", "", 0},
                    GoldenView{"peg_in_hole", "", 70}, GoldenView{"touch", "", 0}, GoldenView{"touch", "", 50},
                    GoldenView{"free_collision", "", 25}),
    [](const auto& golden) { return NameOf(golden.param); });

}  // namespace
}  // namespace visual_node
