#include "tools/oos/attach.hpp"

#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>

#include "tools/oos/places.hpp"

namespace oos {
namespace {

std::atomic<int> interrupted{0};
static_assert(std::atomic<int>::is_always_lock_free, "set from a signal handler");

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
      {"--registry", "ENDPOINT", "of the session; default: the one that runs here"},
      {"--session", "N", "its number, with --registry"},
      {"--keys", "DIR", "its key directory, with --registry"},
      {"--no_encryption", "", "with --registry: it has no keys"}};
  return options;
}

core::Result<std::unique_ptr<bus::Node>> Attach(const Arguments& arguments, const std::string& verb) {
  bus::NodeOptions options;
  options.name = "oos-" + verb + "-" + std::to_string(getpid());
  options.is_observer = true;
  if (arguments.has("--registry")) {
    options.registry = arguments.text("--registry");
    options.session = std::strtoull(arguments.text("--session", "0").c_str(), nullptr, 10);
    options.keys = arguments.text("--keys", "");
    options.is_encrypted = !arguments.has("--no_encryption");
  } else {
    std::ifstream file(SessionFile());
    const nlohmann::json note = nlohmann::json::parse(file, nullptr, false);
    if (!note.is_object() || !note.contains("registry") || !note.contains("session")) {
      return core::Fail(core::ErrorCode::kNotFound,
                        "no session runs here (" + SessionFile().string() +
                            "); start one with 'oos run SCENARIO', or name one with --registry and --session");
    }
    options.registry = note["registry"].get<std::string>();
    options.session = std::strtoull(note["session"].get<std::string>().c_str(), nullptr, 10);
    options.keys = note.value("keys", "");
    options.is_encrypted = !options.keys.empty();
  }
  return bus::Node::Create(options);
}

}  // namespace oos
