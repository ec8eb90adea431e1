#include "tests/lab/machines.hpp"

#include <gtest/gtest.h>
#include <signal.h>
#include <unistd.h>

#include <fstream>
#include <sstream>

#include "core/clock.hpp"

namespace system_tests {
namespace {

constexpr std::int64_t kPatience_ns = 20 * core::kNanosecondsPerSecond;

std::string FirstLine(const std::filesystem::path& file) {
  std::ifstream in(file);
  std::string line;
  std::getline(in, line);
  return line;
}

// Removes what killed tests left: their machines ended with them, but the folders stay.
void RemoveLeftovers() {
  const std::string prefix = "oos-machines-";
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator("/tmp", error)) {
    const std::string name = entry.path().filename().string();
    if (name.rfind(prefix, 0) != 0 || std::filesystem::exists("/proc/" + name.substr(prefix.size()))) continue;
    const std::string keeper = FirstLine(entry.path() / "launcher.pid");
    std::ifstream in("/proc/" + keeper + "/cmdline");
    const std::string words{std::istreambuf_iterator<char>(in), {}};
    if (!keeper.empty() && words.find(entry.path().string()) != std::string::npos) kill(std::stoi(keeper), SIGKILL);
    std::filesystem::remove_all(entry.path(), error);
  }
}

}  // namespace

std::string Machines::WhyNot() {
  if (geteuid() != 0) return "network, process and time namespaces need root";
  const auto made =
      process::RunHere({"unshare", "--net", "--pid", "--mount", "--uts", "--time", "--monotonic", "1", "--fork", "sh",
                        "-c", "ip link add lab type bridge && ip link add to-a type veth peer name to-b"});
  if (!made || !made->is_good()) return "this kernel has no namespaces with bridges: " + (made ? made->err : "");
  for (const char* program : {"/usr/sbin/sshd", "/usr/bin/supervisord", "/usr/bin/rsync", "/usr/bin/nsenter"}) {
    if (access(program, X_OK) != 0) return std::string(program) + " is not installed";
  }
  return {};
}

Machines::Machines(const std::vector<std::string>& names)
    : folder_(std::filesystem::path("/tmp") / ("oos-machines-" + std::to_string(getpid()))) {
  RemoveLeftovers();
  std::vector<std::string> words = {std::string(VR_OOS_SOURCE_DIR) + "/tests/lab/machines", folder_.string()};
  words.insert(words.end(), names.begin(), names.end());
  auto keeper = process::PipedChild::Start(words);
  if (!keeper) {
    ADD_FAILURE() << keeper.error().detail;
    return;
  }
  keeper_ = std::move(*keeper);
  const std::int64_t deadline_ns = core::MonotonicNow_ns() + kPatience_ns;
  while (!std::filesystem::exists(folder_ / "up") && !keeper_->has_ended() && core::MonotonicNow_ns() < deadline_ns) {
    keeper_->Poll();
    process::WaitForAny({keeper_.get()}, 10);
  }
  EXPECT_TRUE(std::filesystem::exists(folder_ / "up")) << keeper_->err();
}

Machines::~Machines() {
  if (keeper_) kill(keeper_->pid(), SIGKILL);  // unshare ignores other signals; the kernel then ends all its processes
  keeper_.reset();
  std::error_code error;
  std::filesystem::remove_all(folder_, error);
}

std::vector<std::string> Machines::AtLauncher(std::vector<std::string> words) const {
  words.insert(words.begin(), {"nsenter", "--net=/proc/" + FirstLine(folder_ / "launcher.pid") + "/ns/net", "--"});
  return words;
}

std::vector<std::string> Machines::On(const std::string& name, std::vector<std::string> words) const {
  words.insert(words.begin(), {"nsenter", "-t", FirstLine(folder_ / (name + ".pid")), "-n", "-p", "-m", "-u", "--"});
  return words;
}

std::vector<std::string> Machines::InNetworkOf(const std::string& name, std::vector<std::string> words) const {
  words.insert(words.begin(), {"nsenter", "-t", FirstLine(folder_ / (name + ".pid")), "-n", "--"});
  return words;
}

std::vector<std::string> Machines::ProcessesOf(const std::string& name) const {
  const auto answer = process::RunHere(On(name, {"ps", "-eo", "args", "--no-headers"}));
  std::vector<std::string> processes;
  if (!answer || !answer->is_good()) return {"cannot look: " + (answer ? answer->err : answer.error().detail)};
  std::istringstream lines(answer->out);
  for (std::string line; std::getline(lines, line);) {
    const bool is_own = line.find("--machine") != std::string::npos || line.find("sshd") != std::string::npos ||
                        line.rfind("ps ", 0) == 0;
    if (!is_own) processes.push_back(line);
  }
  return processes;
}

}  // namespace system_tests
