#include "nodes/lockstep/replay_steps.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>

#include "bus/log/mcap_reader.hpp"
#include "bus/log/step_log.hpp"
#include "collision/resolution/choose_resolutions.hpp"
#include "core/clock.hpp"
#include "core/hash.hpp"
#include "replay/platform.hpp"

namespace lockstep {
namespace {

constexpr std::uint64_t kStretch_ticks = 100;
constexpr std::size_t kMaxGrowthRows = 1000;

void SleepUntil(std::int64_t due_ns) {
  const timespec due{due_ns / core::kNanosecondsPerSecond, due_ns % core::kNanosecondsPerSecond};
  while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &due, nullptr) != 0) {
  }
}

class Replay {
 public:
  Replay(ReplayedNode* node, const StepsOptions& options) : node_(*node), options_(options) {}

  void Take(const bus::log::Message& message) {
    if (!error_.empty()) return;
    if (!node_.Read(message.data)) {
      error_ = "step " + std::to_string(message.sequence) + " is damaged, or what precedes it is missing";
      return;
    }
    if (error_ = node_.WhyNot(); !error_.empty()) return;
    if (outcome_.num_steps++ == 0) {
      first_ns_ = node_.now_ns();
      begin_ns_ = core::MonotonicNow_ns();
      for (const core::ParameterChange& change : options_.mutations) node_.AddChange(change);
    }
    const std::int64_t since_first_ns = node_.now_ns() - first_ns_;
    outcome_.recorded_s = static_cast<double>(since_first_ns) * 1e-9;
    if (options_.speed > 0.0) {
      SleepUntil(begin_ns_ + static_cast<std::int64_t>(static_cast<double>(since_first_ns) / options_.speed));
    }
    const std::int64_t step_ns = core::ThreadCpuNow_ns();
    node_.Step();
    cpu_ns_ += core::ThreadCpuNow_ns() - step_ns;
    Compare();
  }

  core::Result<StepsOutcome> Finish() {
    if (!error_.empty()) return core::Fail(core::ErrorCode::kInvalidInput, error_);
    if (outcome_.num_steps == 0) return core::Fail(core::ErrorCode::kInvalidInput, "not one step of it is recorded");
    outcome_.cpu_s = static_cast<double>(cpu_ns_) * 1e-9;
    return outcome_;
  }

 private:
  void Compare() {
    const std::uint64_t digest = node_.digest();
    outcome_.digest = core::Hash64(&digest, sizeof digest, outcome_.digest);
    if (digest == node_.recorded_digest()) return;
    ++outcome_.num_inexact;
    const std::vector<replay::Leaf> recorded = node_.RecordedOutputs();
    const std::vector<replay::Leaf> got = node_.Outputs();
    const auto differences = replay::Compare(recorded, got, options_.tolerance,
                                             [this](const std::string& path) { return node_.NameOf(path); });
    if (differences.empty()) return;
    if (outcome_.num_different++ == 0) TakeFirst(differences);
    Grow(differences);
  }

  void TakeFirst(const std::vector<replay::FieldDifference>& differences) {
    // Numbers of the world before sums over it.
    const auto is_figure = [](const replay::FieldDifference& d) { return !d.path.ends_with("state_hash"); };
    const auto first = std::find_if(differences.begin(), differences.end(), is_figure);
    outcome_.first = first == differences.end() ? differences.front() : *first;
    outcome_.tick = node_.tick();
    outcome_.time_s = static_cast<double>(node_.now_ns()) * 1e-9;
    outcome_.name = node_.NameOf(outcome_.first.path);
    outcome_.thing = node_.ThingOf(outcome_.first.path);
    outcome_.others = differences.size() - 1;
  }

  void Grow(const std::vector<replay::FieldDifference>& differences) {
    const std::uint64_t first_tick = node_.tick() / kStretch_ticks * kStretch_ticks;
    if (outcome_.growth.empty() || outcome_.growth.back().first_tick != first_tick) {
      if (outcome_.growth.size() == kMaxGrowthRows) return;
      outcome_.growth.push_back({first_tick, node_.tick(), 0.0, "", 0.0});
    }
    GrowthRow& row = outcome_.growth.back();
    row.last_tick = node_.tick();
    for (const replay::FieldDifference& difference : differences) {
      if (difference.path.ends_with("state_hash") || !std::isfinite(difference.distance)) continue;
      if (difference.path == outcome_.first.path) {
        row.distance_of_first = std::max(row.distance_of_first, difference.distance);
      }
      if (difference.distance <= row.distance) continue;
      row.distance = difference.distance;
      row.name = node_.NameOf(difference.path);
    }
  }

  ReplayedNode& node_;
  const StepsOptions& options_;
  StepsOutcome outcome_;
  std::string error_;
  std::int64_t first_ns_ = 0, begin_ns_ = 0, cpu_ns_ = 0;
};

template <class... Arguments>
std::string Format(const char* format, Arguments... arguments) {
  char text[512];
  std::snprintf(text, sizeof text, format, arguments...);
  return text;
}

}  // namespace

core::Result<StepsOutcome> ReplaySteps(const std::filesystem::path& file, const RecordedNode& recorded,
                                       const scene::Scenario& scenario, const StepsOptions& options) {
  if (const auto how = recorded.about.find("denormals"); how != recorded.about.end()) {
    replay::SetDenormals(how->second);
  }
  scene::Scenario its = scenario;
  if (const auto method = recorded.about.find("method");
      method != recorded.about.end() && method->second != its.method) {
    its.method = method->second;
    if (const auto chosen = collision::ChooseResolutions(&its); !chosen) {
      return core::Fail(core::ErrorCode::kInvalidInput, scene::Format(chosen.error().front()));
    }
  }
  // What was recorded before there was a choice has no entry.
  const auto coupling = recorded.about.find("coupling");
  its.coupling.type = coupling == recorded.about.end() ? "paper" : coupling->second;
  auto node = ReplayedNode::Create(recorded, its, options.node);
  if (!node) return tl::unexpected(node.error());
  Replay replay(node->get(), options);
  const std::string topic = bus::log::StepTopic(recorded.node);
  const auto read = bus::log::ReadMcap(file, [&](const bus::log::Channel& channel, const bus::log::Message& message) {
    if (channel.topic == topic) replay.Take(message);
  });
  if (!read) return tl::unexpected(read.error());
  return replay.Finish();
}

std::string Describe(const RecordedNode& recorded, const StepsOutcome& o) {
  std::string text =
      Format("%s: %llu steps, %.3f s, digest %016llx, %.1f times real time on one core: ", recorded.node.c_str(),
             static_cast<unsigned long long>(o.num_steps), o.recorded_s, static_cast<unsigned long long>(o.digest),
             o.cpu_s > 0.0 ? o.recorded_s / o.cpu_s : 0.0);
  if (o.num_different == 0) {
    if (o.num_inexact == 0) return text + "equal bit for bit\n";
    return text + Format("equal within the tolerance; %llu steps are not the same bits\n",
                         static_cast<unsigned long long>(o.num_inexact));
  }
  const std::size_t colon = o.name.find(':');
  text += Format("%llu steps DIFFER\n", static_cast<unsigned long long>(o.num_different));
  text += Format("  first: tick %llu (%.3f s), topic %s, field %s%s%s: expected %s, got %s",
                 static_cast<unsigned long long>(o.tick), o.time_s, o.name.substr(0, colon).c_str(),
                 o.name.substr(colon + 1).c_str(), o.thing.empty() ? "" : " of ", o.thing.c_str(),
                 o.first.expected.c_str(), o.first.got.c_str());
  text += Format("; %zu more fields in that step\n  how it grows (largest difference of a number):\n", o.others);
  for (std::size_t i = 0; i < o.growth.size(); ++i) {
    const GrowthRow& row = o.growth[i];
    if (i == 12 && o.growth.size() > 14) {
      text += Format("    ... %zu rows more ...\n", o.growth.size() - 13);
      i = o.growth.size() - 2;
      continue;
    }
    text += Format("    ticks %llu-%llu: %.3g in %s; %.3g in the first field\n",
                   static_cast<unsigned long long>(row.first_tick), static_cast<unsigned long long>(row.last_tick),
                   row.distance, row.name.empty() ? "no number" : row.name.c_str(), row.distance_of_first);
  }
  return text;
}

}  // namespace lockstep
