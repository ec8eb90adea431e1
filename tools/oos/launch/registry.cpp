#include "bus/membership/registry.hpp"

#include <cstdio>
#include <cstdlib>
#include <iterator>
#include <memory>
#include <nlohmann/json.hpp>
#include <set>

#include "bus/node.hpp"
#include "bus/security/keys.hpp"
#include "core/clock.hpp"
#include "lab/lab.hpp"
#include "tools/oos/attach/attach.hpp"
#include "tools/oos/launch/verbs.hpp"

namespace oos {
namespace {

constexpr std::int64_t kPoll_ns = 20'000'000;

void PrintRecord(nlohmann::json line) {
  line["time_ns"] = core::MonotonicNow_ns();
  std::printf("%s\n", line.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace).c_str());
  std::fflush(stdout);
}

// "tcp://10.0.0.1:7450" -> "10.0.0.1"
std::string AddressOf(const std::string& endpoint) {
  const std::size_t begin = endpoint.find("://");
  const std::size_t end = endpoint.rfind(':');
  return begin == std::string::npos || end < begin + 3 ? "" : endpoint.substr(begin + 3, end - begin - 3);
}

// Prints what happens on the bus, a line of JSON each: nodes that join and leave, events, the procedure's steps.
class Watcher {
 public:
  Watcher(bus::Registry* registry, bus::Node* node) : registry_(registry), node_(node) {
    status_ = &node_->ReadState<core::LogicStatus>(bus::kLogicStatusTopic);
    node_->ReadEvents();
  }

  void Watch() {
    node_->Wait(core::MonotonicNow_ns() + kPoll_ns);
    core::Event event;
    while (node_->PollEvent(&event)) {
      PrintRecord({{"is", event.name == "ready" ? "ready" : "event"},
                   {"node", event.source},
                   {"name", event.name},
                   {"detail", event.detail}});
    }
    PrintNames();
    PrintRefusals();
    if (status_->has_value()) PrintLogic(status_->value());
  }

 private:
  void PrintNames() {
    const std::vector<std::string> names = registry_->Names();
    const std::set<std::string> now(names.begin(), names.end());
    for (const std::string& name : now) {
      if (registered_.count(name) == 0) PrintRecord({{"is", "registered"}, {"node", name}});
    }
    for (const std::string& name : registered_) {
      if (now.count(name) == 0) PrintRecord({{"is", "gone"}, {"node", name}});
    }
    registered_ = now;
  }

  void PrintRefusals() {
    const std::vector<std::string> refusals = registry_->Refusals();
    for (; num_refusals_ < refusals.size(); ++num_refusals_) {
      PrintRecord({{"is", "refused"}, {"detail", refusals[num_refusals_]}});
    }
  }

  void PrintLogic(const core::LogicStatus& status) {
    const bool runs = status.time_ns > 0;
    if (status.step == step_ && runs == runs_ && status.is_final == is_final_ && status.is_failed == is_failed_) return;
    step_ = status.step;
    runs_ = runs;
    is_final_ = status.is_final;
    is_failed_ = status.is_failed;
    PrintRecord({{"is", "step"},
                 {"step", status.step},
                 {"detail", status.hint},
                 {"runs", runs},
                 {"final", status.is_final},
                 {"failed", status.is_failed},
                 {"why", status.why}});
  }

  bus::Registry* registry_;
  bus::Node* node_;
  bus::StateReader<core::LogicStatus>* status_ = nullptr;
  std::set<std::string> registered_;
  std::size_t num_refusals_ = 0;
  std::string step_;
  bool runs_ = false, is_final_ = false, is_failed_ = false;
};

int RunRegistry(const Arguments& arguments) {
  if (!arguments.has("--registry") || !arguments.has("--session")) {
    return Complain("registry", "--registry tcp://ADDRESS:PORT and --session N are needed", kBadUsage);
  }
  const std::atomic<int>& interrupted = CatchInterrupt();
  bus::RegistryOptions options;
  options.endpoint = arguments.text("--registry");
  options.session = std::strtoull(arguments.text("--session").c_str(), nullptr, 10);
  options.keys = arguments.text("--keys", "");
  options.is_encrypted = !arguments.has("--no_encryption");
  if (arguments.has("--make_keys")) {
    if (options.keys.empty())
      return Complain("registry", "--make_keys needs --keys DIR, the folder for the keys", kBadUsage);
    std::vector<std::string> names(std::begin(lab::kNodeNames), std::end(lab::kNodeNames));
    names.insert(names.end(), {"rt_worker", "oos", "client"});
    if (auto made = bus::MakeKeys(options.keys, names); !made) {
      return Complain("registry", made.error().detail, kDoesNotHold);
    }
  }
  auto registry = bus::Registry::Create(options);
  if (!registry) return Complain("registry", registry.error().detail, kDoesNotHold);
  bus::NodeOptions node_options;
  node_options.name = "oos-registry";
  node_options.registry = (*registry)->endpoint();
  node_options.bind_address = AddressOf((*registry)->endpoint());
  node_options.session = options.session;
  node_options.is_observer = true;
  node_options.keys = options.keys;
  node_options.is_encrypted = options.is_encrypted;
  auto node = bus::Node::Create(node_options);
  if (!node) return Complain("registry", node.error().detail, kDoesNotHold);
  Watcher watcher(registry->get(), node->get());
  if (const auto started = (*node)->Start(); !started) {
    return Complain("registry", started.error().detail, kDoesNotHold);
  }
  PrintRecord({{"is", "up"}, {"endpoint", (*registry)->endpoint()}});
  while (interrupted.load() == 0) watcher.Watch();
  PrintRecord({{"is", "down"}});
  return kHolds;
}

}  // namespace

Verb RegistryVerb() {
  return {"registry",
          "runs a session's registry, where its nodes find each other; 'oos launch' starts it",
          "",
          0,
          0,
          {{"--registry", "ENDPOINT", "address to listen on, tcp://ADDRESS:PORT"},
           {"--session", "N", "number of the session"},
           {"--keys", "DIR", "key directory of the session"},
           {"--make_keys", "", "makes the keys that are missing there; they stay when it ends"},
           {"--no_encryption", "", "the session has no keys"}},
          RunRegistry,
          "Prints what happens on the bus, a line of JSON each: registered, ready, gone, refused, event, step."};
}

}  // namespace oos
