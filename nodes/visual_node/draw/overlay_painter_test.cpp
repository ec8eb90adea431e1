#include "nodes/visual_node/draw/overlay_painter.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "nodes/visual_node/draw/renderer.hpp"
#include "nodes/visual_node/testing/gl_test.hpp"
#include "nodes/visual_node/testing/share_points.hpp"
#include "view/projection.hpp"
#include "view/robot_marks.hpp"
#include "vps/mesh/vertex_normals.hpp"
#include "vps/testing/shapes.hpp"

namespace visual_node {
namespace {

constexpr int kFrameWidth = 640, kFrameHeight = 360;

core::Result<vps::VisualMesh> MakeOverlayShape(const std::filesystem::path& name) {
  if (name == "ball") return vps::VisualMesh{{vps::SplitAtCreases(vps::MakeSphere(0.1, 48), 0.6)}};
  return vps::VisualMesh{{vps::SplitAtCreases(vps::MakeBox({2.0, 0.02, 2.0}), 0.6)}};
}

scene::Camera CameraFromTheFront() {
  scene::Camera camera;
  camera.eye_m = {0.0, -1.0, 0.0};
  camera.target_m = {0.0, 0.0, 0.0};
  camera.vertical_fov_rad = 0.6;
  return camera;
}

// A ball at the origin in front of a wall; the sun is behind the eye.
view::Scene BallAndWall() {
  view::Scene scene;
  auto assets = std::make_shared<view::Assets>();
  assets->meshes = {"ball", "wall"};
  assets->instance_names = {"ball", "wall"};
  assets->cameras = {CameraFromTheFront()};
  scene.assets = assets;
  scene.space.sun_direction_W = {0.0, -1.0, 0.0};
  for (std::uint32_t i = 0; i < 2; ++i) {
    view::Instance instance;
    instance.mesh = i;
    instance.X_WM.translation.y = 0.5 * i;
    instance.material.base_color = glm::vec3(0.2f);
    instance.material.roughness = 1.0f;
    instance.is_material_given = true;
    scene.instances.push_back(instance);
  }
  return scene;
}

class OverlayPainterTest : public GlTest {
 protected:
  void SetUp() override {
    GlTest::SetUp();
    if (IsSkipped()) return;
    auto renderer = Renderer::Create(scene_, MakeOverlayShape);
    ASSERT_TRUE(renderer) << renderer.error().detail;
    renderer_ = std::move(*renderer);
    target_ = std::make_unique<RenderTarget>(kFrameWidth, kFrameHeight);
  }
  Image Draw() {
    const auto drawn = renderer_->Draw(scene_, CameraFromTheFront(), *target_, look_);
    EXPECT_TRUE(drawn) << drawn.error().detail;
    EXPECT_EQ(glGetError(), static_cast<GLenum>(GL_NO_ERROR));
    return target_->Read();
  }
  // Linear light at the pixel that shows p_W.
  glm::vec3 LightAt(const glm::dvec3& p_W) {
    Draw();
    const glm::dvec3 pixel = view::ProjectToPixel(CameraFromTheFront(), kFrameWidth, kFrameHeight, p_W);
    const std::vector<float> light = renderer_->film().ReadLight();
    const int row = kFrameHeight - 1 - static_cast<int>(pixel.y);
    const auto index = 4 * static_cast<std::size_t>(row * kFrameWidth + static_cast<int>(pixel.x));
    return {light[index], light[index + 1], light[index + 2]};
  }
  // Pixels of a column or a row that are the colour of an overlay: much redder than the grey scene.
  static int CountRed(const Image& image, int x, int y, bool is_column) {
    int count = 0;
    for (int i = 0; i < (is_column ? image.height : image.width); ++i) {
      const std::uint8_t* p = is_column ? image.Pixel(x, i) : image.Pixel(i, y);
      count += p[0] > p[1] + 100 ? 1 : 0;
    }
    return count;
  }

  view::Scene scene_ = BallAndWall();
  std::unique_ptr<Renderer> renderer_;
  std::unique_ptr<RenderTarget> target_;
  Look look_{.exposure = 1.0f, .with_texts = false};
};

// Pixels around what is at p_W, in a square of `half_m` to each side, for which `is_one` holds.
template <class IsOne>
int CountAround(const glm::dvec3& p_W, double half_m, const IsOne& is_one) {
  const auto at = [&](double side) {
    return view::ProjectToPixel(CameraFromTheFront(), kFrameWidth, kFrameHeight,
                                p_W + side * half_m * glm::dvec3(1.0, 0.0, 1.0));
  };
  const glm::dvec3 low = at(-1.0), high = at(1.0);
  int count = 0;
  for (int y = static_cast<int>(std::min(low.y, high.y)); y <= static_cast<int>(std::max(low.y, high.y)); ++y) {
    for (int x = static_cast<int>(low.x); x <= static_cast<int>(high.x); ++x) count += is_one(x, y) ? 1 : 0;
  }
  return count;
}

// A robot before the scene: three joints whose axes point to the eye, the first with 10 Nm more than it was commanded,
// the last with 10 Nm less; its interpolator wants it 0.11 m higher.
core::DeviceJoints RobotInFront() {
  core::DeviceJoints robot;
  robot.X_WD.translation = {0.28, -0.3, -0.08};
  robot.X_WD_target.translation = {0.28, -0.3, 0.1};
  for (int i = 0; i < 3; ++i) {
    core::DeviceJoint joint;
    joint.X_WL = {core::QuaternionFromRollPitchYaw({1.5707963267948966, 0.0, 0.0}), {0.2 * i - 0.2, -0.3, -0.08}};
    joint.X_WL_target = {joint.X_WL.rotation, {0.2 * i - 0.2, -0.3, 0.1}};
    joint.radius_m = 0.025f;
    joint.commanded_Nm = 3.0f;
    joint.measured_Nm = i == 0 ? 13.0f : i == 1 ? 3.2f : -7.0f;
    robot.joints.push_back(joint);
  }
  return robot;
}

TEST_F(OverlayPainterTest, ARobotHasRedArcsAtJointsWithATorqueErrorAndAtNoOthers) {
  const core::DeviceJoints robot = RobotInFront();
  view::AddRobot(robot, &scene_);
  const Image image = Draw();
  const auto reds = [&](std::size_t joint) {
    return CountAround(robot.joints[joint].X_WL.translation, 0.06, [&](int x, int y) {
      const std::uint8_t* p = image.Pixel(x, y);
      return p[0] > p[1] + 60 && p[0] > p[2] + 60;
    });
  };
  EXPECT_GT(reds(0), 40);
  EXPECT_EQ(reds(1), 0) << "0.2 Nm are below what its sensors see";
  EXPECT_GT(reds(2), 40);
}

TEST_F(OverlayPainterTest, ARobotsGreenPhantomStandsAtItsTargetAndOnlyWhereThereIsOne) {
  core::DeviceJoints robot = RobotInFront();
  const view::Scene bare = scene_;
  const auto greens = [&](const glm::dvec3& p_W) {
    scene_ = bare;
    view::AddRobot(robot, &scene_);
    const Image image = Draw();
    return CountAround(p_W, 0.015, [&](int x, int y) {
      const std::uint8_t* p = image.Pixel(x, y);
      return p[1] > p[0] + 15 && p[1] > p[2] + 10;
    });
  };
  const glm::dvec3 wanted = robot.joints[1].X_WL_target.translation;
  EXPECT_EQ(greens(wanted), 0) << "no target";
  robot.has_target = true;
  EXPECT_GT(greens(wanted), 100);
  EXPECT_EQ(greens(robot.joints[1].X_WL.translation), 0) << "the robot itself is not green";
  for (core::DeviceJoint& joint : robot.joints) joint.X_WL_target.translation.z -= 0.25;
  robot.X_WD_target.translation.z -= 0.25;
  EXPECT_EQ(greens(wanted), 0) << "it has moved away";
}

TEST_F(OverlayPainterTest, ARobotsBillboardsStandAtItsJoints) {
  const core::DeviceJoints robot = RobotInFront();
  view::AddRobot(robot, &scene_);
  const Image without = Draw();
  look_.with_texts = true;
  const Image with = Draw();
  for (const core::DeviceJoint& joint : robot.joints) {
    EXPECT_GT(CountAround(joint.X_WL.translation, 0.08,
                          [&](int x, int y) {
                            const std::uint8_t *a = with.Pixel(x, y), *b = without.Pixel(x, y);
                            return std::abs(int{a[0]} - int{b[0]}) > 30;
                          }),
              20);
  }
}

TEST_F(OverlayPainterTest, OverlappingPhantomsLookTheSameInAnyOrder) {
  const auto phantom = [](double x_m, double y_m, const glm::vec3& color, float opacity) {
    view::Phantom one;
    one.X_WM.translation = {x_m, y_m, 0.0};
    one.color = color;
    one.opacity = opacity;
    return one;
  };
  scene_.phantoms = {phantom(-0.05, -0.3, {0, 1, 0}, 0.3f), phantom(0.05, -0.4, {1, 0, 0}, 0.6f),
                     phantom(0.0, -0.2, {0, 0, 1}, 0.5f)};
  const Image forwards = Draw();
  std::reverse(scene_.phantoms.begin(), scene_.phantoms.end());
  const Image backwards = Draw();
  int most = 0;
  for (std::size_t i = 0; i < forwards.rgba.size(); ++i) {
    most = std::max(most, std::abs(int{forwards.rgba[i]} - int{backwards.rgba[i]}));
  }
  EXPECT_LE(most, 1);
  scene_.phantoms.clear();
  EXPECT_NE(Draw().rgba, forwards.rgba) << "no phantom was drawn";
}

TEST_F(OverlayPainterTest, APhantomHidesAsMuchAsItsOpacity) {
  const glm::dvec3 in_front{0.0, -0.4, 0.0};
  const glm::vec3 without = LightAt(in_front);
  view::Phantom phantom;
  phantom.X_WM.translation = in_front;
  phantom.color = {0.0f, 0.9f, 0.0f};
  phantom.opacity = 0.4f;
  scene_.phantoms = {phantom};
  const glm::vec3 with = LightAt(in_front);
  EXPECT_NEAR(with.r, 0.6f * without.r, 0.01f);
  EXPECT_NEAR(with.g, 0.6f * without.g + 0.4f * 0.9f, 0.01f);
  look_.exposure = 0.5f;
  EXPECT_NEAR(LightAt(in_front).g, 0.6f * without.g + 0.4f * 1.8f, 0.02f) << "the same in every exposure";
}

TEST_F(OverlayPainterTest, APhantomBehindAPartIsHidden) {
  const Image without = Draw();
  view::Phantom phantom;
  phantom.X_WM.translation.y = 0.7;  // behind the wall
  scene_.phantoms = {phantom};
  EXPECT_EQ(Draw().rgba, without.rgba);
}

TEST_F(OverlayPainterTest, ATransparentInstanceLetsTheWallThroughAndCastsNoShadow) {
  const glm::vec3 wall = LightAt({0.25, 0.0, 0.0});
  scene_.instances[0].opacity = 0.25f;
  const glm::vec3 middle = LightAt({0.0, 0.0, 0.0});
  const glm::vec3 own(0.2f);  // seen along its normal
  EXPECT_NEAR(middle.g, 0.75f * wall.g + 0.25f * own.g, 0.05f * wall.g);
}

TEST_F(OverlayPainterTest, AHighlightIsOverItsOwnSurface) {
  const glm::vec3 without = LightAt({0.0, 0.0, 0.0});
  scene_.instances[0].highlight = 0.4f;
  const glm::vec3 with = LightAt({0.0, 0.0, 0.0});
  EXPECT_NEAR(with.r, 0.6f * without.r + 0.4f * view::kHighlight.r, 0.01f);
}

TEST_F(OverlayPainterTest, ALineHasItsWidthAtAnyDistance) {
  for (const double y_m : {-0.5, -0.2}) {
    view::LineStrip line;
    const auto y = static_cast<float>(y_m);
    line.p_W = Share({{-0.3f, y, 0.0f}, {0.0f, y, 0.0f}, {0.3f, y, 0.0f}});
    line.color = {1.0f, 0.0f, 0.0f};
    line.width_px = 6.0f;
    scene_.lines = {line};
    EXPECT_NEAR(CountRed(Draw(), kFrameWidth / 2 + 10, 0, true), 6, 1) << y_m;
  }
}

TEST_F(OverlayPainterTest, ALineThatPassesTheEyeIsCutOff) {
  view::LineStrip line;
  line.p_W = Share({{0.0f, -3.0f, -0.1f}, {0.0f, 0.0f, -0.05f}});
  line.color = {1.0f, 0.0f, 0.0f};
  scene_.lines = {line};
  const Image image = Draw();
  EXPECT_EQ(CountRed(image, 0, 40, false), 0) << "above the horizon";
  EXPECT_GT(CountRed(image, 0, kFrameHeight - 40, false), 0);
}

TEST_F(OverlayPainterTest, APointIsADiscOfItsSizeAtItsPlace) {
  view::PointSet set;
  set.X_WP.translation = {0.0, -0.4, 0.0};
  set.p_P = Share({{0.1f, 0.0f, 0.05f}});
  set.colors = Share({{1.0f, 0.0f, 0.0f}});
  set.size_px = 8.0f;
  scene_.points = {set};
  const Image image = Draw();
  const glm::dvec3 pixel = view::ProjectToPixel(CameraFromTheFront(), kFrameWidth, kFrameHeight, {0.1, -0.4, 0.05});
  const auto x = static_cast<int>(pixel.x), y = static_cast<int>(pixel.y);
  int all = 0;
  for (int column = x - 4; column <= x + 4; ++column) all += CountRed(image, column, 0, true);
  EXPECT_NEAR(all, 50, 14) << "pi times the square of 4, its edge is smoothed";
  EXPECT_EQ(CountRed(image, x - 6, 0, true) + CountRed(image, x + 6, 0, true), 0);
  EXPECT_EQ(CountRed(image, 0, y - 6, false) + CountRed(image, 0, y + 6, false), 0);
}

TEST_F(OverlayPainterTest, ACubeCoversItsFaceAndHidesWhatIsBehindIt) {
  view::Cubes cubes;
  cubes.X_WP.translation = {0.0, -0.4, 0.0};
  cubes.p_P = Share({{0.0f, 0.0f, 0.0f}});
  cubes.edge_m = 0.1;
  cubes.color = {1.0f, 0.0f, 0.0f};
  scene_.cubes = {cubes};
  const Image image = Draw();
  const double face_px = 0.1 / 0.55 * 0.5 * kFrameHeight / std::tan(0.3);  // its front face is 0.55 m away
  EXPECT_NEAR(CountRed(image, 0, kFrameHeight / 2, false), face_px, 2.0);
  EXPECT_NEAR(CountRed(image, kFrameWidth / 2, 0, true), face_px, 2.0);
  view::LineStrip line;  // behind the cube's front, before its back
  line.p_W = Share({{-0.02f, -0.4f, 0.0f}, {0.02f, -0.4f, 0.0f}});
  line.color = {0.0f, 0.0f, 1.0f};
  scene_.lines = {line};
  EXPECT_GT(LightAt({0.0, -0.4, 0.0}).r, LightAt({0.0, -0.4, 0.0}).b) << "a cube is solid: the line is faint";
}

TEST_F(OverlayPainterTest, ASphereHasItsSilhouetteAndPartsHideIt) {
  const Image without = Draw();
  view::Spheres spheres;
  spheres.X_WP.translation = {0.0, -0.4, 0.0};
  spheres.p_P_radius_m = std::make_shared<const std::vector<glm::vec4>>(1, glm::vec4(0.25f, 0.0f, 0.0f, 0.05f));
  spheres.color = {1.0f, 0.0f, 0.0f};
  scene_.spheres = {spheres};
  const Image with = Draw();
  int changed = 0;
  for (std::size_t i = 0; i < with.rgba.size(); i += 4) changed += std::abs(with.rgba[i] - without.rgba[i]) > 3 ? 1 : 0;
  // Of a sphere at the eye's distance d its outline has the area of the ellipse pi (r f / d)^2 cos^-3, to within r/d.
  const double focal_px = 0.5 * kFrameHeight / std::tan(0.3), d = std::hypot(0.25, 0.6);
  const double area_px = 3.14159 * std::pow(0.05 * focal_px / d, 2) / std::pow(0.6 / d, 3);
  EXPECT_NEAR(changed, area_px, 0.05 * area_px);
  spheres.X_WP.translation.y = 0.7;  // behind the wall
  scene_.spheres = {spheres};
  EXPECT_EQ(Draw().rgba, without.rgba);
}

TEST_F(OverlayPainterTest, PointsOfASurfaceAreBeforeItAndDoNotShowThroughIt) {
  const Image without = Draw();
  view::PointSet set;
  set.p_P = Share({{0.04f, 0.0916f, 0.0f}});  // on the ball's back
  set.color = {1.0f, 0.0f, 0.0f};
  set.size_px = 8.0f;
  set.shows_through = false;
  scene_.points = {set};
  EXPECT_EQ(Draw().rgba, without.rgba);
  scene_.points[0].p_P = Share({{0.0f, -0.099f, 0.0f}});  // on its front, to within a millimetre
  EXPECT_GE(CountRed(Draw(), kFrameWidth / 2, 0, true), 7);
}

TEST_F(OverlayPainterTest, APointIsNeverLargerThanItsPlaceOnThePart) {
  view::PointSet set;
  set.p_P = Share({{0.0f, -0.4f, 0.0f}});
  set.color = {1.0f, 0.0f, 0.0f};
  set.size_px = 40.0f;
  set.most_m = 0.02f;
  scene_.points = {set};
  EXPECT_NEAR(CountRed(Draw(), kFrameWidth / 2, 0, true), 0.02 / 0.6 * 0.5 * kFrameHeight / std::tan(0.3), 1.5);
}

TEST_F(OverlayPainterTest, ARingSpansItsSweep) {
  view::RingArrow ring;
  ring.p_WCentre = {0.0, -0.4, 0.0};
  ring.axis_W = {0.0, -1.0, 0.0};  // towards the eye
  ring.radius_m = 0.1;
  ring.sweep_rad = 1.0;
  ring.color = {1.0f, 0.0f, 0.0f};
  const auto count = [&] {
    scene_.rings = {ring};
    const Image image = Draw();
    int pixels = 0;
    for (int y = 0; y < kFrameHeight; ++y) pixels += CountRed(image, 0, y, false);
    return pixels;
  };
  const int small = count();
  ring.sweep_rad = 4.0;
  const int big = count();
  EXPECT_GT(small, 50);
  const double pixel_m = 2.0 * 0.6 * std::tan(0.3) / kFrameHeight;
  EXPECT_NEAR(big - small, 3.0 * ring.radius_m / pixel_m * 3.0, 150.0) << "an arc of 3 rad, 3 px thick";
}

TEST_F(OverlayPainterTest, AxesAreRedGreenAndBlueAlongXYAndZ) {
  const core::Pose X_WA{glm::angleAxis(-1.5707963267948966, glm::dvec3(1.0, 0.0, 0.0)), {-0.05, -0.4, 0.0}};
  scene_.axes.push_back({X_WA, 0.1});  // y points down in the picture, z to the eye's back
  const auto light = [&](double x_m, double z_m) { return LightAt({-0.05 + x_m, -0.4, z_m}); };
  const glm::vec3 x = light(0.05, 0.0), y = light(0.0, -0.05), opposite = light(-0.05, 0.0);
  EXPECT_GT(x.r, 2.0f * std::max(x.g, x.b));
  EXPECT_GT(y.g, 2.0f * std::max(y.r, y.b));
  EXPECT_NEAR(opposite.r, opposite.b, 0.1f * opposite.r) << "the scene's grey";
  scene_.axes[0].X_WA.rotation = glm::dquat(1.0, 0.0, 0.0, 0.0);
  const glm::vec3 z = light(0.0, 0.05);
  EXPECT_GT(z.b, 2.0f * std::max(z.r, z.g));
}

TEST_F(OverlayPainterTest, ALabelStandsAboveItsPlaceInReadableLetters) {
  look_.with_texts = true;
  scene_.labels.push_back({{0.1, -0.4, 0.05}, "12.3 N", {1.0f, 1.0f, 1.0f}});
  scene_.labels.push_back({{0.1, -0.4, 0.05}, "the same place", {1.0f, 1.0f, 1.0f}});
  scene_.labels.push_back({{0.1, -3.0, 0.05}, "behind the eye", {1.0f, 1.0f, 1.0f}});
  Draw();
  const std::vector<PlacedLine>& placed = renderer_->placed_lines();
  ASSERT_EQ(placed.size(), 2u);
  const glm::dvec3 pixel = view::ProjectToPixel(CameraFromTheFront(), kFrameWidth, kFrameHeight, {0.1, -0.4, 0.05});
  EXPECT_NEAR(placed[0].x + 0.5 * placed[0].width, pixel.x, 1.0);
  EXPECT_LT(placed[0].y + placed[0].height, pixel.y);
  EXPECT_GE(placed[0].height, 12);
  const bool is_beside = placed[1].x >= placed[0].x + placed[0].width || placed[1].x + placed[1].width <= placed[0].x;
  const bool is_over = placed[1].y >= placed[0].y + placed[0].height || placed[1].y + placed[1].height <= placed[0].y;
  EXPECT_TRUE(is_beside || is_over) << "one label covers the other";
}

TEST_F(OverlayPainterTest, ALabelKeepsClearOfArrowsAndCaptionsAndLongOnesHaveSeveralLines) {
  look_.with_texts = true;
  const glm::dvec3 p_W(0.0, -0.4, 0.0);
  scene_.labels.push_back({p_W, "Take the cover by its tab, pull it off and put it aside", {1.0f, 1.0f, 1.0f}});
  scene_.arrows.push_back({p_W, {0.0, 0.0, 0.08}, {1.0f, 0.0f, 0.0f}});
  scene_.texts = {{view::Anchor::kTopLeft, view::TextStyle::kBody, glm::vec3(1.0f), "a caption"}};
  Draw();
  const std::vector<PlacedLine>& placed = renderer_->placed_lines();
  ASSERT_GE(placed.size(), 3u);
  const glm::dvec2 tail(view::ProjectToPixel(CameraFromTheFront(), kFrameWidth, kFrameHeight, p_W));
  const glm::dvec2 tip(
      view::ProjectToPixel(CameraFromTheFront(), kFrameWidth, kFrameHeight, p_W + glm::dvec3(0, 0, 0.08)));
  for (std::size_t i = 1; i < placed.size(); ++i) {
    const glm::dvec2 low(placed[i].x, placed[i].y);
    EXPECT_EQ(LengthWithin({low, low + glm::dvec2(placed[i].width, placed[i].height)}, {tail, tip}), 0.0);
    EXPECT_LE(placed[i].width, kFrameHeight / 2) << placed[i].line.text;
  }
}

}  // namespace
}  // namespace visual_node
