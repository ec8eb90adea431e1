#include "nodes/visual_node/camera_feed.hpp"

#include <gtest/gtest.h>

#include "nodes/visual_node/testing/gl_test.hpp"
#include "vps/mesh/vertex_normals.hpp"
#include "vps/testing/shapes.hpp"

namespace visual_node {
namespace {

constexpr std::int64_t kMoment_ns = 1'000'000'000;

core::Result<vps::VisualMesh> MakeBallMesh(const std::filesystem::path& /*name*/) {
  return vps::VisualMesh{{vps::SplitAtCreases(vps::MakeSphere(0.1, 32), 0.6)}};
}

// A red ball at the origin, and a carrier without a mesh on which the second camera is mounted.
view::Scene BallAndCarrier() {
  view::Scene scene;
  auto assets = std::make_shared<view::Assets>();
  assets->meshes = {"ball", ""};
  assets->instance_names = {"ball", "carrier"};
  scene::Camera mounted;
  mounted.name = "mounted";
  mounted.eye_m = {0.0, -1.0, 0.0};
  mounted.object = 1;
  mounted.is_mounted = true;
  assets->cameras = {scene::Camera{.name = "free"}, mounted};
  scene.assets = assets;
  scene.instances.resize(2);
  scene.instances[0].material.base_color = {0.8f, 0.05f, 0.05f};
  scene.instances[0].is_material_given = true;
  scene.instances[1].mesh = 1;
  scene.instances[1].is_visible = false;
  scene.space.sun_direction_W = {0.0, -1.0, 0.0};
  return scene;
}

class CameraFeedTest : public GlTest {
 protected:
  void SetUp() override {
    GlTest::SetUp();
    if (IsSkipped()) return;
    auto renderer = Renderer::Create(scene_, MakeBallMesh);
    ASSERT_TRUE(renderer) << renderer.error().detail;
    renderer_ = std::move(*renderer);
    feed_ = std::make_unique<CameraFeed>(renderer_.get());
  }
  std::vector<CameraFeed::Seen> Take(const std::vector<double>& rates_hz, std::int64_t now_ns) {
    auto seen = feed_->Take(scene_, rates_hz, {}, now_ns);
    EXPECT_TRUE(seen) << seen.error().detail;
    return std::move(*seen);
  }
  static bool IsRedInTheMiddle(const core::CameraImage& image) {
    const std::size_t middle = 3 * (image.height / 2 * image.width + image.width / 2);
    return static_cast<std::uint8_t>(image.rgb[middle]) > static_cast<std::uint8_t>(image.rgb[middle + 1]) + 60;
  }

  view::Scene scene_ = BallAndCarrier();
  std::unique_ptr<Renderer> renderer_;
  std::unique_ptr<CameraFeed> feed_;
};

TEST_F(CameraFeedTest, ACameraTakesPicturesAtItsRateAndOthersTakeNone) {
  scene_.time_ns = 77;
  const auto first = Take({0.0, 2.0}, kMoment_ns);
  ASSERT_EQ(first.size(), 1u);
  EXPECT_EQ(first[0].camera, 1u);
  EXPECT_EQ(first[0].image.time_ns, 77);
  EXPECT_EQ(first[0].image.rgb.size(), 3u * first[0].image.width * first[0].image.height);
  EXPECT_LT(first[0].image.rgb.size(), 65'000u) << "must fit into a value of a STATE topic";
  EXPECT_TRUE(Take({0.0, 2.0}, kMoment_ns + 499'000'000).empty());
  EXPECT_EQ(Take({0.0, 2.0}, kMoment_ns + 500'000'000).size(), 1u);
}

TEST_F(CameraFeedTest, AMountedCameraSeesWhatIsInFrontOfItsPart) {
  EXPECT_EQ(CameraFeed::MountedCamera(*scene_.assets), 1);
  EXPECT_TRUE(IsRedInTheMiddle(Take({0.0, 5.0}, kMoment_ns).at(0).image));
  scene_.instances[1].X_WM.translation.x = 2.0;  // the part moves away, and its camera with it
  EXPECT_FALSE(IsRedInTheMiddle(Take({0.0, 5.0}, 2 * kMoment_ns).at(0).image));
}

TEST_F(CameraFeedTest, TheInsetIsInTheCornerOfThePicture) {
  const RenderTarget target(640, 360);
  ASSERT_TRUE(renderer_->Draw(scene_, scene_.assets->cameras[0], target, {.with_texts = false}));
  const Image before = target.Read();
  ASSERT_TRUE(feed_->DrawInset(scene_, {}, kMoment_ns, 16.0 / 9.0, target));
  const Image after = target.Read();
  EXPECT_NE(std::vector<std::uint8_t>(before.Pixel(550, 240), before.Pixel(551, 240)),
            std::vector<std::uint8_t>(after.Pixel(550, 240), after.Pixel(551, 240)));
  EXPECT_TRUE(std::equal(before.rgba.begin(), before.rgba.begin() + std::ptrdiff_t{4} * 640 * 180, after.rgba.begin()))
      << "the upper half stays";
}

}  // namespace
}  // namespace visual_node
