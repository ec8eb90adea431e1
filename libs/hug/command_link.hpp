#pragma once

#include <array>
#include <cstdint>

#include "core/wrench.hpp"
#include "hug/faults.hpp"
#include "hug/noise.hpp"

namespace hug {

// What the motors shall apply, as it came through the safety filter.
struct ArmCommand {
  core::Wrench F_Do_W;
  double grip_force_N = 0.0;
  double brake_N_s_per_m = 0.0;
  double brake_Nm_s_per_rad = 0.0;
};

// The line from the bridge to an arm: commands come late, or not at all.
class CommandLink {
 public:
  CommandLink(double delay_s, std::uint64_t seed) : delay_s_(delay_s), noise_(seed) {}
  void Send(double time_s, const ArmCommand& command, const FaultSwitches& faults);
  // Takes over what has arrived by now.
  void Receive(double time_s);
  [[nodiscard]] const ArmCommand& newest() const { return newest_; }
  // Since the newest one was sent; 1e9: there was none.
  [[nodiscard]] double age_s(double time_s) const { return newest_number_ > 0 ? time_s - sent_s_ : 1e9; }

 private:
  struct Pending {
    double due_s = 0.0;
    double sent_s = 0.0;
    std::uint64_t number = 0;
    ArmCommand command;
  };
  static constexpr std::size_t kMost = 512;

  double delay_s_;
  Noise noise_;
  std::array<Pending, kMost> pending_;  // in no order
  std::size_t num_pending_ = 0;
  ArmCommand newest_;
  double sent_s_ = 0.0;  // of the newest
  std::uint64_t num_sent_ = 0;
  std::uint64_t newest_number_ = 0;  // 0: none yet
};

}  // namespace hug
