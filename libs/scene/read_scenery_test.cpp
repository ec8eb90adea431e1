#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>

#include "scene/load_scenario.hpp"

namespace scene {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::HasSubstr;

class SceneryTest : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::temp_directory_path() / ("vr_oos_scenery_" + std::to_string(::getpid()));
    std::filesystem::create_directories(folder_ / "arm");
    for (const char* mesh : {"mesh.obj", "arm/link.obj"}) {
      std::ofstream(folder_ / mesh) << "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    }
    std::ofstream(folder_ / "procedure.scxml") << "<scxml/>\n";
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  // Writes a file of seven links, in which joint 4 has the given pose.
  void WriteLinks(const std::string& fourth) const {
    std::ofstream links(folder_ / "arm" / "links.xml");
    links << "<links>\n";
    const std::string poses[] = {R"(position="0 0 0.1")",
                                 R"(position="0 0 0.2" rpy_deg="90 0 0")",
                                 R"(position="0 0.2 0" rpy_deg="-90 0 0")",
                                 fourth,
                                 R"(position="0 0.3 0" rpy_deg="-90 0 0")",
                                 R"(position="0 0 0.1" rpy_deg="90 0 0")",
                                 R"(position="0 0.1 0" rpy_deg="-90 0 0")"};
    for (const std::string& pose : poses) {
      links << "<link " << pose
            << R"( mass_kg="1"><visual mesh="link.obj"/><frame name="flange" position="0 0 0.05"/></link>)"
            << "\n";
    }
    links << "</links>\n";
  }
  // `element` is line 6 of the file.
  tl::expected<Scenario, std::vector<Diagnostic>> Load(const std::string& element) const {
    std::ofstream(folder_ / "scenario.xml")
        << "<scenario name=\"test\">\n<procedure file=\"procedure.scxml\"/>\n"
        << R"(<object name="ball" owner="hand" part="palm" role="right"><visual mesh="mesh.obj"/></object>)"
        << "\n"
        << R"(<object name="body" owner="physics" mass_kg="1"><visual mesh="mesh.obj"/></object>)"
        << "\n"
        << R"(<device role="right" position="0 0 1"/>)"
        << "\n"
        << element << "\n</scenario>\n";
    return LoadScenario(folder_);
  }
  void ExpectRefusal(const std::string& where, const std::string& what, const std::string& element) const {
    std::vector<std::string> texts;
    const auto scenario = Load(element);
    if (!scenario) {
      for (const Diagnostic& diagnostic : scenario.error()) texts.push_back(Format(diagnostic));
    }
    EXPECT_THAT(texts, Contains(AllOf(HasSubstr(where), HasSubstr(what))));
  }

  static constexpr const char* kFourth = R"(position="0 0 0.3" rpy_deg="90 0 0")";
  static constexpr const char* kArm = R"(<shown_arm name="a" role="right" links="arm/links.xml" position="1 0 0"
      flange_position="0 0 0.1" flange_rpy_deg="180 0 0" elbow="0 1 0"/>)";
  std::filesystem::path folder_;
};

TEST_F(SceneryTest, IsNoObject) {
  const auto scenario = Load(R"(<scenery name="wing" mesh="mesh.obj" position="1 2 3"/>)");
  ASSERT_TRUE(scenario) << Format(scenario.error().front());
  EXPECT_EQ(scenario->objects.size(), 2u);
  ASSERT_EQ(scenario->scenery.size(), 1u);
  EXPECT_EQ(scenario->scenery[0].name, "wing");
  EXPECT_EQ(scenario->scenery[0].X_WM.translation, glm::dvec3(1, 2, 3));
  ExpectRefusal("scenario.xml:6: ", "mesh 'nowhere.glb' is missing", R"(<scenery name="wing" mesh="nowhere.glb"/>)");
}

TEST_F(SceneryTest, ASkinNamesWhatItsJointsGoWith) {
  WriteLinks(kFourth);
  const auto hose = [](const std::string& joints) {
    return R"(<scenery name="hose" mesh="mesh.obj" variant="red" joints=")" + joints + "\"/>" + kArm;
  };
  const auto scenario = Load(hose("body  a_7"));
  ASSERT_TRUE(scenario) << Format(scenario.error().front());
  EXPECT_EQ(scenario->scenery[0].joints, (std::vector<std::string>{"body", "a_7"}));
  EXPECT_EQ(scenario->scenery[0].variant, "red");
  ExpectRefusal("scenario.xml:6: ", "nothing is called 'bodi'", hose("bodi a_7"));
  ExpectRefusal("scenario.xml:6: ", "nothing is called 'a_8'", hose("a_8"));
}

TEST_F(SceneryTest, AShownArmHasItsLinksMeshesBesideTheirFile) {
  WriteLinks(kFourth);
  const auto scenario = Load(kArm);
  ASSERT_TRUE(scenario) << Format(scenario.error().front());
  EXPECT_EQ(scenario->objects.size(), 2u);
  const ShownArm& arm = scenario->shown_arms.at(0);
  EXPECT_EQ(arm.role, 0);
  EXPECT_EQ(arm.links[6].visual_mesh, folder_ / "arm" / "link.obj");
  EXPECT_EQ(arm.links[4].X_PJ.translation, glm::dvec3(0, 0.3, 0));
  EXPECT_EQ(arm.X_7F.translation, glm::dvec3(0, 0, 0.05));
  EXPECT_EQ(arm.X_PalmF.translation, glm::dvec3(0, 0, 0.1));
  EXPECT_EQ(arm.elbow_W, glm::dvec3(0, 1, 0));
}

TEST_F(SceneryTest, AnArmWhosePostureHasNoClosedFormIsRefusedAtItsJoint) {
  for (const char* fourth : {R"(position="0 0.01 0.3" rpy_deg="90 0 0")", R"(position="0 0 0.3" rpy_deg="80 0 0")",
                             R"(position="0 0 -0.3" rpy_deg="90 0 0")"}) {
    WriteLinks(fourth);
    ExpectRefusal("links.xml:5: ", "its joint 4 is not where", kArm);
  }
  std::ofstream(folder_ / "arm" / "links.xml") << "<links>\n<link mass_kg=\"1\"/>\n</links>\n";
  ExpectRefusal("scenario.xml:6: ", "it has 1 links", kArm);
  WriteLinks(kFourth);
  ExpectRefusal("scenario.xml:6: ", "no device has the role 'rigth'",
                R"(<shown_arm name="a" role="rigth" links="arm/links.xml"/>)");
}

}  // namespace
}  // namespace scene
