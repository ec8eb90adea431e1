#include "tools/oos/doctor/doctor_limits.hpp"

#include <gtest/gtest.h>
#include <sched.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <set>

namespace oos {
namespace {

TEST(JudgeRealTimeShare, WarnsOfATimeInWhichRealTimeThreadsMayNotRun) {
  EXPECT_EQ(JudgeRealTimeShare(-1, 1'000'000).grade, Grade::kOk);
  EXPECT_EQ(JudgeRealTimeShare(1'000'000, 1'000'000).grade, Grade::kOk);
  const Finding finding = JudgeRealTimeShare(950'000, 1'000'000);
  EXPECT_EQ(finding.grade, Grade::kWarn);
  EXPECT_NE(finding.what.find("50 ms of every 1000 ms"), std::string::npos) << finding.what;
  EXPECT_NE(finding.remedy.find("kernel.sched_rt_runtime_us = -1"), std::string::npos) << finding.remedy;
}

TEST(JudgeGovernor, WarnsOfCoresThatChangeTheirSpeed) {
  EXPECT_EQ(JudgeGovernor("").grade, Grade::kOk);
  EXPECT_EQ(JudgeGovernor("performance").grade, Grade::kOk);
  const Finding finding = JudgeGovernor("schedutil");
  EXPECT_EQ(finding.grade, Grade::kWarn);
  EXPECT_NE(finding.what.find("schedutil"), std::string::npos) << finding.what;
}

TEST(CheckLimits, LeavesTheProcessAsItWas) {
  const int scheduler = sched_getscheduler(0), nice = getpriority(PRIO_PROCESS, 0);
  CheckLimits();
  EXPECT_EQ(sched_getscheduler(0), scheduler);
  EXPECT_EQ(getpriority(PRIO_PROCESS, 0), nice);
}

// Exit status of a child that runs as nobody, without raised limits: 0 when each of its limits is reported.
int CheckLimitsOfNobody() {
  const rlimit nothing{0, 0};
  const uid_t nobody = 65534;
  if (setrlimit(RLIMIT_RTPRIO, &nothing) != 0 || setrlimit(RLIMIT_NICE, &nothing) != 0) return 2;
  if (setrlimit(RLIMIT_MEMLOCK, &nothing) != 0 || setpriority(PRIO_PROCESS, 0, 0) != 0 || setuid(nobody) != 0) return 2;
  std::set<std::string> reported;
  for (const Finding& finding : CheckLimits()) {
    if (finding.grade == Grade::kWarn && finding.remedy.find("limits.d") != std::string::npos) {
      reported.insert(finding.subject);
    }
  }
  return reported == std::set<std::string>{"realtime", "memlock", "nice"} ? 0 : 1;
}

TEST(CheckLimits, ReportsEachMissingLimitWithARemedy) {
  if (geteuid() != 0) GTEST_SKIP() << "only root can become nobody";
  const pid_t child = fork();
  if (child == 0) _exit(CheckLimitsOfNobody());
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  ASSERT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 0);
}

}  // namespace
}  // namespace oos
