#include "bus/log/step_log.hpp"

#include <algorithm>
#include <cerrno>
#include <ctime>
#include <utility>

namespace bus::log {
namespace {

// Twice per 100 ms, the most that a kill may lose.
constexpr std::int64_t kDrainPeriod_ns = 50'000'000;

}  // namespace

core::Result<std::unique_ptr<StepFile>> StepFile::Create(const std::filesystem::path& path) {
  auto writer = McapWriter::Create(path, {"", "vr-oos"});
  if (!writer) return tl::unexpected(writer.error());
  return std::unique_ptr<StepFile>(new StepFile(std::move(*writer)));
}

std::uint16_t StepFile::AddNode(const std::string& node, const std::string& fields, const TextMap& about) {
  const std::uint16_t schema = writer_->AddSchema("oos.Step." + node, "oos-fields", {fields.begin(), fields.end()});
  if (auto done = writer_->Write(Metadata{"replay/" + node, about}); !done && first_failure_) first_failure_ = done;
  return writer_->AddChannel(schema, StepTopic(node), "oos-step", {{"writer", node}});
}

core::Result<void> StepFile::Attach(const std::string& name, const std::vector<std::uint8_t>& bytes) {
  return writer_->Write(Attachment{0, 0, name, "application/octet-stream", bytes});
}

core::Result<void> StepFile::Write(std::uint16_t channel, std::uint64_t tick, std::int64_t now_ns,
                                   std::span<const std::uint8_t> step) {
  if (!first_failure_) return first_failure_;
  const auto time_ns = static_cast<std::uint64_t>(std::max<std::int64_t>(now_ns, 0));
  return writer_->Write(
      Message{channel, static_cast<std::uint32_t>(tick), time_ns, time_ns, {step.begin(), step.end()}});
}

core::Result<void> StepFile::WriteLoss(const std::string& node, std::uint64_t count, std::int64_t now_ns) {
  return writer_->Write(Metadata{"dropped",
                                 {{"node", node},
                                  {"count", std::to_string(count)},
                                  {"until_ns", std::to_string(now_ns)},
                                  {"why", "the ring of steps was full: the disk was too slow"}}});
}

core::Result<void> StepFile::Close() {
  return first_failure_ ? writer_->Close() : first_failure_;
}

StepLog::StepLog(std::unique_ptr<StepFile> file, std::string node, std::uint16_t channel)
    : file_(std::move(file)), node_(std::move(node)), channel_(channel) {
  slot_ = tap_.AddTopic({TapKind::kStep, StepTopic(node_), TopicClass::kControl, "", ""});
  sem_init(&wake_, 0, 0);
  thread_ = std::thread([this] { Run(); });
}

StepLog::~StepLog() {
  (void)Close();
  sem_destroy(&wake_);
}

core::Result<void> StepLog::Close() {
  if (thread_.joinable()) {
    is_stopping_.store(true);
    sem_post(&wake_);
    thread_.join();
  }
  return done_;
}

bool StepLog::Push(std::uint64_t tick, std::int64_t now_ns, std::span<const std::uint8_t> step) noexcept {
  const std::uint64_t num_lost_before = num_lost();
  tap_.Put(slot_, tick, now_ns, now_ns, {}, step);
  return num_lost() == num_lost_before;
}

void StepLog::Run() {
  timespec next{};
  clock_gettime(CLOCK_MONOTONIC, &next);
  while (!is_stopping_.load()) {
    next.tv_nsec += kDrainPeriod_ns;
    if (next.tv_nsec >= 1'000'000'000) {
      next.tv_nsec -= 1'000'000'000;
      ++next.tv_sec;
    }
    while (sem_clockwait(&wake_, CLOCK_MONOTONIC, &next) != 0 && errno == EINTR) {
    }
    Drain();
  }
  Drain();
  if (done_) done_ = file_->Close();
}

void StepLog::Drain() {
  std::int64_t last_ns = 0;
  tap_.Drain([&](const TapHead& entry, std::span<const std::uint8_t>, std::span<const std::uint8_t> step) {
    last_ns = entry.time_ns;
    if (done_) done_ = file_->Write(channel_, entry.sequence, entry.time_ns, step);
  });
  const std::uint64_t lost = num_lost();
  if (done_ && lost > reported_lost_)
    done_ = file_->WriteLoss(node_, lost - std::exchange(reported_lost_, lost), last_ns);
  if (done_) done_ = file_->Flush();
}

}  // namespace bus::log
