#include "tactile/usb_driver.hpp"

#include <algorithm>
#include <utility>

namespace tactile {

const char* NameOf(DriverStatus status) {
  switch (status) {
    case DriverStatus::kWaiting:
      return "waiting";
    case DriverStatus::kAlive:
      return "alive";
    case DriverStatus::kNotAnswering:
      return "not answering";
    case DriverStatus::kGone:
      return "gone";
  }
  return "";
}

UsbDriver::UsbDriver(UsbTable table, std::unique_ptr<UsbTransport> transport)
    : table_(std::move(table)), transport_(std::move(transport)) {}

UsbDriver::~UsbDriver() {
  Stop();
}

void UsbDriver::Turn(std::int64_t now_ns) {
  if (!is_open_) LookForDevice(now_ns);
  if (is_open_) Send(now_ns);
}

void UsbDriver::Stop() {
  if (!is_open_) return;
  EncodeFrame(table_, {}, &frame_);
  transport_->Write(frame_, kTimeout_ms);
  LetGo(DriverStatus::kWaiting);
}

void UsbDriver::LookForDevice(std::int64_t now_ns) {
  if (now_ns < next_scan_ns_) return;
  next_scan_ns_ = now_ns + kScan_ns;
  if (!transport_->Open(table_)) return;
  is_open_ = true;
  failures_ = 0;
  sent_.clear();
  SetUp();
}

void UsbDriver::SetUp() {
  for (const ControlRequest& request : table_.setup) {
    const UsbOutcome outcome = transport_->Control(request, 5 * kTimeout_ms);
    if (outcome == UsbOutcome::kDone) continue;
    ++state_.errors;
    LetGo(outcome == UsbOutcome::kGone ? DriverStatus::kGone : DriverStatus::kNotAnswering);
    return;
  }
}

void UsbDriver::LetGo(DriverStatus status) {
  transport_->Close();
  is_open_ = false;
  state_.status = status;
  state_.levels = {};
}

void UsbDriver::Send(std::int64_t now_ns) {
  const Strengths wanted = now_ns - strengths_.made_ns <= kSilence_ns ? strengths_ : Strengths{};
  EncodeFrame(table_, wanted.levels, &frame_);
  const bool is_off =
      std::all_of(wanted.levels.begin(), wanted.levels.end(), [](float level) { return level == 0.0f; });
  const std::int64_t age_ns = now_ns - sent_ns_;
  if (frame_ == sent_ && age_ns < (is_off ? kIdle_ns : table_.period_ns)) return;
  const UsbOutcome outcome = transport_->Write(frame_, kTimeout_ms);
  if (outcome != UsbOutcome::kDone) {
    TakeFailure(outcome);
    return;
  }
  ++state_.frames;
  state_.status = DriverStatus::kAlive;
  state_.levels = wanted.levels;
  failures_ = 0;
  sent_ns_ = now_ns;
  sent_ = frame_;
}

// The next turn tries again: what the motors do now is not known.
void UsbDriver::TakeFailure(UsbOutcome outcome) {
  ++state_.errors;
  sent_.clear();
  if (outcome == UsbOutcome::kGone) return LetGo(DriverStatus::kGone);
  if (outcome == UsbOutcome::kStall) transport_->ClearStall();
  state_.status = DriverStatus::kNotAnswering;
  if (++failures_ >= kMostFailures) LetGo(DriverStatus::kNotAnswering);
}

}  // namespace tactile
