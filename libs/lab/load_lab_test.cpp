#include "lab/load_lab.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "scene/load_scenario.hpp"

namespace lab {
namespace {

constexpr const char* kGood = R"(<lab name="bench">
  <host name="haptics" address="10.0.0.11" user="oos" port="2222" bind="eth1" run_folder="/var/tmp/oos"/>
  <host name="sim" address="sim.lab" supervisor="systemd" cache="/srv/cooked"/>
  <registry host="sim" port="7500"/>
  <node name="device_bridge" host="haptics" cores="2" rt="enforce">
    <device role="op1/arm.right" path="/dev/hidraw0" type="udp" address="10.0.0.5:7460"/>
  </node>
  <node name="haptic_node" host="haptics" cores="3"/>
  <node name="physics_node" host="sim"/>
  <node name="logic_node" host="sim"/>
  <node name="visual_node" host="sim" display=":0"/>
</lab>
)";

std::filesystem::path Write(const std::string& text) {
  const auto file = std::filesystem::path(testing::TempDir()) / "lab.xml";
  std::ofstream(file) << text;
  return file;
}

std::string Replace(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

TEST(LoadLab, ReadsHostsPlacementsAndRegistry) {
  const auto lab = LoadLab(Write(kGood));
  ASSERT_TRUE(lab) << scene::Format(lab.error().front());
  EXPECT_EQ(lab->name, "bench");
  ASSERT_EQ(lab->hosts.size(), 2u);
  EXPECT_EQ(lab->hosts[0].ssh_port, 2222);
  EXPECT_EQ(lab->hosts[0].run_folder, "/var/tmp/oos");
  EXPECT_EQ(lab->hosts[1].supervisor, SupervisorKind::kSystemd);
  EXPECT_EQ(lab->registry_host, "sim");
  EXPECT_EQ(lab->registry_port, 7500);
  ASSERT_NE(lab->FindPlacement("device_bridge"), nullptr);
  EXPECT_EQ(lab->FindPlacement("device_bridge")->rt, "enforce");
  EXPECT_EQ(lab->FindPlacement("device_bridge")->devices[0].path, "/dev/hidraw0");
  EXPECT_EQ(lab->FindPlacement("device_bridge")->devices[0].type, "udp");
  EXPECT_EQ(lab->FindPlacement("device_bridge")->devices[0].address, "10.0.0.5:7460");
}

TEST(LoadLab, WorkersTraceThePicturesOnAnyHostAsManyAsAViewerHasSeats) {
  const auto with = [](const std::string& workers) {
    return LoadLab(Write(Replace(kGood, "</lab>", workers + "</lab>")));
  };
  const auto lab = with("<ray_workers host=\"sim\" count=\"2\"/><ray_workers host=\"haptics\"/>");
  ASSERT_TRUE(lab) << scene::Format(lab.error().front());
  ASSERT_EQ(lab->ray_workers.size(), 2u);
  EXPECT_EQ(lab->ray_workers[0].count, 2u);
  EXPECT_EQ(lab->ray_workers[1].count, 1u);
  EXPECT_TRUE(lab->traces_rays());
  const auto unknown = with("<ray_workers host=\"simm\"/>");
  ASSERT_FALSE(unknown);
  EXPECT_THAT(scene::Format(unknown.error().front()), testing::HasSubstr("ray_workers: unknown host 'simm'"));
  const auto many = with("<ray_workers host=\"sim\" count=\"17\"/>");
  ASSERT_FALSE(many);
  EXPECT_THAT(scene::Format(many.error().front()), testing::HasSubstr("1 to 16"));
}

constexpr const char* kPictures = R"(  <view name="teacher" host="sim" layout="overview | gripper" size="640x360"/>
  <room name="cave" camera="overview" user="operator" stereo="top_bottom" eye_distance_mm="65">
    <screen name="front" host="sim" lower_left="-1 1 -1" lower_right="1 1 -1" upper_left="-1 1 1" size="640x640" display=":1" place="0,0"/>
    <screen name="left" host="haptics" lower_left="-1 -1 -1" lower_right="-1 1 -1" upper_left="-1 -1 1" size="640x640"/>
  </room>
</lab>
)";

std::string WithPictures() {
  return Replace(kGood, "</lab>\n", kPictures);
}

TEST(LoadLab, ReadsViewsAndTheWallsOfARoom) {
  const auto lab = LoadLab(Write(WithPictures()));
  ASSERT_TRUE(lab) << scene::Format(lab.error().front());
  ASSERT_EQ(lab->viewers.size(), 1u);
  EXPECT_EQ(lab->viewers[0].layout, "overview | gripper");
  ASSERT_EQ(lab->rooms.size(), 1u);
  ASSERT_EQ(lab->rooms[0].walls.size(), 2u);
  EXPECT_NEAR(lab->rooms[0].eye_distance_m, 0.065, 1e-12);
  const Wall& front = lab->rooms[0].walls[0];
  EXPECT_EQ(front.viewer.camera, "overview");
  EXPECT_EQ(front.viewer.stereo, "top_bottom");
  EXPECT_EQ(front.viewer.user, "operator");
  EXPECT_EQ(front.place, "0,0");
  EXPECT_EQ(front.screen_R.lower_right, glm::dvec3(1, 1, -1));
  EXPECT_EQ(lab->ViewersOn("sim").size(), 2u);
  EXPECT_EQ(lab->ViewersOn("haptics").size(), 1u);
}

TEST(LoadLab, AViewerCanHaveAnotherRenderer) {
  const auto with = [](const std::string& attributes) {
    return LoadLab(Write(Replace(kGood, "</lab>\n", "<view name=\"v\" host=\"sim\" " + attributes + "/></lab>\n")));
  };
  const auto read = [&](const std::string& attributes) {
    const auto lab = with(attributes);
    EXPECT_TRUE(lab) << attributes << ": " << scene::Format(lab.error().front());
    return lab ? lab->viewers.at(0) : Viewer();
  };
  EXPECT_EQ(read("").renderer, Renderer::kOpenGl);
  EXPECT_EQ(read("renderer=\"opengl\"").num_workers, 0u);
  EXPECT_EQ(read("renderer=\"rays\"").num_workers, 1u);
  EXPECT_EQ(read("renderer=\"rays\" workers=\"3\"").num_workers, 3u);
  EXPECT_EQ(read("renderer=\"headset\" camera=\"overview\"").renderer, Renderer::kHeadset);
  EXPECT_EQ(read("renderer=\"page\" camera=\"overview\"").port, 8765);
  EXPECT_EQ(read("renderer=\"page\" port=\"9000\"").port, 9000);
  for (const auto& [attributes, why] : {std::pair{"renderer=\"pages\"", "pages"},
                                        {"renderer=\"page\" size=\"640x360\"", "has size"},
                                        {"renderer=\"page\" display=\":0\"", "has display"},
                                        {"renderer=\"page\" port=\"65536\"", "1 to 65535"},
                                        {"port=\"9000\"", "has a port"},
                                        {"workers=\"2\"", "2 workers"},
                                        {"renderer=\"rays\" workers=\"17\"", "1 to 16"},
                                        {"renderer=\"headset\" size=\"640x360\"", "has size"}}) {
    const auto lab = with(attributes);
    ASSERT_FALSE(lab) << attributes;
    EXPECT_THAT(scene::Format(lab.error().front()), testing::HasSubstr(why));
  }
}

TEST(LoadLab, PagesOfOneHostHaveDifferentPorts) {
  const auto with = [](const std::string& second) {
    return LoadLab(Write(Replace(kGood, "</lab>\n",
                                 "<view name=\"v\" host=\"sim\" renderer=\"page\"/>"
                                 "<view name=\"w\" renderer=\"page\" " +
                                     second + "/></lab>\n")));
  };
  EXPECT_TRUE(with("host=\"haptics\""));
  EXPECT_TRUE(with("host=\"sim\" port=\"8766\""));
  const auto lab = with("host=\"sim\"");
  ASSERT_FALSE(lab);
  EXPECT_THAT(scene::Format(lab.error().front()), testing::HasSubstr("that of view 'v'"));
}

TEST(LoadLab, ReportsCamerasAndUsersThatTheScenarioLacks) {
  const auto lab = LoadLab(Write(WithPictures()));
  ASSERT_TRUE(lab);
  scene::Scenario scenario;
  scenario.devices.emplace_back().role = "op1/arm.right";
  scenario.cameras.emplace_back().name = "overvieww";
  scenario.users.emplace_back().name = "operator";
  const auto problems = CheckAgainst(*lab, scenario, {});
  ASSERT_EQ(problems.size(), 2u) << "of both walls";
  EXPECT_THAT(scene::Format(problems[0]), testing::HasSubstr("unknown camera 'overview'"));
  EXPECT_EQ(problems[0].where.line, 14);
}

std::string Colocated() {
  const std::string text = Replace(kGood, "name=\"bench\"", "name=\"bench\" colocate=\"haptic physics\"");
  return Replace(text, "\"physics_node\" host=\"sim\"", "\"physics_node\" host=\"haptics\" cores=\"3\"");
}

TEST(LoadLab, ColocateNeedsOneHostAndBothNodes) {
  const auto lab = LoadLab(Write(Colocated()));
  ASSERT_TRUE(lab) << scene::Format(lab.error().front());
  EXPECT_TRUE(lab->is_colocated);
  const auto problems = CheckAgainst(*lab, scene::Scenario{}, {"physics_node"});
  ASSERT_FALSE(problems.empty());
  EXPECT_THAT(scene::Format(problems.front()), testing::HasSubstr("physics_node is left out, but colocated"));
  const auto other_cores =
      LoadLab(Write(Replace(Colocated(), " cores=\"3\"/>\n  <node name=\"logic", "/>\n  <node name=\"logic")));
  ASSERT_FALSE(other_cores);
  EXPECT_THAT(scene::Format(other_cores.error().front()), testing::HasSubstr("other cores or another rt"));
}

TEST(LoadLab, TheExampleInTheDocumentationIsValid) {
  const auto lab = LoadLab(std::filesystem::path(VR_OOS_SOURCE_DIR) / "docs" / "howto" / "lab_example.xml");
  ASSERT_TRUE(lab) << scene::Format(lab.error().front());
  const auto scenario = scene::LoadScenario(std::filesystem::path(VR_OOS_SOURCE_DIR) / "scenarios" / "touch");
  ASSERT_TRUE(scenario);
  EXPECT_TRUE(CheckAgainst(*lab, *scenario, {}).empty());
}

struct BadLab {
  const char* name;
  const char* from;
  const char* to;
  int line;
  const char* what;
};

class LoadLabBad : public testing::TestWithParam<BadLab> {};

TEST_P(LoadLabBad, YieldsOneMessageWithItsLine) {
  const auto lab = LoadLab(Write(Replace(WithPictures(), GetParam().from, GetParam().to)));
  ASSERT_FALSE(lab);
  ASSERT_EQ(lab.error().size(), 1u) << scene::Format(lab.error().back());
  EXPECT_EQ(lab.error()[0].where.line, GetParam().line);
  EXPECT_THAT(scene::Format(lab.error()[0]), testing::HasSubstr(GetParam().what));
}

INSTANTIATE_TEST_SUITE_P(
    , LoadLabBad,
    testing::Values(
        BadLab{"UnknownHost", "\"physics_node\" host=\"sim\"", "\"physics_node\" host=\"simm\"", 9,
               "unknown host 'simm'"},
        BadLab{"UnknownRegistryHost", "registry host=\"sim\"", "registry host=\"haptic\"", 4, "'haptics'"},
        BadLab{"NodeTwice", "\"logic_node\"", "\"physics_node\"", 10, "physics_node is placed twice"},
        BadLab{"UnknownNode", "\"logic_node\"", "\"logics_node\"", 10, "one of"},
        BadLab{"PairOnTwoHosts", "name=\"bench\"", "name=\"bench\" colocate=\"haptic physics\"", 1,
               "haptic_node is on haptics, physics_node on sim"},
        BadLab{"UnknownPair", "name=\"bench\"", "name=\"bench\" colocate=\"haptic logic\"", 1, "colocate"},
        BadLab{"HostTwice", "<registry", "<host name=\"haptics\" address=\"x\"/><registry", 4, "is declared twice"},
        BadLab{"UnknownAttribute", "display", "displey", 11, "unknown attribute 'displey'"},
        BadLab{"NoAddress", " address=\"sim.lab\"", "", 3, "'address' is missing"},
        BadLab{"AddressIsAnOption", "sim.lab", "-oProxyCommand=x", 3, "ssh would take it for an option"},
        BadLab{"PortTooLarge", "7500", "75000", 4, "from 1 to 65535"},
        BadLab{"NoSuchKey", "port=\"2222\"", "identity=\"no_such_key\"", 2, "no_such_key' is not a file"},
        BadLab{"Cores", "cores=\"3\"", "cores=\"three\"", 8, "CPU numbers"},
        BadLab{"RunFolderWithQuote", "/var/tmp/oos", "/var/tmp/it's", 2, "unit files"},
        BadLab{"RunFolderWithSemicolon", "/var/tmp/oos", "/var/tmp/a;b", 2, "letters, digits"},
        BadLab{"AddressWithBackquotes", "sim.lab", "sim`id`", 3, "becomes part of commands"},
        BadLab{"RelativeCache", "/srv/cooked", "cooked", 3, "absolute path"},
        BadLab{"MulticastOutsideItsRange", "name=\"bench\"", "name=\"bench\" multicast=\"10.0.0.9:7450\"", 1,
               "multicast is '10.0.0.9:7450'"},
        BadLab{"MulticastWithoutPort", "name=\"bench\"", "name=\"bench\" multicast=\"239.255.74.50\"", 1,
               "239.255.74.50:7450"},
        BadLab{"TopicsWithBlank", "name=\"bench\"", "name=\"bench\" tcp_topics=\"a/*, b/*\"", 1,
               "with commas between them"},
        BadLab{"ViewTwice", "<view name=\"teacher\"", "<view name=\"front\"", 14, "a second viewer 'front'"},
        BadLab{"ViewOnNoHost", "\"teacher\" host=\"sim\"", "\"teacher\" host=\"sin\"", 12, "unknown host 'sin'"},
        BadLab{"ViewWithBackquotes", "overview | gripper", "`id`", 12, "the viewer's command"},
        BadLab{"ViewOfCameraAndLayout", "layout=", "camera=\"a\" layout=", 12, "a camera and a layout"},
        BadLab{"WallOfNoSize", "size=\"640x640\" display", "size=\"640\" display", 14, "two whole numbers of pixels"},
        BadLab{"WallThatIsNoRectangle", "upper_left=\"-1 1 1\"", "upper_left=\"1 1 1\"", 14,
               "corners are no rectangle"},
        BadLab{"RoomWithoutWalls", "<room name=\"cave\"", "<room name=\"hall\"/><room name=\"cave\"", 13,
               "<screen> is missing"},
        BadLab{"UnknownStereo", "top_bottom", "crossed", 13, "one of"},
        BadLab{"DeviceWithoutAddress", " address=\"10.0.0.5:7460\"", "", 6, "no address"},
        BadLab{"DeviceOfUnknownType", "type=\"udp\"", "type=\"upd\"", 6, "one of"},
        BadLab{"DeviceAddressWithQuote", "10.0.0.5:7460", "10.0.0.5'7460", 6, "part of a command"},
        BadLab{"NoRegistry", "<registry host=\"sim\" port=\"7500\"/>", "", 1, "<registry> is missing"}),
    [](const auto& one) { return one.param.name; });

TEST(LoadLab, ReportsEveryReferenceToAnUnknownHost) {
  const auto lab = LoadLab(Write(Replace(kGood, "host name=\"sim\"", "host name=\"other\"")));
  ASSERT_FALSE(lab);
  EXPECT_EQ(lab.error().size(), 4u);  // the registry and three nodes
}

TEST(LoadLab, ReportsMissingPlacementsAndUnknownRoles) {
  const auto scenario = scene::LoadScenario(std::filesystem::path(VR_OOS_SOURCE_DIR) / "scenarios" / "touch");
  ASSERT_TRUE(scenario);
  std::string text = Replace(kGood, "<node name=\"logic_node\" host=\"sim\"/>", "");
  text = Replace(text, "op1/arm.right", "op9/arm");
  const auto lab = LoadLab(Write(text));
  ASSERT_TRUE(lab) << scene::Format(lab.error().front());
  const auto diagnostics = CheckAgainst(*lab, *scenario, {});
  ASSERT_EQ(diagnostics.size(), 2u);
  EXPECT_THAT(scene::Format(diagnostics[0]), testing::HasSubstr("logic_node is not placed on a host"));
  EXPECT_THAT(scene::Format(diagnostics[1]), testing::HasSubstr("op9/arm"));
  EXPECT_EQ(CheckAgainst(*lab, *scenario, {"logic_node"}).size(), 1u);
}

}  // namespace
}  // namespace lab
