#include "nodes/visual_node/sky/sky.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/gtc/quaternion.hpp>
#include <glm/gtc/type_ptr.hpp>

#include "nodes/visual_node/draw/renderer.hpp"
#include "nodes/visual_node/testing/gl_test.hpp"
#include "space/orbit.hpp"
#include "view/appearance/environment_light.hpp"
#include "view/projection.hpp"

namespace visual_node {
namespace {

constexpr int kSkyWidth = 320, kSkyHeight = 180;
constexpr double kEye_m = space::kEarthMeanRadius_m + 400e3;

space::AirTableSizes SmallAir() {
  space::AirTableSizes sizes;
  sizes.r = 12;
  sizes.mu = 48;
  sizes.mu_s = 20;
  sizes.num_orders = 3;
  return sizes;
}

// 400 km above the Earth, z up, and a camera that looks along x, so far down that the limb is in the middle.
class SkyTest : public GlTest {
 protected:
  void SetUp() override {
    GlTest::SetUp();
    if (IsSkipped()) return;
    scene_.assets = std::make_shared<view::Assets>();
    scene_.space.X_WE.translation = {0.0, 0.0, -kEye_m};
    const double down_rad = std::acos(space::kEarthMeanRadius_m / kEye_m);
    camera_.eye_m = glm::dvec3(0.0);
    camera_.target_m = {std::cos(down_rad), 0.0, -std::sin(down_rad)};
    camera_.vertical_fov_rad = 0.6;
    auto renderer = Renderer::Create(scene_, [](const std::filesystem::path&) { return vps::VisualMesh{}; });
    ASSERT_TRUE(renderer) << renderer.error().detail;
    renderer_ = std::move(*renderer);
  }

  void SetSun(double height_rad, double turn_rad) {
    scene_.space.sun_direction_W = {std::cos(height_rad) * std::cos(turn_rad),
                                    std::cos(height_rad) * std::sin(turn_rad), std::sin(height_rad)};
  }

  // Turns the Earth so that this place is below the eye.
  void Below(double longitude_rad, double latitude_rad) {
    const glm::dvec3 place_E(std::cos(latitude_rad) * std::cos(longitude_rad),
                             std::cos(latitude_rad) * std::sin(longitude_rad), std::sin(latitude_rad));
    const glm::dvec3 up(0.0, 0.0, 1.0);
    scene_.space.X_WE.rotation = glm::normalize(glm::dquat(1.0 + glm::dot(place_E, up), glm::cross(place_E, up)));
  }

  // The film's light: linear RGB and alpha at pixel (x, y) from the top left corner.
  std::vector<glm::vec4> Light() {
    const RenderTarget target(kSkyWidth, kSkyHeight);
    EXPECT_TRUE(renderer_->Draw(scene_, camera_, target));
    EXPECT_EQ(glGetError(), static_cast<GLenum>(GL_NO_ERROR));
    const std::vector<float> light = renderer_->film().ReadLight();
    std::vector<glm::vec4> pixels;
    for (int y = kSkyHeight - 1; y >= 0; --y) {
      for (int x = 0; x < kSkyWidth; ++x) pixels.push_back(glm::make_vec4(&light[4 * Index(x, y)]));
    }
    return pixels;
  }

  static std::size_t Index(int x, int y) { return static_cast<std::size_t>(y * kSkyWidth + x); }

  [[nodiscard]] glm::dvec3 Ray(double x, double y) const {
    const double focal_px = 0.5 * kSkyHeight / std::tan(0.5 * camera_.vertical_fov_rad);
    const glm::dvec3 d_V(x - 0.5 * kSkyWidth, 0.5 * kSkyHeight - y, -focal_px);
    return glm::normalize(glm::transpose(glm::dmat3(view::ViewMatrix(camera_))) * d_V);
  }

  view::Scene scene_;
  scene::Camera camera_;
  std::unique_ptr<Renderer> renderer_;
};

// How much redder than blue the reddest pixel is that sees the ground, with the place below the eye.
TEST_F(SkyTest, TownsShineAtNightOnly) {
  camera_.target_m = {0.2, 0.0, -1.0};
  camera_.vertical_fov_rad = 1.0;
  const auto redness_above = [&](double longitude_rad, double latitude_rad) {
    Below(longitude_rad, latitude_rad);
    float most = 0.0f;
    for (const glm::vec4& pixel : Light()) most = std::max(most, pixel.r - pixel.b);
    return most;
  };
  SetSun(-1.0, 0.0);
  EXPECT_GT(redness_above(0.122, 0.899), 0.1f) << "Ruhr";
  EXPECT_LT(redness_above(0.175, 0.384), 0.01f) << "Sahara";
  EXPECT_LT(redness_above(-2.6, 0.0), 0.01f) << "Pacific";
}

// How far the Moon's pixels reach, and how many of them have light. Nothing else in the picture is opaque.
TEST_F(SkyTest, TheMoonHasItsSizeAndIsLitOnTheSunsSide) {
  const glm::dvec3 to_moon = glm::normalize(glm::dvec3(1.0, 0.0, 1.0));
  const double distance_m = 384'400e3;
  scene_.space.moon_position_W = distance_m * to_moon;
  camera_.target_m = to_moon;
  camera_.vertical_fov_rad = 0.014;
  const double radius_px = 0.5 * kSkyHeight / std::tan(0.5 * camera_.vertical_fov_rad) *
                           std::tan(std::asin(space::kMoonRadius_m / distance_m));
  const double area_px = 3.14159265 * radius_px * radius_px;
  ASSERT_GT(radius_px, 50.0);
  const glm::dvec3 right = glm::normalize(Ray(kSkyWidth, 0.5 * kSkyHeight) - Ray(0.0, 0.5 * kSkyHeight));
  for (const double phase_rad : {0.0, 0.7, 1.5708, 2.4, 3.14159}) {  // between the sun and the eye, seen from there
    scene_.space.sun_direction_W = -std::cos(phase_rad) * to_moon + std::sin(phase_rad) * right;
    const std::vector<glm::vec4> light = Light();
    int covered = 0, lit = 0;
    double sum_x = 0.0, sum = 0.0;
    for (int y = 0; y < kSkyHeight; ++y) {
      for (int x = 0; x < kSkyWidth; ++x) {
        const glm::vec4& pixel = light[Index(x, y)];
        if (pixel.a < 0.5f) continue;
        ++covered;
        lit += pixel.g > 0.02f ? 1 : 0;
        sum += pixel.g;
        sum_x += pixel.g * (x + 0.5 - 0.5 * kSkyWidth);
      }
    }
    EXPECT_NEAR(covered, area_px, 0.01 * area_px) << phase_rad;
    EXPECT_NEAR(lit, 0.5 * (1.0 + std::cos(phase_rad)) * area_px, 0.02 * area_px) << phase_rad;
    if (phase_rad < 0.5 || phase_rad > 3.0) continue;
    EXPECT_GT(sum_x / sum, 0.1 * radius_px) << "towards the sun: " << phase_rad;
  }
}

// The same places in the light of a sun as high on the other side, from where waves mirror it to somebody else.
TEST_F(SkyTest, TheSunGlintsOnTheOceanTowardsItsMirrorImageAndNotOnLand) {
  constexpr double kSunFromZenith_rad = 0.4;
  camera_.target_m = {std::sin(kSunFromZenith_rad), 0.0, -std::cos(kSunFromZenith_rad)};
  camera_.vertical_fov_rad = 0.9;
  // Of open water in a ring around the mirror's way [rad]: the mean light that is added, and of how many pixels.
  constexpr float kOpenWater = 0.03f;  // clouds and land are brighter
  struct Glint {
    double mean = 0.0;
    int count = 0;
  };
  const auto glint = [&](double from_rad, double to_rad, float brightest_ground) {
    SetSun(1.5707963 - kSunFromZenith_rad, 0.0);
    const std::vector<glm::vec4> there = Light();
    const glm::dvec3 mirror_way(scene_.space.sun_direction_W.x, 0.0, -scene_.space.sun_direction_W.z);
    SetSun(1.5707963 - kSunFromZenith_rad, 3.14159265);
    const std::vector<glm::vec4> away = Light();
    Glint sum;
    for (int y = 0; y < kSkyHeight; ++y) {
      for (int x = 0; x < kSkyWidth; ++x) {
        const double off_rad = std::acos(std::min(1.0, glm::dot(Ray(x + 0.5, y + 0.5), mirror_way)));
        if (off_rad < from_rad || off_rad >= to_rad || away[Index(x, y)].g > brightest_ground) continue;
        sum.mean += there[Index(x, y)].g - away[Index(x, y)].g;
        ++sum.count;
      }
    }
    sum.mean /= std::max(sum.count, 1);
    return sum;
  };
  Below(-2.8, 0.3);  // the Pacific, where there are few clouds
  const Glint inner = glint(0.0, 0.1, kOpenWater), ring = glint(0.2, 0.3, kOpenWater),
              outer = glint(0.4, 0.5, kOpenWater);
  for (const Glint& each : {inner, ring, outer}) EXPECT_GT(each.count, 100);
  // F E / (4 s cos(view) cos(slope)^4) with F = 0.02 where the mirror's image is.
  EXPECT_NEAR(inner.mean, 0.02 / (4.0 * 0.039 * std::cos(kSunFromZenith_rad)), 0.02);
  EXPECT_GT(inner.mean, 1.3 * ring.mean);
  EXPECT_GT(ring.mean, 1.3 * outer.mean);
  Below(0.175, 0.384);
  EXPECT_NEAR(glint(0.0, 0.1, 1.0f).mean, 0.0, 0.02) << "Sahara";
}

TEST_F(SkyTest, TheLimbIsWhereTheHorizonIs) {
  SetSun(1.0, 0.3);
  const std::vector<glm::vec4> light = Light();
  const double dip_rad = std::acos(space::kEarthMeanRadius_m / kEye_m);
  int checked = 0;
  for (int x = 0; x < kSkyWidth; ++x) {
    int edge = 0;  // the first row of the ground
    while (edge < kSkyHeight && light[Index(x, edge)].a < 0.5f) ++edge;
    if (edge == 0 || edge == kSkyHeight) continue;
    double expected = 0.0;  // the place down the column where the ray dips to the horizon
    while (expected < kSkyHeight && Ray(x + 0.5, expected).z > -std::sin(dip_rad)) expected += 0.01;
    EXPECT_NEAR(edge, expected, 0.51) << x;
    ++checked;
  }
  EXPECT_GT(checked, kSkyWidth / 2);
}

// What the tables have in double precision for each pixel: the light of the air, and what arrives through it of the
// ground's light, which a picture without air shows.
TEST_F(SkyTest, TheAirInThePictureIsThatOfTheTablesWithin46dB) {
  SetSun(0.12, 0.4);
  const std::vector<glm::vec4> vacuum = Light();
  const auto tables = space::MakeAirTables<float>(space::Air{}, SmallAir());
  const auto exact = space::MakeAirTables<double>(space::Air{}, SmallAir());
  renderer_->SetAir(space::AirFromSpace::From(*tables));
  const std::vector<glm::vec4> light = Light();
  const space::Shell<double> shell{space::Air{}.bottom_m, space::Air{}.top_m};
  const glm::dvec3 sun = scene_.space.sun_direction_W, eye(0.0, 0.0, kEye_m), color(view::kSunColor);
  const glm::dvec3 space_light(0.0012, 0.0018, 0.0036);
  const auto developed = [](double value) { return 255.0 * std::pow(1.0 - std::exp(-3.0 * value), 1.0 / 2.2); };
  double sum = 0.0;
  int num_sky = 0, num_ground = 0;
  for (int y = 0; y < kSkyHeight; ++y) {
    for (int x = 0; x < kSkyWidth; ++x) {
      const glm::dvec3 d = Ray(x + 0.5, y + 0.5);
      const double along = -glm::dot(d, eye), miss = glm::length(eye + along * d);
      if (along < 0.0 || miss >= shell.top || glm::length(d - sun) < 0.3) continue;
      const bool is_ground = miss < shell.bottom;
      const double half = std::sqrt(shell.top * shell.top - miss * miss), mu = -half / shell.top;
      const glm::dvec3 entry = (eye + (along - half) * d) / shell.top;
      const double mu_s = glm::dot(entry, sun), nu = glm::dot(d, sun);
      glm::dvec3 expected = std::acos(-1.0) * color * space::SkyRadiance(*exact, shell.top, mu, mu_s, nu, is_ground);
      const glm::dvec3 through = space::TransmittanceThrough(space::Air{}, shell.top, mu, is_ground);
      if (is_ground) {
        const double to_ground = shell.DistanceToBottom(shell.top, mu);
        const double height = glm::dot(entry * shell.top + to_ground * d, sun) / shell.bottom;
        if (height < 0.03) continue;  // nothing to compare the ground with in the night
        const glm::dvec3 ground = glm::dvec3(vacuum[Index(x, y)]) - space_light;
        expected += through * ground * space::GroundIrradiance(*exact, height) / height + space_light;
        ++num_ground;
      } else {
        if (glm::length(glm::vec3(vacuum[Index(x, y)]) - glm::vec3(space_light)) > 1e-3f) continue;  // a star
        expected += through * space_light;
        ++num_sky;
      }
      for (int k = 0; k < 3; ++k) {
        const double off = developed(light[Index(x, y)][k]) - developed(expected[k]);
        sum += off * off;
      }
    }
  }
  EXPECT_GT(num_sky, 1000);
  EXPECT_GT(num_ground, 5000);
  const double psnr_db = 10.0 * std::log10(255.0 * 255.0 * 3.0 * (num_sky + num_ground) / sum);
  RecordProperty("psnr_db", std::to_string(psnr_db));
  EXPECT_GT(psnr_db, 46.0);
}

TEST_F(SkyTest, TheSunThroughTheAirIsRedderThanAboveIt) {
  const auto tables = space::MakeAirTables<float>(space::Air{}, SmallAir());
  renderer_->SetAir(space::AirFromSpace::From(*tables));
  const double dip_rad = std::acos(space::kEarthMeanRadius_m / kEye_m);
  const auto at_sun = [&](double above_rad) {
    SetSun(above_rad - dip_rad, 0.0);
    const glm::dvec3 pixel =
        view::ProjectToPixel(camera_, kSkyWidth, kSkyHeight, 100.0 * glm::dvec3(scene_.space.sun_direction_W));
    return Light()[Index(static_cast<int>(pixel.x), static_cast<int>(pixel.y))];
  };
  const glm::vec4 high = at_sun(0.1), low = at_sun(0.003);
  EXPECT_NEAR(high.r / high.b, 1.0f, 0.05f);
  EXPECT_GT(low.r, 3.0f * low.b);
  EXPECT_LT(low.r, high.r);
}

}  // namespace
}  // namespace visual_node
