#pragma once

#include <cstdint>
#include <deque>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "bus/log/mcap_indexed_reader.hpp"
#include "bus/node.hpp"
#include "bus/topics.hpp"
#include "core/clock.hpp"
#include "core/result.hpp"

namespace oos {

// Publishes a recorded message on the bus by a writer of its topic and type.
class Outlet {
 public:
  virtual ~Outlet() = default;
  enum class Took { kYes, kNotNow, kNever };  // kNotNow: the queue to the bus is full; kNever: it cannot be decoded
  // A message of the channel. Parts of one that was split are put together first.
  virtual Took Take(const bus::log::Message& message) = 0;
  [[nodiscard]] virtual bool is_state() const { return false; }
  // Of a state: publishes an empty value, as a bus cannot take one back.
  virtual Took Empty() { return Took::kNever; }
};

// A command to a running replay: "pause", "play", "step [MESSAGES]", "seek SECONDS", "speed X", "quit".
struct ReplayCommand {
  enum class Kind { kPause, kPlay, kStep, kSeek, kSpeed, kQuit };
  Kind kind = Kind::kPause;
  double value = 0.0;
};
// Nothing if the line is no command.
std::optional<ReplayCommand> ParseReplayCommand(const std::string& line);

// Publishes again what nodes published in a recording, under the same topics: LATEST, STATE and EVENT. Messages that
// nodes received, steps and services are left out. Order: log time, then the recording's own order. Sequence numbers
// and publish times are new; traces are those of the recording where it contains them.
//
// Time is given by the caller, so that a test needs no clock.
class BusReplay {
 public:
  // A message that the bus does not accept is offered again for this time, then left out and counted.
  static constexpr std::int64_t kPatience_ns = core::kNanosecondsPerSecond;

  // Reads the file's index. Errors: kIo, kDamaged; kNotFound if nothing in it can be published.
  static core::Result<std::unique_ptr<BusReplay>> Open(const std::filesystem::path& file);
  // Call once, before all below: declares the topics on `node`, which must not be started yet and must outlive this.
  void Declare(bus::Node* node);

  // Continues from `from_s` after the first message. Advance first publishes the states as of then, also during a
  // pause. A state that this replay has published but that did not exist yet at that time becomes an empty value.
  core::Result<void> Seek(double from_s, std::int64_t now_ns);
  void Apply(const ReplayCommand& command, std::int64_t now_ns);  // kSeek calls Seek
  // Publishes what is due. Errors: kDamaged.
  core::Result<void> Advance(std::int64_t now_ns);

  [[nodiscard]] bool is_over() const { return !next_.has_value() && states_.empty(); }
  [[nodiscard]] bool is_paused() const { return is_paused_; }
  // When the next message is due or is offered again; nothing during a pause and at the end.
  [[nodiscard]] std::optional<std::int64_t> due_ns() const;
  [[nodiscard]] double position_s() const;  // of the last message, from the first one
  [[nodiscard]] double duration_s() const { return static_cast<double>(last_ns_ - first_ns_) * 1e-9; }
  [[nodiscard]] std::uint64_t num_published() const { return num_published_; }
  // Messages that the bus did not accept or that cannot be decoded, states that a seek had to publish included.
  [[nodiscard]] std::uint64_t num_not_published() const { return num_not_published_; }
  [[nodiscard]] const std::vector<std::string>& topics() const { return topics_; }

 private:
  explicit BusReplay(bus::log::McapIndexedReader reader) : reader_(std::move(reader)) {}
  // A channel that can be published.
  struct Source {
    const bus::TopicRule* rule = nullptr;
    std::string topic, key;
    bool is_published = false;  // a state of which the bus holds a value by now
    std::shared_ptr<Outlet> outlet;
  };
  // A state that a seek must publish before anything else.
  struct PendingState {
    std::uint16_t channel = 0;
    std::optional<bus::log::Message> message;  // nothing: an empty value
  };
  core::Result<void> LookThrough();
  core::Result<void> Fetch();
  bool PublishState(std::int64_t now_ns);
  core::Result<bool> Publish(std::int64_t now_ns);
  bool IsDone(Outlet::Took took, std::int64_t now_ns, std::uint64_t* num_taken);
  [[nodiscard]] std::int64_t DueOf(std::uint64_t log_time_ns) const;

  bus::log::McapIndexedReader reader_;
  std::map<std::uint16_t, Source> sources_;  // by channel
  std::vector<std::string> topics_;
  std::deque<PendingState> states_;
  std::optional<bus::log::Message> next_;
  std::uint64_t first_ns_ = 0, last_ns_ = 0, position_ns_ = 0;
  std::uint64_t num_published_ = 0, num_not_published_ = 0;
  std::optional<std::int64_t> refused_ns_;  // since when the bus does not accept the next message
  std::int64_t offered_ns_ = 0;             // for the last time
  double speed_ = 1.0;
  bool is_paused_ = false;
  std::uint64_t num_steps_ = 0;      // still to be published though it pauses
  std::uint64_t anchor_log_ns_ = 0;  // this log time is due
  std::int64_t anchor_now_ns_ = 0;   // at this time
};

}  // namespace oos
