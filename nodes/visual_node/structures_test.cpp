#include "nodes/visual_node/structures.hpp"

#include <gtest/gtest.h>

#include <thread>

#include "scene/load_scenario.hpp"
#include "view/scene_mirror.hpp"

namespace visual_node {
namespace {

class StructuresTest : public testing::Test {
 protected:
  [[nodiscard]] view::Choices Choose(const std::string& list) const {
    return *view::ReadChoices(list, scene_.assets->instance_names);
  }
  [[nodiscard]] bool HasLine(const std::string& part) const {
    for (const view::TextLine& line : scene_.texts) {
      if (line.text.find(part) != std::string::npos) return true;
    }
    return false;
  }

  const scene::Scenario scenario_ = *scene::LoadScenario(VR_OOS_SOURCE_DIR "/scenarios/touch");
  view::Scene scene_ = view::SceneMirror(scenario_).scene();
  const int block_ = scenario_.FindObject("block");
};

TEST_F(StructuresTest, PointsSpheresAndVoxelsMoveWithTheirObject) {
  const core::Pose X_WO{glm::angleAxis(0.7, glm::normalize(glm::dvec3(1, 2, 3))), {0.1, 0.2, 0.3}};
  scene_.instances[static_cast<std::size_t>(block_)].X_WM = X_WO;
  StructureShow(scenario_).BuildAndAddTo(Choose("samples tree voxels select.block"), &scene_);
  ASSERT_EQ(scene_.points.size(), 1u);
  ASSERT_EQ(scene_.spheres.size(), 1u);
  ASSERT_EQ(scene_.cubes.size(), 1u);
  EXPECT_EQ(scene_.points[0].X_WP.translation, X_WO.translation);
  EXPECT_EQ(scene_.spheres[0].X_WP.rotation, X_WO.rotation);
  const scene::Object& block = scenario_.objects[static_cast<std::size_t>(block_)];
  EXPECT_EQ(scene_.cubes[0].edge_m, block.voxel_size_m);
  EXPECT_NEAR(static_cast<double>(scene_.points[0].p_P->size()), block.num_points, 0.1 * block.num_points);
  EXPECT_GE(scene_.spheres[0].p_P_radius_m->size(), 12u);
  EXPECT_GT(scene_.cubes[0].p_P->size(), 100u);
  EXPECT_TRUE(HasLine("block: " + std::to_string(scene_.cubes[0].p_P->size()) + " voxels"));
}

TEST_F(StructuresTest, OnlyWhatIsChosenOfWhatIsSelectedIsShown) {
  StructureShow show(scenario_);
  show.BuildAndAddTo(Choose("samples tree voxels"), &scene_);
  EXPECT_TRUE(scene_.points.empty() && scene_.spheres.empty() && scene_.cubes.empty()) << "nothing is selected";
  show.BuildAndAddTo(Choose("tree select.block"), &scene_);
  EXPECT_TRUE(scene_.points.empty() && scene_.cubes.empty());
  EXPECT_EQ(scene_.spheres.size(), 1u);
}

TEST_F(StructuresTest, AWindowGoesOnWhileTheyAreBuilt) {
  StructureShow show(scenario_);
  const view::Choices choices = Choose("voxels select.block");
  view::Scene first = scene_;
  show.AddTo(choices, &first);
  while (first.cubes.empty()) {
    EXPECT_GT(first.texts.size(), scene_.texts.size()) << "nothing says why there are no voxels yet";
    first = scene_;
    show.AddTo(choices, &first);
    std::this_thread::yield();
  }
  // Another one takes its place.
  view::Scene second = scene_;
  show.AddTo(Choose("voxels select.plate"), &second);
  while (second.cubes.empty()) {
    second = scene_;
    show.AddTo(Choose("voxels select.plate"), &second);
    std::this_thread::yield();
  }
  EXPECT_NE(second.cubes[0].p_P->size(), first.cubes[0].p_P->size());
}

TEST_F(StructuresTest, AnObjectWithoutThemSaysSo) {
  scene::Scenario bare = scenario_;
  bare.objects[static_cast<std::size_t>(block_)].collision_mesh.clear();
  StructureShow(bare).BuildAndAddTo(Choose("voxels select.block"), &scene_);
  EXPECT_TRUE(HasLine("block: no part of collisions"));
}

}  // namespace
}  // namespace visual_node
