#include "view/recorded_scene.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>

namespace view {

core::Result<std::unique_ptr<RecordedScene>> RecordedScene::Open(const std::filesystem::path& file,
                                                                 const scene::Scenario& scenario) {
  auto reader = bus::log::McapIndexedReader::Open(file);
  if (!reader) return tl::unexpected(reader.error());
  std::unique_ptr<RecordedScene> recorded(new RecordedScene(std::move(*reader), scenario));
  if (auto found = recorded->FindEnds(file); !found) return tl::unexpected(found.error());
  recorded->Begin();
  return recorded;
}

core::Result<void> RecordedScene::FindEnds(const std::filesystem::path& file) {
  std::map<std::uint16_t, bool> is_read;
  bool is_any = false;
  const auto see = [&](const bus::log::Channel& channel, const bus::log::Message& message) {
    const auto [known, is_new] = is_read.try_emplace(channel.id, false);
    if (is_new) known->second = RecordedFeed::IsRead(channel);
    if (!known->second) return true;
    if (!is_any) first_ns_ = message.log_time_ns;
    is_any = true;
    last_ns_ = message.log_time_ns;
    return true;
  };
  if (auto done = reader_.ReadMessages(see); !done) return done;
  if (is_any) return {};
  return core::Fail(core::ErrorCode::kNotFound,
                    file.string() +
                        ": holds nothing that a viewer shows; 'oos info' lists what it holds, and 'oos run "
                        "--record' or 'oos record' makes a recording that can be shown");
}

void RecordedScene::Begin() {
  reader_.Seek();
  feed_ = {};
  mirror_.emplace(scenario_);
  mirror_->Choose(choices_);
  next_.reset();
  reached_ns_ = first_ns_;
}

core::Result<void> RecordedScene::CheckTime(std::optional<double> at_s) const {
  if (!at_s || *at_s <= duration_s()) return {};
  char what[96];
  std::snprintf(what, sizeof what, "%.3f s is beyond the end of the recording, which is %.3f s long", *at_s,
                duration_s());
  return core::Fail(core::ErrorCode::kInvalidInput, what);
}

core::Result<void> RecordedScene::GoTo(double at_s) {
  const std::uint64_t to_ns = first_ns_ + static_cast<std::uint64_t>(std::llround(1e9 * std::max(0.0, at_s)));
  if (to_ns < reached_ns_) Begin();
  while (true) {
    if (!next_) {
      bus::log::Message message;
      const auto got = reader_.Next(&message);
      if (!got) return tl::unexpected(got.error());
      if (!*got) break;
      next_ = std::move(message);
    }
    if (next_->log_time_ns > to_ns) break;
    if (const auto channel = reader_.channels().find(next_->channel_id); channel != reader_.channels().end()) {
      feed_.Apply(channel->second, *next_, &*mirror_);
      mirror_->Remember(static_cast<std::int64_t>(next_->log_time_ns));
    }
    next_.reset();
  }
  reached_ns_ = to_ns;
  mirror_->Refresh(static_cast<std::int64_t>(to_ns));
  return {};
}

}  // namespace view
