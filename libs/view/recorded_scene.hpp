#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>

#include "bus/log/mcap_indexed_reader.hpp"
#include "core/result.hpp"
#include "scene/scenario.hpp"
#include "view/recorded_feed.hpp"
#include "view/scene_mirror.hpp"

namespace view {

// The scene of a recording at any time of it. A function of the file, the scenario and the time alone.
class RecordedScene {
 public:
  // Errors: kIo, kDamaged; kNotFound when the file holds no pose that a viewer reads.
  static core::Result<std::unique_ptr<RecordedScene>> Open(const std::filesystem::path& file,
                                                           const scene::Scenario& scenario);

  // From the first message that a viewer reads to the last one [s].
  [[nodiscard]] double duration_s() const { return 1e-9 * static_cast<double>(last_ns_ - first_ns_); }
  // CLOCK_MONOTONIC of the recording's machine at the first message that a viewer reads.
  [[nodiscard]] std::uint64_t first_ns() const { return first_ns_; }

  // Error: kInvalidInput, when it is given and beyond the end.
  [[nodiscard]] core::Result<void> CheckTime(std::optional<double> at_s) const;

  // Applies all messages up to `at_s` after the first one. Forward it reads on; backward it begins anew. Error:
  // kDamaged.
  core::Result<void> GoTo(double at_s);
  [[nodiscard]] const Scene& scene() const { return mirror_->scene(); }
  [[nodiscard]] const Choices& choices() const { return mirror_->choices(); }
  // What the scene shows after the next GoTo.
  void Choose(const Choices& choices) {
    choices_ = choices;
    mirror_->Choose(choices);
  }

 private:
  RecordedScene(bus::log::McapIndexedReader reader, const scene::Scenario& scenario)
      : reader_(std::move(reader)), scenario_(scenario) {}
  core::Result<void> FindEnds(const std::filesystem::path& file);
  void Begin();

  bus::log::McapIndexedReader reader_;
  scene::Scenario scenario_;
  RecordedFeed feed_;
  Choices choices_;
  std::optional<SceneMirror> mirror_;
  std::optional<bus::log::Message> next_;  // read, but not applied yet
  std::uint64_t first_ns_ = 0, last_ns_ = 0, reached_ns_ = 0;
};

}  // namespace view
