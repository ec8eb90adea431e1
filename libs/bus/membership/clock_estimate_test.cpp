#include "bus/membership/clock_estimate.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace bus::detail {
namespace {

// A path with random delays and two clocks, one of which drifts. Time is the observer's own clock.
class SimulatedPeer {
 public:
  SimulatedPeer(std::uint64_t seed, double drift, double wobble) : random_(seed), drift_(drift), wobble_(wobble) {
    start_offset_ns_ = static_cast<double>(static_cast<std::int64_t>(random_()) / 1000);
  }
  // Short and long delays; the two ways are asymmetric for random periods.
  double Delay_ns(double base_ns) {
    const double share = static_cast<double>(random_() >> 11) * 0x1p-53;
    const bool is_late = random_() % 16 == 0;
    return base_ns * (1.0 + share) + (is_late ? share * 5e6 : 0.0);
  }
  // Rate of change: drift + wobble cos(t); |drift| + |wobble| <= kMaxDrift.
  [[nodiscard]] double Offset_ns(double time_ns) const {
    return start_offset_ns_ + drift_ * time_ns + wobble_ * 1e9 * std::sin(time_ns * 1e-9);
  }
  ClockExchange Exchange(double time_ns, double there_ns, double held_ns, double back_ns) {
    const double received = time_ns + Delay_ns(there_ns);
    const double answered = received + held_ns;
    const double returned = answered + Delay_ns(back_ns);
    return {std::llround(time_ns), std::llround(received + Offset_ns(received)),
            std::llround(answered + Offset_ns(answered)), std::llround(returned)};
  }

 private:
  std::mt19937_64 random_;
  double drift_, wobble_, start_offset_ns_ = 0.0;
};

TEST(ClockEstimate, TheTrueOffsetIsAlwaysWithinTheBound) {
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    std::mt19937_64 random(seed);
    const auto share = [&random] { return static_cast<double>(random() >> 11) * 0x1p-53; };
    const double wobble = share() * 0.5 * kMaxDrift;
    const double drift = (2.0 * share() - 1.0) * (kMaxDrift - wobble);
    SimulatedPeer peer(seed, drift, wobble);
    const double there_ns = 1e3 + 3e5 * share(), back_ns = 1e3 + 3e5 * share();
    ClockEstimate estimate;
    for (int i = 1; i <= 600; ++i) {
      const double time_ns = 1e12 + 50e6 * i;
      if (random() % 10 == 0) continue;  // lost
      const ClockExchange exchange = peer.Exchange(time_ns, there_ns, share() * 1e5, back_ns);
      ASSERT_TRUE(estimate.Add(exchange));
      for (const std::int64_t later : {0, 1'000'000, 49'000'000}) {
        const std::int64_t now = exchange.received_ns + later;
        const ClockReading reading = estimate.At(now);
        // Offsets up to 1e16 ns: a double is exact to 1 ns only, and every stamp of the simulation was rounded.
        const double error = peer.Offset_ns(static_cast<double>(now)) - static_cast<double>(reading.offset_ns);
        ASSERT_LE(std::abs(error), static_cast<double>(reading.bound_ns) + 8.0) << "seed " << seed << ", step " << i;
      }
    }
    EXPECT_EQ(estimate.num_restarts(), 0u) << "seed " << seed;
  }
}

TEST(ClockEstimate, TheBoundIsHalfTheShortestRoundTripPlusDrift) {
  SimulatedPeer peer(3, 50e-6, 0.0);
  ClockEstimate estimate;
  std::int64_t shortest = INT64_MAX, now = 0;
  for (int i = 1; i <= 200; ++i) {
    const ClockExchange exchange = peer.Exchange(50e6 * i, 40e3, 2e3, 40e3);
    ASSERT_TRUE(estimate.Add(exchange));
    now = exchange.received_ns;
    shortest = std::min(
        shortest, (exchange.received_ns - exchange.sent_ns) - (exchange.peer_sent_ns - exchange.peer_received_ns));
  }
  const ClockReading reading = estimate.At(now);
  // The best of the last half second costs half its round trip and what the clocks may have drifted since.
  EXPECT_LE(reading.bound_ns, shortest / 2 + static_cast<std::int64_t>(kMaxDrift * 5e8));
  EXPECT_NEAR(reading.drift_ppm, 50.0, 5.0);
  EXPECT_LE(std::abs(peer.Offset_ns(static_cast<double>(now)) - static_cast<double>(reading.offset_ns)), 40e3);
}

TEST(ClockEstimate, IsUnknownBeforeTheFirstExchange) {
  EXPECT_EQ(ClockEstimate().At(5).bound_ns, kUnknownBound_ns);
}

TEST(ClockEstimate, RefusesExchangesThatViolateCausality) {
  ClockEstimate estimate;
  EXPECT_FALSE(estimate.Add({100, 50, 60, 90}));             // came back before it left
  EXPECT_FALSE(estimate.Add({100, 60, 50, 200}));            // was answered before it arrived
  EXPECT_FALSE(estimate.Add({0, 0, 2'000'000, 1'000'000}));  // was held for longer than it was away
  EXPECT_EQ(estimate.num_exchanges(), 0u);
}

TEST(ClockEstimate, RestartsWhenAClockJumps) {
  ClockEstimate estimate;
  for (std::int64_t i = 1; i <= 20; ++i)
    ASSERT_TRUE(estimate.Add({i * 1000000, i * 1000000 + 500, i * 1000000 + 500, i * 1000000 + 1000}));
  EXPECT_NEAR(static_cast<double>(estimate.At(20'001'000).offset_ns), 0.0, 2000.0);
  constexpr std::int64_t kJump = 1'000'000'000;
  ASSERT_TRUE(estimate.Add({30'000'000, 30'000'500 + kJump, 30'000'500 + kJump, 30'001'000}));
  EXPECT_EQ(estimate.num_restarts(), 1u);
  EXPECT_NEAR(static_cast<double>(estimate.At(30'001'000).offset_ns), static_cast<double>(kJump), 2000.0);
}

}  // namespace
}  // namespace bus::detail
