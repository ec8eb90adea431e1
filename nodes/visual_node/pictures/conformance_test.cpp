// The GL node against exact geometry, and its live pictures against those that it keeps (libs/view/conformance).

#include <gtest/gtest.h>

#include <algorithm>

#include "nodes/visual_node/draw/object_pass.hpp"
#include "nodes/visual_node/draw/renderer.hpp"
#include "nodes/visual_node/pictures/still.hpp"
#include "nodes/visual_node/testing/gl_test.hpp"
#include "nodes/visual_node/testing/share_points.hpp"
#include "picture/flip.hpp"
#include "raytrace/develop.hpp"
#include "raytrace/tracer.hpp"
#include "scene/load_scenario.hpp"
#include "view/conformance/cast_ids.hpp"
#include "view/conformance/compare.hpp"
#include "view/conformance/testing/known_scene.hpp"
#include "view/scene_mirror.hpp"

namespace visual_node {
namespace {

constexpr int kPictureWidth = 320, kPictureHeight = 180;

class ConformanceTest : public GlTest {
 protected:
  void SetUp() override {
    GlTest::SetUp();
    if (IsSkipped()) return;
    auto renderer = Renderer::Create(scene_, view::MeshOfBody);
    ASSERT_TRUE(renderer) << renderer.error().detail;
    renderer_ = std::move(*renderer);
  }
  view::Rendering Kept() {
    const auto image = RenderSmooth(*renderer_, scene_, view::KnownCamera(), kPictureWidth, kPictureHeight);
    EXPECT_TRUE(image) << image.error().detail;
    return {*image, Ids()};
  }
  view::Rendering Live(double scale) {
    const RenderTarget target(kPictureWidth, kPictureHeight);
    const Look look{.scale = scale, .with_penumbra = false};
    const auto drawn = renderer_->Draw(scene_, view::KnownCamera(), target, look);
    EXPECT_TRUE(drawn) << drawn.error().detail;
    return {target.Read(), Ids()};
  }
  picture::Measured<std::uint16_t> Ids() {
    const auto pass = ObjectPass::Create();
    EXPECT_TRUE(pass) << pass.error().detail;
    return pass->Draw(*renderer_, scene_, view::KnownCamera(), kPictureWidth, kPictureHeight).ids;
  }

  view::Scene scene_ = view::KnownScene();
  std::unique_ptr<Renderer> renderer_;
};

TEST_F(ConformanceTest, EachPixelShowsTheObjectThatItsRayMeets) {
  const view::Rendering kept = Kept();
  view::Rendering exact = kept;
  exact.ids = view::CastIds(view::KnownBodies(), view::KnownCamera(), kPictureWidth, kPictureHeight);
  const view::Agreement agreement = view::Compare(exact, kept);
  RecordProperty("same_ids", std::to_string(agreement.same_ids));
  EXPECT_GE(agreement.same_ids, 0.995);
  EXPECT_EQ(agreement.same_ids_inside, 1.0) << "differs off the silhouettes";
}

TEST_F(ConformanceTest, ALivePictureLooksLikeTheOneThatIsKept) {
  const view::Rendering kept = Kept();
  const view::Agreement full = view::Compare(kept, Live(1.0)), half = view::Compare(kept, Live(0.5));
  RecordProperty("flip", std::to_string(full.flip));
  RecordProperty("flip_at_half_scale", std::to_string(half.flip));
  EXPECT_LE(full.flip, 0.05);
  EXPECT_LE(half.flip, 0.10);
  EXPECT_LT(full.flip, half.flip);
}

// As far off as live pictures may be, in the size of one at scale 0.7.
TEST_F(ConformanceTest, LevelsOfDetailAreNotSeen) {
  const auto scenario = scene::LoadScenario(std::filesystem::path(VR_OOS_SOURCE_DIR) / "scenarios/module_replacement");
  ASSERT_TRUE(scenario);
  const view::SceneMirror mirror(*scenario);
  const view::Scene& scene = mirror.scene();
  const auto load = [](const std::filesystem::path& file) { return vps::LoadVisualMesh(file); };
  auto renderer = Renderer::Create(scene, load);
  ASSERT_TRUE(renderer) << renderer.error().detail;
  const RenderTarget target(448, 252);
  const auto draw = [&](const scene::Camera& camera, double detail_px) {
    EXPECT_TRUE((*renderer)->Draw(scene, camera, target, {.with_penumbra = false, .detail_px = detail_px}));
    return target.Read();
  };
  std::vector<Image> whole;
  for (const scene::Camera& camera : scene.assets->cameras) whole.push_back(draw(camera, 0.0));
  for (std::size_t i = 0; i < scene.assets->meshes.size(); ++i) {
    auto mesh = load(scene.assets->meshes[i]);
    ASSERT_TRUE(mesh);
    const std::vector<Piece> pieces = MakePieces(&*mesh);
    (*renderer)->SetDetail(i, *mesh, pieces);
  }
  for (std::size_t i = 0; i < whole.size(); ++i) {
    const scene::Camera& camera = scene.assets->cameras[i];
    const double flip = picture::Mean(picture::Flip(whole[i], draw(camera, 0.25)));
    RecordProperty("flip_" + camera.name, std::to_string(flip));
    EXPECT_GT(flip, 0.0) << camera.name;
    EXPECT_LE(flip, 0.02) << camera.name;
  }
}

TEST_F(ConformanceTest, AnotherColourIsNoticed) {
  const view::Rendering kept = Kept();
  scene_.instances[2].material.base_color = {0.7f, 0.3f, 0.1f};
  EXPECT_GT(view::Compare(kept, Kept()).flip, 0.02);
}

// The ray tracer's picture, with as many samples for each pixel as a picture that is kept. OpenGL mirrors only the
// light around.
view::Rendering Traced(const view::Scene& scene, const raytrace::MeshLoader& load_mesh, const scene::Camera& camera,
                       int width, int height) {
  const auto tracer = raytrace::Tracer::Create(scene, load_mesh);
  EXPECT_TRUE(tracer) << tracer.error().detail;
  (*tracer)->Update(scene, view::LightOf(scene.space));
  constexpr int kSamples = 2;
  const auto fine = raytrace::Eye::Of(camera, kSamples * width, kSamples * height);
  const auto lit = (*tracer)->Draw(fine, {0, 0, fine.width, fine.height}, {tiles::Mirrors::kNone});
  const auto objects = (*tracer)->FindObjects(raytrace::Eye::Of(camera, width, height), {0, 0, width, height});
  return {picture::Shrink(raytrace::Develop(lit.light, Exposure::kDaylight), kSamples), objects.ids};
}

// As rt_visual_node shows it: the sky and what is over the scene drawn with OpenGL, by the tiles' depths.
view::Rendering TracedOverSky(Renderer& renderer, const raytrace::Tracer& tracer, const view::Scene& scene,
                              const scene::Camera& camera, tiles::Mirrors mirrors) {
  constexpr int width = kPictureWidth, height = kPictureHeight;
  const RenderTarget target(kSmoothSamples * width, kSmoothSamples * height);
  const tiles::Tile whole{0, 0, target.width(), target.height()};
  const auto eye = raytrace::Eye::Of(camera, whole.width, whole.height);
  const auto lit = tracer.Draw(eye, whole, {mirrors});
  tiles::Canvas canvas;
  canvas.Resize(whole.width, whole.height);
  for (std::size_t i = 0; i < canvas.light.size(); ++i) {
    canvas.light[i] =
        tiles::PackLight({lit.light.values[3 * i], lit.light.values[3 * i + 1], lit.light.values[3 * i + 2]});
    canvas.depth[i] = tiles::PackDepth(lit.depth_m.values[i]);
  }
  const Pasted pasted{&canvas, {0, 0, canvas.width, canvas.height}};
  const auto drawn = renderer.Draw(scene, camera, target, {.surfaces = {&pasted, 1}});
  EXPECT_TRUE(drawn) << drawn.error().detail;
  const auto objects = tracer.FindObjects(raytrace::Eye::Of(camera, width, height), {0, 0, width, height});
  return {picture::Shrink(target.Read(), kSmoothSamples), objects.ids};
}

TEST_F(ConformanceTest, TheRayTracerSeesTheSameObjectsAndMaterials) {
  const view::Agreement agreement =
      view::Compare(Kept(), Traced(scene_, view::MeshOfBody, view::KnownCamera(), kPictureWidth, kPictureHeight));
  RecordProperty("same_ids", std::to_string(agreement.same_ids));
  RecordProperty("flip", std::to_string(agreement.flip));
  EXPECT_GE(agreement.same_ids, 0.995);
  EXPECT_EQ(agreement.same_ids_inside, 1.0);
  EXPECT_LE(agreement.flip, 0.05);
}

// One of each shape at least, over the known scene: before its bodies, behind them, and through them.
void AddEveryShape(view::Scene* scene) {
  const glm::vec3 red{1.0f, 0.1f, 0.1f}, green{0.1f, 0.9f, 0.2f}, blue{0.1f, 0.3f, 1.0f};
  scene->arrows = {{{-0.25, 0.0, 0.1}, {0.0, -0.1, 0.25}, red}, {{0.2, 0.3, 0.1}, {-0.5, -0.1, 0.1}, green}};
  scene->rings.push_back({{0.12, -0.3, 0.12}, glm::normalize(glm::dvec3(0.2, -1.0, 0.6)), 0.08, 4.0, blue});
  scene->axes.push_back({scene->instances[2].X_WM, 0.25});
  scene->lines.push_back({Share({{-0.6f, -0.4f, 0.05f}, {-0.2f, 0.1f, 0.1f}, {0.6f, 0.0f, 0.3f}}), green, 3.0f});
  view::PointSet points{{}, Share({{-0.3f, -0.3f, 0.01f}, {-0.2f, -0.3f, 0.01f}, {0.2f, 0.2f, 0.1f}}), nullptr, red};
  points.size_px = 8.0f;
  scene->points = {points};
  view::Cubes cubes{{}, Share({{0.4f, -0.3f, 0.05f}, {0.44f, -0.3f, 0.05f}, {0.25f, 0.1f, 0.2f}})};
  cubes.edge_m = 0.04;
  cubes.color = blue;
  scene->cubes = {cubes};
  const std::vector<glm::vec4> balls = {{-0.45f, -0.3f, 0.1f, 0.08f}, {-0.25f, 0.1f, 0.1f, 0.08f}};
  scene->spheres.push_back({{}, std::make_shared<const std::vector<glm::vec4>>(balls), red});
  view::Phantom phantom{1, scene->instances[1].X_WM, green};
  phantom.X_WM.translation += glm::dvec3(0.25, 0.1, 0.05);
  scene->phantoms = {phantom};
  scene->instances[3].highlight = 0.4f;
}

// Pixels that differ.
picture::Measured<std::uint16_t> Changed(const Image& before, const Image& after) {
  constexpr int kLeast = 12;  // of 255
  picture::Measured<std::uint16_t> changed(before.width, before.height);
  for (std::size_t i = 0; i < changed.values.size(); ++i) {
    for (std::size_t k = 4 * i; k < 4 * i + 3; ++k) {
      if (std::abs(int{before.rgba[k]} - int{after.rgba[k]}) >= kLeast) changed.values[i] = 1;
    }
  }
  return changed;
}

TEST_F(ConformanceTest, OverlaysOverTracedSurfacesAreWhereTheGlNodeHasThem) {
  const auto tracer = raytrace::Tracer::Create(scene_, view::MeshOfBody);
  ASSERT_TRUE(tracer) << tracer.error().detail;
  const auto traced = [&] {
    (*tracer)->Update(scene_, view::LightOf(scene_.space));
    return TracedOverSky(*renderer_, **tracer, scene_, view::KnownCamera(), tiles::Mirrors::kNone).image;
  };
  const Image gl_bare = Kept().image, traced_bare = traced();
  AddEveryShape(&scene_);
  const Image gl = Kept().image, over_traced = traced();
  const picture::Measured<std::uint16_t> in_gl = Changed(gl_bare, gl), in_traced = Changed(traced_bare, over_traced);
  int covered = 0, same = 0;
  for (std::size_t i = 0; i < in_gl.values.size(); ++i) {
    covered += in_gl.values[i];
    same += in_gl.values[i] == in_traced.values[i] ? 1 : 0;
  }
  const double flip = picture::Mean(picture::Flip(gl, over_traced), in_gl);
  const double share = static_cast<double>(same) / static_cast<double>(in_gl.values.size());
  RecordProperty("covered", std::to_string(covered));
  RecordProperty("same_overlays", std::to_string(share));
  RecordProperty("flip", std::to_string(flip));
  EXPECT_GT(covered, 2000) << "nothing is seen of the overlays";
  EXPECT_GE(share, 0.995);
  EXPECT_LE(flip, 0.02);
}

// Fingers bend while all that OpenGL draws of them is their highlight.
TEST_F(ConformanceTest, AHighlightOverATracedSkinHasTheSkinsPosture) {
  const auto scenario = scene::LoadScenario(std::filesystem::path(VR_OOS_SOURCE_DIR) / "scenarios/five_fingers");
  ASSERT_TRUE(scenario);
  view::Scene scene = view::SceneMirror(*scenario).scene();
  scene.texts.clear();
  const auto skin = std::find_if(scene.instances.begin(), scene.instances.end(),
                                 [](const view::Instance& instance) { return instance.posture != nullptr; });
  ASSERT_NE(skin, scene.instances.end());
  skin->highlight = 0.4f;
  const auto load = [](const std::filesystem::path& file) { return vps::LoadVisualMesh(file); };
  auto by_gl = Renderer::Create(scene, load), over_traced = Renderer::Create(scene, load);
  ASSERT_TRUE(by_gl && over_traced);
  const auto tracer = raytrace::Tracer::Create(scene, load);
  ASSERT_TRUE(tracer) << tracer.error().detail;
  const scene::Camera camera = view::PlaceCamera(scene.assets->cameras.front(), scene);
  for (const double bend_m : {0.0, 0.03}) {
    auto posture = *skin->posture;
    for (core::Pose& joint : posture) joint.translation.z += bend_m;
    skin->posture = std::make_shared<const std::vector<core::Pose>>(std::move(posture));
    (*tracer)->Update(scene, view::LightOf(scene.space));
    const auto gl = RenderSmooth(**by_gl, scene, camera, kPictureWidth, kPictureHeight);
    ASSERT_TRUE(gl);
    const auto pass = ObjectPass::Create();
    ASSERT_TRUE(pass);
    const view::Rendering kept{*gl, pass->Draw(**by_gl, scene, camera, kPictureWidth, kPictureHeight).ids};
    const view::Agreement agreement =
        view::Compare(kept, TracedOverSky(**over_traced, **tracer, scene, camera, tiles::Mirrors::kNone));
    EXPECT_LE(agreement.flip, 0.05) << bend_m;
    EXPECT_GE(agreement.same_ids, 0.995) << bend_m;
  }
}

// Five views: the scenario's own cameras, and what is missing from around the first one's target.
std::vector<scene::Camera> FiveViews(const view::Scene& scene) {
  std::vector<scene::Camera> views;
  for (const scene::Camera& camera : scene.assets->cameras) {
    if (views.size() < 5) views.push_back(view::PlaceCamera(camera, scene));
  }
  while (views.size() < 5) {
    scene::Camera turned = views.front();
    const double angle_rad = 1.2566 * static_cast<double>(views.size());
    const glm::dquat turn = glm::angleAxis(angle_rad, glm::dvec3(0.0, 0.0, 1.0));
    turned.eye_m = turned.target_m + turn * (turned.eye_m - turned.target_m);
    views.push_back(turned);
  }
  return views;
}

// OpenGL mirrors the light around, and no parts. Of metal that stands close together, as in module_replacement's
// cavity, the images of parts are what takes the difference beyond 0.05: without them all views are below it.
constexpr double kMostWithMirrors = 0.06;

// Textures, foil, sheets, lamps and metal.
class ConformanceOf : public ConformanceTest, public testing::WithParamInterface<const char*> {};

TEST_P(ConformanceOf, TheRayTracerDrawsFiveViewsAsTheGlNodeDoes) {
  const auto scenario = scene::LoadScenario(std::filesystem::path(VR_OOS_SOURCE_DIR) / "scenarios" / GetParam());
  ASSERT_TRUE(scenario);
  view::Scene scene = view::SceneMirror(*scenario).scene();
  scene.texts.clear();
  const auto load = [](const std::filesystem::path& file) { return vps::LoadVisualMesh(file); };
  auto renderer = Renderer::Create(scene, load);
  ASSERT_TRUE(renderer) << renderer.error().detail;
  const auto pass = ObjectPass::Create();
  ASSERT_TRUE(pass);
  const auto tracer = raytrace::Tracer::Create(scene, load);
  ASSERT_TRUE(tracer) << tracer.error().detail;
  (*tracer)->Update(scene, view::LightOf(scene.space));
  double least_ids = 1.0, most_flip = 0.0, most_with_mirrors = 0.0;
  for (const scene::Camera& camera : FiveViews(scene)) {
    const auto image = RenderSmooth(**renderer, scene, camera, kPictureWidth, kPictureHeight);
    ASSERT_TRUE(image);
    const view::Rendering kept{*image, pass->Draw(**renderer, scene, camera, kPictureWidth, kPictureHeight).ids};
    const auto compare = [&](tiles::Mirrors mirrors) {
      return view::Compare(kept, TracedOverSky(**renderer, **tracer, scene, camera, mirrors));
    };
    const view::Agreement agreement = compare(tiles::Mirrors::kNone), mirrored = compare(tiles::Mirrors::kAll);
    least_ids = std::min(least_ids, agreement.same_ids);
    most_flip = std::max(most_flip, agreement.flip);
    most_with_mirrors = std::max(most_with_mirrors, mirrored.flip);
    EXPECT_GE(agreement.same_ids, 0.995) << camera.name;
    EXPECT_LE(agreement.flip, 0.05) << camera.name;
    EXPECT_LE(mirrored.flip, kMostWithMirrors) << camera.name << ", with mirror images";
  }
  RecordProperty("same_ids", std::to_string(least_ids));
  RecordProperty("flip", std::to_string(most_flip));
  RecordProperty("flip_with_mirrors", std::to_string(most_with_mirrors));
}

INSTANTIATE_TEST_SUITE_P(Scenario, ConformanceOf,
                         testing::Values("device_view", "five_fingers", "five_fingers/left.xml", "free_collision",
                                         "module_replacement", "module_replacement/five_fingers.xml", "peg_in_hole",
                                         "peg_in_hole/ground.xml", "service_robot", "touch", "touch/bracelet.xml",
                                         "touch/forearm.xml", "two_hands", "two_hands/everything.xml"),
                         [](const auto& test) {
                           std::string name = test.param;
                           std::replace_if(
                               name.begin(), name.end(), [](char c) { return c == '/' || c == '.'; }, '_');
                           return name;
                         });

}  // namespace
}  // namespace visual_node
