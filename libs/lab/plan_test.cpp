#include "lab/plan.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>

#include "lab/unit_files.hpp"

namespace lab {
namespace {

using testing::HasSubstr;

Lab TwoHosts(SupervisorKind kind) {
  Lab lab;
  Host a;
  a.name = a.address = "a";
  a.supervisor = kind;
  Host b = a;
  b.name = b.address = "b";
  b.cache = "/srv/100%cooked";
  lab.hosts = {a, b};
  lab.registry_host = "b";
  for (const char* node : {"device_bridge", "haptic_node", "physics_node", "visual_node"}) {
    Placement placement;
    placement.node = node;
    placement.host = lab.placements.size() < 2 ? "a" : "b";
    lab.placements.push_back(placement);
  }
  lab.placements[0].cores = "2,3";
  lab.placements[0].devices.push_back({"right", "", "udp", "0.0.0.0:7460", {}});
  lab.placements[0].devices.push_back({"left", "/dev/hidraw0", "", "", {}});
  return lab;
}

// `program_folder`: systemd-analyze checks that the programs exist.
Plan PlanOf(const Lab& lab, const std::string& program_folder = "/opt/oos") {
  const std::map<std::string, HostFacts> facts = {
      {"a",
       {"/home/u/vr_oos", "10.0.0.1", program_folder, "/home/u/s.xml", "/home/u", ":120", "/home/u/page",
        "/home/u/page/stubs"}},
      {"b", {"/home/u/vr_oos", "10.0.0.2", program_folder, "/home/u/s.xml", "/home/u", ":120", "", ""}}};
  PlanOptions options;
  options.run = "run-1";
  options.session = 7;
  options.method = "fast";
  options.seed = 5;
  options.is_recorded = true;
  options.records_steps = true;
  return MakePlan(lab, facts, options);
}

std::vector<std::string> NamesOf(const HostPlan& host) {
  std::vector<std::string> names;
  for (const Unit& unit : host.units) names.push_back(unit.name);
  return names;
}

TEST(Plan, PlacesRegistryRecorderAndNodes) {
  const Plan plan = PlanOf(TwoHosts(SupervisorKind::kSupervisor));
  ASSERT_EQ(plan.hosts.size(), 2u);
  EXPECT_THAT(NamesOf(plan.hosts[0]), testing::ElementsAre("device_bridge", "haptic_node"));
  EXPECT_THAT(NamesOf(plan.hosts[1]),
              testing::ElementsAre("registry", "recorder", "physics_node", "display", "visual_node"));
  EXPECT_EQ(plan.registry, "tcp://10.0.0.2:7450");
  const std::string text = Describe(plan);
  EXPECT_THAT(text, HasSubstr("device_bridge: on cores 2,3: /opt/oos/device_bridge --scenario /home/u/s.xml --registry "
                              "tcp://10.0.0.2:7450 --session 7 --no_encryption --bind 10.0.0.1"));
  EXPECT_THAT(text, HasSubstr("--device right=udp:0.0.0.0:7460"));
  EXPECT_THAT(text, testing::Not(HasSubstr("--device left")));
  EXPECT_THAT(text, HasSubstr("--method fast --resume /home/u/vr_oos/runs/run-1"));
  EXPECT_THAT(text, HasSubstr("--steps /home/u/vr_oos/runs/run-1/steps/physics_node.mcap"));
  EXPECT_THAT(text, testing::Not(HasSubstr("steps/device_bridge.mcap")));
}

TEST(Plan, WritersOfLatestTopicsGetTheNetworkOptionsOfTheLab) {
  Lab lab = TwoHosts(SupervisorKind::kSupervisor);
  lab.tcp_topics = "physics/*,contacts/*";
  lab.multicast = "239.255.74.50:7450";
  for (const HostPlan& host : PlanOf(lab).hosts) {
    for (const Unit& unit : host.units) {
      const bool is_writer = unit.name.find("_node") != std::string::npos && unit.name != "visual_node";
      if (!is_writer) continue;
      EXPECT_THAT(unit.arguments,
                  testing::IsSupersetOf({"--tcp_topics", "physics/*,contacts/*", "--multicast", "239.255.74.50:7450"}))
          << unit.name;
    }
  }
}

TEST(Plan, WorkersTakeTheSeatsOfAViewerThatTracesRays) {
  Lab lab = TwoHosts(SupervisorKind::kSupervisor);
  lab.ray_workers = {{"b", 1, {}}, {"a", 2, {}}};
  const Plan plan = PlanOf(lab);
  EXPECT_THAT(NamesOf(plan.hosts[0]), testing::ElementsAre("device_bridge", "haptic_node", "rt_worker-visual_node-2",
                                                           "rt_worker-visual_node-3"));
  EXPECT_THAT(NamesOf(plan.hosts[1]), testing::Contains("rt_worker-visual_node-1"));
  const Unit& worker = plan.hosts[0].units[2];
  EXPECT_EQ(worker.program, "/opt/oos/rt_worker");
  EXPECT_THAT(worker.arguments, testing::IsSupersetOf({"--name", "rt_worker-visual_node-2", "--bind", "10.0.0.1"}));
  for (const Unit& unit : plan.hosts[1].units) {
    if (unit.name == "visual_node") {
      EXPECT_EQ(unit.program, "/opt/oos/rt_visual_node");
    }
  }
}

TEST(Plan, ColocateMakesOneUnitOfBothNodesWithBothNodesOptions) {
  Lab lab = TwoHosts(SupervisorKind::kSupervisor);
  lab.is_colocated = true;
  for (Placement& placement : lab.placements) placement.host = "a";
  const Plan plan = PlanOf(lab);
  EXPECT_THAT(NamesOf(plan.hosts[0]),
              testing::ElementsAre("device_bridge", "haptic_physics_node", "display", "visual_node"));
  const Unit& pair = plan.hosts[0].units[1];
  EXPECT_EQ(pair.program, "/opt/oos/haptic_physics_node");
  EXPECT_THAT(pair.nodes, testing::UnorderedElementsAre("haptic_node", "physics_node"));
  EXPECT_THAT(pair.arguments, testing::IsSupersetOf({"--workers", "--method", "--rt", "--resume"}));
  EXPECT_THAT(pair.arguments, testing::Contains("/home/u/vr_oos/runs/run-1/steps"));
}

TEST(Plan, ViewersAndWallsAreUnitsOfTheirHosts) {
  Lab lab = TwoHosts(SupervisorKind::kSupervisor);
  Viewer teacher;
  teacher.name = "teacher";
  teacher.host = "a";
  teacher.camera = "overview";
  teacher.display = ":1";
  lab.viewers = {teacher};
  Wall front;
  front.viewer.name = "front";
  front.viewer.host = "b";
  front.viewer.size = "640x480";
  front.place = "0,0";
  Wall left = front;
  left.viewer.name = "left";
  left.viewer.host = "a";
  lab.rooms = {{"cave", 0.065, {front, left}}};
  const Plan plan = PlanOf(lab);
  EXPECT_THAT(NamesOf(plan.hosts[0]), testing::ElementsAre("device_bridge", "haptic_node", "visual_node-teacher",
                                                           "display", "visual_node-left"));
  EXPECT_THAT(NamesOf(plan.hosts[1]), testing::ElementsAre("registry", "recorder", "physics_node", "display",
                                                           "visual_node", "visual_node-front"))
      << "one display for both";
  const Unit& wall = plan.hosts[1].units.back();
  EXPECT_EQ(wall.program, "/opt/oos/visual_node");
  EXPECT_THAT(wall.nodes, testing::ElementsAre("visual_node-front"));
  const std::string text = Describe(plan);
  EXPECT_THAT(text, HasSubstr("--size 640x480 --headless --room cave --wall front --walls front,left --screen "
                              "'-1 0 -1 1 0 -1 -1 0 1' --place 0,0 --eye_distance_mm 65"));
  EXPECT_THAT(text, HasSubstr("--out /home/u/vr_oos/runs/run-1/visual_node-teacher --view overview"));
}

TEST(Plan, AViewerHasItsOwnRendererAndWorkers) {
  Lab lab = TwoHosts(SupervisorKind::kSupervisor);
  Viewer teacher;
  teacher.name = "teacher";
  teacher.host = "a";
  teacher.renderer = Renderer::kRays;
  teacher.num_workers = 2;
  Viewer worn = teacher;
  worn.name = "worn";
  worn.renderer = Renderer::kHeadset;
  worn.num_workers = 0;
  lab.viewers = {teacher, worn};
  Wall front;
  front.viewer = teacher;
  front.viewer.name = "front";
  front.viewer.num_workers = 1;
  lab.rooms = {{"cave", 0.0, {front}}};
  const Plan plan = PlanOf(lab);
  EXPECT_THAT(NamesOf(plan.hosts[0]),
              testing::ElementsAre("device_bridge", "haptic_node", "display", "visual_node-teacher",
                                   "rt_worker-visual_node-teacher-1", "rt_worker-visual_node-teacher-2",
                                   "visual_node-worn", "visual_node-front", "rt_worker-visual_node-front-1"));
  const std::vector<Unit>& units = plan.hosts[0].units;
  EXPECT_EQ(units[3].program, "/opt/oos/rt_visual_node");
  EXPECT_EQ(units[5].program, "/opt/oos/rt_worker");
  EXPECT_EQ(units[6].program, "/opt/oos/headset_node");
  EXPECT_THAT(units[6].nodes, testing::ElementsAre("visual_node-worn"));
  EXPECT_THAT(units[6].arguments, testing::Not(testing::Contains("--headless"))) << "it has no such option";
  EXPECT_EQ(units[7].program, "/opt/oos/rt_visual_node");
  EXPECT_THAT(lab.ProgramsOfViewersOn("a"), testing::ElementsAre("rt_visual_node", "rt_worker", "headset_node"));
  EXPECT_TRUE(lab.ProgramsOfViewersOn("b").empty());
}

TEST(Plan, APageIsTheBridgesAndHasTheKeysOfAToolAndOfAViewer) {
  Lab lab = TwoHosts(SupervisorKind::kSupervisor);
  Viewer page;
  page.name = "phone";
  page.host = "a";
  page.camera = "overview";
  page.renderer = Renderer::kPage;
  page.port = 9000;
  lab.viewers = {page};
  const Plan plan = PlanOf(lab);
  EXPECT_THAT(NamesOf(plan.hosts[0]), testing::ElementsAre("device_bridge", "haptic_node", "visual_node-phone"))
      << "no display";
  const Unit& unit = plan.hosts[0].units.back();
  EXPECT_THAT(unit.nodes, testing::ElementsAre("visual_node-phone"));
  EXPECT_TRUE(unit.has_tools_key);
  EXPECT_EQ(unit.environment.at("OOS_STUBS"), "/home/u/page/stubs");
  EXPECT_THAT(Describe(plan), HasSubstr("/usr/bin/env node /home/u/page/tools/web_bridge/bridge.mjs /home/u/s.xml "
                                        "--registry tcp://10.0.0.2:7450 --session 7 --name visual_node-phone --bind "
                                        "10.0.0.1 --port 9000 --programs /opt/oos --view overview"));
  EXPECT_THAT(lab.ProgramsOfViewersOn("a"), testing::ElementsAre("scene_stream"));
  EXPECT_TRUE(lab.HasPageOn("a"));
  EXPECT_FALSE(lab.HasPageOn("b"));
}

TEST(Plan, LeavesOutAHostWithoutUnits) {
  Lab lab = TwoHosts(SupervisorKind::kSupervisor);
  for (Placement& placement : lab.placements) placement.host = "b";
  const Plan plan = PlanOf(lab);
  ASSERT_EQ(plan.hosts.size(), 1u);
  EXPECT_EQ(plan.hosts[0].host.name, "b");
}

TEST(SupervisorFiles, EveryUnitRestartsOnFailureAndIsStoppedAsAGroup) {
  const Plan plan = PlanOf(TwoHosts(SupervisorKind::kSupervisor));
  const std::string text = SupervisorFiles(plan.hosts[1]).files.at("supervisord.conf");
  for (const char* name : {"registry", "recorder", "physics_node", "display", "visual_node"}) {
    EXPECT_THAT(text, HasSubstr("[program:" + std::string(name) + "]"));
  }
  EXPECT_THAT(text, HasSubstr("autorestart=unexpected"));
  EXPECT_THAT(text, HasSubstr("killasgroup=true"));
  const auto patience_of = [&](const std::string& name) {
    const std::size_t at = text.find("stopwaitsecs=", text.find("[program:" + name + "]"));
    return text.substr(at, text.find('\n', at) - at);
  };
  EXPECT_EQ(patience_of("physics_node"), "stopwaitsecs=3");
  EXPECT_EQ(patience_of("visual_node"), "stopwaitsecs=10") << "it writes its last pictures";
  EXPECT_THAT(text, HasSubstr("OOS_RUN=\"run-1\""));
  EXPECT_THAT(text, HasSubstr("VR_OOS_CACHE=\"/srv/100%%cooked\""));
  EXPECT_THAT(text, HasSubstr("/bin/sh -c 'until [ -S /tmp/.X11-unix/X120 ]; do sleep 0.05; done; exec "
                              "\"$0\" \"$@\"' /opt/oos/visual_node --scenario"));
}

// Checked by systemd-analyze. Running the units is not tested: that needs systemd as the first process.
TEST(SystemdFiles, PassSystemdsOwnVerification) {
  if (std::system("command -v systemd-analyze >/dev/null") != 0) GTEST_SKIP() << "systemd-analyze is not installed";
  const auto folder = std::filesystem::path(testing::TempDir()) / "units";
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
  const Plan plan = PlanOf(TwoHosts(SupervisorKind::kSystemd), "/usr/bin");
  std::string files;
  for (const HostPlan& host : plan.hosts) {
    for (auto [name, text] : SystemdFiles(host).files) {
      // systemd-analyze accepts any program that exists.
      for (const Unit& unit : host.units) {
        const std::size_t at = text.find("ExecStart=" + unit.program);
        if (at != std::string::npos) text.replace(at + 10, unit.program.size(), "/bin/true");
      }
      std::ofstream(folder / name) << text;
      files += " " + (folder / name).string();
    }
  }
  const std::string log = (folder / "verdict").string();
  const int status = std::system(
      ("XDG_RUNTIME_DIR=" + folder.string() + " systemd-analyze verify --user --man=no" + files + " >" + log + " 2>&1")
          .c_str());
  std::ifstream in(log);
  std::string line, complaints;
  while (std::getline(in, line)) {
    if (line.find(folder.string()) != std::string::npos || line.find("oos-") != std::string::npos)
      complaints += line + "\n";
  }
  EXPECT_EQ(complaints, "");
  EXPECT_EQ(status, 0);
}

}  // namespace
}  // namespace lab
