#include "nodes/visual_node/draw/renderer.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <glm/gtc/type_ptr.hpp>
#include <numbers>

#include "nodes/visual_node/sky/ground.hpp"
#include "nodes/visual_node/testing/gl_test.hpp"
#include "space/orbit.hpp"
#include "view/projection.hpp"
#include "vps/mesh/vertex_normals.hpp"
#include "vps/testing/shapes.hpp"

namespace visual_node {
namespace {

constexpr int kWidth = 640;
constexpr int kHeight = 360;

// Meshes: 0 floor, 1 ball (radius 0.1), 2 box, 3 lamp. The names denote generated shapes; no file is read.
core::Result<vps::VisualMesh> MakeShape(const std::filesystem::path& name) {
  const auto shaded = [](const vps::TriangleMesh& mesh) { return vps::VisualMesh{{vps::SplitAtCreases(mesh, 0.6)}}; };
  if (name == "floor") return shaded(vps::MakeBox({1.6, 1.2, 0.02}));
  if (name == "ball") return shaded(vps::MakeSphere(0.1, 48));
  if (name == "box") return shaded(vps::MakeBox({0.2, 0.2, 0.2}));
  if (name == "lamp") return shaded(vps::MakeSphere(0.02, 24));
  return core::Fail(core::ErrorCode::kNotFound, "no shape called " + name.string());
}

scene::Camera FrontCamera() {
  scene::Camera camera;
  camera.name = "front";
  camera.eye_m = {0.0, -1.3, 0.75};
  camera.target_m = {0.0, 0.0, 0.08};
  camera.vertical_fov_rad = 0.75;
  return camera;
}

// Floor top at z = 0; ball at (-0.3, 0, 0.1); box at (0.25, 0.1, 0.1); lamp on the box. Sun straight above.
view::Scene TestScene() {
  view::Scene scene;
  auto assets = std::make_shared<view::Assets>();
  assets->meshes = {"floor", "ball", "box", "lamp"};
  assets->instance_names = {"floor", "ball", "box", "lamp"};
  assets->cameras = {FrontCamera()};
  scene.assets = assets;
  scene.space.sun_direction_W = {0.0, 0.0, 1.0};
  const glm::dvec3 positions[4] = {{0, 0, -0.01}, {-0.3, 0, 0.1}, {0.25, 0.1, 0.1}, {0.25, 0.1, 0.22}};
  const glm::vec3 colors[4] = {{0.55f, 0.55f, 0.58f}, {0.75f, 0.25f, 0.06f}, {0.10f, 0.25f, 0.6f}, {0, 0.3f, 0}};
  for (std::uint32_t i = 0; i < 4; ++i) {
    view::Instance instance;
    instance.mesh = i;
    instance.X_WM.translation = positions[i];
    instance.material.base_color = colors[i];
    instance.material.roughness = 0.45f;
    instance.is_material_given = true;
    instance.is_movable = i == 1;
    scene.instances.push_back(instance);
  }
  scene.instances[3].material.emissive = {0.0f, 1.0f, 0.0f};
  scene.lamps.push_back({3, {0.0f, 1.0f, 0.0f}});
  return scene;
}

int Luma(const std::uint8_t* p) {
  return (2 * p[0] + 5 * p[1] + p[2]) / 8;
}

class RendererTest : public GlTest {
 protected:
  void SetUp() override {
    GlTest::SetUp();
    if (IsSkipped()) return;
    auto renderer = Renderer::Create(scene_, MakeShape);
    ASSERT_TRUE(renderer) << renderer.error().detail;
    renderer_ = std::move(*renderer);
    target_ = std::make_unique<RenderTarget>(kWidth, kHeight);
    small_ = std::make_unique<RenderTarget>(16, 16);
  }
  Image Draw(bool with_texts = false) {
    look_.with_texts = with_texts;
    const auto drawn = renderer_->Draw(scene_, FrontCamera(), *target_, look_);
    EXPECT_TRUE(drawn) << drawn.error().detail;
    EXPECT_EQ(glGetError(), static_cast<GLenum>(GL_NO_ERROR));
    return target_->Read();
  }
  // What the film has, before it is developed: linear RGB and alpha at pixel (x, y) from the top left corner.
  std::vector<glm::vec4> Light() {
    Draw();
    const std::vector<float> light = renderer_->film().ReadLight();
    std::vector<glm::vec4> pixels;
    for (int y = kHeight - 1; y >= 0; --y) {
      for (int x = 0; x < kWidth; ++x) pixels.push_back(glm::make_vec4(&light[4 * PixelIndex(x, y)]));
    }
    return pixels;
  }
  static std::size_t PixelIndex(int x, int y) { return static_cast<std::size_t>(y * kWidth + x); }
  static glm::ivec2 At(const glm::dvec3& p_W) {
    const glm::dvec3 pixel = view::ProjectToPixel(FrontCamera(), kWidth, kHeight, p_W);
    return {static_cast<int>(pixel.x), static_cast<int>(pixel.y)};
  }

  view::Scene scene_ = TestScene();
  std::unique_ptr<Renderer> renderer_;
  std::unique_ptr<RenderTarget> target_;
  std::unique_ptr<RenderTarget> small_;
  Look look_;
};

TEST_F(RendererTest, ASphereCoversTheAnalyticSilhouette) {
  // Only the ball. A pixel's ray hits the ball when it passes the centre nearer than the radius.
  for (const std::size_t i : {0u, 2u, 3u}) scene_.instances[i].is_visible = false;
  scene_.lamps.clear();
  const std::vector<glm::vec4> light = Light();
  scene_.instances[1].is_visible = false;
  const std::vector<glm::vec4> sky = Light();
  const scene::Camera camera = FrontCamera();
  const glm::dmat4 X_WE = glm::inverse(view::ViewMatrix(camera));
  const double focal_px = 0.5 * kHeight / std::tan(0.5 * camera.vertical_fov_rad);
  int inside = 0, wrong = 0;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const glm::dvec3 ray_E(x + 0.5 - 0.5 * kWidth, 0.5 * kHeight - y - 0.5, -focal_px);
      const glm::dvec3 ray_W = glm::normalize(glm::dmat3(X_WE) * ray_E);
      const glm::dvec3 to = scene_.instances[1].X_WM.translation - camera.eye_m;
      const double miss_m = glm::length(to - glm::dot(to, ray_W) * ray_W);
      const bool is_ball = light[PixelIndex(x, y)] != sky[PixelIndex(x, y)];
      inside += miss_m < 0.1;
      // Half a pixel is 0.65 mm there, and the 48-sided mesh lies up to 0.3 mm inside the sphere.
      if (miss_m < 0.0985 && !is_ball) ++wrong;
      if (miss_m > 0.1010 && is_ball) ++wrong;
    }
  }
  EXPECT_GT(inside, 2000);
  EXPECT_EQ(wrong, 0);
}

TEST_F(RendererTest, TheShadowOfAVerticalSunIsStraightBelow) {
  const Image image = Draw();
  // The camera sees the part of the floor in front of the ball (centre at x = -0.3, radius 0.1).
  const glm::ivec2 dark = At({-0.3, -0.075, 0.0});
  const glm::ivec2 lit = At({-0.3, -0.125, 0.0});
  EXPECT_LT(Luma(image.Pixel(dark.x, dark.y)), 0.75 * Luma(image.Pixel(lit.x, lit.y)));
}

TEST_F(RendererTest, WhatReachesIntoThePictureIsDrawnThoughItsMiddleIsOutside) {
  for (const std::size_t i : {0u, 2u, 3u}) scene_.instances[i].is_visible = false;
  scene_.lamps.clear();
  const glm::dmat3 R_WV = glm::transpose(glm::dmat3(view::ViewMatrix(FrontCamera())));
  const double depth_m = 1.3, high_m = depth_m * std::tan(0.5 * FrontCamera().vertical_fov_rad);
  const double wide_m = high_m * kWidth / kHeight;
  scene_.instances[1].is_visible = false;
  const std::vector<glm::vec4> sky = Light();
  scene_.instances[1].is_visible = true;
  for (const glm::dvec2 side : {glm::dvec2(1, 0), glm::dvec2(-1, 0), glm::dvec2(0, 1), glm::dvec2(0, -1)}) {
    for (const double beyond_m : {0.05, 0.2}) {
      const glm::dvec2 at = side * (glm::dvec2(wide_m, high_m) + beyond_m);
      scene_.instances[1].X_WM.translation = FrontCamera().eye_m + R_WV * glm::dvec3(at, -depth_m);
      EXPECT_EQ(Light() != sky, beyond_m < 0.1) << side.x << " " << side.y << " " << beyond_m;
    }
  }
}

TEST_F(RendererTest, TheShadowMapIsUpdatedOnlyWhenSomethingMoves) {
  Draw();
  const int updates = renderer_->num_shadow_updates();
  Draw();
  EXPECT_EQ(renderer_->num_shadow_updates(), updates);
  scene_.instances[1].X_WM.translation.y = 0.25;
  const Image image = Draw();
  EXPECT_EQ(renderer_->num_shadow_updates(), updates + 1);
  const glm::ivec2 was_dark = At({-0.3, -0.075, 0.0});
  const glm::ivec2 lit = At({-0.3, -0.125, 0.0});
  EXPECT_NEAR(Luma(image.Pixel(was_dark.x, was_dark.y)), Luma(image.Pixel(lit.x, lit.y)), 8);
}

// Live: a caster may be half a texel off its place in the map, and no more. A picture that is kept has exact shadows.
TEST_F(RendererTest, LiveShadowsFollowWhenACasterHasMovedByHalfATexel) {
  look_.detail_px = 0.25;
  Draw();
  const int updates = renderer_->num_shadow_updates();
  const float texel_m = renderer_->shadow_texel_m();
  scene_.instances[1].X_WM.translation.y += 0.4 * texel_m;
  Draw();
  EXPECT_EQ(renderer_->num_shadow_updates(), updates);
  scene_.instances[1].X_WM.translation.y += 0.2 * texel_m;
  Draw();
  EXPECT_EQ(renderer_->num_shadow_updates(), updates + 1);
  scene_.instances[1].X_WM.translation.y += 0.4 * texel_m;
  look_.detail_px = 0.0;
  Draw();
  EXPECT_EQ(renderer_->num_shadow_updates(), updates + 2);
  Draw();
  EXPECT_EQ(renderer_->num_shadow_updates(), updates + 2);
}

TEST_F(RendererTest, ALampShowsItsColour) {
  const glm::ivec2 at = At({0.25, 0.1, 0.22});
  Image image = Draw();
  EXPECT_GT(image.Pixel(at.x, at.y)[1], 180);
  EXPECT_LT(image.Pixel(at.x, at.y)[0], 120);
  scene_.instances[3].material.emissive = scene_.lamps[0].color = {1.0f, 0.0f, 0.0f};
  scene_.instances[3].material.base_color = {0.3f, 0.0f, 0.0f};
  image = Draw();
  EXPECT_GT(image.Pixel(at.x, at.y)[0], 180);
  EXPECT_LT(image.Pixel(at.x, at.y)[1], 120);
}

// The lamp's reach is 2.5 times its radius of 0.02 m; seven of them do not reach the ball, but a turned box beside it.
TEST_F(RendererTest, ALampLightsWhatIsNearAndNothingFarAway) {
  scene_.instances[2].X_WM.rotation = glm::angleAxis(0.6, glm::dvec3(0.0, 0.0, 1.0));
  const Image lit = Draw();
  scene_.lamps[0].color = glm::vec3(0.0f);
  const Image dark = Draw();
  const auto brighter = [&](const glm::dvec3& p_W) {
    const glm::ivec2 at = At(p_W);
    return lit.Pixel(at.x, at.y)[1] - dark.Pixel(at.x, at.y)[1];
  };
  EXPECT_GT(brighter({0.25, 0.06, 0.2}), 10);   // the box's top
  EXPECT_EQ(brighter({-0.3, -0.06, 0.15}), 0);  // the ball
}

TEST_F(RendererTest, AnArrowIsDrawnAtItsContact) {
  const Image before = Draw();
  scene_.arrows.push_back({{0.0, -0.2, 0.0}, {0.0, 0.0, 0.12}, {0.1f, 0.9f, 0.2f}});
  const Image after = Draw();
  for (const double z : {0.02, 0.06, 0.10}) {
    const glm::ivec2 at = At({0.0, -0.2, z});
    EXPECT_GT(after.Pixel(at.x, at.y)[1], after.Pixel(at.x, at.y)[0] + 40) << z;
    EXPECT_LT(std::abs(before.Pixel(at.x, at.y)[1] - before.Pixel(at.x, at.y)[0]), 30) << z;
  }
}

TEST_F(RendererTest, TextsAreDrawnAtTheirAnchors) {
  scene_.texts.push_back({view::Anchor::kBottomLeft, view::TextStyle::kTitle, glm::vec3(1.0f), "switch_off"});
  scene_.texts.push_back({view::Anchor::kTopRight, view::TextStyle::kBadge, glm::vec3(1.0f, 0.6f, 0.1f), "SIMULATED"});
  const Image without = Draw(false);
  const Image with = Draw(true);
  ASSERT_EQ(renderer_->placed_lines().size(), 2u);
  for (const PlacedLine& placed : renderer_->placed_lines()) {
    int changed = 0;
    for (int y = placed.y; y < placed.y + placed.height; ++y) {
      for (int x = placed.x; x < placed.x + placed.width; ++x) {
        changed += std::abs(Luma(with.Pixel(x, y)) - Luma(without.Pixel(x, y))) > 60;
      }
    }
    EXPECT_GT(changed, placed.width * placed.height / 10) << placed.line.text;
  }
  EXPECT_LT(renderer_->placed_lines()[0].x, kWidth / 4);
  EXPECT_GT(renderer_->placed_lines()[0].y, 3 * kHeight / 4);
  EXPECT_GT(renderer_->placed_lines()[1].x, kWidth / 2);
  EXPECT_LT(renderer_->placed_lines()[1].y, kHeight / 4);
}

// Only the sky, with the Earth 20000 km ahead and the sun on the right: half of it is day.
TEST_F(RendererTest, TheTerminatorOfTheEarthIsAtRightAnglesToTheSun) {
  for (view::Instance& instance : scene_.instances) instance.is_visible = false;
  const scene::Camera camera = FrontCamera();
  const glm::dmat3 R_WV = glm::transpose(glm::dmat3(view::ViewMatrix(camera)));
  const double distance_m = 2e7;
  scene_.space.sun_direction_W = R_WV[0];
  scene_.space.X_WE.translation = -distance_m * R_WV[2];
  const auto ground = ReadGround();
  ASSERT_TRUE(ground);
  // Within half a degree, up to 60 degrees north or south: the texture is filtered.
  const auto has_town = [&](const glm::dvec3& n_E) {
    const picture::Image& lights = ground->lights;
    const int column = static_cast<int>((std::atan2(n_E.y, n_E.x) / (2.0 * std::numbers::pi) + 0.5) * lights.width);
    const int row = static_cast<int>((0.5 - std::asin(n_E.z) / std::numbers::pi) * lights.height);
    for (int j = std::max(row - 2, 0); j <= std::min(row + 2, lights.height - 1); ++j) {
      for (int i = column - 4; i <= column + 4; ++i) {
        if (lights.Pixel((i + lights.width) % lights.width, j)[0] != 0) return true;
      }
    }
    return false;
  };
  const std::vector<glm::vec4> light = Light();
  const double focal_px = 0.5 * kHeight / std::tan(0.5 * camera.vertical_fov_rad);
  int wrong = 0, checked = 0;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const glm::dvec3 d = glm::normalize(glm::dvec3(x + 0.5 - 0.5 * kWidth, 0.5 * kHeight - y - 0.5, -focal_px));
      const glm::dvec3 centre(0.0, 0.0, -distance_m);
      const double along_m = glm::dot(d, centre), miss_m = glm::length(along_m * d - centre);
      if (miss_m > 0.9 * space::kEarthMeanRadius_m) continue;
      const glm::dvec3 n =
          along_m * d - std::sqrt(space::kEarthMeanRadius_m * space::kEarthMeanRadius_m - miss_m * miss_m) * d - centre;
      const double sine = n.x / space::kEarthMeanRadius_m;  // of the sun's height
      if (std::abs(sine) < 0.01) continue;                  // a pixel is 45 km or 0.007 there
      if (has_town(glm::normalize(R_WV * n))) continue;
      ++checked;
      const bool is_day = light[PixelIndex(x, y)].g > 0.00185f;  // the night and space have 0.0018
      wrong += is_day != (sine > 0.0);
    }
  }
  EXPECT_GT(checked, 20000);
  EXPECT_EQ(wrong, 0);
}

TEST_F(RendererTest, TheEarthTurnsInThePicture) {
  for (view::Instance& instance : scene_.instances) instance.is_visible = false;
  const glm::dmat3 R_WV = glm::transpose(glm::dmat3(view::ViewMatrix(FrontCamera())));
  scene_.space.sun_direction_W = R_WV[2];
  scene_.space.X_WE.translation = -2e7 * R_WV[2];
  const Image before = Draw();
  scene_.space.X_WE.rotation = glm::angleAxis(0.5, glm::dvec3(0, 0, 1));
  const Image after = Draw();
  int changed = 0;
  for (int y = 90; y < 270; ++y) {
    for (int x = 230; x < 410; ++x) changed += std::abs(Luma(after.Pixel(x, y)) - Luma(before.Pixel(x, y))) > 8;
  }
  EXPECT_GT(changed, 10000);
}

TEST_F(RendererTest, ABrightStarShinesWhereItStands) {
  for (view::Instance& instance : scene_.instances) instance.is_visible = false;
  const glm::dmat3 R_WV = glm::transpose(glm::dmat3(view::ViewMatrix(FrontCamera())));
  scene_.space.X_WE.translation = 4e7 * R_WV[2];  // behind
  scene_.space.sun_direction_W = R_WV[1];
  // Turns the sky so that Vega stands at pixel (400.5, 100.5).
  const double ra = glm::radians(279.2347), dec = glm::radians(38.7837);
  const glm::dvec3 vega_C(std::cos(dec) * std::cos(ra), std::cos(dec) * std::sin(ra), std::sin(dec));
  const double focal_px = 0.5 * kHeight / std::tan(0.5 * FrontCamera().vertical_fov_rad);
  const glm::dvec3 there_W = glm::normalize(R_WV * glm::dvec3(400.5 - 320.0, 180.0 - 100.5, -focal_px));
  const glm::dvec3 axis = glm::normalize(glm::cross(vega_C, there_W));
  scene_.space.R_WC = glm::angleAxis(std::acos(glm::dot(vega_C, there_W)), axis);
  const Image image = Draw();
  EXPECT_GT(Luma(image.Pixel(400, 100)), 200);
  EXPECT_LT(Luma(image.Pixel(398, 100)), 100);
  EXPECT_LT(Luma(image.Pixel(400, 102)), 100);
}

// White balls in uniform light are invisible: whatever the material, they reflect all that they get.
TEST_F(RendererTest, AWhiteFurnaceLosesNoEnergyAtAnyRoughness) {
  for (view::Instance& instance : scene_.instances) instance.is_visible = false;
  scene_.lamps.clear();
  scene_.instances[1].is_visible = true;
  view::Material& material = scene_.instances[1].material;
  material.base_color = glm::vec3(1.0f);
  scene_.space.X_WE.translation = {0.0, 1e15, 0.0};  // no Earth in the picture
  const RenderTarget quarter(kWidth / 4, kHeight / 4);
  view::EnvironmentLight furnace;
  furnace.everywhere = glm::vec3(1.0f);
  look_.light = furnace;
  enum class Kind { kPlain, kFoil, kSmoothCoat, kRoughCoat };
  for (const Kind kind : {Kind::kPlain, Kind::kFoil, Kind::kSmoothCoat, Kind::kRoughCoat}) {
    material.is_foil = kind == Kind::kFoil;
    material.coat = kind == Kind::kSmoothCoat ? 1.0f : (kind == Kind::kRoughCoat ? 0.5f : 0.0f);
    material.coat_roughness = kind == Kind::kRoughCoat ? 0.7f : 0.05f;
    for (const float metallic : {0.0f, 0.5f, 1.0f}) {
      for (float roughness = 0.0f; roughness < 1.05f; roughness += 0.1f) {
        material.metallic = metallic;
        material.roughness = roughness;
        int checked = 0;
        ASSERT_TRUE(renderer_->Draw(scene_, FrontCamera(), quarter, look_));
        const std::vector<float> light = renderer_->film().ReadLight();
        for (std::size_t i = 0; i < light.size(); i += 4) {
          if (light[i + 3] == 0.0f) continue;
          ++checked;
          ASSERT_NEAR(light[i + 1], 1.0f, 0.01f) << metallic << " " << roughness << " " << static_cast<int>(kind);
        }
        ASSERT_GT(checked, 150);
      }
    }
  }
}

// As the furnace, for the sun: what a wall reflects towards the eye of suns from all directions is what it gets.
TEST_F(RendererTest, SunsFromAllSidesAreReflectedWhole) {
  for (view::Instance& instance : scene_.instances) instance.is_visible = false;
  scene_.lamps.clear();
  scene_.instances[0].is_visible = true;
  view::Material& material = scene_.instances[0].material;
  material.base_color = glm::vec3(1.0f);
  constexpr int kHeights = 24, kTurns = 32;
  struct Wall {
    float metallic, roughness, coat;
  };
  for (const auto& [metallic, roughness, coat] :
       {Wall{0, 0.6f, 0}, Wall{0, 1, 0}, Wall{1, 0.6f, 0}, Wall{1, 1, 0}, Wall{0, 0.8f, 1}, Wall{1, 0.8f, 0.5f}}) {
    material.metallic = metallic;
    material.roughness = roughness;
    material.coat = coat;
    material.coat_roughness = 0.6f;
    double sum = 0.0;
    for (int i = 0; i < kHeights; ++i) {
      const float nl = (static_cast<float>(i) + 0.5f) / kHeights, ring = std::sqrt(1.0f - nl * nl);
      for (int k = 0; k < kTurns; ++k) {
        const float turn = 6.2831853f * (static_cast<float>(k) + 0.5f) / kTurns;
        view::EnvironmentLight sun;
        sun.sun_direction_W = {ring * std::cos(turn), ring * std::sin(turn), nl};
        sun.sun = glm::vec3(1.0f);
        look_.light = sun;
        // The shadow map stays that of a sun straight above: nothing stands on the floor.
        ASSERT_TRUE(renderer_->Draw(scene_, FrontCamera(), *small_, look_));
        const std::vector<float> light = renderer_->film().ReadLight();
        sum += 2.0 * 3.14159265 / (kHeights * kTurns) * light[4 * (8 * 16 + 8) + 1];
      }
    }
    EXPECT_NEAR(sum, 1.0, 0.012) << metallic << " " << roughness << " " << coat;
  }
}

// A floor of gold foil.
class FoilTest : public RendererTest {
 protected:
  void SetUp() override {
    RendererTest::SetUp();
    if (IsSkipped()) return;
    for (view::Instance& instance : scene_.instances) instance.is_visible = false;
    scene_.lamps.clear();
    scene_.instances[0].is_visible = true;
    view::Material& material = scene_.instances[0].material;
    material.base_color = {1.0f, 0.75f, 0.35f};
    material.metallic = 1.0f;
    material.roughness = 0.3f;
    material.is_foil = true;
    scene_.space.X_WE.translation = {0.0, 1e15, 0.0};  // no Earth in the picture
  }
  // Of the floor's light, in that surrounding.
  glm::dvec3 Mean(const scene::Camera& camera, const view::EnvironmentLight& light_around) {
    look_.light = light_around;
    const RenderTarget quarter(kWidth / 4, kHeight / 4);
    EXPECT_TRUE(renderer_->Draw(scene_, camera, quarter, look_));
    const std::vector<float> light = renderer_->film().ReadLight();
    glm::dvec3 sum(0.0);
    double count = 0.0;
    for (std::size_t i = 0; i < light.size(); i += 4) {
      if (light[i + 3] == 0.0f) continue;
      sum += glm::dvec3(light[i], light[i + 1], light[i + 2]);
      count += 1.0;
    }
    EXPECT_GT(count, 1000.0);
    return sum / count;
  }
};

TEST_F(FoilTest, ItMirrorsTheEarthsSideInItsOwnColourAndDarkSpaceBlack) {
  const scene::Camera camera = FrontCamera();
  const glm::vec3 mirrored_way = glm::normalize(glm::vec3(0.0f, 1.3f, 0.67f));
  const auto with_earth_at = [&](const glm::vec3& direction) {
    view::EnvironmentLight light;
    light.earth_direction_W = direction;
    light.sun_direction_W = -direction;  // of the Earth its day is seen
    light.earth_sine = 0.6f;
    light.earth = glm::vec3(1.0f);
    return Mean(camera, light);
  };
  const glm::dvec3 earth = with_earth_at(mirrored_way);
  const glm::dvec3 space = with_earth_at(glm::normalize(glm::vec3(0.0f, -1.0f, 0.2f)));
  EXPECT_GT(earth.g, 0.3);
  EXPECT_GT(earth.g, 5.0 * space.g);
  EXPECT_GT(earth.r, 1.2 * earth.g);
  EXPECT_GT(earth.g, 1.5 * earth.b);
}

// The sun's image is longer along the direction in which foil was rolled, here x. Other metal has a round one.
TEST_F(FoilTest, TheSunsImageIsLongerAlongTheDirectionOfRolling) {
  scene::Camera above;
  above.eye_m = {0.0, 0.0, 40.0};  // so far that it sees all places from the same direction
  above.vertical_fov_rad = 0.02;
  const auto tilted = [&](const glm::vec3& towards) {
    view::EnvironmentLight light;
    light.sun_direction_W = glm::normalize(glm::vec3(0.0f, 0.0f, 1.0f) + towards);
    light.sun = glm::vec3(1.0f);
    return Mean(above, light).g;
  };
  const glm::vec3 x(0.7f, 0.0f, 0.0f), y(0.0f, 0.7f, 0.0f);
  const double along = tilted(x), across = tilted(y);
  EXPECT_GT(along, 1.5 * across);
  EXPECT_NEAR(tilted(-x), along, 0.25 * along) << "wrinkles lean to no side";
  scene_.instances[0].material.is_foil = false;
  EXPECT_NEAR(tilted(x), tilted(y), 0.05 * tilted(y));
}

// The sun's lowest ray that touches the ball's top meets the floor at a known place; the light is half there.
TEST_F(RendererTest, TheEdgeOfAShadowIsWhereTheSunsRayMeetsTheFloor) {
  for (const std::size_t i : {2u, 3u}) scene_.instances[i].is_visible = false;
  scene_.lamps.clear();
  const glm::dvec3 to_sun = glm::normalize(glm::dvec3(-1.0, 0.0, 1.5));
  scene_.space.sun_direction_W = to_sun;
  look_.light = view::EnvironmentLight{.sun_direction_W = glm::vec3(to_sun), .sun = glm::vec3(3.0f)};
  const std::vector<glm::vec4> light = Light();
  // The shadow of a ball is an ellipse around the shadow of its centre, longer by 1 / sine of the sun's height.
  const glm::dvec3 centre = scene_.instances[1].X_WM.translation;
  const double tip_x = centre.x + centre.z * 1.0 / 1.5 + 0.1 / to_sun.z;
  const auto at = [&](double x) {
    const glm::ivec2 pixel = At({x, 0.0, 0.0});
    return light[PixelIndex(pixel.x, pixel.y)].g;
  };
  const float lit = at(tip_x + 0.05), dark = at(tip_x - 0.03);
  EXPECT_LT(dark, 0.02f * lit);
  double edge_x = tip_x - 0.03;
  while (at(edge_x) < 0.5f * (lit + dark)) edge_x += 1e-4;
  const double pixel_m = 1.3 * 2.0 * std::tan(0.5 * 0.75) / kHeight;
  EXPECT_NEAR(edge_x, tip_x, renderer_->shadow_texel_m() + pixel_m);
}

TEST_F(RendererTest, ThePenumbraGrowsWithTheDistanceOfWhatCastsIt) {
  // Two boxes: the light falls past one onto the other's top at z = 0. A small scene has a fine shadow map.
  for (view::Instance& instance : scene_.instances) instance.is_visible = false;
  scene_.lamps.clear();
  for (const std::size_t i : {2u, 3u}) {
    scene_.instances[i].is_visible = true;
    scene_.instances[i].mesh = 2;
  }
  const auto lift = [&](double height_m) { scene_.instances[3].X_WM.translation = {0.1, 0.05, height_m + 0.1}; };
  scene_.instances[2].X_WM.translation = {0.0, 0.0, -0.1};
  scene_.instances[3].is_movable = true;
  lift(0.6);
  renderer_ = std::move(*Renderer::Create(scene_, MakeShape));
  look_.light = view::EnvironmentLight{.sun = glm::vec3(3.0f)};
  scene::Camera camera = FrontCamera();
  camera.eye_m = {0.0, -0.13, 0.1};
  camera.target_m = {0.0, -0.02, 0.0};
  // The width over which the floor's light rises from 15 to 85 % at the shadow's edge, x = 0.
  const auto width_m = [&](double height_m) {
    lift(height_m);
    EXPECT_TRUE(renderer_->Draw(scene_, camera, *target_, look_));
    const std::vector<float> light = renderer_->film().ReadLight();
    const auto at = [&](double x) {
      const glm::dvec3 pixel = view::ProjectToPixel(camera, kWidth, kHeight, {x, -0.02, 0.0});
      return light[4 * PixelIndex(static_cast<int>(pixel.x), kHeight - 1 - static_cast<int>(pixel.y)) + 1];
    };
    const float lit = at(-0.02), dark = at(0.02);
    EXPECT_LT(dark, 0.1f * lit);
    double from = 0.0, to = 0.0;
    for (double x = 0.02; x > -0.02; x -= 2e-5) {
      const float share = (at(x) - dark) / (lit - dark);
      if (share < 0.15f) from = x;
      if (share < 0.85f) to = x;
    }
    return from - to;
  };
  // The sun is 0.0093 wide. Seen past a straight edge, its light rises from 15 to 85 % over 0.59 of that.
  const double high_m = width_m(0.6);
  EXPECT_NEAR(high_m, 0.59 * 0.0093 * 0.6, renderer_->shadow_texel_m());
  EXPECT_GT(high_m, 1.5 * width_m(0.05));
}

TEST_F(RendererTest, DrawingTwiceGivesEqualPictures) {
  const Image first = Draw(true);
  EXPECT_EQ(first.rgba, Draw(true).rgba);
}

TEST_F(RendererTest, ReportsTheNameOfAMissingMesh) {
  auto assets = std::make_shared<view::Assets>(*scene_.assets);
  assets->meshes.emplace_back("nowhere.glb");
  scene_.assets = assets;
  const auto renderer = Renderer::Create(scene_, MakeShape);
  ASSERT_FALSE(renderer);
  EXPECT_NE(renderer.error().detail.find("nowhere.glb"), std::string::npos);
}

// With VISUAL_NODE_TEST_PICTURE=FILE the picture is written to that file.
TEST_F(RendererTest, ASupersampledStillHasTheSameMeansAsAPlainPicture) {
  scene_.space.sun_direction_W = glm::normalize(glm::dvec3(-0.4, -0.5, 0.9));
  scene_.arrows.push_back({{-0.3, -0.06, 0.02}, {0.0, -0.05, 0.12}, {0.2f, 0.95f, 0.35f}});
  scene_.texts = {
      {view::Anchor::kTopLeft, view::TextStyle::kBody, glm::vec3(0.9f), "Ball, box and lamp"},
      {view::Anchor::kTopRight, view::TextStyle::kBadge, {1.0f, 0.6f, 0.1f}, "SIMULATED OPERATOR · SIMULATED ARM"},
      {view::Anchor::kBottomLeft, view::TextStyle::kTitle, glm::vec3(0.9f), "press"},
      {view::Anchor::kBottomLeft, view::TextStyle::kBody, glm::vec3(0.6f), "Press the ball on the plane"}};
  const RenderTarget big(2 * kWidth, 2 * kHeight);
  ASSERT_TRUE(renderer_->Draw(scene_, FrontCamera(), big));
  const Image still = Shrink(big.Read(), 2);
  ASSERT_EQ(still.width, kWidth);
  if (const char* file = std::getenv("VISUAL_NODE_TEST_PICTURE")) {
    const auto written = WritePng(still, file);
    EXPECT_TRUE(written) << written.error().detail;
  }
  // The same scene without supersampling: every tile of 64 x 40 pixels has nearly the same mean.
  const Image plain = Draw(true);
  for (int ty = 0; ty < kHeight; ty += 40) {
    for (int tx = 0; tx < kWidth; tx += 64) {
      int difference = 0;
      for (int y = ty; y < ty + 40; ++y) {
        for (int x = tx; x < tx + 64; ++x) difference += Luma(still.Pixel(x, y)) - Luma(plain.Pixel(x, y));
      }
      EXPECT_LT(std::abs(difference) / (64.0 * 40.0), 6.0) << tx << " " << ty;
    }
  }
}

}  // namespace
}  // namespace visual_node
