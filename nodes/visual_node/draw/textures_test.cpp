// Textures of a material: what they hold multiplies the material's figures, in linear light.

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "nodes/visual_node/draw/renderer.hpp"
#include "nodes/visual_node/testing/gl_test.hpp"
#include "scene/load_scenario.hpp"

namespace visual_node {
namespace {

using Color = std::array<std::uint8_t, 4>;

vps::VisualTexture MakePicture(int width, int height, bool is_color, const std::function<Color(int, int)>& at) {
  vps::VisualTexture picture{width, height, {}, is_color};
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      for (const std::uint8_t c : at(x, y)) picture.rgba.push_back(c);
    }
  }
  return picture;
}

// A square of 0.2 m in the plane z = 0; u along x, v against y.
vps::VisualMesh MakeSquare() {
  vps::VisualPrimitive square;
  for (const glm::vec2 corner : {glm::vec2(-1, -1), glm::vec2(1, -1), glm::vec2(1, 1), glm::vec2(-1, 1)}) {
    square.positions.emplace_back(0.1f * corner.x, 0.1f * corner.y, 0.0f);
    square.normals.emplace_back(0.0f, 0.0f, 1.0f);
    square.uvs.emplace_back(0.5f * corner.x + 0.5f, 0.5f - 0.5f * corner.y);
  }
  square.indices = {0, 1, 2, 0, 2, 3};
  square.base_color = glm::vec3(1.0f);
  square.metallic = 0.0f;
  square.roughness = 1.0f;
  return {{square}, {}};
}

class TexturesTest : public GlTest {
 protected:
  [[nodiscard]] view::Scene Scene() const {
    view::Scene scene;
    auto assets = std::make_shared<view::Assets>();
    assets->meshes = {"square"};
    assets->instance_names = {"square"};
    assets->variants = {variant_};
    scene.assets = assets;
    scene.instances.emplace_back();
    scene.space.X_WE.translation = {0.0, 0.0, 1e15};
    return scene;
  }
  // Linear RGB in the middle of the square, seen from above; `look_` says in which light.
  glm::vec3 Light(const vps::VisualMesh& mesh, double height_m = 0.5, int size = 64) {
    const view::Scene scene = Scene();
    auto renderer = Renderer::Create(scene, [&](const std::filesystem::path&) { return mesh; });
    EXPECT_TRUE(renderer);
    scene::Camera camera;
    camera.eye_m = {1e-4, -1e-4, height_m};
    const RenderTarget target(size, size);
    EXPECT_TRUE((*renderer)->Draw(scene, camera, target, look_));
    EXPECT_EQ(glGetError(), static_cast<GLenum>(GL_NO_ERROR));
    const std::vector<float> light = (*renderer)->film().ReadLight();
    const auto at = 4 * static_cast<std::size_t>(size / 2 * size + size / 2);
    return {light[at], light[at + 1], light[at + 2]};
  }
  static view::EnvironmentLight Sun(const glm::vec3& direction) {
    return {.sun_direction_W = glm::normalize(direction), .sun = glm::vec3(2.0f)};
  }
  static double FromSrgb(int code) {
    const double c = code / 255.0;
    return c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4);
  }

  std::string variant_;
  Look look_{.with_texts = false, .with_penumbra = false, .light = Sun({0, 0, 1})};
};

TEST_F(TexturesTest, AColourTextureIsSrgbAndMultipliesTheColour) {
  for (const int code : {10, 61, 128, 188, 240}) {
    vps::VisualMesh plain = MakeSquare(), textured = MakeSquare();
    plain.primitives[0].base_color = {0.5f * FromSrgb(code), 0.25f * FromSrgb(255 - code), 0.0f};
    textured.primitives[0].base_color = {0.5f, 0.25f, 0.0f};
    textured.primitives[0].base_texture = 0;
    const auto red = static_cast<std::uint8_t>(code), green = static_cast<std::uint8_t>(255 - code);
    textured.textures = {MakePicture(8, 8, true, [&](int, int) { return Color{red, green, 77, 255}; })};
    const glm::vec3 a = Light(plain), b = Light(textured);
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(a[i], b[i], 0.005 * a[i] + 2e-4) << code;
  }
}

TEST_F(TexturesTest, ABoardOfBlackAndWhiteSeenFromAfarIsHalfAsBrightAsWhite) {
  vps::VisualMesh board = MakeSquare();
  board.primitives[0].base_texture = 0;
  board.textures = {MakePicture(256, 256, true, [](int x, int y) {
    const auto c = static_cast<std::uint8_t>((x + y) % 2 * 255);
    return Color{c, c, c, 255};
  })};
  vps::VisualMesh grey = MakeSquare();
  grey.primitives[0].base_color = glm::vec3(0.5f);
  EXPECT_NEAR(Light(board, 0.5, 32).g, Light(grey, 0.5, 32).g, 0.02 * Light(grey, 0.5, 32).g);
}

TEST_F(TexturesTest, ASurfaceTextureGivesRoughnessMetalAndOcclusion) {
  look_.light = Sun({0.1f, 0, 1});
  look_.light->everywhere = glm::vec3(0.3f);
  vps::VisualMesh plain = MakeSquare(), textured = MakeSquare();
  plain.primitives[0].roughness = static_cast<float>(0.8 * 128 / 255);
  plain.primitives[0].metallic = static_cast<float>(0.5 * 51 / 255);
  textured.primitives[0].roughness = 0.8f;
  textured.primitives[0].metallic = 0.5f;
  textured.primitives[0].surface_texture = 0;
  textured.textures = {MakePicture(4, 4, false, [](int, int) { return Color{102, 128, 51, 255}; })};
  EXPECT_NEAR(Light(plain).g, Light(textured).g, 0.005 * Light(plain).g);
  // Occlusion takes from the surroundings' light, and nothing from the sun's.
  textured.primitives[0].has_occlusion = true;
  const float both = Light(textured).g;
  look_.light->everywhere = glm::vec3(0.0f);
  const float sun = Light(textured).g;
  EXPECT_NEAR(sun, Light(plain).g, 0.005 * sun);
  look_.light->everywhere = glm::vec3(0.3f);
  EXPECT_NEAR(both - sun, 0.4 * (Light(plain).g - sun), 0.01 * sun);
}

// Lacquer over black metal, which mirrors nothing at right angles, is a dielectric with a refractive index of 1.5.
TEST_F(TexturesTest, LacquerMirrorsFourPercentAndDimsWhatIsBelow) {
  look_.light = view::EnvironmentLight{.everywhere = glm::vec3(1.0f)};
  vps::VisualMesh mesh = MakeSquare();
  vps::VisualPrimitive& square = mesh.primitives[0];
  square.base_color = glm::vec3(0.0f);
  square.metallic = 1.0f;
  const float black = Light(mesh).g;
  square.coat = 1.0f;
  const float coated = Light(mesh).g;
  EXPECT_NEAR(coated - black, 0.04f * (1.0f - black), 0.002f);
  square.coat = 0.5f;
  EXPECT_NEAR(Light(mesh).g, 0.5f * (black + coated), 2e-4f);
  square.emissive = glm::vec3(10.0f);
  square.coat = 1.0f;
  EXPECT_NEAR(Light(mesh).g - coated, 9.6f, 0.02f);
}

TEST_F(TexturesTest, WhatASurfaceEmitsIsAddedAsItsPictureSays) {
  vps::VisualMesh mesh = MakeSquare();
  const glm::vec3 dark = Light(mesh);
  mesh.primitives[0].emissive = {2.0f, 1.0f, 0.0f};
  EXPECT_NEAR(Light(mesh).r - dark.r, 2.0f, 0.01f);
  mesh.primitives[0].emissive_texture = 0;
  mesh.textures = {MakePicture(4, 4, true, [](int, int) { return Color{188, 128, 255, 255}; })};
  const glm::vec3 lit = Light(mesh);
  EXPECT_NEAR(lit.r - dark.r, 2.0 * FromSrgb(188), 0.01);
  EXPECT_NEAR(lit.g - dark.g, FromSrgb(128), 0.01);
  EXPECT_NEAR(lit.b - dark.b, 0.0, 0.002);
}

TEST_F(TexturesTest, AnInstanceShowsTheVariantThatItNames) {
  vps::VisualMesh mesh = MakeSquare();
  const glm::vec3 white = Light(mesh);
  mesh.variants = {"grey", "red"};
  mesh.primitives[0].variants.assign(2, mesh.primitives[0]);
  mesh.primitives[0].variants[0].base_color = glm::vec3(0.5f);
  mesh.primitives[0].variants[1].base_color = {1.0f, 0.0f, 0.0f};
  EXPECT_EQ(Light(mesh), white) << "none named";
  variant_ = "red";
  const glm::vec3 red = Light(mesh);
  EXPECT_NEAR(red.r, white.r, 1e-3f);
  EXPECT_LT(red.g, 0.1f * white.g);
  view::Scene scene = Scene();
  const auto refused = Renderer::Create(scene, [&](const std::filesystem::path&) { return MakeSquare(); });
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().detail.find("square: it has no variant 'red'"), std::string::npos);
}

TEST_F(TexturesTest, ANormalTextureTurnsTheNormalAlongUAndAgainstV) {
  const auto tilted = [](double x_deg, double y_deg) {
    vps::VisualMesh mesh = MakeSquare();
    mesh.primitives[0].normal_texture = 0;
    const glm::dvec3 n(std::sin(glm::radians(x_deg)), std::sin(glm::radians(y_deg)), 0.0);
    const double up = std::sqrt(1.0 - glm::dot(n, n));
    const auto code = [](double c) { return static_cast<std::uint8_t>(std::lround(128.0 + 127.0 * c)); };
    mesh.textures = {MakePicture(4, 4, false, [&](int, int) { return Color{code(n.x), code(n.y), code(up), 255}; })};
    return mesh;
  };
  const glm::vec3 flat = Light(MakeSquare());
  EXPECT_NEAR(Light(tilted(0, 0)).g, flat.g, 0.002 * flat.g);
  // Matt surfaces: the light goes with the cosine between normal and sun, and with what a dielectric mirrors.
  const double angle = glm::radians(40.0);
  for (const bool is_y : {false, true}) {
    const auto s = static_cast<float>(std::sin(angle)), c = static_cast<float>(std::cos(angle));
    look_.light = Sun(is_y ? glm::vec3(0, s, c) : glm::vec3(s, 0, c));
    const float towards = Light(is_y ? tilted(0, 30) : tilted(30, 0)).g;
    const float away = Light(is_y ? tilted(0, -30) : tilted(-30, 0)).g;
    EXPECT_NEAR(towards / away, std::cos(glm::radians(10.0)) / std::cos(glm::radians(70.0)), 0.25) << is_y;
  }
}

TEST_F(TexturesTest, TexturesAreReadFromTheScenariosMeshes) {
  const auto folder = std::filesystem::path(VR_OOS_SOURCE_DIR) / "scenarios" / "module_replacement" / "meshes";
  const auto module = vps::LoadVisualMesh(folder / "module.glb");
  ASSERT_TRUE(module);
  int num_labels = 0, num_brushed = 0;
  for (const vps::VisualPrimitive& primitive : module->primitives) {
    if (primitive.base_texture >= 0) {
      ++num_labels;
      const vps::VisualTexture& picture = module->textures.at(static_cast<std::size_t>(primitive.base_texture));
      EXPECT_TRUE(picture.is_color);
      EXPECT_EQ(picture.rgba.size(), 4u * static_cast<std::size_t>(picture.width * picture.height));
      EXPECT_EQ(primitive.uvs.size(), primitive.positions.size());
    }
    if (primitive.surface_texture >= 0) {
      ++num_brushed;
      EXPECT_FALSE(module->textures.at(static_cast<std::size_t>(primitive.surface_texture)).is_color);
    }
  }
  EXPECT_EQ(num_labels, 1);
  EXPECT_EQ(num_brushed, 1);
  const auto lamp = vps::LoadVisualMesh(folder / "lamp.glb");
  ASSERT_TRUE(lamp);
  EXPECT_EQ(std::count_if(lamp->primitives.begin(), lamp->primitives.end(), [](const auto& p) { return p.is_lens; }),
            1);
}

}  // namespace
}  // namespace visual_node
