#include "tools/oos/launch/comeback.hpp"

#include "core/clock.hpp"

namespace oos {
namespace {

constexpr std::int64_t kPeriod_ns = 300'000'000;
constexpr std::int64_t kPatience_ns = 120 * core::kNanosecondsPerSecond;  // a computer boots in less

}  // namespace

std::string Comebacks::Poll(const std::function<void(const std::string&, const std::string&)>& say) {
  const std::int64_t now_ns = core::MonotonicNow_ns();
  if (now_ns < next_ns_) return {};
  next_ns_ = now_ns + kPeriod_ns;
  for (std::size_t i = 0; i < hosts_.size(); ++i) {
    if (!streams_->has_ended(i)) continue;
    const std::string& name = remotes_->hosts()[i].name;
    if (since_ns_[i] == 0) {
      since_ns_[i] = now_ns;
      say(name, "is silent");
    }
    if (now_ns - since_ns_[i] > kPatience_ns) return "host " + name + " is silent for too long";
    if (!remotes_->Reconnect(i)) continue;
    if (const std::string why = Resume(i); !why.empty()) return "host " + name + ": " + why;
    char text[64];
    std::snprintf(text, sizeof text, "is back after %.1f s", 1e-9 * static_cast<double>(now_ns - since_ns_[i]));
    say(name, text);
    since_ns_[i] = 0;
  }
  return {};
}

std::string Comebacks::Resume(std::size_t host) {
  const Host& its = hosts_[host];
  const std::string folder = its.root + "/runs/" + run_;
  if (remotes_->Run(host, "[ -d " + folder + " ] || echo gone=1\n").value("gone") == "1") {
    was_stopped_ = true;
    return "the run was stopped from elsewhere";
  }
  if (const auto done = streams_->Reopen(host, run_, its.root, its.units, remotes_); !done) return done.error().detail;
  const Answer answer = remotes_->Run(host, its.resume);
  return answer.is_good() ? "" : "the supervisor does not start again: " + answer.err + answer.out;
}

}  // namespace oos
