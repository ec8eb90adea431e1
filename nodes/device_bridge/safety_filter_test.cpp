#include "nodes/device_bridge/safety_filter.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <random>

#include "core/clock.hpp"

namespace device_bridge {
namespace {

DeviceReading Held() {
  DeviceReading reading;
  reading.is_engaged = true;
  return reading;
}

core::DeviceCommand Command(std::uint64_t sequence, const glm::dvec3& force_N) {
  core::DeviceCommand command;
  command.header.sequence = sequence;
  command.F_Do_W.force_N = force_N;
  return command;
}

// A filter past its start ramp with `force_N` acting, at time *now_ns, sequence *sequence.
SafetyFilter Running(const glm::dvec3& force_N, std::int64_t* now_ns, std::uint64_t* sequence,
                     const FilterLimits& limits = {}) {
  SafetyFilter filter = *SafetyFilter::Create(limits);
  for (int i = 0; i < 1200; ++i) {
    *now_ns += core::kMillisecond_ns;
    filter.Accept(Command(++*sequence, force_N), *now_ns);
    filter.Apply(*now_ns, Held());
  }
  return filter;
}

TEST(SafetyFilter, PassesAValidCommandUnchanged) {
  std::int64_t now_ns = 0;
  std::uint64_t sequence = 0;
  SafetyFilter filter = Running({3, -4, 12}, &now_ns, &sequence);
  const FilteredForce out = filter.Apply(now_ns + core::kMillisecond_ns, Held());
  EXPECT_EQ(out.F_Do_W().force_N, glm::dvec3(3, -4, 12));
  EXPECT_EQ(filter.status(), kFilterOk);
  EXPECT_EQ(out.brake_N_s_per_m(), 0.0);
}

// The output follows the command; one that is always across it must not keep it alive.
TEST(SafetyFilter, IsGoneTwentyMillisecondsAfterTheDeadManWhereverTheCommandJumps) {
  std::int64_t now_ns = 0;
  std::uint64_t sequence = 0;
  FilterLimits slow;
  slow.max_force_rate_N_per_s = 500.0;
  SafetyFilter filter = Running({50, 0, 0}, &now_ns, &sequence, slow);
  glm::dvec3 out_N(50, 0, 0);
  for (int i = 0; i <= 20; ++i) {
    now_ns += core::kMillisecond_ns;
    filter.Accept(Command(++sequence, 1e3 * glm::cross(out_N, glm::dvec3(0, 0, 1))), now_ns);
    out_N = filter.Apply(now_ns, DeviceReading{}).F_Do_W().force_N;
  }
  EXPECT_LT(glm::length(out_N), 1e-9);
}

TEST(SafetyFilter, AnOriginOfAnyTimeNeitherKeepsNorOverflowsTheAge) {
  for (const std::int64_t origin_ns :
       {std::numeric_limits<std::int64_t>::min(), std::int64_t{-1}, std::numeric_limits<std::int64_t>::max()}) {
    SafetyFilter filter = *SafetyFilter::Create(FilterLimits{});
    std::int64_t now_ns = 1'000'000'000'000;
    core::DeviceCommand command = Command(1, {10, 0, 0});
    command.header.direct = {7, origin_ns, {}};
    filter.Accept(command, now_ns);
    for (int i = 0; i < 100; ++i) filter.Apply(now_ns += core::kMillisecond_ns, Held());
    EXPECT_NE(filter.status() & kSilent, 0U) << origin_ns;
    EXPECT_EQ(filter.Apply(now_ns, Held()).F_Do_W().force_N.x, 0.0);
  }
}

TEST(SafetyFilter, StartsWithARampOfOneSecond) {
  SafetyFilter filter = *SafetyFilter::Create(FilterLimits{});
  std::int64_t now_ns = 0;
  double previous = 0.0;
  for (int i = 1; i <= 1000; ++i) {
    now_ns += core::kMillisecond_ns;
    filter.Accept(Command(static_cast<std::uint64_t>(i), {10, 0, 0}), now_ns);
    const double force_N = filter.Apply(now_ns, Held()).F_Do_W().force_N.x;
    EXPECT_GE(force_N, previous);
    EXPECT_LE(force_N, 10.0 * i / 1000.0 + 1e-9);
    previous = force_N;
  }
  EXPECT_GT(previous, 9.9);
}

TEST(SafetyFilter, SilenceHoldsThenFadesToZeroWithin60Ms) {
  std::int64_t now_ns = 0;
  std::uint64_t sequence = 0;
  SafetyFilter filter = Running({0, 0, 24}, &now_ns, &sequence);
  for (std::int64_t silent_ns = 0; silent_ns <= 80 * core::kMillisecond_ns; silent_ns += core::kMillisecond_ns / 4) {
    const FilteredForce out = filter.Apply(now_ns + silent_ns, Held());
    const double force_N = out.F_Do_W().force_N.z;
    if (silent_ns <= 10 * core::kMillisecond_ns) {
      EXPECT_EQ(force_N, 24.0);
    } else if (silent_ns < 58 * core::kMillisecond_ns) {
      EXPECT_NEAR(force_N, 24.0 * (1.0 - (silent_ns - 10e6) / 48e6), 0.02);
      EXPECT_GT(out.brake_N_s_per_m(), 0.0);
      EXPECT_TRUE(filter.status() & kDegraded);
    } else {
      EXPECT_EQ(force_N, 0.0);
      EXPECT_TRUE(filter.status() & kSilent);
    }
  }
  EXPECT_EQ(filter.first_cause(), kDegraded);
}

TEST(SafetyFilter, KeepsTheFirstCauseOfALossOfForce) {
  std::int64_t now_ns = 0;
  std::uint64_t sequence = 0;
  SafetyFilter filter = Running({0, 0, 24}, &now_ns, &sequence);
  filter.Apply(now_ns + 15 * core::kMillisecond_ns, Held());
  const std::int64_t first_ns = filter.first_cause_ns();
  DeviceReading released;
  filter.Apply(now_ns + 90 * core::kMillisecond_ns, released);
  EXPECT_EQ(filter.first_cause(), kDegraded);
  EXPECT_EQ(filter.first_cause_ns(), first_ns);
}

TEST(SafetyFilter, ARepeatedOldForceCountsAsSilence) {
  std::int64_t now_ns = 0;
  std::uint64_t sequence = 0;
  SafetyFilter filter = Running({0, 0, 24}, &now_ns, &sequence);
  const std::int64_t origin_ns = now_ns;  // every later command is computed from this one sample
  double force_N = 0.0;
  for (int i = 0; i < 100; ++i) {
    now_ns += core::kMillisecond_ns;
    core::DeviceCommand command = Command(++sequence, {0, 0, 24});
    command.header.direct.id = core::MakeTraceId(0, 7);
    command.header.direct.origin_ns = origin_ns;
    filter.Accept(command, now_ns);
    force_N = filter.Apply(now_ns, Held()).F_Do_W().force_N.z;
  }
  EXPECT_EQ(force_N, 0.0);
}

TEST(SafetyFilter, DuplicateAndReorderedCommandsCountAsSilence) {
  std::int64_t now_ns = 0;
  std::uint64_t sequence = 0;
  SafetyFilter filter = Running({5, 0, 0}, &now_ns, &sequence);
  for (int i = 0; i < 60; ++i) {
    now_ns += core::kMillisecond_ns;
    filter.Accept(Command(sequence - static_cast<std::uint64_t>(i % 3), {-40, 0, 0}), now_ns);  // same or older numbers
    const double force_N = filter.Apply(now_ns, Held()).F_Do_W().force_N.x;
    EXPECT_GE(force_N, 0.0) << "an old command was obeyed";
    EXPECT_TRUE(filter.status() & kRefused);
  }
  EXPECT_EQ(filter.Apply(now_ns, Held()).F_Do_W().force_N.x, 0.0);
  // The same datagram again is refused after silence too.
  filter.Accept(Command(sequence, {-40, 0, 0}), now_ns);
  EXPECT_FALSE(filter.was_accepted());
}

TEST(SafetyFilter, AcceptsARestartedSourceAfterSilenceWithARamp) {
  std::int64_t now_ns = 0;
  std::uint64_t sequence = 0;
  SafetyFilter filter = Running({5, 0, 0}, &now_ns, &sequence);
  now_ns += 100 * core::kMillisecond_ns;
  filter.Apply(now_ns, Held());
  double first = -1.0;
  double last = 0.0;
  for (std::uint64_t i = 1; i <= 250; ++i) {
    now_ns += core::kMillisecond_ns;
    filter.Accept(Command(i, {5, 0, 0}), now_ns);
    last = filter.Apply(now_ns, Held()).F_Do_W().force_N.x;
    if (first < 0.0) first = last;
  }
  EXPECT_LT(first, 0.5);
  EXPECT_EQ(last, 5.0);
}

TEST(SafetyFilter, ACommandThatIsNotFiniteIsAFaultUntilTheDeadManIsPressedAgain) {
  std::int64_t now_ns = 0;
  std::uint64_t sequence = 0;
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    SafetyFilter filter = Running({0, 20, 0}, &now_ns, &sequence);
    filter.Accept(Command(++sequence, {0, bad, 0}), now_ns + core::kMillisecond_ns);
    double force_N = 1.0;
    for (int i = 1; i <= 100; ++i) {
      now_ns += core::kMillisecond_ns;
      filter.Accept(Command(++sequence, {0, 20, 0}), now_ns);
      force_N = filter.Apply(now_ns, Held()).F_Do_W().force_N.y;
      if (i >= 21) {
        EXPECT_EQ(force_N, 0.0) << i;
      }
    }
    EXPECT_TRUE(filter.status() & kNotFinite);
    EXPECT_EQ(filter.first_cause(), kNotFinite);
    filter.Apply(now_ns, DeviceReading{});  // let go
    for (int i = 0; i < 1100; ++i) {
      now_ns += core::kMillisecond_ns;
      filter.Accept(Command(++sequence, {0, 20, 0}), now_ns);
      force_N = filter.Apply(now_ns, Held()).F_Do_W().force_N.y;
    }
    EXPECT_EQ(force_N, 20.0);
  }
}

TEST(SafetyFilter, ReleasingTheDeadManRemovesTheForceWithin20Ms) {
  std::int64_t now_ns = 0;
  std::uint64_t sequence = 0;
  SafetyFilter filter = Running({30, 0, 0}, &now_ns, &sequence);
  double force_N = 30.0;
  for (int i = 1; i <= 20; ++i) {
    now_ns += core::kMillisecond_ns;
    filter.Accept(Command(++sequence, {30, 0, 0}), now_ns);
    force_N = filter.Apply(now_ns, DeviceReading{}).F_Do_W().force_N.x;
  }
  EXPECT_NEAR(force_N, 0.0, 1e-9);
}

TEST(SafetyFilter, LimitsTheNormAndKeepsTheDirectionEvenOf1e300) {
  std::int64_t now_ns = 0;
  std::uint64_t sequence = 0;
  SafetyFilter filter = Running({3e300, 0, -4e300}, &now_ns, &sequence);
  const glm::dvec3 force_N = filter.Apply(now_ns, Held()).F_Do_W().force_N;
  EXPECT_NEAR(force_N.x, 30.0, 1e-9);
  EXPECT_NEAR(force_N.z, -40.0, 1e-9);
  EXPECT_LE(glm::length(force_N), 50.0);
  EXPECT_TRUE(filter.status() & kForceLimited);
}

TEST(SafetyFilter, LimitsTheRate) {
  std::int64_t now_ns = 0;
  std::uint64_t sequence = 0;
  SafetyFilter filter = Running({-50, 0, 0}, &now_ns, &sequence);
  now_ns += core::kMillisecond_ns;
  filter.Accept(Command(++sequence, {50, 0, 0}), now_ns);
  EXPECT_NEAR(filter.Apply(now_ns, Held()).F_Do_W().force_N.x, -50.0 + 20.0, 1e-9);  // 20 kN/s for 1 ms
  EXPECT_TRUE(filter.status() & kRateLimited);
}

TEST(SafetyFilter, LimitsPowerIntoTheHandButNotResistance) {
  std::int64_t now_ns = 0;
  std::uint64_t sequence = 0;
  FilterLimits limits;
  limits.max_power_W = 5.0;
  SafetyFilter filter = Running({20, 0, 0}, &now_ns, &sequence);
  filter.Tighten(limits);
  DeviceReading moving = Held();
  moving.V_WD.linear_m_per_s = {0.5, 0, 0};
  EXPECT_NEAR(filter.Apply(now_ns, moving).F_Do_W().force_N.x, 10.0, 1e-9);
  EXPECT_TRUE(filter.status() & kPowerLimited);
  moving.V_WD.linear_m_per_s = {-0.5, 0, 0};  // the hand pushes against it
  now_ns += core::kMillisecond_ns;
  EXPECT_NEAR(filter.Apply(now_ns, moving).F_Do_W().force_N.x, 20.0, 1e-9);
}

TEST(SafetyFilter, BrakesAFastArm) {
  std::int64_t now_ns = 0;
  std::uint64_t sequence = 0;
  SafetyFilter filter = Running({20, 0, 0}, &now_ns, &sequence);
  DeviceReading fast = Held();
  fast.V_WD.linear_m_per_s = {0, 1.0, 0};
  EXPECT_GT(filter.Apply(now_ns, fast).brake_N_s_per_m(), 0.0);
  fast.V_WD.linear_m_per_s = {0, 2.0, 0};
  EXPECT_EQ(glm::length(filter.Apply(now_ns, fast).F_Do_W().force_N), 0.0);
}

TEST(SafetyFilter, CanBeTightenedButNeverLoosened) {
  SafetyFilter filter = *SafetyFilter::Create(FilterLimits{});
  FilterLimits wide;
  wide.max_force_N = 500.0;
  wide.max_torque_Nm = std::numeric_limits<double>::quiet_NaN();
  wide.hold_ns = 1'000'000'000;
  wide.start_ramp_ns = 0;
  filter.Tighten(wide);
  EXPECT_EQ(filter.limits().max_force_N, 50.0);
  EXPECT_EQ(filter.limits().max_torque_Nm, 8.0);
  EXPECT_EQ(filter.limits().hold_ns, 10 * core::kMillisecond_ns);
  EXPECT_EQ(filter.limits().start_ramp_ns, 1000 * core::kMillisecond_ns);
  FilterLimits narrow;
  narrow.max_force_N = 12.0;
  filter.Tighten(narrow);
  EXPECT_EQ(filter.limits().max_force_N, 12.0);
}

TEST(SafetyFilter, RefusesInvalidLimits) {
  FilterLimits limits;
  limits.max_force_N = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(SafetyFilter::Create(limits));
  limits.max_force_N = 5000.0;
  EXPECT_FALSE(SafetyFilter::Create(limits));
  limits.max_force_N = -1.0;
  const auto refused = SafetyFilter::Create(limits);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().detail.find("max_force_N"), std::string::npos);
}

// A double of any bit pattern: NaN, infinities, denormals, 1e308 and ordinary figures.
double AnyDouble(std::mt19937_64& random) {
  const std::uint64_t bits = random();
  if (bits % 4 == 0) {
    double value = 0.0;
    const std::uint64_t pattern = random();
    std::memcpy(&value, &pattern, sizeof value);
    return value;
  }
  return (static_cast<double>(random() % 2'000'001) - 1.0e6) * 1e-4;
}

TEST(SafetyFilter, HoldsItsLimitsInEverySampleOf100000RandomCommandStreams) {
  std::mt19937_64 random(20240607);
  std::uint64_t num_samples = 0;
  std::uint64_t num_acting = 0;
  for (int stream = 0; stream < 100'000; ++stream) {
    FilterLimits limits;
    limits.start_ramp_ns = static_cast<std::int64_t>(random() % 3) * core::kMillisecond_ns;
    limits.restart_ramp_ns = static_cast<std::int64_t>(random() % 3) * core::kMillisecond_ns;
    limits.max_force_N = 1.0 + static_cast<double>(random() % 100);
    limits.max_torque_Nm = 0.1 + static_cast<double>(random() % 100) * 0.1;
    SafetyFilter filter = *SafetyFilter::Create(limits);
    const bool is_wild = random() % 2 == 0;
    std::int64_t now_ns = static_cast<std::int64_t>(random() % 1000) * core::kMillisecond_ns;
    std::int64_t last_good_ns = now_ns - 1000 * core::kMillisecond_ns;
    std::int64_t latest_ns = now_ns;
    std::int64_t previous_ns = now_ns;
    glm::dvec3 previous_N(0.0);
    filter.Apply(now_ns, Held());  // starts its clock
    for (int i = 0; i < 40; ++i) {
      now_ns += static_cast<std::int64_t>(random() % 4) * core::kMillisecond_ns / 2;
      if (random() % 32 == 0) now_ns += static_cast<std::int64_t>(random() % 80) * core::kMillisecond_ns;
      if (is_wild && random() % 32 == 0) now_ns -= static_cast<std::int64_t>(random() % 5) * core::kMillisecond_ns;
      latest_ns = std::max(latest_ns, now_ns);
      if (random() % 4 != 0) {
        core::DeviceCommand command = Command(static_cast<std::uint64_t>(i) + random() % 4, {});
        for (int axis = 0; axis < 3; ++axis) {
          command.F_Do_W.force_N[axis] = is_wild ? AnyDouble(random) : (static_cast<double>(random() % 401) - 200.0);
          command.F_Do_W.torque_Nm[axis] = is_wild ? AnyDouble(random) : (static_cast<double>(random() % 41) - 20.0);
        }
        command.grip_force_N = AnyDouble(random);
        if (is_wild && random() % 8 == 0) command.validity_ns = static_cast<std::int64_t>(random());
        filter.Accept(command, now_ns);
        if (filter.was_accepted()) last_good_ns = latest_ns;
      }
      DeviceReading reading = Held();
      reading.is_engaged = random() % 16 != 0;
      for (int axis = 0; axis < 3; ++axis) {
        reading.V_WD.linear_m_per_s[axis] =
            is_wild && random() % 64 == 0 ? AnyDouble(random) : static_cast<double>(random() % 101) * 0.01 - 0.5;
      }
      const FilteredForce out = filter.Apply(now_ns, reading);
      const glm::dvec3 force_N = out.F_Do_W().force_N;
      const double norm_N = glm::length(force_N);
      ++num_samples;
      num_acting += norm_N > 0.0 ? 1 : 0;
      ASSERT_LE(norm_N, limits.max_force_N);  // false for NaN as well
      ASSERT_LE(glm::length(out.F_Do_W().torque_Nm), limits.max_torque_Nm);
      ASSERT_LE(std::abs(out.grip_force_N()), limits.max_grip_force_N);
      const double power_W = glm::dot(force_N, reading.V_WD.linear_m_per_s) +
                             glm::dot(out.F_Do_W().torque_Nm, reading.V_WD.angular_rad_per_s);
      if (std::isfinite(power_W)) {
        ASSERT_LE(power_W, limits.max_power_W * (1.0 + 1e-9));
      }
      if (latest_ns - last_good_ns >= 60 * core::kMillisecond_ns) {
        ASSERT_EQ(norm_N, 0.0);
      }
      // The rate may be exceeded only where the force is withdrawn for safety.
      const std::uint32_t kTakenAway = kDegraded | kSilent | kDeadMan | kNotFinite | kVelocityBraked | kPowerLimited;
      if ((filter.status() & kTakenAway) == 0) {
        const double dt_s = std::max<double>(0.0, static_cast<double>(latest_ns - previous_ns)) * 1e-9;
        ASSERT_LE(glm::length(force_N - previous_N), limits.max_force_rate_N_per_s * dt_s + 1e-9);
      }
      previous_N = force_N;
      previous_ns = latest_ns;
    }
  }
  EXPECT_GT(num_acting, num_samples / 10) << "otherwise the test would pass with a filter that blocks everything";
}

}  // namespace
}  // namespace device_bridge
