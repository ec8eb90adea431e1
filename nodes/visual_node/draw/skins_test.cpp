#include <gtest/gtest.h>

#include <cmath>

#include "nodes/visual_node/draw/object_pass.hpp"
#include "nodes/visual_node/draw/renderer.hpp"
#include "nodes/visual_node/testing/gl_test.hpp"
#include "view/projection.hpp"

namespace visual_node {
namespace {

constexpr int kSkinWidth = 320, kSkinHeight = 240;
constexpr float kLength_m = 0.4f, kHalf_m = 0.02f;

// A ribbon in the plane y = 0 along x, bent at x = 0 by the joint there: what lies beyond 0 goes with joint 1.
vps::VisualMesh MakeRibbon() {
  vps::VisualPrimitive ribbon;
  for (const float x : {-kLength_m, 0.0f, 0.0f, kLength_m}) {
    const bool is_second = ribbon.positions.size() >= 4;
    for (const float z : {-kHalf_m, kHalf_m}) {
      ribbon.positions.emplace_back(x, 0.0f, z);
      ribbon.normals.emplace_back(0.0f, -1.0f, 0.0f);
      ribbon.joints.emplace_back(is_second ? 1 : 0, 0, 0, 0);
      ribbon.weights.emplace_back(1, 0, 0, 0);
    }
  }
  ribbon.indices = {0, 2, 3, 0, 3, 1, 4, 6, 7, 4, 7, 5};
  vps::VisualMesh mesh;
  mesh.primitives = {ribbon};
  mesh.joints = {{"left", {}, {}}, {"right", {}, {}}};
  return mesh;
}

class SkinsTest : public GlTest {
 protected:
  void SetUp() override {
    GlTest::SetUp();
    if (IsSkipped()) return;
    auto assets = std::make_shared<view::Assets>();
    assets->meshes = {"ribbon"};
    assets->instance_names = {"ribbon"};
    scene_.assets = assets;
    scene_.instances.emplace_back();
    scene_.instances[0].is_movable = true;
    scene_.instances[0].X_WM.translation = {0.05, 0.0, -0.03};
    scene_.space.sun_direction_W = {0.0, -1.0, 0.0};
    camera_.eye_m = {0.0, -1.2, 0.0};
    camera_.vertical_fov_rad = 0.7;
    SetAngle(0.0);
    auto renderer = Renderer::Create(scene_, [](const std::filesystem::path&) { return MakeRibbon(); });
    ASSERT_TRUE(renderer) << renderer.error().detail;
    renderer_ = std::move(*renderer);
  }
  // Of the right half about y, upwards.
  void SetAngle(double angle_rad) {
    scene_.instances[0].posture = std::make_shared<const std::vector<core::Pose>>(
        std::vector<core::Pose>{{}, {glm::angleAxis(-angle_rad, glm::dvec3(0, 1, 0)), glm::dvec3(0.0)}});
  }
  picture::Measured<std::uint16_t> Ids() {
    const RenderTarget target(kSkinWidth, kSkinHeight);
    EXPECT_TRUE(renderer_->Draw(scene_, camera_, target));
    EXPECT_EQ(glGetError(), static_cast<GLenum>(GL_NO_ERROR));
    return ObjectPass::Create()->Draw(*renderer_, scene_, camera_, kSkinWidth, kSkinHeight).ids;
  }
  // Whether the bent ribbon is at p, which lies in its plane, and how far it is from the nearest edge.
  static bool IsOn(const glm::dvec2& p, double angle_rad, double* to_edge_m) {
    const glm::dvec2 right(std::cos(angle_rad) * p.x + std::sin(angle_rad) * p.y,
                           std::cos(angle_rad) * p.y - std::sin(angle_rad) * p.x);
    const auto depth = [](double along, double across) {  // inside: positive
      return std::min({along, kLength_m - along, kHalf_m - std::abs(across)});
    };
    const double inside = std::max(depth(-p.x, p.y), depth(right.x, right.y));
    *to_edge_m = std::abs(inside);
    return inside > 0.0;
  }

  view::Scene scene_;
  scene::Camera camera_;
  std::unique_ptr<Renderer> renderer_;
};

TEST_F(SkinsTest, ABentSkinIsSeenWhereItsJointsCarryIt) {
  const double pixel_m = 2.0 * 1.2 * std::tan(0.35) / kSkinHeight;
  for (const double angle : {0.0, 0.5, 1.3}) {
    SetAngle(angle);
    const auto ids = Ids();
    int num_on = 0;
    for (int y = 0; y < kSkinHeight; ++y) {
      for (int x = 0; x < kSkinWidth; ++x) {
        const glm::dvec2 p_W(pixel_m * (x + 0.5 - 0.5 * kSkinWidth), pixel_m * (0.5 * kSkinHeight - y - 0.5));
        double to_edge_m = 0.0;
        const bool is_on = IsOn(p_W - glm::dvec2(0.05, -0.03), angle, &to_edge_m);
        if (to_edge_m < 0.1 * pixel_m) continue;
        num_on += is_on;
        ASSERT_EQ(*ids.Pixel(x, y) != 0, is_on) << x << " " << y << " at " << angle;
      }
    }
    EXPECT_GT(num_on, 2000);
  }
}

TEST_F(SkinsTest, TheShadowIsDrawnAnewWhenASkinBends) {
  Ids();
  const int before = renderer_->num_shadow_updates();
  Ids();
  EXPECT_EQ(renderer_->num_shadow_updates(), before);
  SetAngle(0.7);
  Ids();
  EXPECT_EQ(renderer_->num_shadow_updates(), before + 1);
}

TEST_F(SkinsTest, ASkinWithAnotherNumberOfJointsIsRefused) {
  scene_.instances[0].posture = std::make_shared<const std::vector<core::Pose>>(3);
  const auto refused = Renderer::Create(scene_, [](const std::filesystem::path&) { return MakeRibbon(); });
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().detail.find("its skin has 2 joints, and the scenario names 3"), std::string::npos);
}

}  // namespace
}  // namespace visual_node
