#include "bus/wire/codec.hpp"

#include <gtest/gtest.h>

#include <array>
#include <random>
#include <vector>

#include "bus/wire/envelope.hpp"

namespace bus {
namespace {

// Own arithmetic: the standard distributions differ between libraries.
class Numbers {
 public:
  double operator()() { return static_cast<double>(random_() >> 11) * 0x1p-53 * 2.0 - 1.0; }
  glm::dvec3 Vec() { return {(*this)(), (*this)(), (*this)()}; }
  glm::vec3 Vecf() { return glm::vec3(Vec()); }
  core::Pose Pose() { return {core::QuaternionFromRotationVector(Vec()), Vec()}; }
  core::Wrench Wrench() { return {Vec(), Vec()}; }
  core::Twist Twist() { return {Vec(), Vec()}; }
  std::uint64_t Bits() { return random_(); }

 private:
  std::mt19937_64 random_{3};
};

void ExpectSame(const core::Pose& a, const core::Pose& b) {
  EXPECT_EQ(a.rotation, b.rotation);
  EXPECT_EQ(a.translation, b.translation);
}
void ExpectSame(const core::Twist& a, const core::Twist& b) {
  EXPECT_EQ(a.angular_rad_per_s, b.angular_rad_per_s);
  EXPECT_EQ(a.linear_m_per_s, b.linear_m_per_s);
}
void ExpectSame(const core::Wrench& a, const core::Wrench& b) {
  EXPECT_EQ(a.force_N, b.force_N);
  EXPECT_EQ(a.torque_Nm, b.torque_Nm);
}

// Encodes all parts and decodes them in the order given by `order`.
template <class M>
std::vector<std::size_t> RoundTrip(const M& in, M* out, std::size_t budget, bool is_reversed = false) {
  LatestCodec<M> encoder, decoder;
  const int parts = encoder.NumParts(in, budget);
  std::vector<std::vector<std::uint8_t>> payloads;
  std::vector<std::size_t> sizes;
  for (int part = 0; part < parts; ++part) {
    std::vector<std::uint8_t> bytes(2000);
    sizes.push_back(encoder.Encode(in, part, budget, bytes.data(), bytes.size()));
    bytes.resize(sizes.back());
    payloads.push_back(bytes);
  }
  for (int i = 0; i < parts; ++i) {
    const auto part = static_cast<std::size_t>(is_reversed ? parts - 1 - i : i);
    EXPECT_TRUE(decoder.Decode(payloads[part], i == 0, out));
  }
  return sizes;
}

core::ContactSet FullContactSet(Numbers& numbers) {
  core::ContactSet set;
  set.pair_index = 300;
  set.sampled_body = 65534;
  set.field_body = 400;
  set.cycle = 0xffff'ffff'ffff;
  set.signed_distance_m = numbers();
  set.is_in_contact = true;
  set.F_So_W = numbers.Wrench();
  set.damping_N_s_per_m = 20;
  set.friction = 0.2f;
  for (std::size_t i = 0; i < core::kMaxContactPlanes; ++i) {
    set.planes.push_back({static_cast<std::uint32_t>(numbers.Bits()), numbers.Vecf(), numbers.Vecf(), numbers.Vecf(),
                          static_cast<float>(numbers())});
  }
  return set;
}

core::PhysicsState FullState(Numbers& numbers, std::size_t num_bodies, std::size_t num_mechanisms) {
  core::PhysicsState state;
  state.tick = 123456789;
  state.time_ns = 123456789'000'000;
  state.state_hash = 0xfedcba9876543210ULL;
  state.is_in_contact = true;
  for (std::size_t i = 0; i < num_bodies; ++i) {
    state.bodies.push_back({static_cast<std::uint16_t>(60000 + i), numbers.Pose(), numbers.Twist()});
  }
  for (std::size_t i = 0; i < num_mechanisms; ++i) {
    state.mechanisms.push_back({static_cast<std::uint16_t>(i), -1 - static_cast<int>(i), numbers(), numbers()});
  }
  return state;
}

void ExpectSame(const core::ContactSet& a, const core::ContactSet& b) {
  EXPECT_EQ(a.pair_index, b.pair_index);
  EXPECT_EQ(a.sampled_body, b.sampled_body);
  EXPECT_EQ(a.field_body, b.field_body);
  EXPECT_EQ(a.cycle, b.cycle);
  EXPECT_EQ(a.signed_distance_m, b.signed_distance_m);
  EXPECT_EQ(a.is_in_contact, b.is_in_contact);
  ExpectSame(a.F_So_W, b.F_So_W);
  EXPECT_EQ(a.damping_N_s_per_m, b.damping_N_s_per_m);
  EXPECT_EQ(a.friction, b.friction);
  ASSERT_EQ(a.planes.size(), b.planes.size());
  for (std::size_t i = 0; i < a.planes.size(); ++i) {
    EXPECT_EQ(a.planes[i].id, b.planes[i].id);
    EXPECT_EQ(a.planes[i].p_S, b.planes[i].p_S);
    EXPECT_EQ(a.planes[i].q_G, b.planes[i].q_G);
    EXPECT_EQ(a.planes[i].n_G, b.planes[i].n_G);
    EXPECT_EQ(a.planes[i].stiffness_N_per_m, b.planes[i].stiffness_N_per_m);
  }
}

void ExpectSame(const core::PhysicsState& a, const core::PhysicsState& b) {
  EXPECT_EQ(a.tick, b.tick);
  EXPECT_EQ(a.time_ns, b.time_ns);
  EXPECT_EQ(a.state_hash, b.state_hash);
  EXPECT_EQ(a.is_in_contact, b.is_in_contact);
  ASSERT_EQ(a.bodies.size(), b.bodies.size());
  for (std::size_t i = 0; i < a.bodies.size(); ++i) {
    EXPECT_EQ(a.bodies[i].object, b.bodies[i].object);
    ExpectSame(a.bodies[i].X_WO, b.bodies[i].X_WO);
    ExpectSame(a.bodies[i].V_WO, b.bodies[i].V_WO);
  }
  ASSERT_EQ(a.mechanisms.size(), b.mechanisms.size());
  for (std::size_t i = 0; i < a.mechanisms.size(); ++i) {
    EXPECT_EQ(a.mechanisms[i].mechanism, b.mechanisms[i].mechanism);
    EXPECT_EQ(a.mechanisms[i].state, b.mechanisms[i].state);
    EXPECT_EQ(a.mechanisms[i].position, b.mechanisms[i].position);
    EXPECT_EQ(a.mechanisms[i].force, b.mechanisms[i].force);
  }
}

TEST(Codec, KeepsEveryBitOfDeviceAndProxyMessages) {
  Numbers numbers;
  core::DeviceState state, state_out;
  state.role_index = 3;
  state.sample_ns = 1'234'567'890'123;
  state.X_WD = numbers.Pose();
  state.V_WD = numbers.Twist();
  state.opening_m = 0.05;
  state.opening_velocity_m_per_s = -0.1;
  state.is_engaged = true;
  state.is_simulated = false;
  RoundTrip(state, &state_out, 1000);
  EXPECT_EQ(state_out.role_index, 3);
  EXPECT_EQ(state_out.sample_ns, state.sample_ns);
  ExpectSame(state_out.X_WD, state.X_WD);
  ExpectSame(state_out.V_WD, state.V_WD);
  EXPECT_EQ(state_out.opening_m, 0.05);
  EXPECT_EQ(state_out.opening_velocity_m_per_s, -0.1);
  EXPECT_TRUE(state_out.is_engaged);
  EXPECT_FALSE(state_out.is_simulated);

  core::DeviceCommand command, command_out;
  command.role_index = 1;
  command.F_Do_W = numbers.Wrench();
  command.grip_force_N = -3.5;
  command.validity_ns = 7'000'000;
  RoundTrip(command, &command_out, 1000);
  EXPECT_EQ(command_out.role_index, 1);
  ExpectSame(command_out.F_Do_W, command.F_Do_W);
  EXPECT_EQ(command_out.grip_force_N, -3.5);
  EXPECT_EQ(command_out.validity_ns, 7'000'000);

  core::HapticProxy proxy, proxy_out;
  proxy.role_index = 2;
  proxy.cycle = 99;
  proxy.X_WD = numbers.Pose();
  proxy.V_WD = numbers.Twist();
  proxy.X_WC = numbers.Pose();
  proxy.opening_m = 0.01;
  proxy.is_in_contact = true;
  proxy.is_engaged = true;
  proxy.F_Do_W = numbers.Wrench();
  RoundTrip(proxy, &proxy_out, 1000);
  EXPECT_EQ(proxy_out.cycle, 99u);
  ExpectSame(proxy_out.X_WD, proxy.X_WD);
  ExpectSame(proxy_out.V_WD, proxy.V_WD);
  ExpectSame(proxy_out.X_WC, proxy.X_WC);
  EXPECT_TRUE(proxy_out.is_in_contact && proxy_out.is_engaged);
  ExpectSame(proxy_out.F_Do_W, proxy.F_Do_W);

  core::Reaction reaction, reaction_out;
  reaction.role_index = 1;
  reaction.tick = 5;
  reaction.grasped_object = core::kNoObject;
  reaction.F_Do_W = numbers.Wrench();
  reaction_out.grasped_object = 0;
  RoundTrip(reaction, &reaction_out, 1000);
  EXPECT_EQ(reaction_out.grasped_object, core::kNoObject);
  EXPECT_EQ(reaction_out.tick, 5u);
  ExpectSame(reaction_out.F_Do_W, reaction.F_Do_W);
}

TEST(Codec, TwentyPlanesWithAUsualTraceFitInOneDatagram) {
  Numbers numbers;
  const core::ContactSet in = FullContactSet(numbers);
  core::ContactSet out;
  const std::size_t usual_envelope = kEnvelopeFixedBytes + 19 * kStampBytes;
  const auto sizes = RoundTrip(in, &out, kMaxDatagramBytes - usual_envelope);
  ASSERT_EQ(sizes.size(), 1u);
  EXPECT_LE(usual_envelope + sizes[0], kMaxDatagramBytes);
  ExpectSame(in, out);
}

TEST(Codec, SplitsLargeMessagesIntoDatagramsThatFit) {
  Numbers numbers;
  const std::size_t budget = kMaxDatagramBytes - kMaxEnvelopeBytes;
  for (const bool is_reversed : {false, true}) {
    const core::ContactSet contacts = FullContactSet(numbers);
    core::ContactSet contacts_out;
    const auto contact_sizes = RoundTrip(contacts, &contacts_out, budget, is_reversed);
    EXPECT_EQ(contact_sizes.size(), 2u);
    for (const std::size_t size : contact_sizes) EXPECT_LE(size, budget);
    ExpectSame(contacts, contacts_out);

    for (const std::size_t num_bodies : {0, 1, 7, 8, 9, 20, 48}) {
      for (const std::size_t num_mechanisms : {0, 1, 5, 32}) {
        const core::PhysicsState state = FullState(numbers, num_bodies, num_mechanisms);
        core::PhysicsState state_out = FullState(numbers, 3, 2);  // must be overwritten completely
        const auto state_sizes = RoundTrip(state, &state_out, budget, is_reversed);
        for (const std::size_t size : state_sizes) EXPECT_LE(size, budget);
        ExpectSame(state, state_out);
      }
    }
  }
}

TEST(Codec, SplitsASheetAndRefusesOneThatContradictsItself) {
  Numbers numbers;
  const std::size_t budget = kMaxDatagramBytes - kMaxEnvelopeBytes;
  core::SheetState sheet;
  sheet.object = 3;
  sheet.tick = 77;
  sheet.num_columns = 32;
  for (std::size_t i = 0; i < core::kMaxSheetNodes; ++i) sheet.p_W.push_back(numbers.Vecf());
  for (const bool is_reversed : {false, true}) {
    core::SheetState out;
    const auto sizes = RoundTrip(sheet, &out, budget, is_reversed);
    EXPECT_LE(sizes.size(), 16u);
    for (const std::size_t size : sizes) EXPECT_LE(size, budget);
    EXPECT_EQ(out.object, 3);
    EXPECT_EQ(out.tick, 77u);
    EXPECT_EQ(out.num_columns, 32);
    ASSERT_EQ(out.p_W.size(), sheet.p_W.size());
    for (std::size_t i = 0; i < out.p_W.size(); ++i) ASSERT_EQ(out.p_W[i], sheet.p_W[i]);
  }
  sheet.num_columns = 31;  // no whole rows
  LatestCodec<core::SheetState> codec;
  std::vector<std::uint8_t> bytes(kMaxDatagramBytes);
  bytes.resize(codec.Encode(sheet, 0, budget, bytes.data(), bytes.size()));
  core::SheetState out;
  EXPECT_FALSE(codec.Decode(bytes, true, &out));
}

TEST(Codec, KeepsStateValues) {
  core::LogicStatus status, status_out;
  status.time_ns = 42;
  status.step = "switch_off";
  status.hint = "turn the switch";
  status.active_states = {"run", "switch_off"};
  status.lamps = {{7, 1.0f, 0.5f, 0.0f}, {8, 0.0f, 1.0f, 0.0f}};
  status.is_failed = true;
  status.why = "stalled";
  std::string bytes;
  EncodeState(status, &bytes);
  ASSERT_TRUE(DecodeState(bytes, &status_out));
  EXPECT_EQ(status_out.time_ns, 42);
  EXPECT_EQ(status_out.step, "switch_off");
  EXPECT_EQ(status_out.hint, status.hint);
  EXPECT_EQ(status_out.active_states, status.active_states);
  ASSERT_EQ(status_out.lamps.size(), 2u);
  EXPECT_EQ(status_out.lamps[0].object, 7);
  EXPECT_EQ(status_out.lamps[0].green, 0.5f);
  EXPECT_FALSE(status_out.is_final);
  EXPECT_TRUE(status_out.is_failed);
  EXPECT_EQ(status_out.why, "stalled");

  Figures figures{{{"step_p50_us", 12.5}, {"misses", 3}}}, figures_out;
  EncodeState(figures, &bytes);
  ASSERT_TRUE(DecodeState(bytes, &figures_out));
  ASSERT_NE(FindFigure(figures_out, "misses"), nullptr);
  EXPECT_EQ(*FindFigure(figures_out, "misses"), 3);
  EXPECT_EQ(FindFigure(figures_out, "nothing"), nullptr);
}

// Payloads that a sound checksum lets through but that contradict themselves.
TEST(Codec, RefusesGarbageAndLeavesTheMessageAsItWas) {
  Numbers numbers;
  const core::PhysicsState state = FullState(numbers, 8, 4);
  LatestCodec<core::PhysicsState> codec;
  std::vector<std::uint8_t> sound(2000);
  sound.resize(codec.Encode(state, 0, 1900, sound.data(), sound.size()));
  const core::PhysicsState before = FullState(numbers, 2, 1);
  std::size_t refused = 0;
  for (std::size_t size = 0; size < sound.size(); ++size) {
    core::PhysicsState out = before;
    if (codec.Decode(std::span(sound).first(size), true, &out)) continue;  // cut between two whole fields
    ++refused;
    ExpectSame(out, before);
  }
  EXPECT_GT(refused, sound.size() * 9 / 10);

  std::array<std::uint8_t, 400> noise;
  LatestCodec<core::ContactSet> contacts;
  LatestCodec<core::DeviceCommand> commands;
  for (int round = 0; round < 20'000; ++round) {
    const std::size_t size = numbers.Bits() % noise.size();
    for (std::uint8_t& byte : noise) byte = static_cast<std::uint8_t>(numbers.Bits());
    core::PhysicsState state_out = before;
    core::ContactSet contacts_out;
    core::DeviceCommand command_out;
    codec.Decode(std::span(noise).first(size), round % 3 != 0, &state_out);
    contacts.Decode(std::span(noise).first(size), round % 3 != 0, &contacts_out);
    EXPECT_FALSE(commands.Decode(std::span(noise).first(size), true, &command_out));
    ASSERT_LE(state_out.bodies.size(), core::kMaxBodies);
    ASSERT_LE(contacts_out.planes.size(), core::kMaxContactPlanes);
  }
}

}  // namespace
}  // namespace bus
