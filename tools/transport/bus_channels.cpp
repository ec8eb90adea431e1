#include "tools/transport/bus_channels.hpp"

#include <unistd.h>

#include <atomic>

#include "bus/security/keys.hpp"
#include "core/clock.hpp"
#include "core/messages/device.hpp"
#include "core/messages/haptic.hpp"
#include "core/messages/physics.hpp"

namespace transport {
namespace {

constexpr std::int64_t kStart_ns = 5 * core::kNanosecondsPerSecond;

std::string NameOf(const char* topic_class, bool is_encrypted) {
  return std::string(topic_class) + (is_encrypted ? "" : ", not encrypted");
}

std::int64_t Soon() {
  return core::MonotonicNow_ns() + kPatience_ms * std::int64_t{1'000'000};
}

void SetTime(std::int64_t now_ns, core::DeviceState* state) {
  state->sample_ns = now_ns;
}
std::int64_t TimeOf(const core::DeviceState& state) {
  return state.sample_ns;
}
void SetTime(std::int64_t now_ns, core::ContactSet* contacts) {
  contacts->cycle = static_cast<std::uint64_t>(now_ns);
}
void SetTime(std::int64_t now_ns, core::SheetState* sheet) {
  sheet->tick = static_cast<std::uint64_t>(now_ns);
}
std::int64_t TimeOf(const core::ContactSet& contacts) {
  return static_cast<std::int64_t>(contacts.cycle);
}
std::int64_t TimeOf(const core::SheetState& sheet) {
  return static_cast<std::int64_t>(sheet.tick);
}

template <class M>
class LatestChannel final : public Channel {
 public:
  LatestChannel(std::size_t num_bytes, std::unique_ptr<Link> link, M message, const std::string& topic)
      : Channel(NameOf("LATEST", link->is_encrypted), num_bytes), link_(std::move(link)), message_(message) {
    writer_ = link_->near->WriteLatest<M>(topic);
    reader_ = &link_->far->template ReadLatest<M>(topic);
  }
  bool Start() {
    if (!link_->Start()) return false;
    const std::int64_t end_ns = core::MonotonicNow_ns() + kStart_ns;
    while (!writer_.has_subscribers() && core::MonotonicNow_ns() < end_ns) link_->near->Wait(Soon());
    return writer_.has_subscribers();
  }
  bool Send(std::int64_t now_ns) override {
    SetTime(now_ns, &message_);
    return writer_.Send(message_) > 0;
  }
  std::int64_t Receive() override {
    link_->far->Wait(Soon());
    return reader_->is_fresh() ? TimeOf(reader_->value()) : 0;
  }

 private:
  std::unique_ptr<Link> link_;
  M message_;
  bus::LatestWriter<M> writer_;
  bus::LatestReader<M>* reader_;
};

template <class M>
std::unique_ptr<Channel> StartLatest(std::size_t num_bytes, bool is_encrypted, const M& message,
                                     const std::string& topic) {
  auto link = Link::Make(is_encrypted);
  if (link == nullptr) return nullptr;
  auto channel = std::make_unique<LatestChannel<M>>(num_bytes, std::move(link), message, topic);
  if (!channel->Start()) return nullptr;
  return channel;
}

class StateChannel final : public Channel {
 public:
  explicit StateChannel(std::unique_ptr<Link> link)
      : Channel(NameOf("STATE", link->is_encrypted), kSmallBytes), link_(std::move(link)) {
    writer_ = link_->near->WriteState<core::LogicStatus>(bus::kLogicStatusTopic);
    reader_ = &link_->far->ReadState<core::LogicStatus>(bus::kLogicStatusTopic);
    status_.hint = std::string(60, 'x');
  }
  bool Start() { return link_->Start(); }
  bool Send(std::int64_t now_ns) override {
    status_.time_ns = now_ns;
    return writer_.Set(status_);
  }
  std::int64_t Receive() override {
    const std::int64_t end_ns = Soon();
    do {
      link_->far->Wait(core::MonotonicNow_ns() + kPollPeriod_ns);
      if (reader_->is_fresh()) return reader_->value().time_ns;
    } while (core::MonotonicNow_ns() < end_ns);
    return 0;
  }

 private:
  std::unique_ptr<Link> link_;
  core::LogicStatus status_;
  bus::StateWriter<core::LogicStatus> writer_;
  bus::StateReader<core::LogicStatus>* reader_;
};

class EventChannel final : public Channel {
 public:
  explicit EventChannel(std::unique_ptr<Link> link)
      : Channel(NameOf("EVENT", link->is_encrypted), kSmallBytes), link_(std::move(link)) {
    link_->far->ReadEvents();
    event_.name = "bench";
    event_.detail = std::string(60, 'x');
  }
  bool Start() { return link_->Start(); }
  bool Send(std::int64_t now_ns) override {
    event_.time_ns = now_ns;
    return link_->near->Emit(event_);
  }
  std::int64_t Receive() override {
    const std::int64_t end_ns = Soon();
    core::Event event;
    do {
      while (link_->far->PollEvent(&event)) {
        if (event.name == event_.name) return event.time_ns;
      }
      link_->far->Wait(core::MonotonicNow_ns() + kPollPeriod_ns);
    } while (core::MonotonicNow_ns() < end_ns);
    return 0;
  }

 private:
  std::unique_ptr<Link> link_;
  core::Event event_;
};

template <class C>
std::unique_ptr<Channel> StartReliable(bool is_encrypted) {
  auto link = Link::Make(is_encrypted);
  if (link == nullptr) return nullptr;
  auto channel = std::make_unique<C>(std::move(link));
  if (!channel->Start()) return nullptr;
  return channel;
}

}  // namespace

Link::~Link() {
  near.reset();
  far.reset();
  registry.reset();
  std::error_code error;
  if (!keys.empty()) std::filesystem::remove_all(keys, error);
}

std::unique_ptr<Link> Link::Make(bool is_encrypted) {
  static std::atomic<int> num_made{0};
  auto link = std::make_unique<Link>();
  link->is_encrypted = is_encrypted;
  if (is_encrypted) {
    link->keys = std::filesystem::temp_directory_path() /
                 ("oos_bench_bus-" + std::to_string(getpid()) + "-" + std::to_string(num_made++));
    if (!bus::MakeKeys(link->keys, {"near", "far"})) return nullptr;
  }
  bus::RegistryOptions of_registry;
  of_registry.is_encrypted = is_encrypted;
  of_registry.keys = link->keys.string();
  auto registry = bus::Registry::Create(of_registry);
  if (!registry) return nullptr;
  link->registry = std::move(*registry);
  for (auto* node : {&link->near, &link->far}) {
    bus::NodeOptions& options = node == &link->near ? link->near_options : link->far_options;
    options.name = node == &link->near ? "near" : "far";
    options.registry = link->registry->endpoint();
    options.is_encrypted = is_encrypted;
    options.keys = link->keys.string();
    auto made = bus::Node::Create(options);
    if (!made) return nullptr;
    *node = std::move(*made);
  }
  return link;
}

bool Link::Start() {
  return near->Start(kStart_ns) && far->Start(kStart_ns) && near->WaitForPeers({"far"}, kStart_ns) &&
         far->WaitForPeers({"near"}, kStart_ns);
}

std::unique_ptr<Channel> MakeLatest(std::size_t num_bytes, bool is_encrypted) {
  if (num_bytes == kSheetBytes) {
    core::SheetState sheet;
    sheet.num_columns = 32;
    sheet.p_W.resize(core::kMaxSheetNodes);
    return StartLatest(num_bytes, is_encrypted, sheet, bus::SheetTopic("bench"));
  }
  if (num_bytes == kSmallBytes) {
    return StartLatest(num_bytes, is_encrypted, core::DeviceState{}, bus::DeviceStateTopic("bench"));
  }
  core::ContactSet contacts;
  contacts.planes.resize(core::kMaxContactPlanes);
  return StartLatest(num_bytes, is_encrypted, contacts, bus::ContactsTopic("near", "bench"));
}

std::unique_ptr<Channel> MakeState(bool is_encrypted) {
  return StartReliable<StateChannel>(is_encrypted);
}

std::unique_ptr<Channel> MakeEvent(bool is_encrypted) {
  return StartReliable<EventChannel>(is_encrypted);
}

}  // namespace transport
