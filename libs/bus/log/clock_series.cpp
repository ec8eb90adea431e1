#include "bus/log/clock_series.hpp"

#include <algorithm>
#include <deque>

namespace bus::log {
namespace {

// Linear between samples, constant outside.
std::int64_t OffsetAt(const std::vector<ClockSeries::Sample>& samples, std::int64_t time_ns) {
  const auto after = std::lower_bound(samples.begin(), samples.end(), time_ns,
                                      [](const auto& sample, std::int64_t t) { return sample.time_ns < t; });
  if (after == samples.begin()) return after->offset_ns;
  const auto before = std::prev(after);
  if (after == samples.end() || after->time_ns == before->time_ns) return before->offset_ns;
  const double part =
      static_cast<double>(time_ns - before->time_ns) / static_cast<double>(after->time_ns - before->time_ns);
  return before->offset_ns +
         static_cast<std::int64_t>(part * static_cast<double>(after->offset_ns - before->offset_ns));
}

}  // namespace

void ClockSeries::AddNode(const std::string& node, const std::string& machine) {
  machines_[node] = machine;
}

void ClockSeries::Add(const std::string& node, const std::string& peer, const Sample& sample) {
  measured_[{node, peer}].push_back(sample);
}

core::Result<void> ClockSeries::SetReference(const std::string& machine) {
  // From machine to machine: each measurement in both directions.
  std::map<std::pair<std::string, std::string>, std::vector<Sample>> links;
  for (const auto& [pair, samples] : measured_) {
    const auto from = machines_.find(pair.first);
    const auto to = machines_.find(pair.second);
    if (from == machines_.end() || to == machines_.end() || from->second == to->second) continue;
    for (const Sample& s : samples) {
      links[{from->second, to->second}].push_back(s);
      links[{to->second, from->second}].push_back({s.time_ns + s.offset_ns, -s.offset_ns, s.bound_ns});
    }
  }
  ways_.clear();
  ways_[machine] = {};
  std::deque<std::string> reached = {machine};
  while (!reached.empty()) {
    const std::string near = reached.front();
    reached.pop_front();
    for (auto& [pair, samples] : links) {
      if (pair.second != near || ways_.count(pair.first) != 0) continue;
      std::stable_sort(samples.begin(), samples.end(),
                       [](const Sample& a, const Sample& b) { return a.time_ns < b.time_ns; });
      ways_[pair.first] = {near, samples};
      reached.push_back(pair.first);
    }
  }
  for (const auto& [node, its] : machines_) {
    if (ways_.count(its) == 0) {
      return core::Fail(core::ErrorCode::kInvalidInput,
                        "the clock of " + node +
                            "'s machine cannot be compared with the first file's: no node "
                            "has recorded samples between the two; record with all nodes' taps on");
    }
  }
  return {};
}

std::int64_t ClockSeries::ToReference(const std::string& machine, std::int64_t time_ns) const {
  for (auto way = ways_.find(machine); way != ways_.end() && !way->second.samples.empty();
       way = ways_.find(way->second.next)) {
    time_ns += OffsetAt(way->second.samples, time_ns);
  }
  return time_ns;
}

std::optional<std::string> ClockSeries::MachineOf(const std::string& node) const {
  const auto found = machines_.find(node);
  if (found == machines_.end()) return {};
  return found->second;
}

std::int64_t ClockSeries::BoundOf(const std::string& machine) const {
  std::int64_t bound_ns = 0;
  for (auto way = ways_.find(machine); way != ways_.end() && !way->second.samples.empty();
       way = ways_.find(way->second.next)) {
    std::int64_t widest = 0;
    for (const Sample& sample : way->second.samples) widest = std::max(widest, sample.bound_ns);
    bound_ns += widest;
  }
  return bound_ns;
}

}  // namespace bus::log
