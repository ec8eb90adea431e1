#include "tools/oos/record/record_scenario.hpp"

#include <algorithm>
#include <chrono>
#include <utility>

#include "core/clock.hpp"

namespace oos {
namespace {

constexpr const char* kName = "scenario";  // the list of the files, which is offered after them
constexpr std::uint64_t kMaxTextBytes = 1 << 20;
constexpr std::int64_t kTimeout_ns = 2 * core::kNanosecondsPerSecond;  // also what a recorder's end waits at most
constexpr std::int64_t kGathering_ns = 100'000'000;
constexpr std::int64_t kPause_ns = 5 * core::kNanosecondsPerSecond;  // between tries

bool IsText(const bus::BulkOffer& offer) {
  const auto ends_with = [&offer](const std::string& end) { return offer.name.ends_with(end); };
  return (ends_with(".xml") || ends_with(".scxml")) && offer.size <= kMaxTextBytes;
}

}  // namespace

SessionScenario::SessionScenario(bus::Node* node, bus::NodeOptions options)
    : offers_(node->ReadState<bus::BulkOffer>(bus::BulkTopic(kOwner))), options_(std::move(options)) {}

SessionScenario::Texts SessionScenario::Fetch(const std::vector<bus::BulkOffer>& offers,
                                              const bus::NodeOptions& options) {
  Texts texts;
  const std::string folder = std::string(kName) + "/";
  const std::int64_t deadline_ns = core::MonotonicNow_ns() + kTimeout_ns;
  for (const bus::BulkOffer& offer : offers) {
    const std::int64_t left_ns = deadline_ns - core::MonotonicNow_ns();
    auto bytes = bus::BulkFetch(offer, kOwner, options).Run(std::max<std::int64_t>(left_ns, 1));
    if (!bytes) return {};
    texts.push_back({0, 0, offer.name.substr(folder.size()), "application/xml", std::move(*bytes)});
  }
  return texts;
}

std::vector<bus::log::Attachment> SessionScenario::Take(std::int64_t now_ns) {
  if (is_done_ || now_ns < next_ns_) return {};
  if (fetched_.valid()) {
    if (fetched_.wait_for(std::chrono::seconds(0)) != std::future_status::ready) return {};
    Texts texts = fetched_.get();
    is_done_ = !texts.empty();
    next_ns_ = now_ns + kPause_ns;
    return texts;
  }
  const auto& values = offers_.values();
  if (values.count(kName) == 0) return {};
  if (!is_offered_) {  // a joining node gets all offers at once, but in any order
    is_offered_ = true;
    next_ns_ = now_ns + kGathering_ns;
    return {};
  }
  std::vector<bus::BulkOffer> wanted;
  for (const auto& [name, offer] : values) {
    if (name.starts_with(std::string(kName) + "/") && IsText(offer)) wanted.push_back(offer);
  }
  if (wanted.empty()) {
    next_ns_ = now_ns + kPause_ns;
    return {};
  }
  fetched_ = std::async(std::launch::async, Fetch, std::move(wanted), options_);
  return {};
}

}  // namespace oos
