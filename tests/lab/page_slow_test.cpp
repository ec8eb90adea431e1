// A page on one machine of three: launched, reached there with the session's key alone, ended with the run.

#include <gmock/gmock.h>

#include "tests/lab/survive.hpp"

namespace system_tests {
namespace {

using testing::HasSubstr;

class PageInALab : public SurviveTest {
 protected:
  // The HTTP status of an address as a program on that machine gets it; empty: nobody answers.
  static std::string StatusOn(const char* machine, const std::string& url, const std::string& key) {
    const auto answer = process::RunHere(machines_->InNetworkOf(
        machine, {"curl", "-s", "-o", "/dev/null", "-w", "%{http_code}", "-H", "Authorization: Bearer " + key, url}));
    return answer && answer->is_good() ? answer->out : std::string();
  }
  // What follows a word in the launcher's output, up to a blank.
  std::string Said(const std::string& word) {
    const std::size_t at = launcher_->out().find(word);
    if (at == std::string::npos) return {};
    const std::string rest = launcher_->out().substr(at + word.size());
    return rest.substr(0, rest.find_first_of(" \n"));
  }
};

TEST_F(PageInALab, IsLaunchedReachedWithTheKeyAndEndedWithTheRun) {
  const std::filesystem::path packages =
      std::filesystem::path(VR_OOS_SOURCE_DIR) / "tools/web_bridge/node_modules/.package-lock.json";
  if (!std::filesystem::exists(packages)) GTEST_SKIP() << "npm's packages of the page are not installed";
  if (!std::filesystem::exists("/usr/bin/curl")) GTEST_SKIP() << "curl is missing";
  const std::string lab = WriteLab("page", OnThree());
  std::string text;
  {
    std::ifstream in(lab);
    text.assign(std::istreambuf_iterator<char>(in), {});
  }
  std::ofstream(lab) << text.replace(
      text.find("</lab>\n"), 7, "  <view name=\"phone\" host=\"beta\" renderer=\"page\" port=\"8770\"/>\n</lab>\n");
  StartRun("page", {}, lab);
  if (HasFatalFailure()) return;
  ASSERT_TRUE(Until([&] { return !Said("http://127.0.0.1:8770/#key=").empty(); })) << launcher_->out();
  const std::string key = Said("http://127.0.0.1:8770/#key="), assets = "http://127.0.0.1:8770/session/assets";
  EXPECT_THAT(launcher_->out(), HasSubstr("ssh -L 8770:127.0.0.1:8770 10.77.0.12"));
  EXPECT_TRUE(Until([&] { return StatusOn("beta", assets, key) == "200"; })) << "it has the scene";
  EXPECT_EQ(StatusOn("beta", assets, "another"), "401");
  EXPECT_EQ(StatusOn("alpha", "http://10.77.0.12:8770/", key), "") << "only on its own machine";
  // The launcher waits for every node, the page among them.
  EXPECT_TRUE(Until([&] { return launcher_->out().find("nodes are ready") != std::string::npos; }));
  EXPECT_THAT(launcher_->out(), testing::Not(HasSubstr("shows no picture")));
  FinishRun();  // nothing is left
  EXPECT_EQ(StatusOn("beta", assets, key), "");
}

}  // namespace
}  // namespace system_tests
