#include <algorithm>
#include <cstdio>
#include <cstdlib>

#include "core/names.hpp"
#include "tools/oos/attach.hpp"
#include "tools/oos/verb.hpp"

namespace oos {
namespace {

int Run(const Arguments& arguments) {
  const std::string& path = arguments.positional()[0];
  const std::string& text = arguments.positional()[1];
  const std::size_t dot = path.find('.');
  if (dot == std::string::npos || dot == 0 || dot + 1 == path.size()) {
    return Complain("set", "say NODE.PARAM, e.g. haptic_node.force_cap_N", kBadUsage);
  }
  char* end = nullptr;
  const double value = std::strtod(text.c_str(), &end);
  if (text.empty() || *end != '\0') return Complain("set", "'" + text + "' is not a number", kBadUsage);

  auto node = Attach(arguments, "set");
  if (!node) return Complain("set", node.error().detail, kDoesNotHold);
  if (const auto started = (*node)->Start(5'000'000'000); !started) {
    return Complain("set", started.error().detail, kDoesNotHold);
  }
  const std::string owner = path.substr(0, dot);
  // The registry has told of every node by now; observers like this one have no parameters.
  std::vector<std::string> nodes;
  for (const bus::PeerStatus& peer : (*node)->Peers()) {
    if (!peer.is_observer) nodes.push_back(peer.name);
  }
  if (std::find(nodes.begin(), nodes.end(), owner) == nodes.end()) {
    return Complain("set", "no node is called '" + owner + "'; " + core::SuggestName(owner, nodes), kDoesNotHold);
  }
  if (const auto alive = (*node)->WaitForPeers({owner}, 2'000'000'000); !alive) {
    return Complain("set", alive.error().detail, kDoesNotHold);
  }
  const auto tick = (*node)->SetParameter(owner, {path.substr(dot + 1), value}, 2'000'000'000);
  if (!tick) return Complain("set", tick.error().detail, kDoesNotHold);
  std::printf("%s = %g, applied at tick %llu of %s\n", path.substr(dot + 1).c_str(), value,
              static_cast<unsigned long long>(*tick), owner.c_str());
  return kHolds;
}

}  // namespace

Verb SetVerb() {
  return {"set",
          "changes a parameter of a running node and says at which tick it was applied",
          "NODE.PARAM VALUE",
          2,
          2,
          AttachOptions(),
          Run};
}

}  // namespace oos
