#include "tools/transport/lossy_network.hpp"

#include <fcntl.h>
#include <sched.h>
#include <unistd.h>

#include <array>
#include <cstdio>
#include <thread>

namespace transport {
namespace {

int NewNetwork() {
  int fd = -1;
  std::thread([&fd] {
    if (unshare(CLONE_NEWNET) == 0) fd = open("/proc/thread-self/ns/net", O_RDONLY | O_CLOEXEC);
  }).join();
  return fd;
}

}  // namespace

LossyNetwork::~LossyNetwork() {
  if (near_fd_ >= 0) close(near_fd_);
  if (far_fd_ >= 0) close(far_fd_);
}

void LossyNetwork::Do(int fd, const std::function<void()>& body) {
  std::thread([&] {
    if (setns(fd, CLONE_NEWNET) == 0) body();
  }).join();
}

std::string LossyNetwork::RunIn(int fd, const std::string& command) {
  std::string answer = "not run";
  Do(fd, [&] {
    FILE* pipe = popen((command + " 2>&1").c_str(), "r");
    if (pipe == nullptr) return;
    answer.clear();
    std::array<char, 256> part;
    while (std::fgets(part.data(), part.size(), pipe) != nullptr) answer += part.data();
    const bool is_done = pclose(pipe) == 0;
    if (is_done) answer.clear();
    if (!is_done && answer.empty()) answer = command;
  });
  return answer;
}

core::Result<std::unique_ptr<LossyNetwork>> LossyNetwork::Make() {
  std::unique_ptr<LossyNetwork> network(new LossyNetwork);
  network->near_fd_ = NewNetwork();
  network->far_fd_ = NewNetwork();
  if (network->near_fd_ < 0 || network->far_fd_ < 0) {
    return core::Fail(core::ErrorCode::kUnsupported, "no network namespaces here (root is needed)");
  }
  const std::string far = "/proc/" + std::to_string(getpid()) + "/fd/" + std::to_string(network->far_fd_);
  const std::string address = "/24 dev v && ip link set v up && ip link set lo up";
  for (const auto& [fd, command] :
       {std::pair{network->near_fd_, "ip link add v type veth peer name v netns " + far},
        std::pair{network->near_fd_, std::string("ip addr add ") + kNearAddress + address},
        std::pair{network->far_fd_, std::string("ip addr add ") + kFarAddress + address},
        std::pair{network->far_fd_, std::string("nft add table ip f && nft add chain ip f i "
                                                "'{ type filter hook input priority 0; }'")}}) {
    const std::string wrong = RunIn(fd, command);
    if (!wrong.empty()) return core::Fail(core::ErrorCode::kUnsupported, "the kernel lacks something: " + wrong);
  }
  if (!network->Lose(1) || !network->Lose(0)) {
    return core::Fail(core::ErrorCode::kUnsupported, "the packet filter cannot drop at random");
  }
  return network;
}

bool LossyNetwork::Lose(int per_mille) const {
  std::string command = "nft flush chain ip f i";
  if (per_mille > 0) {
    command += " && nft add rule ip f i iifname v meta l4proto '{ tcp, udp }' numgen random mod 1000 '<' " +
               std::to_string(per_mille) + " drop";
  }
  return RunIn(far_fd_, command).empty();
}

}  // namespace transport
