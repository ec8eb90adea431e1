// The launcher loses its connection to a host for a while; the run goes on, and the launcher reports the missed events
// afterwards.

#include <gmock/gmock.h>

#include "tests/lab/survive.hpp"

namespace system_tests {
namespace {

using testing::HasSubstr;

class OutageTest : public SurviveTest {};

TEST_F(OutageTest, StepsEnteredDuringAnOutageAreReportedAfterwards) {
  StartRun("outage");
  if (HasFatalFailure()) return;
  ASSERT_TRUE(Until([&] { return watch_->step() == "slide"; }, 60.0));
  std::vector<pid_t> sshd = FindAll("beta", "sshd");
  ASSERT_GE(sshd.size(), 2u);
  kill(sshd[0], SIGSTOP);  // the listening process: no connection is accepted
  for (std::size_t i = 1; i < sshd.size(); ++i) kill(sshd[i], SIGKILL);
  const bool has_gone_on = Until([&] { return watch_->step() == "push_block"; }, 60.0);
  const std::string before = launcher_->out();
  kill(sshd[0], SIGCONT);
  ASSERT_TRUE(has_gone_on) << launcher_->out();
  EXPECT_THAT(before, HasSubstr("host beta is silent"));
  EXPECT_THAT(before, testing::Not(HasSubstr("[beta] bus: step edge")));
  FinishRun();
  EXPECT_THAT(launcher_->out(), HasSubstr("host beta is back after "));
  EXPECT_THAT(launcher_->out(), HasSubstr("[beta] bus: step edge"));
}

}  // namespace
}  // namespace system_tests
