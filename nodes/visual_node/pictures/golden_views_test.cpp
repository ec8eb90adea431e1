// Scenes and times as they were drawn when their pictures were stored (golden_views/). Made anew, when pictures change
// on purpose: VR_OOS_MAKE_GOLDEN_VIEWS=1 xvfb-run -a visual_node_lib_test --gtest_filter='*GoldenViews*'
//
// The pictures depend on no cache: the stars are those of the committed catalogue, and the air is computed here, from
// small tables (kAirSizes), in a second or two instead of half a minute.

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include "nodes/visual_node/draw/renderer.hpp"
#include "nodes/visual_node/pictures/still.hpp"
#include "nodes/visual_node/testing/gl_test.hpp"
#include "nodes/visual_node/testing/read_png.hpp"
#include "picture/flip.hpp"
#include "scene/load_scenario.hpp"
#include "view/scene_mirror.hpp"

namespace visual_node {
namespace {

// Mean over all pixels. An object of another colour is above it (ConformanceTest.AnotherColourIsNoticed).
constexpr double kMostFlip = 0.02;

constexpr space::AirTableSizes kAirSizes{.transmittance_mu = 128,
                                         .transmittance_r = 32,
                                         .r = 16,
                                         .mu = 64,
                                         .mu_s = 32,
                                         .nu = 4,
                                         .irradiance_mu_s = 32,
                                         .irradiance_r = 8,
                                         .num_orders = 3};

struct GoldenView {
  const char* scenario;
  const char* camera;   // empty: the first
  int along_deg = 0;    // how much farther along its orbit the scenario begins: another sun over the same Earth
  int altitude_km = 0;  // 0: the scenario's own
};

std::string NameOf(const GoldenView& golden) {
  return std::string(golden.scenario) + (*golden.camera == '\0' ? "" : "_") + golden.camera + "_" +
         std::to_string(golden.along_deg) + (golden.altitude_km == 0 ? "" : "_low");
}

class GoldenViews : public GlTest, public testing::WithParamInterface<GoldenView> {
 protected:
  // An empty cache, so that no larger catalogue of stars is found.
  static void SetUpTestSuite() {
    if (const char* cache = std::getenv("VR_OOS_CACHE")) cache_before_ = cache;
    const auto empty = std::filesystem::path(testing::TempDir()) / "golden_views_cache";
    setenv("VR_OOS_CACHE", empty.c_str(), 1);
  }
  static void TearDownTestSuite() {
    renderers_.clear();
    cache_before_ ? setenv("VR_OOS_CACHE", cache_before_->c_str(), 1) : unsetenv("VR_OOS_CACHE");
  }

  core::Result<Image> DrawView() {
    const std::filesystem::path root = VR_OOS_SOURCE_DIR;
    auto scenario = scene::LoadScenario((root / "scenarios" / GetParam().scenario / "scenario.xml").string());
    if (!scenario) return core::Fail(core::ErrorCode::kInvalidInput, scenario.error().front().what);
    space::Orbit& orbit = scenario->place.orbit;
    orbit.argument_rad += glm::radians(static_cast<double>(GetParam().along_deg));
    if (GetParam().altitude_km != 0) orbit.altitude_m = 1e3 * GetParam().altitude_km;
    const view::SceneMirror mirror(*scenario);
    const view::Scene& scene = mirror.scene();
    std::unique_ptr<Renderer>& renderer = renderers_[GetParam().scenario];
    if (renderer == nullptr) {
      auto made = Renderer::Create(scene, [](const std::filesystem::path& file) { return vps::LoadVisualMesh(file); });
      if (!made) return tl::unexpected(made.error());
      renderer = std::move(*made);
      renderer->SetAir(Air());
    }
    return RenderSmooth(*renderer, scene, view::CameraFor(*scene.assets, GetParam().camera, ""), 256, 144);
  }

  static const space::AirFromSpace& Air() {
    static const auto air = space::AirFromSpace::From(space::MakeAirTables<float>(space::Air{}, kAirSizes).value());
    return air;
  }

  static inline std::map<std::string, std::unique_ptr<Renderer>> renderers_;  // by scenario
  static inline std::optional<std::string> cache_before_;
};

TEST_P(GoldenViews, LookAsTheyDidWhenTheyWereStored) {
  const auto image = DrawView();
  ASSERT_TRUE(image) << image.error().detail;
  const std::filesystem::path file = std::filesystem::path(VR_OOS_SOURCE_DIR) / "nodes" / "visual_node" / "pictures" /
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

// Day, the terminator, the Earth's shadow and its night side before the stars; far orbits and low ones.
INSTANTIATE_TEST_SUITE_P(Orbit, GoldenViews,
                         testing::Values(GoldenView{"module_replacement", "overview"},
                                         GoldenView{"module_replacement", "overview", 330},
                                         GoldenView{"module_replacement", "overview", 270, 420},
                                         GoldenView{"module_replacement", "overview", 150, 420},
                                         GoldenView{"module_replacement", "cavity", 300},
                                         GoldenView{"module_replacement", "switch_off", 0, 420},
                                         GoldenView{"service_robot", "", 330}, GoldenView{"service_robot", "", 30, 420},
                                         GoldenView{"peg_in_hole", "", 300}, GoldenView{"peg_in_hole", "", 245, 420},
                                         GoldenView{"touch", "", 300, 420}, GoldenView{"free_collision", "", 330}),
                         [](const auto& golden) { return NameOf(golden.param); });

}  // namespace
}  // namespace visual_node
