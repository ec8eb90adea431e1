#pragma once

#include <cstddef>
#include <cstdint>

#include "muscle/emg_frame.hpp"

namespace muscle {

enum class EmgFault : std::uint8_t { kNone, kElectrodeOff, kSaturated, kMainsHum };
const char* NameOf(EmgFault fault);

// Finds what is wrong with a channel, in windows of 100 ms, five periods of 50 Hz: a fault is there once two windows in
// a row have it, and gone once two have not.
class FaultWatch {
 public:
  // `raw_V` as it came, `band_V` after the band-pass.
  void Step(double raw_V, double band_V);
  [[nodiscard]] EmgFault fault() const { return fault_; }

  static constexpr int kWindow = 100;
  // Quieter than the noise of skin under an electrode, some 5 uV.
  static constexpr double kOff_V = 1.5e-6;
  static constexpr double kSaturatedShare = 0.05;  // of samples at the amplifier's end
  // Of the band's power, in 50 Hz. A muscle has some hundredths there, in a window of this length.
  static constexpr double kHumShare = 0.5;

 private:
  [[nodiscard]] EmgFault Judge() const;

  EmgFault fault_ = EmgFault::kNone;
  EmgFault last_ = EmgFault::kNone;  // of the window before
  int count_ = 0;
  int num_at_end_ = 0;
  double sum_V2_ = 0.0;
  double cosine_V_ = 0.0, sine_V_ = 0.0;  // of 50 Hz
};

}  // namespace muscle
