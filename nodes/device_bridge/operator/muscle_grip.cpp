#include "nodes/device_bridge/operator/muscle_grip.hpp"

#include <algorithm>

namespace device_bridge {
namespace {

constexpr int kCalibrationPart = 3000;  // samples
constexpr int kRestBefore = 2000;

}  // namespace

core::Result<std::optional<MuscleGrip>> MuscleGrip::Create(const scene::Device& device, std::uint64_t seed) {
  for (const auto& [name, value] : device.options) {
    if (name != "muscle") continue;
    if (value == "simulated") return MuscleGrip(seed);
    return core::Fail(core::ErrorCode::kUnsupported, "device '" + device.role + "': option muscle is '" + value +
                                                         "', and only simulated muscles are known");
  }
  return std::optional<MuscleGrip>();
}

MuscleGrip::MuscleGrip(std::uint64_t seed) : muscle_(seed) {
  using Part = muscle::EmgCalibrator::Part;
  muscle::EmgCalibrator calibrator;
  for (const auto& [part, activation] : {std::pair{Part::kRest, 0.0}, std::pair{Part::kMost, 1.0}}) {
    for (int i = 0; i < kCalibrationPart; ++i) {
      estimate_.Step(muscle_.Step(activation));
      calibrator.Add(part, estimate_.envelopes_V());
    }
  }
  if (const auto calibration = calibrator.result()) estimate_.Calibrate(*calibration);
  for (int i = 0; i < kRestBefore; ++i) estimate_.Step(muscle_.Step(0.0));
}

double MuscleGrip::Step(double wanted_N) noexcept {
  estimate_.Step(muscle_.Step(std::clamp(wanted_N / kStrongest_N, 0.0, 1.0)));
  return map_.Step(estimate_.share());
}

}  // namespace device_bridge
