// relay FOLDER NAME=PID...  a network switch between the test machines that delays and loses frames.
//
// Makes a TAP device for each machine, moves it into the network of process PID as eth0, and keeps one, "lab", for the
// launcher. Every frame is delivered after DELAY + a random part of JITTER, or lost; frames may overtake each other.
// FOLDER/link holds the settings, "delay_ms jitter_ms loss_percent [NAME of a machine that is cut off]", and is read
// again every 2 ms.

#include <fcntl.h>
#include <linux/if.h>
#include <linux/if_tun.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <fstream>
#include <map>
#include <queue>
#include <random>
#include <string>
#include <vector>

#include "core/clock.hpp"

namespace {

using Mac = std::array<unsigned char, 6>;

constexpr std::int64_t kReadLink_ns = 2 * core::kMillisecond_ns;
constexpr std::size_t kMaxFrame = 2048;

std::int64_t Now_ns() {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return now.tv_sec * 1'000'000'000LL + now.tv_nsec;
}

struct Port {
  std::string name;
  int fd = -1;
};

struct Frame {
  std::int64_t due_ns = 0;
  std::uint64_t number = 0;  // equal times: in order
  std::size_t port = 0;
  std::vector<char> bytes;
  bool operator>(const Frame& other) const {
    return due_ns != other.due_ns ? due_ns > other.due_ns : number > other.number;
  }
};

struct Link {
  double delay_ms = 0.0, jitter_ms = 0.0, loss_percent = 0.0;
  std::string cut;  // the machine that is off
};

void Must(bool is_good, const std::string& what) {
  if (is_good) return;
  std::perror(("relay: " + what).c_str());
  std::exit(1);
}

Port OpenPort(const std::string& name, const std::string& device) {
  Port port{name, open("/dev/net/tun", O_RDWR | O_NONBLOCK | O_CLOEXEC)};
  Must(port.fd >= 0, "/dev/net/tun");
  ifreq request{};
  request.ifr_flags = IFF_TAP | IFF_NO_PI;
  std::strncpy(request.ifr_name, device.c_str(), IFNAMSIZ - 1);
  Must(ioctl(port.fd, TUNSETIFF, &request) == 0, "TUNSETIFF " + device);
  return port;
}

class Relay {
 public:
  explicit Relay(std::string folder) : folder_(std::move(folder)) {}

  void Add(const Port& port) { ports_.push_back(port); }

  [[noreturn]] void Run() {
    std::vector<pollfd> fds;
    for (const Port& port : ports_) fds.push_back({port.fd, POLLIN, 0});
    while (true) {
      const std::int64_t now_ns = Now_ns();
      if (now_ns >= read_link_ns_) ReadLink(now_ns);
      Deliver(now_ns);
      const std::int64_t next_ns = frames_.empty() ? read_link_ns_ : std::min(read_link_ns_, frames_.top().due_ns);
      const std::int64_t wait_ns = std::max<std::int64_t>(0, next_ns - now_ns);
      const timespec wait{wait_ns / 1'000'000'000, wait_ns % 1'000'000'000};
      ppoll(fds.data(), fds.size(), &wait, nullptr);
      for (std::size_t port = 0; port < ports_.size(); ++port) Take(port);
    }
  }

 private:
  void ReadLink(std::int64_t now_ns) {
    read_link_ns_ = now_ns + kReadLink_ns;
    std::ifstream in(folder_ + "/link");
    Link link;
    if (in >> link.delay_ms >> link.jitter_ms >> link.loss_percent) {
      in >> link.cut;
      link_ = link;
    }
  }

  void Take(std::size_t from) {
    std::vector<char> bytes(kMaxFrame);
    for (ssize_t got = read(ports_[from].fd, bytes.data(), bytes.size()); got > 14;
         got = read(ports_[from].fd, bytes.data(), bytes.size())) {
      Mac to, source;
      std::memcpy(to.data(), bytes.data(), 6);
      std::memcpy(source.data(), bytes.data() + 6, 6);
      places_[source] = from;
      const auto known = places_.find(to);
      for (std::size_t port = 0; port < ports_.size(); ++port) {
        if (port == from || (known != places_.end() && known->second != port)) continue;
        Send(from, port, {bytes.begin(), bytes.begin() + got});
      }
    }
  }

  void Send(std::size_t from, std::size_t to, std::vector<char> bytes) {
    const double lot = static_cast<double>(random_() >> 11) * 0x1.0p-53;
    const double late = static_cast<double>(random_() >> 11) * 0x1.0p-53;
    const bool is_cut = !link_.cut.empty() && (link_.cut == ports_[from].name || link_.cut == ports_[to].name);
    if (is_cut || lot * 100.0 < link_.loss_percent) return;
    const double delay_ms = link_.delay_ms + late * link_.jitter_ms;
    frames_.push({Now_ns() + static_cast<std::int64_t>(delay_ms * 1e6), ++number_, to, std::move(bytes)});
  }

  void Deliver(std::int64_t now_ns) {
    while (!frames_.empty() && frames_.top().due_ns <= now_ns) {
      const Frame& frame = frames_.top();
      // A full queue of the device drops the frame, as a real switch does.
      [[maybe_unused]] const ssize_t put = write(ports_[frame.port].fd, frame.bytes.data(), frame.bytes.size());
      frames_.pop();
    }
  }

  std::string folder_;
  std::vector<Port> ports_;
  std::map<Mac, std::size_t> places_;
  std::priority_queue<Frame, std::vector<Frame>, std::greater<>> frames_;
  std::mt19937_64 random_{1};
  Link link_;
  std::uint64_t number_ = 0;
  std::int64_t read_link_ns_ = 0;
};

}  // namespace

int main(int argc, char** argv) {
  if (argc < 3) {
    std::fprintf(stderr, "relay FOLDER NAME=PID...\n");
    return 2;
  }
  const std::string folder = argv[1];
  Relay relay(folder);
  relay.Add(OpenPort("launcher", "lab"));
  Must(std::system("ip address add 10.77.0.1/24 dev lab && ip link set lab up") == 0, "ip");
  for (int i = 2; i < argc; ++i) {
    const std::string argument = argv[i];
    const std::size_t equals = argument.find('=');
    const std::string name = argument.substr(0, equals), pid = argument.substr(equals + 1);
    relay.Add(OpenPort(name, "to-" + name));
    Must(std::system(("ip link set to-" + name + " netns " + pid + " name eth0").c_str()) == 0, "ip link set");
    std::ofstream(folder + "/" + name + "/linked") << "\n";
  }
  relay.Run();
}
