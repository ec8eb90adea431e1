#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "bus/log/recorder.hpp"
#include "core/result.hpp"
#include "scene/scenario.hpp"
#include "view/bus_feed.hpp"

namespace view {

// Records what a viewer gets, thinned to 30 Hz: of each topic the newest message, of the procedure's state and the
// figures every one. A recording like any other, of a size that every run can leave.
class SceneRecorder {
 public:
  static constexpr std::int64_t kPeriod_ns = 33'333'333;

  // Replaces the file. Error: kIo.
  static core::Result<std::unique_ptr<SceneRecorder>> Create(const std::filesystem::path& file,
                                                             const scene::Scenario& scenario);

  // After each BusFeed::Apply. Error: kIo; then call it no more.
  core::Result<void> Take(const BusFeed& feed, std::int64_t now_ns);
  core::Result<void> Close(std::int64_t now_ns) { return recorder_->Close(now_ns, 0); }

 private:
  explicit SceneRecorder(std::unique_ptr<bus::log::Recorder> recorder) : recorder_(std::move(recorder)) {}
  template <class M>
  core::Result<void> AddLatest(const std::string& topic, const std::string& writer, const M& message,
                               std::int64_t received_ns);
  template <class M>
  core::Result<void> AddState(const std::string& topic, const std::string& writer, const M& value,
                              std::uint64_t version, std::int64_t now_ns);

  std::unique_ptr<bus::log::Recorder> recorder_;
  std::map<std::string, std::uint64_t> newest_;  // by topic: sequence or version of what was written last
  std::vector<std::uint8_t> bytes_;
  std::int64_t next_ns_ = 0;
};

}  // namespace view
