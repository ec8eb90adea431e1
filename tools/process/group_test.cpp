#include "tools/process/group.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <unistd.h>

#include <csignal>
#include <fstream>

#include "core/clock.hpp"

namespace process {
namespace {

Command Shell(const std::string& name, const std::string& script) {
  return {name, "/bin/sh", {"-c", script}, {}, {}, 0, -1};
}

// A child that holds the write end of a pipe: the read end reports its death without any waiting in steps.
class Lifeline {
 public:
  Lifeline() { EXPECT_EQ(pipe2(fds_, O_CLOEXEC), 0); }
  ~Lifeline() { close(fds_[0]); }
  [[nodiscard]] int write_end() const { return fds_[1]; }
  void HandOver() { close(fds_[1]); }
  [[nodiscard]] bool WaitForByte() const {
    char byte = 0;
    return read(fds_[0], &byte, 1) == 1;
  }
  [[nodiscard]] bool WaitUntilClosed(int timeout_ms) const {
    pollfd p{fds_[0], POLLIN, 0};
    return poll(&p, 1, timeout_ms) == 1 && (p.revents & POLLHUP) != 0;
  }

 private:
  int fds_[2] = {-1, -1};
};

TEST(Group, SaysWhichProgramCannotBeStarted) {
  Group group;
  const auto pid = group.Spawn({"ghost", "/nonexistent/ghost", {}, {}, {}, 0, -1});
  ASSERT_FALSE(pid);
  EXPECT_NE(pid.error().detail.find("/nonexistent/ghost"), std::string::npos);
  EXPECT_TRUE(group.children().empty());
}

TEST(Group, NamesHowAChildEnded) {
  Group group;
  ASSERT_TRUE(group.Spawn(Shell("leaver", "exit 3")));
  ASSERT_TRUE(group.Spawn(Shell("victim", "kill -9 $$")));
  std::size_t ended = 0;
  const std::int64_t deadline = core::MonotonicNow_ns() + 5'000'000'000;
  while (ended < 2 && core::MonotonicNow_ns() < deadline) ended += group.Reap().size();
  ASSERT_EQ(ended, 2u);
  EXPECT_EQ(group.children()[0].exit->Describe(), "exit status 3");
  EXPECT_NE(group.children()[1].exit->Describe().find("signal 9"), std::string::npos);
}

TEST(Group, StopsEvenWhatIgnoresSigtermAndItsChildren) {
  Lifeline line;
  Group group;
  Command command = Shell("stubborn", "trap '' TERM; (trap '' TERM; while :; do sleep 1; done) & echo >&" +
                                          std::to_string(line.write_end()) + "; while :; do sleep 1; done");
  command.inherited_fd = line.write_end();
  ASSERT_TRUE(group.Spawn(command));
  line.HandOver();
  ASSERT_TRUE(line.WaitForByte());  // the trap is set
  EXPECT_EQ(group.StopAll(0.1), std::vector<std::string>{"stubborn"});
  EXPECT_TRUE(line.WaitUntilClosed(2000)) << "somebody still holds the pipe";
}

TEST(Group, AClosingOwnerLeavesNobodyBehind) {
  Lifeline line;
  {
    Group group;
    Command command = Shell("sleeper", "echo >&" + std::to_string(line.write_end()) + "; exec sleep 100");
    command.inherited_fd = line.write_end();
    ASSERT_TRUE(group.Spawn(command));
    line.HandOver();
    ASSERT_TRUE(line.WaitForByte());
  }
  EXPECT_TRUE(line.WaitUntilClosed(2000));
}

}  // namespace
}  // namespace process
