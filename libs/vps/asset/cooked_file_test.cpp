#include "vps/asset/cooked_file.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <array>
#include <fstream>
#include <iterator>
#include <string>
#include <thread>

namespace vps {
namespace {

namespace fs = std::filesystem;

CookedObject Sample() {
  CookedObject object;
  Voxmap map;
  map.origin_m = {-0.01, 0.02, 0.03};
  map.voxel_size_m = 0.001;
  map.nx = 3;
  map.ny = 2;
  map.nz = 2;
  map.layers = {-2, -1, 0, 1, 2, 3, -2, -1, 0, 1, 2, 127};
  object.voxmap = map;
  PointTree tree;
  tree.num_points = 3;
  for (auto* array : {&tree.x, &tree.y, &tree.z, &tree.nx, &tree.ny, &tree.nz}) *array = {1, 2, 3, 0, 0, 0, 0};
  Cluster leaf;
  leaf.radius_m = 0.5f;
  leaf.num_children = 3;
  leaf.is_leaf = 1;
  leaf.num_points = 3;
  tree.clusters = {leaf};
  object.points = tree;
  object.bounding_radius_m = 0.25;
  return object;
}

class CookedFile : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("vr_oos_cooked_" + std::to_string(::getpid()));
    fs::create_directories(folder_);
    file_ = folder_ / "object.vps";
    ASSERT_TRUE(WriteCookedFile(file_, 42, Sample()).has_value());
    std::ifstream in(file_, std::ios::binary);
    bytes_.assign(std::istreambuf_iterator<char>(in), {});
  }
  void TearDown() override { fs::remove_all(folder_); }
  void Rewrite(const std::string& bytes) {
    std::ofstream(file_, std::ios::binary | std::ios::trunc)
        .write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  }

  fs::path folder_, file_;
  std::string bytes_;
};

TEST_F(CookedFile, ComesBackAsItWas) {
  const auto read = ReadCookedFile(file_, 42);
  ASSERT_TRUE(read.has_value()) << read.error().detail;
  EXPECT_TRUE(read->is_from_cache);
  EXPECT_EQ(read->voxmap->layers, Sample().voxmap->layers);
  EXPECT_EQ(read->voxmap->origin_m, Sample().voxmap->origin_m);
  EXPECT_EQ(read->points->x, Sample().points->x);
  EXPECT_EQ(read->points->clusters[0].num_children, 3);
  EXPECT_EQ(read->bounding_radius_m, 0.25);
}

TEST_F(CookedFile, IsNeverTrustedWhenABitIsFlipped) {
  for (std::size_t i = 0; i < bytes_.size() * 8; i += 5) {  // some bit of every byte
    if (i / 8 >= 12 && i / 8 < 16) continue;                // the reserved field
    std::string broken = bytes_;
    broken[i / 8] = static_cast<char>(broken[i / 8] ^ (1 << (i % 8)));
    Rewrite(broken);
    const auto read = ReadCookedFile(file_, 42);
    ASSERT_FALSE(read.has_value()) << "bit " << i;
    ASSERT_EQ(read.error().code, core::ErrorCode::kDamaged);
  }
}

TEST_F(CookedFile, IsNeverTrustedWhenCutShortOrLengthened) {
  for (std::size_t size = 0; size < bytes_.size(); size += 3) {
    Rewrite(bytes_.substr(0, size));
    ASSERT_FALSE(ReadCookedFile(file_, 42).has_value()) << size;
  }
  Rewrite(bytes_ + "x");
  EXPECT_FALSE(ReadCookedFile(file_, 42).has_value());
}

TEST_F(CookedFile, IsRefusedForAnotherKeyAndNotFoundWhenMissing) {
  EXPECT_EQ(ReadCookedFile(file_, 43).error().code, core::ErrorCode::kDamaged);
  EXPECT_EQ(ReadCookedFile(folder_ / "none.vps", 42).error().code, core::ErrorCode::kNotFound);
}

TEST_F(CookedFile, LeavesNoPartialFile) {
  std::size_t num_files = 0;
  for ([[maybe_unused]] const auto& entry : fs::directory_iterator(folder_)) ++num_files;
  EXPECT_EQ(num_files, 1u);
}

TEST_F(CookedFile, IsWrittenByThreadsAtTheSameTime) {
  const auto write = [this](bool* is_written) {
    for (int i = 0; i < 50; ++i) *is_written = *is_written && WriteCookedFile(file_, 42, Sample()).has_value();
  };
  std::array<bool, 2> is_written{true, true};
  {
    const std::jthread a(write, &is_written[0]);
    const std::jthread b(write, &is_written[1]);
  }
  EXPECT_TRUE(is_written[0] && is_written[1]);
  EXPECT_TRUE(ReadCookedFile(file_, 42).has_value());
}

TEST(CookedKey, DependsOnBytesAndParameters) {
  const std::string mesh = "mesh";
  const std::uint64_t key = CookedKey(mesh.data(), mesh.size(), {0.001, 100});
  EXPECT_NE(key, CookedKey("mesk", 4, {0.001, 100}));
  EXPECT_NE(key, CookedKey(mesh.data(), mesh.size(), {0.002, 100}));
  EXPECT_NE(key, CookedKey(mesh.data(), mesh.size(), {0.001, 101}));
  EXPECT_EQ(key, CookedKey(mesh.data(), mesh.size(), {0.001, 100}));
}

}  // namespace
}  // namespace vps
