// The GL node against exact geometry, and its live pictures against those that it keeps (libs/view/conformance).

#include <gtest/gtest.h>

#include "nodes/visual_node/draw/object_pass.hpp"
#include "nodes/visual_node/draw/renderer.hpp"
#include "nodes/visual_node/pictures/still.hpp"
#include "nodes/visual_node/testing/gl_test.hpp"
#include "view/conformance/cast_ids.hpp"
#include "view/conformance/compare.hpp"
#include "vps/mesh/vertex_normals.hpp"
#include "vps/testing/shapes.hpp"

namespace visual_node {
namespace {

constexpr int kPictureWidth = 320, kPictureHeight = 180;

// A mesh is named by its body's index.
core::Result<vps::VisualMesh> MeshOfBody(const std::filesystem::path& name) {
  const view::KnownBody body = view::KnownBodies()[std::stoul(name.string())];
  const vps::TriangleMesh mesh = body.is_ball ? vps::MakeSphere(0.5 * body.size_m.x, 96) : vps::MakeBox(body.size_m);
  return vps::VisualMesh{{vps::SplitAtCreases(mesh, 0.6)}};
}

view::Scene SceneOfBodies() {
  view::Scene scene;
  auto assets = std::make_shared<view::Assets>();
  assets->cameras = {view::KnownCamera()};
  scene.space.sun_direction_W = glm::normalize(glm::dvec3(0.4, -0.5, 0.8));
  const glm::vec3 colors[] = {
      {0.5f, 0.5f, 0.5f}, {0.7f, 0.2f, 0.1f}, {0.1f, 0.3f, 0.7f}, {0.8f, 0.7f, 0.1f}, {0.2f, 0.6f, 0.2f}};
  std::uint32_t index = 0;
  for (const view::KnownBody& body : view::KnownBodies()) {
    assets->meshes.emplace_back(std::to_string(index));
    assets->instance_names.push_back(std::to_string(index));
    view::Instance instance;
    instance.mesh = index;
    instance.X_WM = body.X_WO;
    instance.material.base_color = colors[index++ % std::size(colors)];
    instance.is_material_given = true;
    scene.instances.push_back(instance);
  }
  scene.assets = assets;
  return scene;
}

class ConformanceTest : public GlTest {
 protected:
  void SetUp() override {
    GlTest::SetUp();
    if (IsSkipped()) return;
    auto renderer = Renderer::Create(scene_, MeshOfBody);
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

  view::Scene scene_ = SceneOfBodies();
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

TEST_F(ConformanceTest, AnotherColourIsNoticed) {
  const view::Rendering kept = Kept();
  scene_.instances[2].material.base_color = {0.7f, 0.3f, 0.1f};
  EXPECT_GT(view::Compare(kept, Kept()).flip, 0.02);
}

}  // namespace
}  // namespace visual_node
