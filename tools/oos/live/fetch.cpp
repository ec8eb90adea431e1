#include <unistd.h>

#include <cstdio>

#include "bus/bulk/bulk_folder.hpp"
#include "tools/oos/attach/attach.hpp"
#include "tools/oos/live/verbs.hpp"

namespace oos {
namespace {

constexpr const char* kOwner = "logic_node";
constexpr std::int64_t kTimeout_ns = 60 * core::kNanosecondsPerSecond;

int RunFetch(const Arguments& arguments) {
  auto options = FindSession(arguments);
  if (!options) return Complain("fetch", options.error().detail, kDoesNotHold);
  options->name = "oos-fetch-" + std::to_string(getpid());
  options->is_observer = true;
  auto node = bus::Node::Create(*options);
  if (!node) return Complain("fetch", node.error().detail, kDoesNotHold);
  const auto& offers = (*node)->ReadState<bus::BulkOffer>(bus::BulkTopic(kOwner));
  if (const auto started = (*node)->Start(5'000'000'000); !started) {
    return Complain("fetch", started.error().detail, kDoesNotHold);
  }
  const std::string& folder = arguments.positional()[0];
  const auto fetched = bus::FetchFolder(node->get(), offers, *options, kOwner, "scenario", folder, kTimeout_ns);
  if (!fetched) return Complain("fetch", fetched.error().detail, kDoesNotHold);
  std::printf("%zu files in %s\n", *fetched, folder.c_str());
  return kHolds;
}

}  // namespace

Verb FetchVerb() {
  return {"fetch",  "fetches the scenario of the running session to a machine that does not have it",
          "FOLDER", 1,
          1,        AttachOptions(),
          RunFetch};
}

}  // namespace oos
