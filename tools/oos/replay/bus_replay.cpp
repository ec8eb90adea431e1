#include "tools/oos/replay/bus_replay.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <set>
#include <sstream>
#include <tuple>

#include "bus/log/recorded_message.hpp"
#include "bus/wire/codec.hpp"

namespace oos {
namespace {

constexpr std::int64_t kOfferPeriod_ns = 1'000'000;

Outlet::Took TookIf(bool is_taken) {
  return is_taken ? Outlet::Took::kYes : Outlet::Took::kNotNow;
}

template <class M>
class LatestOutlet final : public Outlet {
 public:
  explicit LatestOutlet(bus::LatestWriter<M> writer) : writer_(writer) {}

  Took Take(const bus::log::Message& message) override {
    const M* whole = message_.Take(bus::log::SplitRecorded(message.data));
    if (whole == nullptr) return message_.is_incomplete() ? Took::kYes : Took::kNever;
    sent_ = *whole;  // its header is written into
    // LATEST is not repeated: a datagram that the socket has no room for is lost, and the node's accounts count it.
    writer_.Send(sent_);
    return Took::kYes;
  }

 private:
  bus::LatestWriter<M> writer_;
  bus::log::RecordedMessage<M> message_;
  M sent_;
};

template <class M>
class StateOutlet final : public Outlet {
 public:
  StateOutlet(bus::StateWriter<M> writer, std::string key) : writer_(writer), key_(std::move(key)) {}
  Took Take(const bus::log::Message& message) override {
    M value;
    if (!bus::DecodeState(std::string(message.data.begin(), message.data.end()), &value)) return Took::kNever;
    return TookIf(writer_.Set(value, key_));
  }
  [[nodiscard]] bool is_state() const override { return true; }
  Took Empty() override { return TookIf(writer_.Set(M{}, key_)); }

 private:
  bus::StateWriter<M> writer_;
  std::string key_;
};

class EventOutlet final : public Outlet {
 public:
  explicit EventOutlet(bus::Node* node) : node_(node) {}
  Took Take(const bus::log::Message& message) override {
    core::Event event;
    if (!bus::DecodeState(std::string(message.data.begin(), message.data.end()), &event)) return Took::kNever;
    return TookIf(node_->Emit(event));
  }

 private:
  bus::Node* node_;
};

std::string Text(const bus::log::TextMap& map, const char* key) {
  const auto found = map.find(key);
  return found == map.end() ? std::string() : found->second;
}

// Null if the channel cannot be published again.
const bus::TopicRule* FindPublished(const std::string& topic) {
  const bus::TopicRule* rule = bus::FindTopicRule(topic);
  if (rule == nullptr || rule->topic_class == bus::TopicClass::kService) return nullptr;
  return rule->type == bus::MessageType::kBulkOffer ? nullptr : rule;
}

// One writer for all keys of a topic.
class Outlets {
 public:
  explicit Outlets(bus::Node* node) : node_(node) {}

  std::shared_ptr<Outlet> Make(const bus::TopicRule& rule, const std::string& topic, const std::string& key) {
    if (rule.topic_class == bus::TopicClass::kEvent) return std::make_shared<EventOutlet>(node_);
    if (rule.topic_class == bus::TopicClass::kLatest)
      return bus::LatestMessages<LatestOf>::Make(this, rule.type, topic);
    return bus::StateMessages<StateOf>::Make(this, rule.type, topic, key);
  }

 private:
  template <class... M>
  struct LatestOf {
    static std::shared_ptr<Outlet> Make(Outlets* outlets, bus::MessageType type, const std::string& topic) {
      std::shared_ptr<Outlet> made;
      (void)((type == bus::kMessageTypeOf<M> && (made = outlets->Latest<M>(topic)) != nullptr) || ...);
      return made;
    }
  };
  template <class... M>
  struct StateOf {
    static std::shared_ptr<Outlet> Make(Outlets* outlets, bus::MessageType type, const std::string& topic,
                                        const std::string& key) {
      std::shared_ptr<Outlet> made;
      (void)((type == bus::kMessageTypeOf<M> && (made = outlets->State<M>(topic, key)) != nullptr) || ...);
      return made;
    }
  };
  template <class... M>
  using WritersOf = std::tuple<std::map<std::string, bus::StateWriter<M>>...>;  // by topic

  template <class M>
  std::shared_ptr<Outlet> Latest(const std::string& topic) {
    std::shared_ptr<Outlet>& outlet = latest_[topic];
    if (outlet == nullptr) outlet = std::make_shared<LatestOutlet<M>>(node_->WriteLatest<M>(topic));
    return outlet;
  }
  template <class M>
  std::shared_ptr<Outlet> State(const std::string& topic, const std::string& key) {
    auto& writers = std::get<std::map<std::string, bus::StateWriter<M>>>(state_writers_);
    if (writers.count(topic) == 0) writers[topic] = node_->WriteState<M>(topic);
    return std::make_shared<StateOutlet<M>>(writers.at(topic), key);
  }

  bus::Node* node_;
  std::map<std::string, std::shared_ptr<Outlet>> latest_;
  bus::StateMessages<WritersOf> state_writers_;
};

}  // namespace

std::optional<ReplayCommand> ParseReplayCommand(const std::string& line) {
  std::istringstream words(line);
  std::string word, rest;
  words >> word;
  double value = 0.0;
  const bool has_value = static_cast<bool>(words >> value);
  words.clear();
  if (words >> rest) return std::nullopt;
  using Kind = ReplayCommand::Kind;
  if (word == "pause" && !has_value) return ReplayCommand{Kind::kPause};
  if (word == "play" && !has_value) return ReplayCommand{Kind::kPlay};
  if (word == "quit" && !has_value) return ReplayCommand{Kind::kQuit};
  if (word == "step" && (!has_value || value >= 1.0)) return ReplayCommand{Kind::kStep, has_value ? value : 1.0};
  if (word == "seek" && has_value && value >= 0.0) return ReplayCommand{Kind::kSeek, value};
  if (word == "speed" && has_value && value > 0.0) return ReplayCommand{Kind::kSpeed, value};
  return std::nullopt;
}

core::Result<std::unique_ptr<BusReplay>> BusReplay::Open(const std::filesystem::path& file) {
  auto reader = bus::log::McapIndexedReader::Open(file);
  if (!reader) return tl::unexpected(reader.error());
  std::unique_ptr<BusReplay> replay(new BusReplay(std::move(*reader)));
  if (auto done = replay->LookThrough(); !done) return tl::unexpected(done.error());
  if (replay->sources_.empty()) {
    return core::Fail(core::ErrorCode::kNotFound,
                      file.string() + ": holds nothing that nodes published; 'oos info' lists what it holds");
  }
  return replay;
}

core::Result<void> BusReplay::LookThrough() {
  std::set<std::string> topics;
  const auto see = [&](const bus::log::Channel& channel, const bus::log::Message& message) {
    const auto [place, is_new] = sources_.try_emplace(channel.id);
    Source& source = place->second;
    if (is_new) {
      const std::string tap = Text(channel.metadata, "tap");
      const bool is_published = channel.message_encoding == "protobuf" && (tap.empty() || tap == "sent");
      source = {is_published ? FindPublished(channel.topic) : nullptr, channel.topic, Text(channel.metadata, "key"),
                false, nullptr};
      if (source.rule != nullptr) topics.insert(channel.topic);
    }
    if (source.rule == nullptr) return true;
    if (first_ns_ == 0) first_ns_ = message.log_time_ns;
    last_ns_ = message.log_time_ns;
    return true;
  };
  if (auto done = reader_.ReadMessages(see); !done) return done;
  std::erase_if(sources_, [](const auto& source) { return source.second.rule == nullptr; });
  topics_.assign(topics.begin(), topics.end());
  return {};
}

void BusReplay::Declare(bus::Node* node) {
  Outlets outlets(node);
  for (auto& [id, source] : sources_) source.outlet = outlets.Make(*source.rule, source.topic, source.key);
}

core::Result<void> BusReplay::Seek(double from_s, std::int64_t now_ns) {
  const std::uint64_t from_ns = first_ns_ + static_cast<std::uint64_t>(std::max(from_s, 0.0) * 1e9);
  // The newest value of every state before that, in the order in which they came.
  std::map<std::uint16_t, bus::log::Message> newest;
  const auto see = [&](const bus::log::Channel& channel, const bus::log::Message& message) {
    const auto source = sources_.find(channel.id);
    if (source != sources_.end() && source->second.outlet->is_state()) newest[channel.id] = message;
    return true;
  };
  if (from_ns > first_ns_) {
    if (auto done = reader_.ReadMessages(see, 0, from_ns); !done) return done;
  }
  states_.clear();
  // Later values that the bus still holds are cleared first: another channel may have the same topic and key.
  for (const auto& [id, source] : sources_) {
    if (source.is_published && newest.count(id) == 0) states_.push_back({id, std::nullopt});
  }
  std::vector<bus::log::Message> values;
  for (auto& [id, message] : newest) values.push_back(std::move(message));
  std::stable_sort(values.begin(), values.end(), [](const bus::log::Message& a, const bus::log::Message& b) {
    return a.log_time_ns < b.log_time_ns;
  });
  for (bus::log::Message& message : values) {
    const std::uint16_t channel = message.channel_id;
    states_.push_back({channel, std::move(message)});
  }
  reader_.Seek(from_ns);
  refused_ns_.reset();
  num_steps_ = 0;
  position_ns_ = anchor_log_ns_ = from_ns;
  anchor_now_ns_ = now_ns;
  return Fetch();
}

core::Result<void> BusReplay::Fetch() {
  bus::log::Message message;
  while (true) {
    const auto got = reader_.Next(&message);
    if (!got) return tl::unexpected(got.error());
    if (!*got) {
      next_.reset();
      return {};
    }
    if (sources_.count(message.channel_id) == 0) continue;
    next_ = std::move(message);
    return {};
  }
}

void BusReplay::Apply(const ReplayCommand& command, std::int64_t now_ns) {
  const bool was_paused = is_paused_;
  switch (command.kind) {
    case ReplayCommand::Kind::kPause:
      is_paused_ = true;
      return;
    case ReplayCommand::Kind::kStep:
      is_paused_ = true;
      num_steps_ = static_cast<std::uint64_t>(command.value);
      return;
    case ReplayCommand::Kind::kPlay:
      is_paused_ = false;
      break;
    case ReplayCommand::Kind::kSpeed:
      break;
    default:
      return;
  }
  // Time goes on from here.
  anchor_log_ns_ = was_paused || !next_
                       ? position_ns_
                       : anchor_log_ns_ + static_cast<std::uint64_t>(
                                              std::max(0.0, static_cast<double>(now_ns - anchor_now_ns_) * speed_));
  anchor_now_ns_ = now_ns;
  if (command.kind == ReplayCommand::Kind::kSpeed) speed_ = command.value;
}

std::int64_t BusReplay::DueOf(std::uint64_t log_time_ns) const {
  const double ahead_ns = static_cast<double>(log_time_ns) - static_cast<double>(anchor_log_ns_);
  return anchor_now_ns_ + static_cast<std::int64_t>(std::max(0.0, ahead_ns) / speed_);
}

std::optional<std::int64_t> BusReplay::due_ns() const {
  if (refused_ns_) return offered_ns_ + kOfferPeriod_ns;
  if (!next_ || is_paused_) return std::nullopt;
  return DueOf(next_->log_time_ns);
}

double BusReplay::position_s() const {
  return static_cast<double>(position_ns_ - first_ns_) * 1e-9;
}

// False if the message must be offered again.
bool BusReplay::IsDone(Outlet::Took took, std::int64_t now_ns, std::uint64_t* num_taken) {
  offered_ns_ = now_ns;
  if (took == Outlet::Took::kNotNow) {
    if (!refused_ns_) refused_ns_ = now_ns;
    if (now_ns - *refused_ns_ < kPatience_ns) return false;
  }
  refused_ns_.reset();
  ++(took == Outlet::Took::kYes ? *num_taken : num_not_published_);
  return true;
}

bool BusReplay::PublishState(std::int64_t now_ns) {
  const PendingState& state = states_.front();
  Source& source = sources_.at(state.channel);
  std::uint64_t num_before = 0;  // published before, in the recording's time: not counted again
  if (!IsDone(state.message ? source.outlet->Take(*state.message) : source.outlet->Empty(), now_ns, &num_before)) {
    return false;
  }
  if (num_before > 0) source.is_published = state.message.has_value();
  states_.pop_front();
  return true;
}

core::Result<bool> BusReplay::Publish(std::int64_t now_ns) {
  Source& source = sources_.at(next_->channel_id);
  const std::uint64_t before = num_published_;
  if (!IsDone(source.outlet->Take(*next_), now_ns, &num_published_)) return false;
  source.is_published |= source.outlet->is_state() && num_published_ > before;
  position_ns_ = next_->log_time_ns;
  if (auto done = Fetch(); !done) return tl::unexpected(done.error());
  return true;
}

core::Result<void> BusReplay::Advance(std::int64_t now_ns) {
  while (!states_.empty()) {
    if (!PublishState(now_ns)) return {};
  }
  const auto is_due = [&] {
    if (!next_) return false;
    return is_paused_ ? num_steps_ > 0 : DueOf(next_->log_time_ns) <= now_ns;
  };
  while (is_due()) {
    const auto is_done = Publish(now_ns);
    if (!is_done) return tl::unexpected(is_done.error());
    if (!*is_done) return {};
    if (is_paused_) --num_steps_;
  }
  return {};
}

}  // namespace oos
