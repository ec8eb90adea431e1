#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "core/testing/backward_threads.hpp"
#include "vps/asset/cooked_file.hpp"
#include "vps/asset/cooked_object.hpp"
#include "vps/testing/shapes.hpp"

namespace vps {
namespace {

namespace fs = std::filesystem;

class Cooking : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("vr_oos_cook_" + std::to_string(::getpid()));
    fs::create_directories(folder_);
    mesh_ = folder_ / "tetrahedron.off";
    std::ofstream(mesh_) << "OFF\n4 4 0\n0 0 0\n0.1 0 0\n0 0.1 0\n0 0 0.1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n";
  }
  void TearDown() override { fs::remove_all(folder_); }

  fs::path CacheEntry() const {
    for (const auto& entry : fs::directory_iterator(folder_ / "cache")) return entry.path();
    return {};
  }

  fs::path folder_, mesh_;
  CookParameters parameters_{0.005, 500};
};

TEST_F(Cooking, TakesTheSecondTimeFromTheCache) {
  const auto first = Cook(mesh_, parameters_, folder_ / "cache");
  ASSERT_TRUE(first.has_value()) << first.error().detail;
  EXPECT_FALSE(first->is_from_cache);
  const auto second = Cook(mesh_, parameters_, folder_ / "cache");
  ASSERT_TRUE(second.has_value());
  EXPECT_TRUE(second->is_from_cache);
  EXPECT_EQ(first->voxmap->layers, second->voxmap->layers);
  EXPECT_EQ(first->points->x, second->points->x);
}

// One node may need a part as a field, another one as a field and sampled, and `oos cook` everything.
TEST_F(Cooking, BuildsEachSideOnceWhoeverNeedsTheOther) {
  const auto both = Cook(mesh_, parameters_, folder_ / "cache");
  ASSERT_TRUE(both.has_value()) << both.error().detail;
  const auto field = Cook(mesh_, {parameters_.voxel_size_m, 0}, folder_ / "cache");
  ASSERT_TRUE(field.has_value());
  EXPECT_TRUE(field->is_from_cache);
  EXPECT_FALSE(field->points.has_value());
  EXPECT_EQ(field->bounding_radius_m, both->bounding_radius_m);
  const auto samples = Cook(mesh_, {0.0, parameters_.num_points}, folder_ / "cache");
  ASSERT_TRUE(samples.has_value());
  EXPECT_TRUE(samples->is_from_cache);
  EXPECT_FALSE(samples->voxmap.has_value());
  const auto finer = Cook(mesh_, {parameters_.voxel_size_m, 2 * parameters_.num_points}, folder_ / "cache");
  ASSERT_TRUE(finer.has_value());
  EXPECT_FALSE(finer->is_from_cache);
  EXPECT_EQ(finer->voxmap->layers, both->voxmap->layers);
}

TEST_F(Cooking, RebuildsADamagedCacheFile) {
  const auto first = Cook(mesh_, parameters_, folder_ / "cache");
  ASSERT_TRUE(first.has_value());
  {
    std::fstream file(CacheEntry(), std::ios::in | std::ios::out | std::ios::binary);
    file.seekp(200);
    file.put('\x5a');
    file.put('\xa5');
  }
  const auto second = Cook(mesh_, parameters_, folder_ / "cache");
  ASSERT_TRUE(second.has_value());
  EXPECT_FALSE(second->is_from_cache);
  EXPECT_EQ(first->voxmap->layers, second->voxmap->layers);
  EXPECT_TRUE(Cook(mesh_, parameters_, folder_ / "cache")->is_from_cache);  // and repaired on disk
}

TEST_F(Cooking, BuildsAnewWhenTheMeshChanges) {
  ASSERT_TRUE(Cook(mesh_, parameters_, folder_ / "cache").has_value());
  std::ofstream(mesh_) << "OFF\n4 4 0\n0 0 0\n0.2 0 0\n0 0.1 0\n0 0 0.1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n";
  EXPECT_FALSE(Cook(mesh_, parameters_, folder_ / "cache")->is_from_cache);
}

TEST_F(Cooking, WorksWithoutAWritableCache) {
  std::ofstream(folder_ / "file") << "not a folder";
  EXPECT_TRUE(Cook(mesh_, parameters_, folder_ / "file" / "cache").has_value());
}

TEST_F(Cooking, NamesTheFileThatIsMissing) {
  const auto result = Cook(folder_ / "none.obj", parameters_, folder_ / "cache");
  ASSERT_FALSE(result.has_value());
  EXPECT_EQ(result.error().code, core::ErrorCode::kNotFound);
  EXPECT_NE(result.error().detail.find("none.obj"), std::string::npos);
}

// Of two bodies that pass through each other, so that the winding number is asked, with all that is cooked for `fast`.
TEST_F(Cooking, GivesTheSameBytesWithAnyNumberOfWorkers) {
  TriangleMesh mesh = MakeTorus(0.03, 0.012, 64, 32);
  const TriangleMesh other = MakeBox({0.05, 0.02, 0.01});
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), other.vertices.begin(), other.vertices.end());
  for (const auto& t : other.triangles) mesh.triangles.push_back({first + t[0], first + t[1], first + t[2]});
  const auto bytes_by = [&](core::ParallelFor* workers) {
    const auto cooked = Cook(mesh, {0.001, 4096, Method::kFast}, {}, workers);
    EXPECT_TRUE(cooked);
    EXPECT_EQ(cooked->coarser.size(), 2U);  // 1024 and 256
    EXPECT_TRUE(WriteCookedFile(folder_ / "cooked.vps", 1, *cooked));
    std::ifstream file(folder_ / "cooked.vps", std::ios::binary);
    return std::string(std::istreambuf_iterator<char>(file), {});
  };
  const std::string alone = bytes_by(nullptr);
  EXPECT_GT(alone.size(), 100'000U);
  for (const int threads : {1, 2, 5}) {
    core::test::BackwardThreads workers(threads);
    EXPECT_TRUE(bytes_by(&workers) == alone) << threads << " workers";
  }
}

}  // namespace
}  // namespace vps
