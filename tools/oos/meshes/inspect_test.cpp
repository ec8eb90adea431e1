#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "tools/oos/meshes/verbs.hpp"

namespace oos {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::Not;

class InspectVerbTest : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::path(testing::TempDir()) / "oos_inspect";
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }

  std::string Write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name) << text;
    return (folder_ / name).string();
  }
  std::string out() const { return (folder_ / "pictures").string(); }

  std::string ComplaintOf(const std::vector<std::string>& words) const {
    testing::internal::CaptureStderr();
    testing::internal::CaptureStdout();
    EXPECT_EQ(RunVerbs({CookVerb(), InspectVerb(), QueryVerb()}, words), kBadUsage);
    testing::internal::GetCapturedStdout();
    EXPECT_FALSE(fs::exists(out()));
    return testing::internal::GetCapturedStderr();
  }

  fs::path folder_;
};

// The plate is a sheet of two triangles, 40 x 30 mm.
constexpr const char* kPlate = "v 0 0 0\nv 0.04 0 0\nv 0.04 0.03 0\nv 0 0.03 0\nf 1 2 3\nf 1 3 4\n";
constexpr const char* kTetrahedron = "v 0 0 0\nv 0.1 0 0\nv 0 0.1 0\nv 0 0 0.1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";

TEST_F(InspectVerbTest, WritesPicturesOfBothMethods) {
  const std::string mesh = Write("part.obj", kTetrahedron);
  testing::internal::CaptureStdout();
  ASSERT_EQ(RunVerbs({CookVerb(), InspectVerb(), QueryVerb()},
                     {"inspect", mesh, "--out", out(), "--voxel_m", "0.004", "--points", "300"}),
            kHolds);
  EXPECT_THAT(testing::internal::GetCapturedStdout(), HasSubstr("4 triangles, 100 x 100 x 100 mm, a solid"));
  for (const char* name : {"paper_slices.png", "paper_points.png", "paper_tree.png", "fast_slices.png",
                           "fast_points.png", "fast_tree.png"}) {
    std::ifstream in(fs::path(out()) / name, std::ios::binary);
    const std::string bytes{std::istreambuf_iterator<char>(in), {}};
    EXPECT_EQ(bytes.substr(1, 3), "PNG") << name;
    EXPECT_GT(bytes.size(), 10'000U) << name;
  }
}

TEST_F(InspectVerbTest, TakesASheet) {
  const std::string mesh = Write("plate.obj", kPlate);
  EXPECT_THAT(ComplaintOf({"inspect", mesh, "--out", out()}), HasSubstr("sheet_thickness_m"));
  testing::internal::CaptureStdout();
  EXPECT_EQ(RunVerbs({CookVerb(), InspectVerb(), QueryVerb()}, {"inspect", mesh, "--out", out(), "--sheet_thickness_m",
                                                                "0.003", "--method", "fast", "--points", "300"}),
            kHolds);
  EXPECT_THAT(testing::internal::GetCapturedStdout(), HasSubstr("thinnest wall: 3 mm"));
}

TEST_F(InspectVerbTest, BadInputGivesOneLineAndLeavesNothing) {
  const std::string mesh = Write("part.obj", kTetrahedron);
  EXPECT_THAT(ComplaintOf({"inspect", mesh}), HasSubstr("--out"));
  EXPECT_THAT(ComplaintOf({"inspect", "/no/mesh.obj", "--out", out()}), HasSubstr("/no/mesh.obj"));
  EXPECT_THAT(ComplaintOf({"inspect", mesh, "--out", out(), "--method", "quick"}), HasSubstr("--method"));
  EXPECT_THAT(ComplaintOf({"inspect", mesh, "--out", out(), "--voxel_m", "1e-7"}), HasSubstr("part.obj"));
  EXPECT_THAT(ComplaintOf({"inspect",
                           Write("mm.obj",
                                 "v 0 0 0\nv 100 0 0\nv 0 100 0\nv 0 0 100\nf 1 3 2\nf 1 2 4\n"
                                 "f 1 4 3\nf 2 3 4\n"),
                           "--out", out()}),
              HasSubstr("--scale 0.001"));
}

TEST_F(InspectVerbTest, CookDescribesTheMeshAndCachesNothingOfABadOne) {
  setenv("VR_OOS_CACHE", (folder_ / "cache").c_str(), 1);
  const std::string open = Write("open.obj", kPlate);
  EXPECT_THAT(ComplaintOf({"cook", open, "--voxel_m", "0.001", "--method", "fast"}), HasSubstr("4 open edges"));
  EXPECT_THAT(ComplaintOf({"cook", Write("nan.obj", "v 0 0 0\nv nan 0 0\n"), "--voxel_m", "0.001"}),
              HasSubstr("nan.obj:2"));
  EXPECT_FALSE(fs::exists(folder_ / "cache"));
  testing::internal::CaptureStdout();
  EXPECT_EQ(RunVerbs({CookVerb(), InspectVerb(), QueryVerb()},
                     {"cook", open, "--voxel_m", "0.001", "--method", "fast", "--sheet_thickness_m", "0.002"}),
            kHolds);
  const std::string text = testing::internal::GetCapturedStdout();
  unsetenv("VR_OOS_CACHE");
  EXPECT_THAT(text, HasSubstr("a sheet"));
  EXPECT_THAT(text, HasSubstr("thinnest wall: 2 mm"));
  EXPECT_THAT(text, HasSubstr("walls from 1 mm, gaps from 1 mm"));
}

// So that the run which follows finds them.
TEST_F(InspectVerbTest, CookBuildsWhatTheScenarioRunsWith) {
  setenv("VR_OOS_CACHE", (folder_ / "cache").c_str(), 1);
  const std::string scenario = VR_OOS_SOURCE_DIR "/scenarios/touch";
  const auto cook = [&](const std::vector<std::string>& words) {
    testing::internal::CaptureStdout();
    EXPECT_EQ(RunVerbs({CookVerb(), InspectVerb(), QueryVerb()}, words), kHolds);
    return testing::internal::GetCapturedStdout();
  };
  EXPECT_THAT(cook({"cook", scenario}), HasSubstr("built in"));
  EXPECT_THAT(cook({"cook", scenario, "--method", "fast"}), Not(HasSubstr("built in")));
  unsetenv("VR_OOS_CACHE");
}

// The plate has walls of 2 mm, so it is sampled, although the part moves.
TEST_F(InspectVerbTest, CookSaysWhatWasChosenForAScenarioThatLeavesItOpen) {
  setenv("VR_OOS_CACHE", (folder_ / "cache").c_str(), 1);
  Write("plate.obj", kPlate);
  Write("part.obj", kTetrahedron);
  Write("procedure.scxml", "<scxml/>");
  const std::string scenario =
      Write("scenario.xml",
            "<scenario name='t'>\n<run method='fast'/>\n<procedure file='procedure.scxml'/>\n"
            "<object name='plate' owner='fixed'><collision mesh='plate.obj' sheet_thickness_m='0.002'/></object>\n"
            "<object name='part' owner='physics' mass_kg='1'><collision mesh='part.obj'/></object>\n</scenario>\n");
  testing::internal::CaptureStdout();
  EXPECT_EQ(RunVerbs({CookVerb(), InspectVerb(), QueryVerb()}, {"cook", scenario}), kHolds);
  const std::string text = testing::internal::GetCapturedStdout();
  unsetenv("VR_OOS_CACHE");
  EXPECT_THAT(text, HasSubstr("chosen: sampled against 'part' (smallest feature 2 mm"));
  EXPECT_THAT(text, HasSubstr("points (a voxel of 'part' apart"));
  EXPECT_THAT(text, HasSubstr("chosen: voxels of 0.391 mm (1/256 of its longest side, 100 mm; against 'plate')"));
}

}  // namespace
}  // namespace oos
