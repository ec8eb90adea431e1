// What the OpenGL renderer and the ray tracer make of the sun's light: what surfaces reflect of it, and where it does
// not come.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "nodes/visual_node/draw/renderer.hpp"
#include "nodes/visual_node/testing/gl_test.hpp"
#include "raytrace/tracer.hpp"
#include "scene/load_scenario.hpp"
#include "view/appearance/split_sum.hpp"
#include "view/conformance/cast_ids.hpp"
#include "view/conformance/testing/known_scene.hpp"
#include "view/scene_mirror.hpp"
#include "vps/mesh/vertex_normals.hpp"
#include "vps/testing/shapes.hpp"

namespace visual_node {
namespace {

constexpr float kPi = 3.14159265f;

// --- Reciprocity: what a surface sends from the direction l to v it sends from v to l.

// A floor, seen from far away along v and lit by the sun along l alone.
class Reciprocity : public GlTest {
 protected:
  static constexpr int kSize = 9;  // of the picture, whose middle is read
  // Places of the split sum's table, so that nothing is interpolated: its columns are cosines, its rows roughnesses.
  static constexpr std::array<int, 4> kColumns = {6, 12, 20, 29};
  static constexpr std::array<float, 4> kTurns_rad = {0.0f, 0.9f, 2.0f, 3.1f};

  void SetUp() override {
    GlTest::SetUp();
    if (IsSkipped()) return;
    scene_.instances.resize(1);
    scene_.instances[0].X_WM = {};
    scene_.lamps.clear();
    auto renderer = Renderer::Create(scene_, Floor);
    ASSERT_TRUE(renderer) << renderer.error().detail;
    renderer_ = std::move(*renderer);
    auto tracer = raytrace::Tracer::Create(scene_, Floor);
    ASSERT_TRUE(tracer) << tracer.error().detail;
    tracer_ = std::move(*tracer);
    target_ = std::make_unique<RenderTarget>(kSize, kSize);
  }

  static core::Result<vps::VisualMesh> Floor(const std::filesystem::path& /*name*/) {
    return vps::VisualMesh{{vps::SplitAtCreases(vps::MakeBox({4.0, 4.0, 1e-6}), 0.6)}};
  }
  static float Cosine(int column) { return static_cast<float>(column) / (view::kSplitSumSize - 1); }
  static glm::vec3 Direction(int column, float turn_rad) {
    const float z = Cosine(column), ring = std::sqrt(1.0f - z * z);
    return {ring * std::cos(turn_rad), ring * std::sin(turn_rad), z};
  }

  // The reflectance [1/sr] of the floor for green light: radiance over irradiance. First OpenGL's, then the tracer's.
  std::array<double, 2> Reflectance(const view::Material& material, const glm::vec3& l, const glm::vec3& v) {
    scene_.instances[0].material = material;
    const view::EnvironmentLight sun{.sun_direction_W = l, .sun = glm::vec3(1.0f)};
    scene::Camera camera;
    camera.eye_m = 30.0 * glm::dvec3(v);
    camera.vertical_fov_rad = 0.001;
    EXPECT_TRUE(renderer_->Draw(scene_, camera, *target_, {.with_penumbra = false, .light = sun}));
    const std::vector<float> light = renderer_->film().ReadLight();
    constexpr std::size_t kMiddle = kSize / 2 * kSize + kSize / 2;
    tracer_->Update(scene_, sun);
    const auto traced =
        tracer_->Draw(raytrace::Eye::Of(camera, kSize, kSize), {0, 0, kSize, kSize}, {tiles::Mirrors::kNone});
    return {light[4 * kMiddle + 1] / l.z, traced.light.values[3 * kMiddle + 1] / l.z};
  }

  // Calls check(l, v) for directions above the floor on both sides of its normal.
  template <typename Check>
  void ForDirections(const Check& check) {
    for (const int one : kColumns) {
      for (const int other : kColumns) {
        for (const float turn_rad : kTurns_rad) check(one, other, turn_rad);
      }
    }
  }

  view::Scene scene_ = view::KnownScene();
  std::unique_ptr<Renderer> renderer_;
  std::unique_ptr<raytrace::Tracer> tracer_;
  std::unique_ptr<RenderTarget> target_;
};

constexpr const char* kRenderers[] = {"OpenGL", "ray tracer"};
constexpr std::array<int, 4> kRows = {9, 14, 20, 31};  // of the split sum's table

float Roughness(int row) {
  return static_cast<float>(row) / (view::kSplitSumSize - 1);
}

// By how much of themselves two values may differ. OpenGL's film has floats of 16 bits, each up to 1/2048 off, and a
// texture's coordinates have 8 bits between two texels.
constexpr std::array<double, 2> kInexact = {0.002, 1e-4};

// D V F is the same both ways. What is mirrored more often is given by the view's side alone [Turquin 2019]; with that
// factor divided out, reflectance is reciprocal.
TEST_F(Reciprocity, WhatIsMirroredIsTheSameBothWaysButForTheViewsShareOfWhatIsMirroredMoreOften) {
  struct Kind {
    float base, metallic, f0;
  };
  std::array<double, 2> most_unequal{};
  for (const Kind& kind : {Kind{0.9f, 1.0f, 0.9f}, Kind{0.5f, 1.0f, 0.5f}, Kind{0.0f, 0.0f, 0.04f}}) {
    for (const int row : kRows) {
      const float roughness = Roughness(row);
      const view::Material material{
          .base_color = glm::vec3(kind.base), .metallic = kind.metallic, .roughness = roughness};
      const auto once = [&](int column) {
        const glm::vec2 split = view::SplitSum(Cosine(column), roughness);
        const double lost = 1.0 - split.x - split.y;
        return 1.0 + kind.f0 * lost / (1.0 - lost);
      };
      ForDirections([&](int one, int other, float turn_rad) {
        const glm::vec3 l = Direction(one, 0.0f), v = Direction(other, turn_rad);
        const auto there = Reflectance(material, l, v), back = Reflectance(material, v, l);
        for (std::size_t i = 0; i < there.size(); ++i) {
          const double forth = there[i] / once(other), again = back[i] / once(one), most = std::max(forth, again);
          EXPECT_GT(most, 1e-5) << "nothing is reflected";
          most_unequal[i] = std::max(most_unequal[i], std::abs(forth - again) / most);
          EXPECT_NEAR(forth, again, kInexact[i] * most)
              << kRenderers[i] << ": metal " << kind.metallic << ", roughness " << roughness << ", cosines "
              << Cosine(one) << " " << Cosine(other) << ", turned by " << turn_rad;
        }
      });
    }
  }
  RecordProperty("most_unequal_OpenGL", std::to_string(most_unequal[0]));
  RecordProperty("most_unequal_ray_tracer", std::to_string(most_unequal[1]));
}

// A matt ground gets what is not mirrored, by the view's side alone: with that share divided out it is Lambert's, 1 /
// pi from everywhere to everywhere.
TEST_F(Reciprocity, TheMattGroundIsLambertsButForTheViewsShareOfWhatIsMirrored) {
  for (const int row : kRows) {
    const float roughness = Roughness(row);
    const view::Material white{.base_color = glm::vec3(1.0f), .metallic = 0.0f, .roughness = roughness};
    const view::Material black{.base_color = glm::vec3(0.0f), .metallic = 0.0f, .roughness = roughness};
    ForDirections([&](int one, int other, float turn_rad) {
      const glm::vec3 l = Direction(one, 0.0f), v = Direction(other, turn_rad);
      const auto all = Reflectance(white, l, v), mirrored = Reflectance(black, l, v);
      const glm::vec2 split = view::SplitSum(Cosine(other), roughness);
      const double lost = 1.0 - split.x - split.y, once = 0.04 * split.x + split.y;
      const double mean = 1.0 / 21.0 + 20.0 / 21.0 * 0.04;  // of Schlick's Fresnel factor over all directions
      const double share = 1.0 - once - once * lost * mean / (1.0 - lost * mean);
      for (std::size_t i = 0; i < all.size(); ++i) {
        EXPECT_NEAR((all[i] - mirrored[i]) / share, 1.0 / kPi, 2.0 * kInexact[i] * all[i] / share)
            << kRenderers[i] << ": roughness " << roughness << ", cosines " << Cosine(one) << " " << Cosine(other);
      }
    });
  }
}

// --- Shadows: the map's against those of rays to the sun.

// Where the sun comes, at each pixel that shows a surface: all surfaces are matt and white, and nothing else shines.
struct SunMask {
  std::vector<std::uint8_t> is_surface, is_lit;
};

// Less than this share of the sun is no light: what the sun only grazes is dark in the shadow and out of it.
constexpr float kLeastLight = 0.02f;

class SunShadows : public GlTest, public testing::WithParamInterface<const char*> {
 protected:
  static constexpr int kWidth = 640, kHeight = 360;

  SunMask ByMap(Renderer& renderer, const view::Scene& scene, const scene::Camera& camera) {
    const RenderTarget target(kWidth, kHeight);
    EXPECT_TRUE(renderer.Draw(scene, camera, target, {.with_penumbra = false, .light = Sun(scene)}));
    const std::vector<float> light = renderer.film().ReadLight();
    SunMask mask;
    for (int y = kHeight - 1; y >= 0; --y) {  // the film begins at the bottom
      for (int x = 0; x < kWidth; ++x) {
        const float* pixel = &light[4 * static_cast<std::size_t>(y * kWidth + x)];
        mask.is_surface.push_back(pixel[3] > 0.0f);
        mask.is_lit.push_back(pixel[1] > kLeastLight);
      }
    }
    return mask;
  }
  static SunMask ByRays(raytrace::Tracer& tracer, const view::Scene& scene, const scene::Camera& camera) {
    tracer.Update(scene, Sun(scene));
    const auto lit =
        tracer.Draw(raytrace::Eye::Of(camera, kWidth, kHeight), {0, 0, kWidth, kHeight}, {tiles::Mirrors::kNone});
    SunMask mask;
    for (std::size_t i = 0; i < lit.depth_m.values.size(); ++i) {
      mask.is_surface.push_back(lit.depth_m.values[i] > 0.0f);
      mask.is_lit.push_back(lit.light.values[3 * i + 1] > kLeastLight);
    }
    return mask;
  }
  // Whether both see a surface there and so far around, and rays all find the sun or none does.
  static bool IsAwayFromEdges(const SunMask& map, const SunMask& rays, int x, int y, int reach_px) {
    if (x < reach_px || y < reach_px || x + reach_px >= kWidth || y + reach_px >= kHeight) return false;
    const std::uint8_t is_lit = rays.is_lit[static_cast<std::size_t>(y * kWidth + x)];
    for (int dy = -reach_px; dy <= reach_px; ++dy) {
      for (int dx = -reach_px; dx <= reach_px; ++dx) {
        const auto i = static_cast<std::size_t>((y + dy) * kWidth + x + dx);
        if (map.is_surface[i] == 0 || rays.is_surface[i] == 0 || rays.is_lit[i] != is_lit) return false;
      }
    }
    return true;
  }
  static view::EnvironmentLight Sun(const view::Scene& scene) {
    return {.sun_direction_W = glm::vec3(scene.space.sun_direction_W), .sun = glm::vec3(1.0f)};
  }
};

// Off the edges of shadows. The map is sampled 1.5 texels outside of a surface and mixes two texels, so an edge may be
// 2.5 texels off its place; a pixel more for where in a pixel an edge runs. Of the
// pixels that are dark in either, 99 % are dark in both.
TEST_P(SunShadows, OfTheMapAreThoseOfRaysButAtTheirEdges) {
  view::Scene scene = view::KnownScene();
  MeshLoader load = view::MeshOfBody;
  if (const std::string name = GetParam(); name != "known") {
    const auto scenario = scene::LoadScenario(std::filesystem::path(VR_OOS_SOURCE_DIR) / "scenarios" / name);
    ASSERT_TRUE(scenario);
    scene = view::SceneMirror(*scenario).scene();
    load = [](const std::filesystem::path& file) { return vps::LoadVisualMesh(file); };
  }
  scene.texts.clear();
  scene.lamps.clear();
  for (view::Instance& instance : scene.instances) {
    instance.material = {.base_color = glm::vec3(1.0f), .metallic = 0.0f, .roughness = 1.0f};
    instance.is_material_given = true;
  }
  auto renderer = Renderer::Create(scene, load);
  ASSERT_TRUE(renderer) << renderer.error().detail;
  const auto tracer = raytrace::Tracer::Create(scene, load);
  ASSERT_TRUE(tracer) << tracer.error().detail;
  std::vector<scene::Camera> cameras = scene.assets->cameras;
  if (cameras.empty()) cameras = {view::KnownCamera()};
  std::size_t compared = 0, same = 0, dark_in_one = 0, dark_in_both = 0;
  for (const scene::Camera& given : cameras) {
    const scene::Camera camera = view::PlaceCamera(given, scene);
    for (const glm::dvec3& direction : {glm::dvec3(-0.4, -0.5, 0.8), glm::dvec3(0.6, -0.3, 0.5)}) {
      scene.space.sun_direction_W = glm::normalize(direction);
      const SunMask map = ByMap(**renderer, scene, camera), rays = ByRays(**tracer, scene, camera);
      const double pixel_m =
          glm::distance(camera.eye_m, camera.target_m) * 2.0 * std::tan(0.5 * camera.vertical_fov_rad) / kHeight;
      const int reach_px = 1 + static_cast<int>(std::ceil(2.5 * (*renderer)->shadow_texel_m() / pixel_m));
      for (int y = 0; y < kHeight; ++y) {
        for (int x = 0; x < kWidth; ++x) {
          const auto i = static_cast<std::size_t>(y * kWidth + x);
          if (!IsAwayFromEdges(map, rays, x, y, reach_px)) continue;
          ++compared;
          same += map.is_lit[i] == rays.is_lit[i] ? 1 : 0;
          dark_in_one += map.is_lit[i] == 0 || rays.is_lit[i] == 0 ? 1 : 0;
          dark_in_both += map.is_lit[i] == 0 && rays.is_lit[i] == 0 ? 1 : 0;
        }
      }
    }
  }
  const double shared = static_cast<double>(dark_in_both) / static_cast<double>(dark_in_one);
  RecordProperty("compared", std::to_string(compared));
  RecordProperty("different", std::to_string(compared - same));
  RecordProperty("dark_in_both_of_dark_in_one", std::to_string(shared));
  EXPECT_GT(compared, cameras.size() * 10'000) << "nothing is seen";
  EXPECT_GT(dark_in_one, cameras.size() * 1'000) << "no shadow is seen";
  EXPECT_GE(shared, 0.99);
  EXPECT_GE(static_cast<double>(same) / static_cast<double>(compared), 0.999);
}

INSTANTIATE_TEST_SUITE_P(Of, SunShadows,
                         testing::Values("known", "touch", "module_replacement", "peg_in_hole", "two_hands",
                                         "service_robot"),
                         [](const auto& test) { return std::string(test.param); });

}  // namespace
}  // namespace visual_node
