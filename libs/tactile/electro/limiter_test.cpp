#include "tactile/electro/limiter.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/clock.hpp"
#include "tactile/testing/hostile_stimulation.hpp"

namespace tactile {
namespace {

constexpr SkinCalibration kSkin{0.3e-3, 0.7e-3, 1.2e-3};

Limiter Ready(const SkinCalibration& skin = kSkin) {
  auto limiter = Limiter::Create({});
  EXPECT_TRUE(limiter);
  for (std::size_t i = 0; i < kNumElectrodes; ++i) EXPECT_TRUE(limiter->Calibrate(i, skin));
  limiter->Arm(0);
  for (std::size_t i = 0; i < kNumElectrodes; ++i) limiter->TakeImpedance(i, 10e3);
  return *limiter;
}

TEST(Limiter, GivesAHarmlessPulseAsItIs) {
  Limiter limiter = Ready();
  const auto pulse = limiter.Bound(1000 * core::kMillisecond_ns, 0, {0.6e-3, 80e-6});
  ASSERT_TRUE(pulse);
  EXPECT_EQ(pulse->current_A, 0.6e-3);
  EXPECT_EQ(pulse->width_s, 80e-6);
}

TEST(Limiter, NeverComesNearerToPainThanATenth) {
  Limiter limiter = Ready();
  EXPECT_NEAR(limiter.Bound(1000 * core::kMillisecond_ns, 0, {1.0, 50e-6})->current_A, 0.9 * 1.2e-3, 1e-12);
}

TEST(Limiter, BoundsPeakAndChargeWhateverAPersonBears) {
  Limiter limiter = Ready({0.3e-3, 0.7e-3, 1.0});
  EXPECT_NEAR(limiter.Bound(1000 * core::kMillisecond_ns, 0, {1.0, 10e-6})->current_A, 5e-3, 1e-12);
  EXPECT_NEAR(limiter.Bound(1001 * core::kMillisecond_ns, 1, {1.0, 90e-6})->current_A, 0.3e-6 / 90e-6, 1e-9);
}

// The figure of the research notes, with both phases: 30 Hz and nearly 100 us leave 0.65/sqrt(2 x 30 x 1e-4) / 10 mA.
TEST(Limiter, KeepsTheDensityOver30PulsesASecond) {
  Limiter limiter = Ready({0.3e-3, 0.7e-3, 4.0e-3});
  double A2s = 0.0, last_A = 0.0;
  for (int i = 0; i < 30; ++i) {
    const auto pulse = limiter.Bound((1000 + 33 * i) * core::kMillisecond_ns, 0, {0.9e-3, 99e-6});
    last_A = pulse ? pulse->current_A : 0.0;
    A2s += 2.0 * last_A * last_A * 99e-6;
    limiter.TakeImpedance(0, 10e3);
  }
  const double rms_mA_per_cm2 = 1e3 * std::sqrt(A2s) / 0.0325120;
  EXPECT_LE(rms_mA_per_cm2, 2.0 + 1e-9);
  EXPECT_GT(rms_mA_per_cm2, 1.99) << "and gives what it may";
  EXPECT_LT(last_A, 0.9e-3);
}

TEST(Limiter, RefusesWhatItCannotProveSafe) {
  const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
  for (const Pulse& wrong :
       {Pulse{nan, 50e-6}, Pulse{inf, 50e-6}, Pulse{-1e-3, 50e-6}, Pulse{0.0, 50e-6}, Pulse{1e-3, nan},
        Pulse{1e-3, 0.0}, Pulse{1e-3, 100e-6}, Pulse{1e-3, 100 * 1e-6}, Pulse{1e-3, 1.0}}) {
    EXPECT_FALSE(Ready().Bound(1000 * core::kMillisecond_ns, 0, wrong)) << wrong.current_A << " " << wrong.width_s;
  }
  EXPECT_FALSE(Ready().Bound(1000 * core::kMillisecond_ns, 8, {0.5e-3, 50e-6}));
  EXPECT_FALSE(Ready().Bound(-1, 0, {0.5e-3, 50e-6})) << "before it was armed";
  auto bare = Limiter::Create({});
  bare->Arm(0);
  bare->TakeImpedance(0, 10e3);
  EXPECT_FALSE(bare->Bound(1000 * core::kMillisecond_ns, 0, {0.5e-3, 50e-6})) << "not calibrated";
  bare->Calibrate(0, kSkin);
  bare->Arm(0);
  EXPECT_FALSE(bare->Bound(1000 * core::kMillisecond_ns, 0, {0.5e-3, 50e-6})) << "impedance unknown";
  bare->TakeImpedance(0, 10e3);
  EXPECT_TRUE(bare->Bound(1000 * core::kMillisecond_ns, 0, {0.5e-3, 50e-6}));
  EXPECT_FALSE(bare->Bound(1100 * core::kMillisecond_ns, 0, {0.5e-3, 50e-6})) << "not measured since";
  bare->TakeImpedance(0, 10e3);
  EXPECT_FALSE(bare->Bound(999 * core::kMillisecond_ns, 0, {0.5e-3, 50e-6})) << "time runs backwards";
  bare->Disarm();
  bare->TakeImpedance(0, 10e3);
  EXPECT_FALSE(bare->Bound(1200 * core::kMillisecond_ns, 0, {0.5e-3, 50e-6})) << "disarmed";
}

TEST(Limiter, PulsesKeepTheirDistanceAndNeverOverlap) {
  Limiter limiter = Ready();
  const Pulse pulse{0.5e-3, 50e-6};
  ASSERT_TRUE(limiter.Bound(1000 * core::kMillisecond_ns, 0, pulse));
  limiter.TakeImpedance(0, 10e3);
  EXPECT_FALSE(limiter.Bound(1000 * core::kMillisecond_ns + 399'999, 1, pulse)) << "another electrode's";
  EXPECT_TRUE(limiter.Bound(1000 * core::kMillisecond_ns + 400'000, 1, pulse));
  EXPECT_FALSE(limiter.Bound(1002 * core::kMillisecond_ns, 0, pulse)) << "500 Hz";
  EXPECT_TRUE(limiter.Bound(1000 * core::kMillisecond_ns + 2'500'000, 0, pulse)) << "400 Hz";
}

TEST(Limiter, CurrentGrowsOver200msOnceItIsArmed) {
  Limiter limiter = Ready();
  EXPECT_FALSE(limiter.Bound(0, 0, {1e-3, 50e-6}));
  EXPECT_NEAR(limiter.Bound(50 * core::kMillisecond_ns, 0, {1e-3, 50e-6})->current_A, 0.25 * 0.9 * 1.2e-3, 1e-12);
}

TEST(Limiter, AJumpOrAnOpenElectrodeStopsAllWithTheNextPulse) {
  struct Case {
    double impedance_Ohm;
    StopCause cause;
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const Case& c : {Case{16e3, StopCause::kImpedanceJumped}, Case{6e3, StopCause::kImpedanceJumped},
                        Case{201e3, StopCause::kOpenElectrode}, Case{nan, StopCause::kOpenElectrode},
                        Case{-1.0, StopCause::kOpenElectrode}}) {
    Limiter limiter = Ready();
    ASSERT_TRUE(limiter.Bound(1000 * core::kMillisecond_ns, 0, {0.5e-3, 50e-6}));
    limiter.TakeImpedance(0, c.impedance_Ohm);
    EXPECT_EQ(limiter.stopped_by(), c.cause);
    for (std::size_t i = 0; i < kNumElectrodes; ++i) {
      EXPECT_FALSE(limiter.Bound((1100 + static_cast<std::int64_t>(i)) * core::kMillisecond_ns, i, {0.5e-3, 50e-6}));
    }
    limiter.TakeImpedance(0, 10e3);
    limiter.Arm(1200 * core::kMillisecond_ns);
    EXPECT_FALSE(limiter.Bound(1300 * core::kMillisecond_ns, 0, {0.5e-3, 50e-6})) << "not before it was disarmed";
    limiter.Disarm();
    limiter.Arm(1300 * core::kMillisecond_ns);
    limiter.TakeImpedance(0, 16e3);
    EXPECT_TRUE(limiter.Bound(1600 * core::kMillisecond_ns, 0, {0.5e-3, 50e-6}));
  }
}

TEST(Limiter, SlowDriftOfImpedanceGoesOn) {
  Limiter limiter = Ready();
  double impedance_Ohm = 10e3;
  for (int i = 0; i < 20; ++i) {
    EXPECT_TRUE(limiter.Bound((1000 + 20 * i) * core::kMillisecond_ns, 0, {0.3e-3, 50e-6})) << i;
    limiter.TakeImpedance(0, impedance_Ohm *= 1.1);
  }
}

TEST(Limiter, ACalibrationThatMakesNoSenseIsNone) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const SkinCalibration& wrong :
       {SkinCalibration{0.7e-3, 0.3e-3, 1.2e-3}, SkinCalibration{0.3e-3, 1.15e-3, 1.2e-3},
        SkinCalibration{nan, 0.7e-3, 1.2e-3}, SkinCalibration{0.3e-3, 0.7e-3, nan}, SkinCalibration{0, 0.7e-3, 1.2e-3},
        SkinCalibration{0.3e-3, 0.7e-3, std::numeric_limits<double>::infinity()}}) {
    Limiter limiter = Ready();
    EXPECT_FALSE(limiter.Calibrate(0, wrong));
    limiter.Arm(0);
    limiter.TakeImpedance(0, 10e3);
    EXPECT_FALSE(limiter.Bound(1000 * core::kMillisecond_ns, 0, {0.3e-3, 50e-6})) << "nor is the one before";
  }
}

TEST(Limiter, CanBeTightenedNotLoosened) {
  const StimulationLimits most;
  const auto with = [&](auto change) {
    StimulationLimits limits = most;
    change(&limits);
    return Limiter::Create(limits).has_value();
  };
  EXPECT_TRUE(with([](StimulationLimits* l) { l->peak_A *= 0.5; }));
  EXPECT_FALSE(with([](StimulationLimits* l) { l->peak_A *= 1.01; }));
  EXPECT_FALSE(with([](StimulationLimits* l) { l->width_s *= 1.01; }));
  EXPECT_FALSE(with([](StimulationLimits* l) { l->charge_C *= 1.01; }));
  EXPECT_FALSE(with([](StimulationLimits* l) { l->rms_A_per_m2 *= 1.01; }));
  EXPECT_FALSE(with([](StimulationLimits* l) { l->area_m2 *= 1.01; }));
  EXPECT_FALSE(with([](StimulationLimits* l) { l->rate_Hz *= 1.01; }));
  EXPECT_FALSE(with([](StimulationLimits* l) { l->peak_A = std::numeric_limits<double>::quiet_NaN(); }));
}

TEST(Limiter, NothingHostileGetsOverALimit) {
  const HostileOutcome outcome = RunHostileStimulation(100'000, 1);
  EXPECT_EQ(outcome.first_wrong, "");
  EXPECT_GT(outcome.pulses, 1'000u) << "much is refused, but not all";
  EXPECT_GT(outcome.stops, 50u);
}

}  // namespace
}  // namespace tactile
