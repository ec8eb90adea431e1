#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>
#include <glm/gtc/constants.hpp>

#include "scene/load_scenario.hpp"

namespace scene {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::HasSubstr;

class JointsTest : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::temp_directory_path() / ("vr_oos_joints_" + std::to_string(::getpid()));
    std::filesystem::create_directories(folder_);
    std::ofstream(folder_ / "mesh.obj") << "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    std::ofstream(folder_ / "procedure.scxml") << "<scxml/>\n";
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  // `joint` is line 5 of the file.
  tl::expected<Scenario, std::vector<Diagnostic>> Load(const std::string& joint, const std::string& extra = "") const {
    std::ofstream(folder_ / "scenario.xml")
        << "<scenario name=\"test\">\n<procedure file=\"procedure.scxml\"/>\n"
        << R"(<object name="body" owner="physics" mass_kg="1" position="0 0 1"><visual mesh="mesh.obj"/></object>)"
        << "\n"
        << R"(<object name="part" owner="physics" mass_kg="0.1" )" << extra << R"(><visual mesh="mesh.obj"/></object>)"
        << "\n"
        << joint << "\n</scenario>\n";
    return LoadScenario(folder_);
  }
  void ExpectRefusal(int line, const std::string& what, const std::string& joint, const std::string& extra = "") const {
    std::vector<std::string> texts;
    const auto scenario = Load(joint, extra);
    if (!scenario) {
      for (const Diagnostic& diagnostic : scenario.error()) texts.push_back(Format(diagnostic));
    }
    EXPECT_THAT(texts, Contains(AllOf(HasSubstr("scenario.xml:" + std::to_string(line) + ": "), HasSubstr(what))));
  }

  std::filesystem::path folder_;
};

TEST_F(JointsTest, ReadsAxisLimitsMotorAndLockOfASlider) {
  const auto scenario = Load(R"(<slider name="drawer" parent="body" child="part" position="0 0 0.5" rpy_deg="0 90 0"
      lower_m="-0.1" upper_m="0.2" damping="3" motor_m_per_s="0.05" motor_force_N="12" locked="true"/>)");
  ASSERT_TRUE(scenario) << Format(scenario.error().front());
  const Mechanism& slider = scenario->mechanisms.at(0);
  EXPECT_EQ(slider.kind, MechanismKind::kSlider);
  EXPECT_EQ(slider.lower, -0.1);
  EXPECT_EQ(slider.upper, 0.2);
  EXPECT_EQ(slider.damping, 3.0);
  EXPECT_EQ(slider.motor_speed, 0.05);
  EXPECT_EQ(slider.motor_limit, 12.0);
  EXPECT_TRUE(slider.is_locked);
  // z of J is W's x; J in the parent, whose origin is 1 m up.
  EXPECT_LT(glm::distance(slider.X_PJ.rotate({0, 0, 1}), glm::dvec3(1, 0, 0)), 1e-12);
  EXPECT_LT(glm::distance(slider.X_PJ.translation, glm::dvec3(0, 0, -0.5)), 1e-12);
  EXPECT_LT(glm::distance(slider.X_CJ.translation, glm::dvec3(0, 0, 0.5)), 1e-12);
}

TEST_F(JointsTest, ReadsTheMotorOfAHinge) {
  const auto scenario = Load(R"(<hinge name="bit" parent="body" child="part" position="0 0 0" motor_deg_per_s="-720"
      motor_torque_Nm="0.8"/>)");
  ASSERT_TRUE(scenario) << Format(scenario.error().front());
  EXPECT_NEAR(scenario->mechanisms.at(0).motor_speed, -4.0 * glm::pi<double>(), 1e-12);
  EXPECT_EQ(scenario->mechanisms[0].motor_limit, 0.8);
  EXPECT_FALSE(scenario->mechanisms[0].is_locked);
}

constexpr const char* kLinks = R"(<links>
  <link position="0 0 0.1" mass_kg="2" inertia_kg_m2="0.01 0.01 0.01 0 0 0" lower_deg="-170" upper_deg="170"
        motor_torque_Nm="50"/>
  <link position="0 0 0.2" rpy_deg="0 90 0" mass_kg="1" inertia_kg_m2="0.01 0.01 0.01 0 0 0" damping="0.1"/>
</links>
)";

TEST_F(JointsTest, AnArmExpandsToLinksAndHingesInItsStartPosture) {
  std::ofstream(folder_ / "links.xml") << kLinks;
  const auto scenario =
      Load(R"(<arm name="left" links="links.xml" base="body" position="0 0 1" rpy_deg="0 0 90" start_deg="30 -45"/>)");
  ASSERT_TRUE(scenario) << Format(scenario.error().front());
  ASSERT_EQ(scenario->objects.size(), 4U);
  const Object& first = scenario->objects[2];
  const Object& second = scenario->objects[3];
  EXPECT_EQ(first.name, "left_1");
  EXPECT_EQ(first.group, "body");
  EXPECT_TRUE(scenario->pairs.empty());
  EXPECT_LT(glm::distance(first.X_WO.translation, glm::dvec3(0, 0, 1.1)), 1e-12);
  // The first joint's axis is W's z: mount and start turn x by 120 degrees.
  EXPECT_LT(glm::distance(first.X_WO.rotate({1, 0, 0}), glm::dvec3(-0.5, std::sqrt(0.75), 0)), 1e-12);
  EXPECT_LT(glm::distance(second.X_WO.translation, glm::dvec3(0, 0, 1.3)), 1e-12);
  EXPECT_LT(glm::distance(second.X_WO.rotate({0, 0, 1}), glm::dvec3(-0.5, std::sqrt(0.75), 0)), 1e-12);
  ASSERT_EQ(scenario->mechanisms.size(), 2U);
  const Mechanism& elbow = scenario->mechanisms[1];
  EXPECT_EQ(elbow.name, "left_2_joint");
  EXPECT_EQ(elbow.parent, 2);
  EXPECT_EQ(elbow.child, 3);
  EXPECT_EQ(elbow.damping, 0.1);
  EXPECT_NEAR(scenario->mechanisms[0].upper, glm::radians(170.0), 1e-12);
  EXPECT_EQ(scenario->mechanisms[0].motor_limit, 50.0);
  // J of parent and child meet, turned against each other by the start angle.
  const core::Pose X_JpJc = (first.X_WO * elbow.X_PJ).inverse() * (second.X_WO * elbow.X_CJ);
  EXPECT_LT(glm::length(X_JpJc.translation), 1e-12);
  EXPECT_LT(glm::distance(core::RotationVector(X_JpJc.rotation), glm::dvec3(0, 0, glm::radians(-45.0))), 1e-12);
}

TEST_F(JointsTest, RefusesArmsWithErrorsInTheirLinksFile) {
  std::ofstream(folder_ / "links.xml") << kLinks;
  ExpectRefusal(5, "start_deg has 3 angles", R"(<arm name="a" links="links.xml" base="body" start_deg="0 0 0"/>)");
  ExpectRefusal(5, "it starts outside its limits",
                R"(<arm name="a" links="links.xml" base="body" start_deg="175 0"/>)");
  std::ofstream(folder_ / "links.xml") << "<links>\n<link mass_kg=\"0\"/>\n<link mass=\"1\"/>\n</links>\n";
  const auto scenario = Load(R"(<arm name="a" links="links.xml" base="body"/>)");
  ASSERT_FALSE(scenario);
  std::string all;
  for (const Diagnostic& diagnostic : scenario.error()) all += Format(diagnostic) + "\n";
  EXPECT_THAT(all, HasSubstr("links.xml:2: "));
  EXPECT_THAT(all, HasSubstr("links.xml:3: "));
}

TEST_F(JointsTest, RefusesInconsistentJoints) {
  ExpectRefusal(5, "parent and child are both 'part'",
                R"(<slider name="s" parent="part" child="part" position="0 0 0"/>)");
  ExpectRefusal(5, "parent and child are both 'part'",
                R"(<hinge name="h" parent="part" child="part" position="0 0 0"/>)");
  ExpectRefusal(5, "lower_m is not below",
                R"(<slider name="s" child="part" position="0 0 0" lower_m="1" upper_m="0"/>)");
  ExpectRefusal(5, "motor_m_per_s without motor_force_N",
                R"(<slider name="s" child="part" position="0 0 0" motor_m_per_s="1"/>)");
  ExpectRefusal(5, "motor_deg_per_s without motor_torque_Nm",
                R"(<hinge name="h" child="part" position="0 0 0" motor_deg_per_s="1"/>)");
  ExpectRefusal(5, "position", R"(<slider name="s" child="part" position="nan 0 0"/>)");
  ExpectRefusal(5, "release_force_N",
                R"(<snap name="s" parent="body" parent_frame="a" child="part" child_frame="a" engage_force_N="5"/>)",
                R"(><frame name="a"/></object><object name="more" owner="fixed")");
}

TEST_F(JointsTest, RefusesASnapProfileWithoutTwoWells) {
  const auto snap = [](const std::string& profile) {
    return R"(<snap name="s" parent="socket" parent_frame="seat" child="part" child_frame="seat" release_force_N="20"
      stiffness_N_per_m="20000" )" +
           profile + "/>";
  };
  const std::string frames =
      R"(><visual mesh="mesh.obj"/><frame name="seat"/></object><object name="socket" owner="fixed"><frame name="seat"/></object><object name="more" owner="fixed")";
  const auto scenario = Load(snap(R"(profile="0.0005 0  0.001 9  0.002 15  0.003 0")"), frames);
  ASSERT_TRUE(scenario) << Format(scenario.error().front());
  EXPECT_EQ(scenario->mechanisms.at(0).profile.size(), 4U);
  EXPECT_EQ(scenario->mechanisms[0].engage_force_N, 15.0);
  EXPECT_EQ(scenario->mechanisms[0].travel_m, 0.003);
  ExpectRefusal(6, "no second well", snap(R"(profile="0.0005 0  0.001 9  0.003 15")"), frames);
  ExpectRefusal(6, "no first well", snap(R"(profile="0.0005 2  0.001 9  0.003 0")"), frames);
  ExpectRefusal(6, "one well only", snap(R"(profile="0.0005 0  0.001 0  0.003 0")"), frames);
  ExpectRefusal(6, "out of order at point 3", snap(R"(profile="0.0005 0  0.002 9  0.001 0")"), frames);
  ExpectRefusal(6, "has 5 numbers", snap(R"(profile="0.0005 0  0.002 9  0.001")"), frames);
  ExpectRefusal(6, "both travel_m and profile", snap(R"(travel_m="0.003" profile="0.0005 0  0.001 9  0.003 0")"),
                frames);
}

TEST_F(JointsTest, AGivenInertiaReplacesThatOfTheMesh) {
  const auto scenario = Load("", R"(inertia_kg_m2="0.1 0.2 0.25 0.01 -0.02 0.03" center_of_mass_m="0 0 0.1")");
  ASSERT_TRUE(scenario) << Format(scenario.error().front());
  ASSERT_TRUE(scenario->objects[1].inertia.has_value());
  EXPECT_EQ(scenario->objects[1].inertia->p_OCm_m.z, 0.1);
  EXPECT_EQ(scenario->objects[1].inertia->I_Cm_O_kg_m2[1][1], 0.2);
  EXPECT_EQ(scenario->objects[1].inertia->I_Cm_O_kg_m2[2][0], -0.02);
  EXPECT_EQ(scenario->objects[1].inertia->I_Cm_O_kg_m2[2][1], 0.03);
  EXPECT_FALSE(scenario->objects[0].inertia.has_value());
}

TEST_F(JointsTest, RefusesPhysicallyImpossibleInertiasAndMasses) {
  ExpectRefusal(4, "not that of a real body", "", R"(inertia_kg_m2="1 1 2.1 0 0 0")");  // 1 + 1 < 2.1
  ExpectRefusal(4, "not that of a real body", "", R"(inertia_kg_m2="1 1 1 0.9 0 0")");  // moments 0.1, 1, 1.9
  ExpectRefusal(4, "not that of a real body", "", R"(inertia_kg_m2="-1 -1 -1 0 0 0")");
  ExpectRefusal(4, "not that of a real body", "", R"(inertia_kg_m2="0 0 0 0 0 0")");
  ExpectRefusal(4, "has 3 numbers", "", R"(inertia_kg_m2="1 1 1")");
  ExpectRefusal(4, "inertia_kg_m2", "", R"(inertia_kg_m2="1 1 nan 0 0 0")");
  ExpectRefusal(5, "mass_kg", R"(<object name="x" owner="physics" mass_kg="0"><visual mesh="mesh.obj"/></object>)");
  ExpectRefusal(
      5, "position",
      R"(<object name="x" owner="physics" mass_kg="1" position="0 nan 0"><visual mesh="mesh.obj"/></object>)");
}

}  // namespace
}  // namespace scene
