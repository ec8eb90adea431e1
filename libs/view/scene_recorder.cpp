#include "view/scene_recorder.hpp"

#include "bus/wire/codec.hpp"

namespace view {
namespace {

constexpr std::size_t kPartBytes = 60'000;  // of a message: only a big sheet takes more

// Empty: a scenario that was not read from a file.
std::string AbsoluteOf(const std::filesystem::path& file) {
  return file.empty() ? "" : std::filesystem::absolute(file).string();
}

}  // namespace

core::Result<std::unique_ptr<SceneRecorder>> SceneRecorder::Create(const std::filesystem::path& file,
                                                                   const scene::Scenario& scenario) {
  std::error_code ignored;
  std::filesystem::remove(file, ignored);  // of a run before, in the same folder
  auto recorder =
      bus::log::Recorder::Create(file, {{"of", "what a viewer got, at most 30 messages a second of each topic"}},
                                 {{"scenario", {{"file", AbsoluteOf(scenario.file)}}}});
  if (!recorder) return tl::unexpected(recorder.error());
  std::unique_ptr<SceneRecorder> made(new SceneRecorder(std::move(*recorder)));
  made->bytes_.resize(kPartBytes);
  return made;
}

template <class M>
core::Result<void> SceneRecorder::AddLatest(const std::string& topic, const std::string& writer, const M& message,
                                            std::int64_t received_ns) {
  std::uint64_t& newest = newest_[topic];
  if (message.header.sequence == 0 || message.header.sequence == newest) return {};
  newest = message.header.sequence;
  const bus::LatestCodec<M> codec;
  bus::Observation seen;
  seen.topic = topic;
  seen.type = bus::kMessageTypeOf<M>;
  seen.writer = writer;
  seen.sequence = message.header.sequence;
  seen.publish_ns = message.header.publish_ns;
  seen.received_ns = received_ns;
  seen.num_parts = static_cast<unsigned>(codec.NumParts(message, kPartBytes));
  for (; seen.part < seen.num_parts; ++seen.part) {
    const std::size_t size =
        codec.Encode(message, static_cast<int>(seen.part), kPartBytes, bytes_.data(), bytes_.size());
    if (size == bus::kDoesNotFit) return {};
    seen.payload.assign(bytes_.begin(), bytes_.begin() + static_cast<std::ptrdiff_t>(size));
    if (auto added = recorder_->Add(seen); !added) return added;
  }
  return {};
}

template <class M>
core::Result<void> SceneRecorder::AddState(const std::string& topic, const std::string& writer, const M& value,
                                           std::uint64_t version, std::int64_t now_ns) {
  std::uint64_t& newest = newest_[topic];
  if (version == newest) return {};
  newest = version;
  bus::Observation seen;
  seen.topic = topic;
  seen.topic_class = bus::TopicClass::kState;
  seen.type = bus::kMessageTypeOf<M>;
  seen.writer = writer;
  seen.sequence = version;
  seen.received_ns = now_ns;
  bus::EncodeState(value, &seen.payload);
  return recorder_->Add(seen);
}

core::Result<void> SceneRecorder::Take(const BusFeed& feed, std::int64_t now_ns) {
  core::Result<void> result;
  feed.VisitStates([&](const std::string& topic, const std::string& writer, const auto& reader) {
    if (result && reader.has_value()) result = AddState(topic, writer, reader.value(), reader.version(), now_ns);
  });
  if (!result || now_ns < next_ns_) return result;
  next_ns_ = std::max(next_ns_ + kPeriod_ns, now_ns);
  feed.VisitLatest([&](const std::string& topic, const std::string& writer, const auto& reader) {
    if (result) result = AddLatest(topic, writer, reader.value(), reader.received_ns());
  });
  return result ? recorder_->Tick(now_ns, 0) : result;
}

}  // namespace view
