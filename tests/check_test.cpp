// `oos check` and `oos run` on scenarios that are broken on purpose: named with file, line, cause and remedy; nothing
// starts.

#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "tests/support.hpp"
#include "tools/oos/check_scenario.hpp"
#include "tools/oos/verb.hpp"

namespace system_tests {
namespace {

// A copy of `touch` in which the first occurrence of `from` in `file` is replaced.
std::filesystem::path Broken(const std::string& name, const std::string& file, const std::string& from,
                             const std::string& to) {
  const std::filesystem::path folder = std::filesystem::path(::testing::TempDir()) / ("broken_" + name);
  std::filesystem::remove_all(folder);
  std::filesystem::copy(std::filesystem::path(VR_OOS_SOURCE_DIR) / "scenarios" / "touch", folder,
                        std::filesystem::copy_options::recursive);
  std::ifstream in(folder / file);
  std::stringstream text;
  text << in.rdbuf();
  std::string content = text.str();
  const std::size_t at = content.find(from);
  EXPECT_NE(at, std::string::npos) << "'" << from << "' is not in " << file << " any more";
  if (at != std::string::npos) content.replace(at, from.size(), to);
  std::ofstream(folder / file) << content;
  return folder;
}

void ExpectNamed(const std::filesystem::path& folder, const std::string& file, const std::string& word) {
  const oos::CheckOutcome outcome = oos::CheckScenario(folder);
  ASSERT_FALSE(outcome.problems.empty());
  const std::string& text = outcome.problems.front();
  EXPECT_NE(text.find(file + ":"), std::string::npos) << text;
  EXPECT_NE(text.find(word), std::string::npos) << text;
  EXPECT_NE(text.find("Fix:"), std::string::npos) << text;
  EXPECT_EQ(oos::RunCommandLine({"check", folder.string()}), oos::kDoesNotHold);
  const std::filesystem::path out = folder / "out";
  EXPECT_EQ(oos::RunCommandLine({"run", folder.string(), "--out", out.string()}), oos::kBadUsage);
  EXPECT_FALSE(std::filesystem::exists(out)) << "something was started";
}

TEST(Check, TheScenariosOfTheProjectAreGood) {
  for (const char* name : {"touch", "peg_in_hole", "module_replacement"}) {
    const oos::CheckOutcome outcome = oos::CheckScenario(std::filesystem::path(VR_OOS_SOURCE_DIR) / "scenarios" / name);
    EXPECT_TRUE(outcome.problems.empty()) << outcome.problems.front();
  }
}

TEST(Check, AMissingMesh) {
  ExpectNamed(Broken("mesh", "scenario.xml", "meshes/plate", "meshes/plait"), "scenario.xml", "plait");
}

TEST(Check, AnUnknownObjectInAPair) {
  ExpectNamed(Broken("pair", "scenario.xml", "a=\"block\" b=\"plate\"", "a=\"blok\" b=\"plate\""), "scenario.xml",
              "blok");
}

TEST(Check, ANegativeMass) {
  ExpectNamed(Broken("mass", "scenario.xml", "mass_kg=\"2\"", "mass_kg=\"-2\""), "scenario.xml", "mass");
}

TEST(Check, MalformedXml) {
  ExpectNamed(Broken("xml", "scenario.xml", "</scenario>", "</scenari>"), "scenario.xml", "");
}

TEST(Check, AnUnreachableState) {
  ExpectNamed(Broken("state", "procedure.scxml", "</scxml>", "<state id=\"island\"/></scxml>"), "procedure.scxml",
              "island");
}

TEST(Check, AMistakeInTheOperatorsScript) {
  ExpectNamed(Broken("operator", "operator.txt", "reach plate.press_spot", "reach plate.pres_spot"), "operator.txt",
              "pres_spot");
}

TEST(Check, ADamagedMesh) {
  const std::filesystem::path folder = Broken("damaged", "scenario.xml", "</scenario>", "</scenario>");
  for (const auto& entry : std::filesystem::directory_iterator(folder / "meshes")) {
    if (entry.path().stem() == "plate") std::ofstream(entry.path()) << "no mesh at all\n";
  }
  ExpectNamed(folder, "scenario.xml", "plate");
}

}  // namespace
}  // namespace system_tests
