#include "tools/oos/launch/watch.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>

namespace oos {

namespace {

constexpr char kBusUnit[] = "registry";

// `from`: "-n +1" from the logs' beginning, "-n 0" from now on.
core::Result<std::unique_ptr<PipedChild>> Tail(std::size_t host, const std::string& run, const std::string& root,
                                               const std::vector<std::string>& units, const std::string& from,
                                               Remotes* remotes) {
  std::string logs;
  for (const std::string& unit : units) logs += " " + unit + ".log";
  // `cat` ends when the connection closes, also when this process dies; then `tail` is killed.
  const std::string command = "cd " + root + "/runs/" + run + " && touch" + logs + " && { tail -v " + from + " -F" +
                              logs + " 2>/dev/null & } && cat >/dev/null; kill $! 2>/dev/null";
  return remotes->Open(host, "sh -c '" + command + "'");
}

}  // namespace

core::Result<void> LogStreams::Open(const std::string& run, const std::vector<std::string>& roots,
                                    const std::vector<std::vector<std::string>>& units, Remotes* remotes) {
  streams_.resize(roots.size());
  for (std::size_t i = 0; i < roots.size(); ++i) {
    streams_[i].host = remotes->hosts()[i].name;
    if (units[i].empty()) continue;
    auto child = Tail(i, run, roots[i], units[i], "-n +1", remotes);
    if (!child) return tl::unexpected(child.error());
    streams_[i].child = std::move(*child);
  }
  return {};
}

core::Result<void> LogStreams::Reopen(std::size_t host, const std::string& run, const std::string& root,
                                      const std::vector<std::string>& units, Remotes* remotes) {
  Stream& stream = streams_[host];
  std::vector<std::string> others = units;
  if (std::erase(others, kBusUnit) != 0) {
    auto bus = Tail(host, run, root, {kBusUnit}, "-n +" + std::to_string(stream.num_bus_lines + 1), remotes);
    if (!bus) return tl::unexpected(bus.error());
    if (others.empty()) {
      stream.child = std::move(*bus);
      stream.unit = kBusUnit;
      return {};
    }
    stream.bus_child = std::move(*bus);
  }
  auto child = Tail(host, run, root, others, "-n 0", remotes);
  if (!child) return tl::unexpected(child.error());
  stream.child = std::move(*child);
  return {};
}

void LogStreams::TakeLines(Stream* stream, PipedChild* child, std::string* unit, const TakeLine& take) {
  if (child == nullptr) return;
  child->Poll();
  for (const std::string& line : child->TakeLines()) {
    // tail names the file whose lines follow: "==> NAME.log <==".
    if (line.rfind("==> ", 0) == 0 && line.size() > 12 && line.compare(line.size() - 8, 8, ".log <==") == 0) {
      *unit = line.substr(4, line.size() - 12);
    } else if (!line.empty()) {
      stream->num_bus_lines += *unit == kBusUnit ? 1 : 0;
      take(stream->host, *unit, line);
    }
  }
}

void LogStreams::Poll(int timeout_ms, const TakeLine& take) {
  std::vector<PipedChild*> children;
  for (const Stream& stream : streams_) {
    for (PipedChild* child : {stream.child.get(), stream.bus_child.get()}) {
      if (child != nullptr && !child->has_ended()) children.push_back(child);
    }
  }
  WaitForAny(children, timeout_ms);
  for (Stream& stream : streams_) {
    std::string bus_unit = kBusUnit;
    TakeLines(&stream, stream.bus_child.get(), &bus_unit, take);
    TakeLines(&stream, stream.child.get(), &stream.unit, take);
  }
}

void LogStreams::Close() {
  for (Stream& stream : streams_) {
    for (PipedChild* child : {stream.child.get(), stream.bus_child.get()}) {
      if (child != nullptr) child->CloseInput();
    }
  }
  streams_.clear();
}

bool LogStreams::has_ended(std::size_t host) const {
  return streams_[host].child != nullptr && streams_[host].child->has_ended();
}

std::string BusStory::Take(const std::string& text) {
  const nlohmann::json line = nlohmann::json::parse(text, nullptr, false);
  if (!line.is_object()) return text;
  const std::string is = line.value("is", ""), node = line.value("node", ""), detail = line.value("detail", "");
  if (is == "ready") {
    ready_.insert(node);
    return node + " is ready";
  }
  if (is == "up" || is == "down") is_down_ = is == "down";
  if (is == "event") return node + ": " + line.value("name", "") + (detail.empty() ? "" : " " + detail);
  if (is == "refused") {
    refusal_ = detail;
    return "refused: " + detail;
  }
  if (is != "step") return {};
  const std::string step = line.value("step", "");
  const bool is_new = step != step_;
  step_ = step;
  runs_ = runs_ || line.value("runs", false);
  is_final_ = line.value("final", false);
  is_failed_ = line.value("failed", false);
  why_ = line.value("why", "");
  return is_new ? "step " + step + (detail.empty() ? "" : ": " + detail) : "";
}

}  // namespace oos
