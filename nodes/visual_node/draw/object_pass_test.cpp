#include "nodes/visual_node/draw/object_pass.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "nodes/visual_node/testing/gl_test.hpp"
#include "view/projection.hpp"
#include "vps/mesh/vertex_normals.hpp"
#include "vps/testing/shapes.hpp"

namespace visual_node {
namespace {

constexpr int kPassWidth = 320, kPassHeight = 180;

core::Result<vps::VisualMesh> PlateOrBall(const std::filesystem::path& name) {
  const auto shaded = [](const vps::TriangleMesh& mesh) { return vps::VisualMesh{{vps::SplitAtCreases(mesh, 0.6)}}; };
  if (name == "plate") return shaded(vps::MakeBox({4.0, 4.0, 0.02}));
  return shaded(vps::MakeSphere(0.1, 48));
}

scene::Camera LookFrom(const glm::dvec3& eye_W, const glm::dvec3& target_W) {
  scene::Camera camera;
  camera.eye_m = eye_W;
  camera.target_m = target_W;
  camera.vertical_fov_rad = 0.7;
  return camera;
}

// A plate whose top is at z = 0, and two balls of radius 0.1 on it. An arrow hides a part of the first ball.
view::Scene PlateAndBalls() {
  view::Scene scene;
  auto assets = std::make_shared<view::Assets>();
  assets->meshes = {"plate", "ball"};
  assets->instance_names = {"plate", "left", "right"};
  scene.assets = assets;
  scene.space.sun_direction_W = {0.0, 0.0, 1.0};
  const glm::dvec3 positions[] = {{0.0, 0.0, -0.01}, {-0.3, 0.0, 0.1}, {0.3, 0.0, 0.1}};
  for (std::uint32_t i = 0; i < 3; ++i) {
    view::Instance instance;
    instance.mesh = std::min(i, 1U);
    instance.X_WM.translation = positions[i];
    scene.instances.push_back(instance);
  }
  scene.arrows.push_back({{-0.3, 0.0, 0.2}, {0.0, 0.0, 0.3}});
  return scene;
}

class ObjectPassTest : public GlTest {
 protected:
  void SetUp() override {
    GlTest::SetUp();
    if (IsSkipped()) return;
    renderer_ = std::move(*Renderer::Create(scene_, PlateOrBall));
  }

  ObjectPicture Draw(const scene::Camera& camera) {
    const RenderTarget target(kPassWidth, kPassHeight);
    EXPECT_TRUE(renderer_->Draw(scene_, camera, target));
    const auto pass = ObjectPass::Create();
    EXPECT_TRUE(pass) << pass.error().detail;
    return pass->Draw(*renderer_, scene_, camera, kPassWidth, kPassHeight);
  }

  static glm::ivec2 PixelOf(const scene::Camera& camera, const glm::dvec3& p_W) {
    return glm::ivec2(glm::floor(view::ProjectToPixel(camera, kPassWidth, kPassHeight, p_W)));
  }

  view::Scene scene_ = PlateAndBalls();
  std::unique_ptr<Renderer> renderer_;
};

TEST_F(ObjectPassTest, DepthOfAPlaneIsWithinAMillimetre) {
  for (const glm::dvec3& eye_W : {glm::dvec3(0.0, -1.0, 1.2), glm::dvec3(0.9, -0.4, 1.9)}) {
    const scene::Camera camera = LookFrom(eye_W, {0.0, 0.0, 0.0});
    const ObjectPicture picture = Draw(camera);
    const picture::Measured<std::uint16_t> millimetres = ToMillimetres(picture.depth_m);
    const glm::dmat4 X_WE = glm::inverse(view::ViewMatrix(camera));
    const double focal_px = 0.5 * kPassHeight / std::tan(0.5 * camera.vertical_fov_rad);
    int num_checked = 0;
    for (int y = 0; y < kPassHeight; ++y) {
      for (int x = 0; x < kPassWidth; ++x) {
        if (*picture.ids.Pixel(x, y) != 1) continue;
        // The pixel's ray at depth 1, and where it meets z = 0.
        const glm::dvec3 ray_E((x + 0.5 - 0.5 * kPassWidth) / focal_px, (0.5 * kPassHeight - y - 0.5) / focal_px, -1.0);
        const glm::dvec3 ray_W = glm::dmat3(X_WE) * ray_E;
        const double depth_m = -camera.eye_m.z / ray_W.z;
        const glm::dvec3 p_W = camera.eye_m + depth_m * ray_W;
        if (std::max(std::abs(p_W.x), std::abs(p_W.y)) > 1.99) continue;  // its side
        ASSERT_NEAR(*picture.depth_m.Pixel(x, y), depth_m, 1e-4) << x << " " << y;
        ASSERT_NEAR(*millimetres.Pixel(x, y), 1e3 * depth_m, 0.6) << x << " " << y;
        ++num_checked;
      }
    }
    EXPECT_GT(num_checked, kPassWidth * kPassHeight / 2);
  }
}

TEST_F(ObjectPassTest, IdsNameTheObjectUnderAPixelAndArrowsAreNone) {
  const scene::Camera camera = LookFrom({0.0, -1.5, 0.6}, {0.0, 0.0, 0.1});
  const ObjectPicture picture = Draw(camera);
  for (std::size_t i = 1; i < 3; ++i) {
    const glm::ivec2 at = PixelOf(camera, scene_.instances[i].X_WM.translation);
    EXPECT_EQ(*picture.ids.Pixel(at.x, at.y), i + 1);
  }
  const glm::ivec2 plate = PixelOf(camera, {0.0, 0.0, 0.0});
  EXPECT_EQ(*picture.ids.Pixel(plate.x, plate.y), 1);
  const glm::ivec2 arrow = PixelOf(camera, {-0.3, 0.0, 0.4});
  EXPECT_EQ(*picture.ids.Pixel(arrow.x, arrow.y), *picture.ids.Pixel(arrow.x - 20, arrow.y));
  const ObjectPicture sky = Draw(LookFrom({0.0, 0.0, 1.0}, {0.0, 1.0, 2.0}));
  EXPECT_EQ(*sky.ids.Pixel(kPassWidth / 2, kPassHeight / 2), 0);
  EXPECT_EQ(*sky.depth_m.Pixel(kPassWidth / 2, kPassHeight / 2), 0.0f);
}

TEST_F(ObjectPassTest, AHiddenObjectHasNoPixel) {
  scene_.instances[2].is_visible = false;
  const ObjectPicture picture = Draw(LookFrom({0.0, -1.5, 0.6}, {0.0, 0.0, 0.1}));
  EXPECT_EQ(std::count(picture.ids.values.begin(), picture.ids.values.end(), 3), 0);
  EXPECT_GT(std::count(picture.ids.values.begin(), picture.ids.values.end(), 2), 100);
}

TEST(IdNames, EveryIdHasItsObjectsName) {
  const std::filesystem::path file = std::filesystem::path(testing::TempDir()) / "id_names.json";
  ASSERT_TRUE(WriteIdNames(*PlateAndBalls().assets, file));
  std::ifstream in(file);
  const auto names = nlohmann::json::parse(in);
  EXPECT_TRUE(names.at("0").is_null());
  EXPECT_EQ(names.at("1"), "plate");
  EXPECT_EQ(names.at("3"), "right");
  std::filesystem::remove(file);
}

}  // namespace
}  // namespace visual_node
