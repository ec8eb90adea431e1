#include "collision/owned_world.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include "vps/asset/cooked_object.hpp"

namespace collision {
namespace {

class OwnedWorldTest : public ::testing::Test {
 protected:
  void SetUp() override {
    cache_ = std::filesystem::temp_directory_path() / ("vr_oos_owned_world_" + std::to_string(::getpid()));
    scenario_.method = "fast";
    for (const char* name : {"tool", "part", "wall", "far"}) {
      scene::Object object;
      object.name = name;
      object.collision_mesh = VR_OOS_SOURCE_DIR "/scenarios/peg_in_hole/meshes/palm.obj";
      object.voxel_size_m = 0.004;
      object.num_points = 200;
      scenario_.objects.push_back(object);
    }
    scenario_.pairs.resize(2);
    scenario_.pairs[0].sampled = 0;
    scenario_.pairs[0].field = 1;
    scenario_.pairs[0].owner = scene::PairOwner::kHaptic;
    scenario_.pairs[1].sampled = 1;
    scenario_.pairs[1].field = 2;
    scenario_.pairs[1].owner = scene::PairOwner::kPhysics;
  }
  void TearDown() override { std::filesystem::remove_all(cache_); }

  // Of each object: f with a field, s with points.
  std::string SidesFor(scene::PairOwner owner) {
    core::SerialFor workers;
    const auto owned = BuildOwnedWorld(scenario_, owner, workers, {cache_, {}});
    if (!owned) return owned.error().detail;
    std::string sides;
    for (const auto& data : owned->data) {
      sides += sides.empty() ? "" : " ";
      if (data == nullptr) sides += '-';
      if (data != nullptr && data->has_field(vps::Method::kFast)) sides += 'f';
      if (data != nullptr && data->has_points(vps::Method::kFast)) sides += 's';
    }
    return sides;
  }

  scene::Scenario scenario_;
  std::filesystem::path cache_;
};

// Every object could be both; a node cooks what its own pairs use.
TEST_F(OwnedWorldTest, CooksOnlyTheSidesThatItsPairsUse) {
  EXPECT_EQ(SidesFor(scene::PairOwner::kHaptic), "s f - -");
  EXPECT_EQ(SidesFor(scene::PairOwner::kPhysics), "- s f -");
}

}  // namespace
}  // namespace collision
