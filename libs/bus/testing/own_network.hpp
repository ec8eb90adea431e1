#pragma once

#include <net/if.h>
#include <sched.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cstdlib>
#include <cstring>
#include <functional>
#include <string>
#include <thread>

// A network namespace for a test: loopback only, with a packet filter. It ends with the last of its threads.
namespace bus::testing {

class OwnNetwork {
 public:
  // Runs `body` in a thread that has a network namespace of its own; so have all threads that it starts. Returns why
  // this machine cannot do that (not root, no packet filter); empty when it could.
  static std::string Run(const std::function<void(OwnNetwork&)>& body) {
    std::string why;
    std::thread inside([&] {
      if (unshare(CLONE_NEWNET) != 0) {
        why = "no network namespaces here (unshare: " + std::string(std::strerror(errno)) + ")";
        return;
      }
      if (!IsLoopbackUp()) {
        why = "loopback of a new network namespace cannot be set up";
        return;
      }
      OwnNetwork network;
      if (!network.Filter("add table inet test") ||
          !network.Filter("add chain inet test in '{ type filter hook input priority 0; }'")) {
        why = "no packet filter here (package nftables, run as root)";
        return;
      }
      body(network);
    });
    inside.join();
    return why;
  }

  // Every TCP connection with traffic is reset, and no new one is established, until Mend().
  bool BreakConnections() {
    return Filter("insert rule inet test in tcp flags & rst != rst reject with tcp reset");  // resets must arrive, too
  }
  // Nothing arrives at all.
  bool Cut() { return Rule("meta l4proto { tcp, udp } drop"); }
  // Loses that many of 1000 packets at random.
  bool Lose(int per_mille) {
    return Rule("meta l4proto { tcp, udp } numgen random mod 1000 < " + std::to_string(per_mille) + " drop");
  }
  // Connections to that port stay, but no data arrives there: 52 B is an empty TCP acknowledgement.
  bool DropWordsTo(unsigned port) { return Rule("tcp dport " + std::to_string(port) + " ip length > 52 drop"); }
  bool DropDatagramsFrom(unsigned port) { return Rule("udp sport " + std::to_string(port) + " drop"); }
  bool Mend() { return Filter("flush chain inet test in"); }

 private:
  bool Rule(const std::string& rule) { return Filter("add rule inet test in " + rule); }
  static bool Filter(const std::string& command) {
    const std::string quoted = command.find('\'') == std::string::npos ? "'" + command + "'" : command;
    return std::system(("nft " + quoted + " >/dev/null 2>&1").c_str()) == 0;  // NOLINT(concurrency-mt-unsafe)
  }
  static bool IsLoopbackUp() {
    const int fd = socket(AF_INET, SOCK_DGRAM, 0);
    if (fd < 0) return false;
    ifreq request{};
    std::strcpy(request.ifr_name, "lo");
    request.ifr_flags = IFF_UP;
    const bool is_up = ioctl(fd, SIOCSIFFLAGS, &request) == 0;
    close(fd);
    return is_up;
  }
};

}  // namespace bus::testing
