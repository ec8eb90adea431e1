#include "hug/command_link.hpp"

namespace hug {

void CommandLink::Send(double time_s, const ArmCommand& command, const FaultSwitches& faults) {
  const double loss = faults.Amount(FaultKind::kLoss, time_s);
  if (loss > 0.0 && noise_.Even() < loss) return;
  if (num_pending_ == kMost) return;  // a line that is half a second behind loses what comes
  double late_s = delay_s_ + faults.Amount(FaultKind::kDelay, time_s);
  const double jitter_s = faults.Amount(FaultKind::kJitter, time_s);
  if (jitter_s > 0.0) late_s += jitter_s * noise_.Even();
  pending_[num_pending_++] = {time_s + late_s, time_s, ++num_sent_, command};
}

void CommandLink::Receive(double time_s) {
  for (std::size_t i = 0; i < num_pending_;) {
    if (pending_[i].due_s > time_s + 1e-12) {
      ++i;
      continue;
    }
    // One that was overtaken on its way is old news.
    if (pending_[i].number > newest_number_) {
      newest_ = pending_[i].command;
      sent_s_ = pending_[i].sent_s;
      newest_number_ = pending_[i].number;
    }
    pending_[i] = pending_[--num_pending_];
  }
}

}  // namespace hug
