#include "tools/oos/attach/attach.hpp"

#include <arpa/inet.h>
#include <sys/socket.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>

#include "tools/oos/attach/lab_session.hpp"
#include "tools/oos/attach/places.hpp"
#include "tools/oos/attach/session_note.hpp"

namespace oos {
namespace {

std::atomic<int> interrupted{0};
static_assert(std::atomic<int>::is_always_lock_free, "set from a signal handler");

// This machine's address on the route to an endpoint such as "tcp://10.0.0.1:7450"; peers there reach us by it. Sends
// nothing.
std::string AddressTowards(const std::string& endpoint) {
  const std::string loopback = "127.0.0.1";
  const std::size_t begin = endpoint.find("://"), end = endpoint.rfind(':');
  if (begin == std::string::npos || end < begin + 3) return loopback;
  sockaddr_in there{}, here{};
  there.sin_family = AF_INET;
  there.sin_port = htons(9);
  if (inet_pton(AF_INET, endpoint.substr(begin + 3, end - begin - 3).c_str(), &there.sin_addr) != 1) return loopback;
  const int fd = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  socklen_t size = sizeof here;
  const bool is_known = fd >= 0 && connect(fd, reinterpret_cast<const sockaddr*>(&there), sizeof there) == 0 &&
                        getsockname(fd, reinterpret_cast<sockaddr*>(&here), &size) == 0;
  if (fd >= 0) close(fd);
  char text[INET_ADDRSTRLEN] = "";
  return is_known && inet_ntop(AF_INET, &here.sin_addr, text, sizeof text) != nullptr ? text : loopback;
}

void OnSignal(int number) {
  interrupted.store(number);
}

}  // namespace

const std::atomic<int>& CatchInterrupt() {
  struct sigaction action {};
  action.sa_handler = OnSignal;
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
  return interrupted;
}

const std::vector<Option>& AttachOptions() {
  static const std::vector<Option> options = {
      {"--lab", "LAB.xml", "the session launched on these machines; works on any machine that can log in there"},
      {"--registry", "ENDPOINT", "registry of the session; default: the session running on this machine"},
      {"--session", "N", "with --registry: the session's number"},
      {"--keys", "DIR", "with --registry: the session's key directory"},
      {"--no_encryption", "", "with --registry: the session has no keys"}};
  return options;
}

core::Result<bus::NodeOptions> FindSession(const Arguments& arguments) {
  bus::NodeOptions options;
  if (arguments.has("--lab")) {
    const auto found = FindLabSession(arguments.text("--lab"));
    if (!found) return tl::unexpected(found.error());
    options.registry = found->registry;
    options.session = std::strtoull(found->session.c_str(), nullptr, 10);
    options.keys = found->keys;
    options.is_encrypted = true;
  } else if (arguments.has("--registry")) {
    options.registry = arguments.text("--registry");
    options.session = std::strtoull(arguments.text("--session", "0").c_str(), nullptr, 10);
    options.keys = arguments.text("--keys", "");
    options.is_encrypted = !arguments.has("--no_encryption");
  } else {
    const auto note = FindSessionNote();
    if (!note && note.error().code == core::ErrorCode::kInvalidInput) return tl::unexpected(note.error());
    if (!note) {
      return core::Fail(core::ErrorCode::kNotFound,
                        "no session runs here (" + SessionFile().string() +
                            "); start one with 'oos run SCENARIO', or name one with --registry and --session");
    }
    options.registry = note->registry;
    options.session = std::strtoull(note->session.c_str(), nullptr, 10);
    options.keys = note->keys;
    options.is_encrypted = !options.keys.empty();
  }
  options.bind_address = AddressTowards(options.registry);
  return options;
}

core::Result<std::unique_ptr<bus::Node>> Attach(const Arguments& arguments, const std::string& verb) {
  auto options = FindSession(arguments);
  if (!options) return tl::unexpected(options.error());
  options->name = "oos-" + verb + "-" + std::to_string(getpid());
  options->is_observer = true;
  return bus::Node::Create(*options);
}

}  // namespace oos
