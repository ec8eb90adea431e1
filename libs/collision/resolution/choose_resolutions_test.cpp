#include "collision/resolution/choose_resolutions.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <fstream>

#include "vps/testing/shapes.hpp"

namespace collision {
namespace {

using testing::HasSubstr;

class ChooseResolutionsTest : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::temp_directory_path() / ("vr_oos_choose_resolutions_" + std::to_string(::getpid()));
    std::filesystem::create_directories(folder_);
    WriteMesh("plate.obj", vps::MakeBox({0.1, 0.1, 0.01}));
    WriteMesh("needle.obj", vps::MakeBox({0.001, 0.001, 0.05}));
    WriteMesh("cube.obj", vps::MakeBox({0.05, 0.05, 0.05}));
    std::ofstream(folder_ / "procedure.scxml") << "<scxml/>";
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  void WriteMesh(const std::string& name, const vps::TriangleMesh& mesh) const {
    std::ofstream stream(folder_ / name);
    stream.precision(17);
    for (const auto& v : mesh.vertices) stream << "v " << v.x << ' ' << v.y << ' ' << v.z << '\n';
    for (const auto& t : mesh.triangles) stream << "f " << t[0] + 1 << ' ' << t[1] + 1 << ' ' << t[2] + 1 << '\n';
  }

  // An object of that mesh, all in a line of the file.
  static std::string Object(const std::string& name, const std::string& attributes = "", const std::string& mesh = "") {
    return "<object name='" + name + "' owner='physics' mass_kg='1'><collision mesh='" + (mesh.empty() ? name : mesh) +
           ".obj' " + attributes + "/></object>\n";
  }

  // The first line is the scenario's.
  auto Load(const std::string& inner, const std::string& method = "fast") const {
    std::ofstream(folder_ / "scenario.xml")
        << "<scenario name='t'>\n<run method='" << method << "'/>\n<procedure file='procedure.scxml'/>\n"
        << inner << "</scenario>\n";
    return LoadResolvedScenario(folder_);
  }

  static const scene::Object& Find(const scene::Scenario& scenario, const char* name) {
    return scenario.objects.at(static_cast<std::size_t>(scenario.FindObject(name)));
  }

  std::filesystem::path folder_;
};

TEST_F(ChooseResolutionsTest, SamplesTheNeedleInEitherOrder) {
  for (const std::string& objects : {Object("needle") + Object("plate"), Object("plate") + Object("needle")}) {
    const auto scenario = Load(objects + "<pair a='plate' b='needle' accuracy='0.1'/>\n");
    ASSERT_TRUE(scenario) << Format(scenario.error().front());
    ASSERT_EQ(scenario->pairs.size(), 1U);
    EXPECT_EQ(scenario->PairName(0), "needle/plate");
    // One side each: voxels of the plate's longest side, and points as far apart.
    const scene::Object& plate = Find(*scenario, "plate");
    const scene::Object& needle = Find(*scenario, "needle");
    EXPECT_NEAR(plate.voxel_size_m, 0.1 / 256.0, 1e-10);
    EXPECT_EQ(plate.num_points, 0U);
    EXPECT_EQ(needle.voxel_size_m, 0.0);
    EXPECT_NEAR(needle.num_points, 0.000202 / (0.1 / 256.0 * 0.1 / 256.0), 1.0);
  }
}

TEST_F(ChooseResolutionsTest, KeepsTheSidesOfEqualParts) {
  for (const char* sampled : {"a", "b"}) {
    const std::string other = sampled == std::string("a") ? "b" : "a";
    const auto scenario =
        Load(Object("a", "", "cube") + Object("b", "", "cube") + "<pair a='" + sampled + "' b='" + other + "'/>\n");
    ASSERT_TRUE(scenario) << Format(scenario.error().front());
    EXPECT_EQ(scenario->PairName(0), sampled + std::string("/") + other);
  }
}

TEST_F(ChooseResolutionsTest, TakesTheFinestVoxelAndTheMostPointsOfAllPairs) {
  // Against the needle alone the plate's voxels are 0.39 mm; a guide in which it has 0.06 mm below and above wants
  // finer ones.
  vps::TriangleMesh two = vps::MakeBox({0.1, 0.1, 0.02});
  const vps::TriangleMesh upper = two;
  for (auto& p : two.vertices) p.z -= 0.5 * (0.02 + 0.01012);
  for (const auto& p : upper.vertices) two.vertices.push_back(p + glm::dvec3(0.0, 0.0, 0.5 * (0.02 + 0.01012)));
  for (const auto& t : upper.triangles) two.triangles.push_back({t[0] + 8, t[1] + 8, t[2] + 8});
  WriteMesh("guide.obj", two);
  const auto scenario = Load(Object("plate") + Object("needle") + Object("guide", "points='5000'"));
  ASSERT_TRUE(scenario) << Format(scenario.error().front());
  EXPECT_NEAR(Find(*scenario, "plate").voxel_size_m, 25.0 * 0.1 * 6e-5, 2e-6);
  EXPECT_EQ(Find(*scenario, "guide").num_points, 5000U) << "given figures stay";
  const double spacing_m = std::sqrt(0.000202 / Find(*scenario, "needle").num_points);
  EXPECT_NEAR(spacing_m, Find(*scenario, "plate").voxel_size_m, 1e-6);
}

TEST_F(ChooseResolutionsTest, FollowsTheMethodAndCanBeAskedAgain) {
  WriteMesh("sheet.obj", vps::MakeBox({0.02, 0.02, 0.0002}));
  auto scenario = Load(Object("sheet") + Object("needle", "points='3000'"), "fast");
  ASSERT_TRUE(scenario) << Format(scenario.error().front());
  const double fast_m = Find(*scenario, "sheet").voxel_size_m;
  EXPECT_NEAR(fast_m, 0.02 / 256.0, 1e-9);
  scenario->method = "paper";
  const auto notes = ChooseResolutions(&*scenario);
  ASSERT_TRUE(notes);
  EXPECT_NEAR(Find(*scenario, "sheet").voxel_size_m, 2e-4 / (2.0 * std::sqrt(3.0)), 1e-9);
  scenario->method = "fast";
  ASSERT_TRUE(ChooseResolutions(&*scenario));
  EXPECT_EQ(Find(*scenario, "sheet").voxel_size_m, fast_m);
}

TEST_F(ChooseResolutionsTest, SaysWhy) {
  auto scenario = Load(Object("plate") + Object("needle"));
  ASSERT_TRUE(scenario) << Format(scenario.error().front());
  const auto notes = ChooseResolutions(&*scenario);
  ASSERT_TRUE(notes);
  std::vector<std::string> lines;
  for (const ResolutionNote& note : *notes) lines.push_back(scenario->objects[note.object].name + ": " + note.text);
  EXPECT_THAT(lines, testing::ElementsAre(
                         HasSubstr("plate: voxels of 0.391 mm (1/256 of its longest side, 100 mm; against 'needle')"),
                         HasSubstr("needle: sampled against 'plate' (smallest feature 1 mm, of the other 10 mm)"),
                         HasSubstr("needle: 1323 points (a voxel of 'plate' apart")));
}

TEST_F(ChooseResolutionsTest, NeedsNoMeshOfGivenObjects) {
  std::ofstream(folder_ / "broken.obj") << "v 0 0\n";
  const auto scenario = Load(Object("broken", "points='100'") + Object("plate", "voxel_size_m='0.001'") +
                             Object("needle", "points='50'"));
  ASSERT_TRUE(scenario) << Format(scenario.error().front());
  EXPECT_EQ(scenario->pairs.size(), 2U);
}

TEST_F(ChooseResolutionsTest, NamesTheLineOfABrokenMesh) {
  std::ofstream(folder_ / "broken.obj") << "v 0 0\n";
  const auto scenario = Load(Object("plate") + Object("broken"));
  ASSERT_FALSE(scenario);
  ASSERT_EQ(scenario.error().size(), 1U);
  EXPECT_THAT(Format(scenario.error().front()),
              testing::AllOf(HasSubstr("scenario.xml:5: object 'broken': its voxels and points cannot be chosen"),
                             HasSubstr("broken.obj")));
}

}  // namespace
}  // namespace collision
