#include "nodes/visual_node/draw/composer.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

#include "nodes/visual_node/testing/gl_test.hpp"
#include "vps/mesh/vertex_normals.hpp"
#include "vps/testing/shapes.hpp"

namespace visual_node {
namespace {

constexpr int kWindowWidth = 640, kWindowHeight = 360;

// "dot_R": a ball of R millimetres.
core::Result<vps::VisualMesh> MakeDot(const std::filesystem::path& name) {
  const double radius_m = 1e-3 * std::stod(name.string().substr(4));
  return vps::VisualMesh{{vps::SplitAtCreases(vps::MakeSphere(radius_m, 48), 0.6)}};
}

scene::Camera Ahead() {
  scene::Camera camera;
  camera.name = "ahead";
  camera.eye_m = {0.0, -1.5, 0.2};
  camera.target_m = {0.0, 0.0, 0.2};
  camera.vertical_fov_rad = 0.8;
  return camera;
}

scene::Camera FromTheRight() {
  scene::Camera camera = Ahead();
  camera.name = "right";
  camera.eye_m = {1.2, -0.4, 0.3};
  return camera;
}

// One ball that shines by itself, so that its picture is a disc of one colour.
view::Scene OneDot(const glm::dvec3& p_W, int radius_mm) {
  view::Scene scene;
  auto assets = std::make_shared<view::Assets>();
  assets->meshes = {"dot_" + std::to_string(radius_mm)};
  assets->instance_names = {"dot"};
  assets->cameras = {Ahead(), FromTheRight()};
  scene.assets = assets;
  scene.space.sun_direction_W = {0.0, 0.0, 1.0};
  view::Instance instance;
  instance.X_WM.translation = p_W;
  instance.material.base_color = glm::vec3(0.0f);
  instance.material.emissive = glm::vec3(0.7f);
  instance.is_material_given = true;
  scene.instances.push_back(instance);
  return scene;
}

class ComposerTest : public GlTest {
 protected:
  void SetUp() override {
    GlTest::SetUp();
    if (IsSkipped()) return;
    auto composer = Composer::Create();
    ASSERT_TRUE(composer) << composer.error().detail;
    composer_ = std::move(*composer);
  }

  Image Draw(const view::Scene& scene, int samples = 1, bool with_texts = false) {
    auto renderer = Renderer::Create(scene, MakeDot);
    EXPECT_TRUE(renderer) << renderer.error().detail;
    const RenderTarget target(kWindowWidth, kWindowHeight);
    const Look look{.with_texts = with_texts};
    const auto drawn = composer_->DrawEyes(**renderer, {scene, Ahead(), composition_}, look, target, samples);
    EXPECT_TRUE(drawn) << drawn.error().detail;
    composer_->Join(composition_.viewing.stereo, target);
    EXPECT_EQ(glGetError(), static_cast<GLenum>(GL_NO_ERROR));
    return target.Read();
  }

  // What the dot adds to a channel of the picture (0 red, 2 blue): its centroid [px], over the pixels that are wanted.
  // All that is brighter than half of the brightest counts alike, because glasses of an anaglyph are told apart by
  // taking a little of one eye's light from the other's, where it has any.
  using Wanted = std::function<bool(int x, int y)>;
  glm::dvec2 Centroid(const Image& with, const Image& without, int channel, const Wanted& is_wanted) {
    const auto added = [&](int x, int y) {
      return is_wanted(x, y) ? with.Pixel(x, y)[channel] - without.Pixel(x, y)[channel] : 0;
    };
    int most = 0;
    for (int y = 0; y < with.height; ++y) {
      for (int x = 0; x < with.width; ++x) most = std::max(most, added(x, y));
    }
    EXPECT_GT(most, 100) << "nothing is seen";
    glm::dvec2 sum(0.0);
    double weight = 0.0;
    for (int y = 0; y < with.height; ++y) {
      for (int x = 0; x < with.width; ++x) {
        const double share = std::clamp(2.0 * added(x, y) / most, 0.0, 1.0);
        if (share < 0.2) continue;  // what the other eye's picture leaves in this channel of an anaglyph
        sum += share * glm::dvec2(x + 0.5, y + 0.5);
        weight += share;
      }
    }
    return sum / weight;
  }

  // Centroids in the left eye's picture and the right one's, in pixels of a window for one eye.
  std::array<glm::dvec2, 2> Seen(const glm::dvec3& p_W, int radius_mm) {
    view::Scene scene = OneDot(p_W, radius_mm);
    const Image with = Draw(scene, 2);
    scene.instances[0].is_visible = false;
    const Image without = Draw(scene, 2);
    std::array<glm::dvec2, 2> seen;
    for (int eye = 0; eye < 2; ++eye) {
      switch (composition_.viewing.stereo) {
        case view::Stereo::kSideBySide:
          seen[eye] = Centroid(with, without, 1, [&](int x, int) { return x / (kWindowWidth / 2) == eye; });
          seen[eye].x = 2.0 * (seen[eye].x - eye * kWindowWidth / 2);
          break;
        case view::Stereo::kTopBottom:
          seen[eye] = Centroid(with, without, 1, [&](int, int y) { return y / (kWindowHeight / 2) == eye; });
          seen[eye].y = 2.0 * (seen[eye].y - eye * kWindowHeight / 2);
          break;
        case view::Stereo::kInterlaced:
          seen[eye] = Centroid(with, without, 1, [&](int, int y) { return y % 2 == eye; });
          break;
        default:
          seen[eye] = Centroid(with, without, eye == 0 ? 0 : 2, [](int, int) { return true; });
      }
    }
    return seen;
  }

  Composition composition_;
  std::optional<Composer> composer_;
};

// Disparity e f (1/D - 1/z): see stereo_test.cpp. Both eyes' pictures are where each display takes them from, the left
// one for the left eye.
TEST_F(ComposerTest, APointAtAKnownDepthHasItsDisparityInEachMode) {
  const double focal_px = 0.5 * kWindowHeight / std::tan(0.5 * Ahead().vertical_fov_rad);
  double largest_px = 0.0;
  for (const view::StereoInfo& info : view::kStereoModes) {
    composition_.viewing.stereo = info.mode;
    for (const double z_m : {0.7, 1.5, 4.0}) {
      const glm::dvec3 p_W = Ahead().eye_m + z_m * glm::dvec3(0.11, 1.0, -0.07);
      const auto seen = Seen(p_W, static_cast<int>(30.0 * z_m));
      const double expected_px = view::kEyeDistance_m * focal_px * (1.0 / 1.5 - 1.0 / z_m);
      const double off_px = std::abs(seen[1].x - seen[0].x - expected_px);
      EXPECT_LE(off_px, 0.25) << info.name << " at " << z_m << " m";
      largest_px = std::max(largest_px, off_px);
      const double middle_px = 0.5 * kWindowWidth + focal_px * 0.11;
      EXPECT_NEAR(0.5 * (seen[0].x + seen[1].x), middle_px, 0.5) << info.name;
      for (int eye = 0; eye < 2; ++eye) {
        EXPECT_NEAR(seen[eye].y, 0.5 * kWindowHeight + focal_px * 0.07, 0.5) << info.name << " eye " << eye;
      }
    }
  }
  RecordProperty("largest_px", std::to_string(largest_px));
}

// Where a ball covers the window that a screen is, seen from an eye: by lines of sight through points of the screen.
glm::dvec2 CoveredCentre(const view::Screen& screen, const glm::dvec3& eye, const glm::dvec3& p, double radius_m) {
  constexpr int kSteps = 3;  // points for each pixel's width and height
  glm::dvec2 sum(0.0);
  double number = 0.0;
  for (int row = 0; row < kSteps * kWindowHeight; ++row) {
    for (int column = 0; column < kSteps * kWindowWidth; ++column) {
      const glm::dvec2 at((column + 0.5) / kSteps, (row + 0.5) / kSteps);
      const glm::dvec3 on_screen = screen.lower_left + at.x / kWindowWidth * (screen.lower_right - screen.lower_left) +
                                   (1.0 - at.y / kWindowHeight) * (screen.upper_left - screen.lower_left);
      if (glm::length(glm::cross(glm::normalize(on_screen - eye), p - eye)) > radius_m) continue;
      sum += at;
      number += 1.0;
    }
  }
  return sum / number;
}

// What is seen on a wall is where the line of sight from the head goes through it, also in the wall's corners.
TEST_F(ComposerTest, AWallIsAWindowForTheHeadBeforeIt) {
  view::Viewing& viewing = composition_.viewing;
  viewing.screen_R = view::Screen{{-1.2, 0.2, -0.7}, {0.0, 1.4, -0.7}, {-1.2, 0.2, 0.254594}};  // 16:9, at 45 degrees
  const core::Pose X_WR = view::RoomOf(Ahead());
  const view::Screen screen_W = view::Place(X_WR, *viewing.screen_R);
  double largest_px = 0.0;
  for (const glm::dvec3& head : {glm::dvec3(0.0, 0.0, 0.0), glm::dvec3(0.3, -0.4, -0.2), glm::dvec3(-0.5, 0.1, 0.2)}) {
    viewing.X_RH.translation = head;
    for (const glm::dvec2& share : {glm::dvec2(0.05, 0.08), glm::dvec2(0.94, 0.07), glm::dvec2(0.06, 0.93)}) {
      const glm::dvec3 p_W = screen_W.lower_left + share.x * (screen_W.lower_right - screen_W.lower_left) +
                             share.y * (screen_W.upper_left - screen_W.lower_left);
      view::Scene scene = OneDot(p_W, 20);
      const Image with = Draw(scene, 2);
      scene.instances[0].is_visible = false;
      const Image without = Draw(scene, 2);
      const glm::dvec2 seen = Centroid(with, without, 1, [](int, int) { return true; });
      const glm::dvec2 expected = CoveredCentre(screen_W, X_WR * head, p_W, 0.02);
      largest_px = std::max(largest_px, glm::distance(seen, expected));
    }
  }
  RecordProperty("largest_px", std::to_string(largest_px));
  EXPECT_LE(largest_px, 0.25);
}

TEST_F(ComposerTest, EachViewOfALayoutShowsItsCamerasPicture) {
  view::Scene scene = OneDot({0.1, 0.2, 0.25}, 30);
  composition_.layout.rows = {{"", "right"}, {"right"}};
  const Image all = Draw(scene);
  const std::vector<view::Pane> panes = view::PanesOf(composition_.layout, kWindowWidth, kWindowHeight);
  auto renderer = Renderer::Create(scene, MakeDot);
  ASSERT_TRUE(renderer);
  for (std::size_t i = 0; i < panes.size(); ++i) {
    const RenderTarget alone(panes[i].size_px.x, panes[i].size_px.y);
    ASSERT_TRUE((*renderer)->Draw(scene, i == 0 ? Ahead() : FromTheRight(), alone, {.with_texts = false}));
    const Image expected = alone.Read();
    int num_different = 0;
    for (int y = 0; y < expected.height; ++y) {
      for (int x = 0; x < expected.width; ++x) {
        const std::uint8_t* is = all.Pixel(panes[i].corner_px.x + x, panes[i].corner_px.y + y);
        const std::uint8_t* should = expected.Pixel(x, y);
        for (int k = 0; k < 3; ++k) num_different += std::abs(is[k] - should[k]) > 1 ? 1 : 0;
      }
    }
    EXPECT_EQ(num_different, 0) << "view " << i;
  }
}

TEST_F(ComposerTest, OneViewForOneEyeIsTheRenderersPicture) {
  const view::Scene scene = OneDot({0.1, 0.2, 0.25}, 30);
  auto renderer = Renderer::Create(scene, MakeDot);
  ASSERT_TRUE(renderer);
  const RenderTarget alone(kWindowWidth, kWindowHeight);
  ASSERT_TRUE((*renderer)->Draw(scene, Ahead(), alone, {.with_texts = false}));
  EXPECT_EQ(Draw(scene).rgba, alone.Read().rgba);
}

// A place in a divided stereo window belongs to the view and the eye whose picture is there: the dot's projection for
// that eye leads back to its pixel.
TEST_F(ComposerTest, APixelOfTheWindowBelongsToItsViewAndEye) {
  const view::Scene scene = OneDot({0.1, 0.2, 0.25}, 30);
  composition_.layout.rows = {{"", "right"}};
  for (const view::Stereo stereo : {view::Stereo::kNone, view::Stereo::kSideBySide, view::Stereo::kTopBottom}) {
    composition_.viewing.stereo = stereo;
    const Composer::Shown shown{scene, Ahead(), composition_};
    int num_found = 0;
    for (int y = 1; y < kWindowHeight; y += 7) {
      for (int x = 1; x < kWindowWidth; x += 7) {
        const auto spot = Composer::Find(shown, kWindowWidth, kWindowHeight, {x, y});
        if (!spot) continue;
        ++num_found;
        EXPECT_LT(spot->at_px.x, spot->size_px.x);
        EXPECT_LT(spot->at_px.y, spot->size_px.y);
      }
    }
    EXPECT_GT(num_found, 4000);
    const auto left = Composer::Find(shown, kWindowWidth, kWindowHeight, {30, 30});
    const auto right =
        Composer::Find(shown, kWindowWidth, kWindowHeight,
                       {stereo == view::Stereo::kSideBySide ? 350 : 30, stereo == view::Stereo::kTopBottom ? 210 : 30});
    ASSERT_TRUE(left && right);
    EXPECT_NEAR(glm::distance(left->eye.eye_W, right->eye.eye_W),
                stereo == view::Stereo::kNone ? 0.0 : view::kEyeDistance_m, 1e-12);
  }
}

}  // namespace
}  // namespace visual_node
