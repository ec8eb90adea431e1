#include "scene/load_scenario.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <glm/gtc/constants.hpp>

namespace scene {
namespace {

using testing::Contains;
using testing::HasSubstr;
using testing::Not;

// A folder of its own for each test, with a mesh and a procedure that exist.
class LoadScenarioTest : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::temp_directory_path() / ("vr_oos_scene_" + std::to_string(::getpid()) + "_" +
                                                        testing::UnitTest::GetInstance()->current_test_info()->name());
    std::filesystem::create_directories(folder_);
    Write("mesh.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    Write("procedure.scxml", "<scxml/>\n");
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  void Write(const std::string& name, const std::string& text) const { std::ofstream(folder_ / name) << text; }

  // `lines` start at line 3 of the file.
  tl::expected<Scenario, std::vector<Diagnostic>> Load(const std::string& lines) const {
    Write("scenario.xml",
          "<scenario name=\"test\">\n<procedure file=\"procedure.scxml\"/>\n" + lines + "\n</scenario>\n");
    return LoadScenario(folder_);
  }
  std::vector<std::string> Complaints(const std::string& lines) const {
    const auto scenario = Load(lines);
    std::vector<std::string> texts;
    if (!scenario) {
      for (const Diagnostic& diagnostic : scenario.error()) texts.push_back(Format(diagnostic));
    }
    return texts;
  }
  // "file:line: " as Format writes it.
  [[nodiscard]] std::string At(int line) const {
    return (folder_ / "scenario.xml").string() + ":" + std::to_string(line) + ": ";
  }

  std::filesystem::path folder_;
};

constexpr const char* kPlate =
    R"(<object name="plate" owner="fixed"><visual mesh="mesh.obj"/><collision voxel_size_m="0.001"/></object>)";
constexpr const char* kBlock =
    R"(<object name="block" owner="physics" mass_kg="0.5"><visual mesh="mesh.obj"/><collision voxel_size_m="0.001" points="64"/></object>)";
constexpr const char* kHand = R"(
<object name="palm" owner="hand" part="palm" role="right" group="hand"><visual mesh="mesh.obj"/><collision points="64"/></object>
<object name="left" owner="hand" part="jaw_left" role="right" group="hand"><visual mesh="mesh.obj"/></object>
<object name="right" owner="hand" part="jaw_right" role="right" group="hand"><visual mesh="mesh.obj"/></object>
<device role="right" position="1 2 3" rpy_deg="0 0 90" opening_start_m="0.04"/>)";

std::string Join(std::initializer_list<std::string> parts) {
  std::string text;
  for (const std::string& part : parts) text += part + "\n";
  return text;
}

TEST_F(LoadScenarioTest, RefusesWhatAHeadHasNoUseForAndAnAddressThatIsNone) {
  const std::string scene = std::string(kPlate) + "\n" + kHand + "\n";
  const int line = 3 + static_cast<int>(std::count(scene.begin(), scene.end(), '\n'));
  for (const char* attribute : {"address=\"5000\"", "body=\"1\"", "position=\"1 2 3\"", "rpy_deg=\"1 2 3\"",
                                "eyes_m=\"0 0 1\"", "eyes_rpy_deg=\"0 0 1\""}) {
    const std::string name(attribute, std::string(attribute).find('='));
    EXPECT_THAT(Complaints(scene + "<user name=\"a\" " + attribute + "/>"),
                Contains(HasSubstr(At(line) + "user 'a': " + name + " means nothing for head simulated_head")))
        << attribute;
    EXPECT_THAT(Complaints(scene + "<user name=\"a\" head=\"dtrack\" " +
                           (name == "address" ? "" : "address=\"239.0.1.1:5000\" ") + attribute + "/>"),
                Not(Contains(HasSubstr("user 'a'"))))
        << attribute;
  }
  for (const char* address : {"port", "300.1.1.1:5000", "127.0.0.1:99999", "5000x"}) {
    EXPECT_THAT(Complaints(scene + "<user name=\"a\" head=\"dtrack\" address=\"" + address + "\"/>"),
                Contains(HasSubstr(At(line) + "user 'a': address is '" + address + "'")));
  }
}

// Turned by 90 degrees about z, the body's y points along the head's -x: where the head's right is, the body has -y.
TEST_F(LoadScenarioTest, ReadsHowAHeadSitsInItsBody) {
  const auto scenario = Load(std::string(kPlate) + "\n" + kHand +
                             R"(<user name="a" head="dtrack" address="5000" eyes_m="1 2 3" eyes_rpy_deg="0 0 -90"/>)");
  ASSERT_TRUE(scenario) << Format(scenario.error().front());
  const core::Pose& X_BH = scenario->users.at(0).X_BH;
  EXPECT_EQ(X_BH.translation, glm::dvec3(1, 2, 3));
  EXPECT_LT(glm::distance(X_BH.rotate({1, 0, 0}), glm::dvec3(0, -1, 0)), 1e-12);
}

TEST_F(LoadScenarioTest, LeavesAResolutionThatIsNotGivenToBeChosen) {
  const auto scenario =
      Load(Join({kPlate,
                 R"(<object name="a" owner="physics" mass_kg="1"><visual mesh="mesh.obj"/>)"
                 R"(<collision/></object>)",
                 R"(<object name="b" owner="physics" mass_kg="1"><collision mesh="mesh.obj"/></object>)"}));
  ASSERT_TRUE(scenario) << Format(scenario.error().front());
  ASSERT_EQ(scenario->objects.size(), 3U);
  EXPECT_FALSE(scenario->objects[0].is_resolution_chosen);
  for (std::size_t i = 1; i < 3; ++i) {
    const Object& object = scenario->objects[i];
    EXPECT_TRUE(object.is_resolution_chosen) << object.name;
    EXPECT_EQ(object.collision_mesh.filename(), "mesh.obj") << object.name;
    EXPECT_EQ(object.voxel_size_m, 0.0) << object.name;
    EXPECT_EQ(object.num_points, 0U) << object.name;
  }
  // Such an object can be either side.
  EXPECT_EQ(scenario->pairs.size(), 3U);
}

TEST_F(LoadScenarioTest, RefusesAZenithAlongTheSun) {
  EXPECT_THAT(Complaints(Join({kPlate, R"(<sun direction="0 0 2"/>)", R"(<environment zenith="0 0 -1"/>)"})),
              Contains(HasSubstr("zenith lies along the sun's direction")));
}

TEST_F(LoadScenarioTest, PairsHaveTheScenariosAccuracyUnlessTheyHaveTheirOwn) {
  const std::string other =
      R"(<object name="other" owner="physics" mass_kg="1"><visual mesh="mesh.obj"/><collision voxel_size_m="0.001" points="100"/></object>)";
  const auto scenario = Load(Join({R"(<run method="fast" accuracy="0.1" budget_us="80"/>)", kPlate, kBlock, other,
                                   R"(<pair a="block" b="plate" accuracy="0.02"/>)"}));
  ASSERT_TRUE(scenario) << Format(scenario.error().front());
  int num_own = 0;
  for (std::size_t i = 0; i < scenario->pairs.size(); ++i) {
    const bool is_own = scenario->PairName(i) == "block/plate";
    num_own += is_own ? 1 : 0;
    EXPECT_EQ(scenario->pairs[i].accuracy, is_own ? 0.02 : 0.1) << scenario->PairName(i);
    EXPECT_EQ(scenario->pairs[i].budget_us, 80.0);
  }
  EXPECT_EQ(num_own, 1);
  EXPECT_GT(scenario->pairs.size(), 1U);
}

TEST_F(LoadScenarioTest, ReadsEveryFigure) {
  const auto scenario = Load(Join({
      R"(<run method="fast" accuracy="0.1" budget_us="80" contact_input="wrench" seed="7" duration_limit_s="60" stall_limit_s="9" force_cap_N="30" gravity_m_per_s2="0 1 -9.81"/>)",
      R"(<coupling type="god_object" stiffness_N_per_m="2000" alpha="3" grip="friction"/>)",
      kPlate,
      kBlock,
      kHand,
      R"(<pair a="block" b="plate" stiffness_N_per_m="1000" friction="0.5" active="false"/>)",
      R"(<parameter name="gain" value="2.5"/>)",
      R"(<camera name="top" eye_m="0 0 1" target_m="0 0.1 0" vertical_fov_deg="90"/>)",
      R"(<sun direction="0 0 1"/>)",
      R"(<environment epoch="2014-03-01T12:00:00Z" altitude_km="800" inclination_deg="90" node_deg="-90" argument_deg="45" zenith="1 0 0"/>)",
  }));
  ASSERT_TRUE(scenario) << Format(scenario.error().front());
  EXPECT_EQ(scenario->name, "test");
  EXPECT_EQ(scenario->method, "fast");
  EXPECT_EQ(scenario->contact_input, ContactInput::kWrench);
  EXPECT_EQ(scenario->accuracy, 0.1);
  EXPECT_EQ(scenario->budget_us, 80.0);
  EXPECT_EQ(scenario->seed, 7U);
  EXPECT_EQ(scenario->stall_limit_s, 9.0);
  EXPECT_EQ(scenario->force_cap_N, 30.0);
  EXPECT_EQ(scenario->gravity_m_per_s2, glm::dvec3(0.0, 1.0, -9.81));
  EXPECT_EQ(scenario->coupling.type, "god_object");
  EXPECT_EQ(scenario->coupling.stiffness_N_per_m, 2000.0);
  EXPECT_EQ(scenario->coupling.alpha, 3.0);
  EXPECT_TRUE(scenario->coupling.is_grip_by_friction);
  EXPECT_EQ(scenario->coupling.eta, Coupling{}.eta);
  EXPECT_TRUE(scenario->procedure.is_absolute());
  ASSERT_EQ(scenario->objects.size(), 5U);
  EXPECT_EQ(scenario->objects[1].mass_kg, 0.5);
  EXPECT_EQ(scenario->objects[1].collision_mesh, scenario->objects[1].visual_mesh);
  ASSERT_EQ(scenario->cameras.size(), 1U);
  EXPECT_NEAR(scenario->cameras[0].vertical_fov_rad, glm::half_pi<double>(), 1e-12);
  ASSERT_EQ(scenario->parameters.size(), 1U);
  EXPECT_EQ(scenario->parameters[0].value, 2.5);
  const space::Place& place = scenario->place;
  EXPECT_EQ(space::FormatInstant(place.epoch), "2014-03-01 12:00:00 UTC");
  EXPECT_EQ(place.orbit.altitude_m, 800e3);
  EXPECT_NEAR(place.orbit.inclination_rad, glm::half_pi<double>(), 1e-12);
  EXPECT_NEAR(place.orbit.node_rad, -glm::half_pi<double>(), 1e-12);
  EXPECT_NEAR(place.orbit.argument_rad, glm::quarter_pi<double>(), 1e-12);
  EXPECT_EQ(place.sun_W, glm::dvec3(0.0, 0.0, 1.0));
  EXPECT_EQ(place.zenith_W, glm::dvec3(1.0, 0.0, 0.0));
  const Device& device = scenario->devices.at(0);
  EXPECT_EQ(device.palm, 2);
  EXPECT_EQ(device.jaw_left, 3);
  EXPECT_EQ(device.jaw_right, 4);
}

TEST_F(LoadScenarioTest, HandPartsStartAtTheirDevice) {
  const auto scenario = Load(kHand);
  ASSERT_TRUE(scenario) << Format(scenario.error().front());
  // The palm's x axis is W's y axis after a quarter turn about z; the jaws stand half the opening to either side.
  EXPECT_LT(glm::distance(scenario->objects[1].X_WO.translation, glm::dvec3(1, 1.98, 3)), 1e-12);
  EXPECT_LT(glm::distance(scenario->objects[2].X_WO.translation, glm::dvec3(1, 2.02, 3)), 1e-12);
}

TEST_F(LoadScenarioTest, PairsComeFromGroupsInFileOrder) {
  const auto scenario = Load(Join({kPlate, kBlock, kHand}));
  ASSERT_TRUE(scenario) << Format(scenario.error().front());
  // The plate has no points and the palm no voxels, so the block is sampled against the plate and the palm against
  // both.
  ASSERT_EQ(scenario->pairs.size(), 3U);
  EXPECT_EQ(scenario->PairName(0), "block/plate");
  EXPECT_EQ(scenario->PairName(1), "palm/plate");
  EXPECT_EQ(scenario->PairName(2), "palm/block");
}

TEST_F(LoadScenarioTest, ExplicitPairChoosesTheSampledBodyAndCanDropThePair) {
  const std::string other =
      R"(<object name="other" owner="physics" mass_kg="1"><visual mesh="mesh.obj"/><collision voxel_size_m="0.001" points="64"/></object>)";
  const auto plain = Load(Join({kBlock, other}));
  const auto turned = Load(Join({kBlock, other, R"(<pair a="other" b="block" friction="0.7"/>)"}));
  const auto dropped = Load(Join({kBlock, other, R"(<pair a="other" b="block" collide="false"/>)"}));
  ASSERT_TRUE(plain && turned && dropped);
  ASSERT_EQ(plain->pairs.size(), 1U);
  EXPECT_EQ(plain->PairName(0), "block/other");
  ASSERT_EQ(turned->pairs.size(), 1U);
  EXPECT_EQ(turned->PairName(0), "other/block");
  EXPECT_EQ(turned->pairs[0].friction, 0.7);
  EXPECT_TRUE(dropped->pairs.empty());
}

TEST_F(LoadScenarioTest, HingeFramesCoincideAtAngleZeroAndChildStartsInItsDetent) {
  const auto scenario = Load(Join({
      R"(<object name="base" owner="fixed" position="1 0 0" rpy_deg="0 0 90"/>)",
      R"(<object name="lever" owner="physics" mass_kg="0.1" position="1 0 0.1"><visual mesh="mesh.obj"/></object>)",
      R"(<hinge name="switch" parent="base" child="lever" position="1 0 0" detents_deg="-20 20" initial_detent="1"/>)",
  }));
  ASSERT_TRUE(scenario) << Format(scenario.error().front());
  const Mechanism& hinge = scenario->mechanisms.at(0);
  const core::Pose X_WJp = scenario->objects[0].X_WO * hinge.X_PJ;
  const core::Pose X_WJc = scenario->objects[1].X_WO * hinge.X_CJ;
  const glm::dvec3 turn = core::RotationVector((X_WJp.inverse() * X_WJc).rotation);
  EXPECT_LT(glm::distance(X_WJp.translation, glm::dvec3(1, 0, 0)), 1e-12);
  EXPECT_LT(glm::distance(X_WJc.translation, glm::dvec3(1, 0, 0)), 1e-12);
  EXPECT_LT(glm::distance(turn, glm::dvec3(0, 0, 20.0 * glm::pi<double>() / 180.0)), 1e-12);
}

TEST_F(LoadScenarioTest, ASnapUsesTheNamedFrames) {
  const std::string parts = Join({
      R"(<object name="cavity" owner="fixed"><frame name="seat" position="0 0 0.1"/></object>)",
      R"(<object name="module" owner="physics" mass_kg="1" position="0 0 0.3"><visual mesh="mesh.obj"/><frame name="seat" position="0 0 -0.2"/></object>)",
  });
  const std::string snap =
      R"(<snap name="latch" parent="cavity" parent_frame="seat" child="module" child_frame="seat" release_force_N="20" stiffness_N_per_m="1000" engaged="true"/>)";
  const auto scenario = Load(parts + snap);
  ASSERT_TRUE(scenario) << Format(scenario.error().front());
  EXPECT_EQ(scenario->mechanisms.at(0).X_PJ.translation.z, 0.1);
  EXPECT_EQ(scenario->mechanisms.at(0).X_CJ.translation.z, -0.2);

  std::string far = parts;
  far.replace(far.find("0 0 0.3"), 7, "0 0 0.4");
  EXPECT_THAT(Complaints(far + snap),
              Contains(testing::AllOf(HasSubstr(At(5)), HasSubstr("100.0"), HasSubstr("Fix:"))));
}

TEST_F(LoadScenarioTest, ReportsTheLineOfMalformedXml) {
  Write("scenario.xml", "<scenario name=\"test\">\n<object name=\"a\">\n</scenario>\n");
  const auto scenario = LoadScenario(folder_);
  ASSERT_FALSE(scenario);
  ASSERT_EQ(scenario.error().size(), 1U);
  EXPECT_EQ(scenario.error()[0].where.line, 3);
  EXPECT_THAT(Format(scenario.error()[0]), HasSubstr("malformed XML"));
  EXPECT_THAT(Format(scenario.error()[0]), HasSubstr("object line 2"));
}

TEST_F(LoadScenarioTest, ReportsTheNameOfAMissingFile) {
  const auto scenario = LoadScenario(folder_ / "nowhere.xml");
  ASSERT_FALSE(scenario);
  EXPECT_THAT(Format(scenario.error()[0]), HasSubstr("nowhere.xml"));
}

TEST_F(LoadScenarioTest, ReportsTheLineOfAMissingMesh) {
  const auto complaints = Complaints("<object name=\"a\" owner=\"fixed\">\n<visual\n  mesh=\"gone.obj\"/></object>");
  ASSERT_EQ(complaints.size(), 1U);
  EXPECT_THAT(complaints[0], testing::StartsWith(At(5) + "mesh 'gone.obj' is missing"));
  EXPECT_THAT(complaints[0], HasSubstr("Fix: "));
}

TEST_F(LoadScenarioTest, SuggestsTheNearestObjectForAnUnknownOne) {
  const auto complaints = Complaints(Join({kPlate, kBlock, R"(<pair a="blok" b="plate"/>)"}));
  ASSERT_EQ(complaints.size(), 1U);
  EXPECT_THAT(complaints[0], testing::StartsWith(At(5) + "pair blok/plate: unknown object 'blok'"));
  EXPECT_THAT(complaints[0], HasSubstr("did you mean 'block'"));
}

TEST_F(LoadScenarioTest, ReportsANegativeMassOnceWithItsLine) {
  const auto complaints =
      Complaints("<object name=\"a\" owner=\"physics\"\n  mass_kg=\"-1\"><visual mesh=\"mesh.obj\"/></object>");
  ASSERT_EQ(complaints.size(), 1U);
  EXPECT_THAT(complaints[0], testing::StartsWith(At(4) + "object 'a': mass_kg is '-1': it must be"));
}

struct BadCase {
  const char* title;
  const char* lines;
  int line;
  const char* says;
};

class LoadScenarioBadCases : public LoadScenarioTest, public testing::WithParamInterface<BadCase> {};

TEST_P(LoadScenarioBadCases, ReportsLineAndCause) {
  const auto complaints = Complaints(GetParam().lines);
  EXPECT_THAT(complaints,
              Contains(testing::AllOf(testing::StartsWith(At(GetParam().line)), HasSubstr(GetParam().says))));
}

// Lines as they stand in the file: the first line given here is line 3.
const BadCase kBadCases[] = {
    {"UnknownElement", "<objekt name='a'/>", 3, "did you mean 'object'"},
    {"UnknownAttribute", "<object name='a' owner='fixed' positon='0 0 0'/>", 3, "did you mean 'position'"},
    {"NotFinite", "<object name='a' owner='fixed' position='0 nan 0'/>", 3, "three finite numbers"},
    {"Infinite", "<parameter name='a' value='inf'/>", 3, "a finite number"},
    {"TooFewNumbers", "<object name='a' owner='fixed'\nposition='0 1'/>", 4, "three finite numbers"},
    {"UnknownChoice", "<object name='a' owner='robot'/>", 3, "'fixed', 'physics' and 'hand'"},
    {"UnknownCoupling", "<coupling type='god-object'/>", 3, "'paper' and 'god_object'"},
    {"NoMass", "<object name='a' owner='physics'><visual mesh='mesh.obj'/></object>", 3, "no mass"},
    {"ZeroMass", "<object name='a' owner='physics' mass_kg='0'><visual mesh='mesh.obj'/></object>", 3,
     "mass_kg is '0'"},
    {"MassAndDensity", "<object name='a' owner='physics' mass_kg='1' density_kg_per_m3='2'/>", 3, "one of them"},
    {"SameName", "<object name='a' owner='fixed'/>\n<object name='a' owner='fixed'/>", 4, "taken by line 3"},
    {"EmptyCollision", "<object name='a' owner='fixed'><visual mesh='mesh.obj'/><collision points='0'/></object>", 3,
     "neither a field nor points"},
    {"AccuracyOfAllOrMore", "<run method='fast'\naccuracy='5'/>", 4, "accuracy is '5'"},
    {"AccuracyOfADepth",
     "<object name='a' owner='fixed'><visual mesh='mesh.obj'/><collision accuracy_m='1e-4'/></object>", 3,
     "no longer has it. Fix: write accuracy=\"0.1\" in <run> or <pair>"},
    {"ChosenWithoutMesh", "<object name='a' owner='fixed'><collision/></object>", 3, "has no mesh"},
    {"CollisionWithoutMesh", "<object name='a' owner='fixed'><collision points='64'/></object>", 3, "has no mesh"},
    {"VoxelInMillimetres",
     "<object name='a' owner='fixed'><visual mesh='mesh.obj'/><collision voxel_size_m='1'/></object>", 3, "0.02 mm"},
    {"TooFewPoints", "<object name='a' owner='fixed'><visual mesh='mesh.obj'/><collision points='3'/></object>", 3,
     "3 points"},
    {"HandWithoutRole", "<object name='a' owner='hand' part='palm'/>", 3, "role is missing"},
    {"HandWithUnknownRole", "<device role='right'/>\n<object name='a' owner='hand' part='palm' role='rigt'/>", 4,
     "did you mean 'right'"},
    {"DeviceWithoutPalm", "<device role='right'/>", 3, "no palm"},
    {"OneJaw",
     "<device role='r'/>\n<object name='p' owner='hand' part='palm' role='r'/>"
     "<object name='j' owner='hand' part='jaw_left' role='r'/>",
     3, "jaw_right is missing"},
    {"TwoPalms",
     "<device role='r'/>\n<object name='p' owner='hand' part='palm' role='r'/>\n"
     "<object name='q' owner='hand' part='palm' role='r'/>",
     5, "has this part already, 'p'"},
    {"SameRole", "<device role='r'/>\n<device role='r'/>", 4, "taken by line 3"},
    {"JointOfOneBody",
     "<object name='a' owner='physics' mass_kg='1'/>\n<hinge name='h' parent='a' child='a' position='0 0 0'/>", 4,
     "joins two bodies"},
    {"JointOnFixed", "<object name='a' owner='fixed'/>\n<hinge name='h' child='a' position='0 0 0'/>", 4,
     "not moved by physics"},
    {"JointOfUnknownObject", "<hinge name='h' child='gone' position='0 0 0'/>", 3, "unknown object 'gone'"},
    {"DetentsDescending",
     "<object name='a' owner='physics' mass_kg='1'/>\n"
     "<hinge name='h' child='a' position='0 0 0' detents_deg='20 -20'/>",
     4, "not ascending"},
    {"ThreeDetents",
     "<object name='a' owner='physics' mass_kg='1'/>\n"
     "<hinge name='h' child='a' position='0 0 0' detents_deg='0 1 2'/>",
     4, "none or two"},
    {"DetentBeyondLimit",
     "<object name='a' owner='physics' mass_kg='1'/>\n"
     "<hinge name='h' child='a' position='0 0 0' lower_deg='-10' upper_deg='10' detents_deg='-20 5'/>",
     4, "outside the limits"},
    {"UnknownFrame",
     "<object name='a' owner='physics' mass_kg='1'><frame name='tip'/></object>\n<object name='b' owner='fixed'/>\n"
     "<snap name='s' parent='b' parent_frame='seat' child='a' child_frame='tipp' release_force_N='1'/>",
     5, "did you mean 'tip'"},
    {"SnapWithoutASecondWell",
     "<object name='a' owner='physics' mass_kg='1'/>\n<object name='b' owner='fixed'/>\n"
     "<snap name='s' parent='b' child='a' release_force_N='0'/>",
     5, "release_force_N"},
    {"PatchOfTwoNumbers",
     "<object name='a' owner='physics' mass_kg='1'/>\n"
     "<hook_and_loop name='v' child='a' patches_m='0 0' release_force_N='1' stiffness_N_per_m='1'/>",
     4, "a point of three"},
    {"PairInOneGroup",
     "<object name='a' owner='physics' mass_kg='1' group='g'/>\n<object name='b' owner='fixed' group='g'/>\n"
     "<pair a='a' b='b'/>",
     5, "group 'g'"},
    {"PairWithoutStructures",
     "<object name='a' owner='physics' mass_kg='1'/>\n<object name='b' owner='fixed'/>\n<pair a='a' b='b'/>", 5,
     "no pointshell"},
    {"TwoRuns", "<object name='a' owner='fixed'/>\n<run/>\n<run/>", 5, "only one"},
    {"CameraLooksNowhere", "<camera name='c' eye_m='1 1 1' target_m='1 1 1'/>", 3, "coincide"},
    {"CameraOnNothing",
     "<object name='palm' owner='fixed'/>\n<camera name='c' eye_m='1 1 1' target_m='0 0 0' mounted_on='plam'/>", 4,
     "did you mean 'palm'"},
    {"CameraMountedAndFollowing",
     "<object name='a' owner='fixed'/>\n<camera name='c' eye_m='1 1 1' target_m='0 0 0' mounted_on='a' follows='a'/>",
     4, "remove mounted_on or follows"},
    {"NoObjects", "<run/>", 1, "<object> is missing"},
    {"StrayText", "<run/>\nhello", 1, "attributes and elements only"},
};

INSTANTIATE_TEST_SUITE_P(All, LoadScenarioBadCases, testing::ValuesIn(kBadCases),
                         [](const auto& param_info) { return std::string(param_info.param.title); });

TEST_F(LoadScenarioTest, ACameraIsCarriedByTheObjectThatItNames) {
  const auto scenario = Load(Join({R"(<camera name="eye" eye_m="0 0 0" target_m="0 0 -1" mounted_on="b"/>)",
                                   R"(<camera name="beside" eye_m="1 0 0" target_m="0 0 0" follows="a"/>)",
                                   R"(<object name="a" owner="fixed"/>)", R"(<object name="b" owner="fixed"/>)"}));
  ASSERT_TRUE(scenario) << scenario.error().front().what;
  EXPECT_EQ(scenario->cameras[0].object, 1);
  EXPECT_TRUE(scenario->cameras[0].is_mounted);
  EXPECT_EQ(scenario->cameras[1].object, 0);
  EXPECT_FALSE(scenario->cameras[1].is_mounted);
}

TEST_F(LoadScenarioTest, ReportsAllErrorsInLineOrder) {
  const auto scenario = Load(Join({R"(<object name="a" owner="physics" mass_kg="-1"/>)", R"(<pair a="x" b="y"/>)",
                                   R"(<camera name="c" eye_m="0 0 0"/>)"}));
  ASSERT_FALSE(scenario);
  int last_line = 0;
  for (const Diagnostic& diagnostic : scenario.error()) {
    EXPECT_GE(diagnostic.where.line, last_line);
    last_line = diagnostic.where.line;
    EXPECT_FALSE(diagnostic.what.empty() || diagnostic.why.empty() || diagnostic.fix.empty());
  }
  EXPECT_GE(scenario.error().size(), 4U);  // mass, mesh or two unknown names, missing target
}

}  // namespace
}  // namespace scene
