// `oos check` on scenarios with one mistake each: its first message names the file, the line, what is wrong, why, and a
// remedy. The mistakes are made in copies of the project's own scenarios.

#include <gtest/gtest.h>
#include <sys/wait.h>

#include <array>
#include <cstdio>
#include <functional>
#include <sstream>

#include "tests/support/scenario_copy.hpp"
#include "tools/oos/check/check_scenario.hpp"
#include "tools/oos/verb/verb.hpp"

namespace system_tests {
namespace {

struct Mistake {
  std::string name;
  std::string scenario;
  std::string file;  // that holds the mistake
  std::string from;  // occurs once
  std::string to;
  std::string at;      // text in the line that the message must name, after the change
  std::string cause;   // in the message
  std::string remedy;  // behind "Fix:"
};

std::ostream& operator<<(std::ostream& out, const Mistake& mistake) {
  return out << mistake.name;
}

const std::vector<Mistake> kMistakes{
    {"MissingMesh", "peg_in_hole", "scenario.xml", "meshes/hole.obj", "meshes/whole.obj", "meshes/whole.obj",
     "whole.obj", ""},
    {"UnknownObjectInAPair", "module_replacement", "scenario.xml", "<pair a=\"module_new\" b=\"cavity_a\"",
     "<pair a=\"module_new\" b=\"cavty_a\"", "cavty_a", "cavty_a", "cavity_a"},
    {"NegativeMass", "touch", "scenario.xml", "mass_kg=\"2\"", "mass_kg=\"-2\"", "mass_kg=\"-2\"", "mass_kg", ""},
    {"UnreachableState", "module_replacement", "procedure.scxml", "target=\"power_a_off\"", "target=\"power_a_on\"",
     "<state id=\"power_a_off\"", "power_a_off", ""},
    {"MalformedXml", "touch", "scenario.xml", "<sun direction=\"0.3 -0.4 0.85\"/>", "<sun direction=\"0.3 -0.4 0.85\">",
     "</scenario>", "", ""},
    {"MalformedProcedure", "touch", "procedure.scxml", "<final id=\"done\"/>", "<final id=\"done\">", "", "", ""},
    {"UnknownCommand", "module_replacement", "operator.txt", "reach cover.tab within", "raech cover.tab within",
     "raech cover.tab", "raech", "reach"},
    {"UnknownStepOfTheOperator", "touch", "operator.txt", "step slide", "step slyde", "step slyde", "slyde", "slide"},
    {"UnknownSignalInACondition", "touch", "procedure.scxml", "pad.position", "pat.position", "pat.position", "pat",
     ""},
};

class BrokenScenario : public ::testing::TestWithParam<Mistake> {};

// "FILE:LINE: what: why. Fix: remedy"
void ExpectSaid(const std::string& problem, const std::string& place, const std::string& cause,
                const std::string& remedy) {
  EXPECT_NE(problem.find(place), std::string::npos) << "'" << place << "' is not in: " << problem;
  EXPECT_NE(problem.find(cause), std::string::npos) << "'" << cause << "' is not in: " << problem;
  const std::size_t fix = problem.find("Fix: ");
  ASSERT_NE(fix, std::string::npos) << problem;
  EXPECT_GT(problem.size(), fix + 10) << "no remedy: " << problem;
  EXPECT_NE(problem.find(remedy, fix), std::string::npos) << "'" << remedy << "' is not the remedy in: " << problem;
}

TEST_P(BrokenScenario, IsNamedWithFileLineCauseAndRemedy) {
  const Mistake& mistake = GetParam();
  ScenarioCopy copy(mistake.scenario, "broken_" + mistake.name);
  ASSERT_TRUE(oos::CheckScenario(copy.folder()).problems.empty()) << "not good before it was broken";
  copy.Replace(mistake.file, mistake.from, mistake.to);
  const oos::CheckOutcome outcome = oos::CheckScenario(copy.folder());
  ASSERT_FALSE(outcome.problems.empty());
  std::string place = mistake.file + ":";
  if (!mistake.at.empty()) place += std::to_string(copy.LineOf(mistake.file, mistake.at)) + ":";
  ExpectSaid(outcome.problems.front(), place, mistake.cause, mistake.remedy);
}

INSTANTIATE_TEST_SUITE_P(Mistakes, BrokenScenario, ::testing::ValuesIn(kMistakes),
                         [](const auto& test) { return test.param.name; });

TEST(SoundScenario, HasNoProblemsInAnyScenarioOfTheProject) {
  for (const char* name : {"touch", "peg_in_hole", "module_replacement"}) {
    const oos::CheckOutcome outcome = oos::CheckScenario(std::filesystem::path(VR_OOS_SOURCE_DIR) / "scenarios" / name);
    EXPECT_TRUE(outcome.problems.empty()) << outcome.problems.front();
  }
}

TEST(BrokenScenarioMesh, IsNamedWhenDamaged) {
  ScenarioCopy copy("peg_in_hole", "damaged");
  copy.Write("meshes/peg.obj", "no mesh at all\n");
  const oos::CheckOutcome outcome = oos::CheckScenario(copy.folder());
  ASSERT_FALSE(outcome.problems.empty());
  ExpectSaid(outcome.problems.front(), "scenario.xml:", "peg.obj", "");
}

TEST(BrokenScenarioMesh, IsNamedWhenInMillimetres) {
  ScenarioCopy copy("peg_in_hole", "millimetres");
  std::istringstream in(copy.Read("meshes/peg.obj"));
  std::ostringstream out;
  for (std::string line; std::getline(in, line);) {
    std::istringstream words(line);
    std::string kind;
    double x = 0.0, y = 0.0, z = 0.0;
    words >> kind;
    if (kind == "v" && words >> x >> y >> z) {
      out << "v " << 1e3 * x << ' ' << 1e3 * y << ' ' << 1e3 * z << '\n';
    } else {
      out << line << '\n';
    }
  }
  copy.Write("meshes/peg.obj", out.str());
  const oos::CheckOutcome outcome = oos::CheckScenario(copy.folder());
  ASSERT_EQ(outcome.problems.size(), 1u);
  ExpectSaid(outcome.problems.front(),
             "scenario.xml:" + std::to_string(copy.LineOf("scenario.xml", "<object name=\"peg\"")) + ":", "unit",
             "0.001");
}

// The program itself: what it prints and its exit status.
struct Output {
  int status = -1;
  std::string text;
};

Output RunProgram(const std::string& arguments) {
  Output output;
  const std::string command = "'" VR_OOS_BINARY_DIR "/bin/oos' " + arguments + " 2>&1";
  FILE* pipe = popen(command.c_str(), "r");
  if (pipe == nullptr) return output;
  std::array<char, 4096> buffer{};
  for (std::size_t n = 0; (n = fread(buffer.data(), 1, buffer.size(), pipe)) > 0;) output.text.append(buffer.data(), n);
  const int status = pclose(pipe);
  if (WIFEXITED(status)) output.status = WEXITSTATUS(status);
  return output;
}

TEST(BrokenScenarioProgram, CheckFailsAndRunStartsNothing) {
  ScenarioCopy copy("touch", "program");
  const Output good = RunProgram("check '" + copy.folder().string() + "'");
  EXPECT_EQ(good.status, oos::kHolds) << good.text;
  copy.Replace("scenario.xml", "mass_kg=\"2\"", "mass_kg=\"-2\"");
  const std::string place = "scenario.xml:" + std::to_string(copy.LineOf("scenario.xml", "mass_kg=\"-2\"")) + ":";

  const Output check = RunProgram("check '" + copy.folder().string() + "'");
  EXPECT_EQ(check.status, oos::kDoesNotHold) << check.text;
  ExpectSaid(check.text, place, "mass_kg", "");

  const std::filesystem::path out = copy.folder() / "out";
  for (const char* mode : {"", " --lockstep"}) {
    const Output run = RunProgram("run '" + copy.folder().string() + "' --out '" + out.string() + "'" + mode);
    EXPECT_EQ(run.status, oos::kBadUsage) << run.text;
    ExpectSaid(run.text, place, "mass_kg", "");
    EXPECT_NE(run.text.find("nothing was started"), std::string::npos) << run.text;
    EXPECT_FALSE(std::filesystem::exists(out)) << "something was started";
  }
}

}  // namespace
}  // namespace system_tests
