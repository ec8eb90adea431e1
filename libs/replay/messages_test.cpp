#include <gtest/gtest.h>

#include <array>
#include <string>

#include "bus/wire/codec.hpp"
#include "bus/wire/envelope.hpp"
#include "bus/wire/schema.hpp"
#include "core/messages/bulk_fields.hpp"
#include "core/messages/camera_fields.hpp"
#include "core/messages/rays_fields.hpp"
#include "core/messages/viewing_fields.hpp"
#include "replay/difference.hpp"
#include "replay/fields.hpp"

namespace replay {

// Gives every field a value of its own, and every list two items.
class DistinctValues {
 public:
  static constexpr bool kReads = true;
  explicit DistinctValues(bool truth) : truth_(truth) {}
  template <class T>
  void Value(std::string_view, T& value) {
    if constexpr (std::is_same_v<T, bool>) {
      value = truth_;
    } else if constexpr (std::is_floating_point_v<T>) {
      value = static_cast<T>(++last_) + T{0.25};
    } else {
      value = static_cast<T>(++last_);
    }
  }
  void Text(std::string_view name, std::string& text) { text = std::string(name) + std::to_string(++last_); }
  std::size_t Count(std::string_view, std::size_t) { return 2; }
  void Enter(std::string_view) {}
  void Enter(std::string_view, std::size_t) {}
  void Leave() {}
  void Fail() { FAIL() << "a list of two is too long"; }

  bool includes_transport = true;

 private:
  bool truth_;
  int last_ = 0;
};

namespace {

template <class M>
void SendAndReceive(const M& sent, M* received) {
  constexpr std::size_t kBudget = bus::kMaxDatagramBytes - bus::kEnvelopeFixedBytes;
  const bus::LatestCodec<M> codec;
  std::array<std::uint8_t, kBudget> bytes;
  for (int part = 0; part < codec.NumParts(sent, kBudget); ++part) {
    const std::size_t size = codec.Encode(sent, part, kBudget, bytes.data(), bytes.size());
    ASSERT_TRUE(codec.Decode({bytes.data(), size}, part == 0, received));
  }
  received->header = sent.header;  // carried by the envelope
}

template <class M>
requires(!requires(M m) { m.header; }) void SendAndReceive(const M& sent, M* received) {
  std::string bytes;
  bus::EncodeState(sent, &bytes);
  ASSERT_TRUE(bus::DecodeState(bytes, received));
}

template <class M>
void ExpectEveryFieldToSurvive(bool truth) {
  M sent, received;
  DistinctValues values(truth);
  Visit(values, sent);
  if constexpr (requires { sent.num_columns; }) sent.num_columns = 1;  // lists have whole rows
  SendAndReceive(sent, &received);
  Leaves expected, got;
  Visit(expected, sent);
  Visit(got, received);
  for (const FieldDifference& difference :
       Compare(expected.all(), got.all(), Tolerance(), [](const std::string& path) { return path; })) {
    ADD_FAILURE() << bus::SchemaOf(bus::kMessageTypeOf<M>).name << " " << difference.path << " was "
                  << difference.expected << " and arrived as " << difference.got;
  }
}

template <class... M>
struct ForAll {
  static void Run() { (Both<M>(), ...); }
  template <class One>
  static void Both() {
    for (const bool truth : {true, false}) ExpectEveryFieldToSurvive<One>(truth);
  }
};

TEST(Messages, EveryFieldSurvivesTheWire) {
  bus::LatestMessages<ForAll>::Run();
  bus::ReliableMessages<ForAll>::Run();
}

// In the order of a comparison of steps; only a build with the same list can read a recording.
TEST(Messages, EveryFieldHasItsName) {
  core::DeviceState state;
  Leaves leaves;
  leaves.includes_transport = false;
  Visit(leaves, state);
  std::string names;
  for (const Leaf& leaf : leaves.all()) names += leaf.path + "\n";
  EXPECT_TRUE(
      names.starts_with("header.direct.id\nheader.direct.origin_ns\nheader.through_physics.id\n"
                        "header.through_physics.origin_ns\nrole_index\nsample_ns\nX_WD.rotation.w\n"
                        "X_WD.rotation.x\nX_WD.rotation.y\nX_WD.rotation.z\nX_WD.translation.x\n"
                        "X_WD.translation.y\nX_WD.translation.z\nV_WD.angular_rad_per_s.x\n"
                        "V_WD.angular_rad_per_s.y\nV_WD.angular_rad_per_s.z\nV_WD.linear_m_per_s.x\n"
                        "V_WD.linear_m_per_s.y\nV_WD.linear_m_per_s.z\nopening_m\nopening_velocity_m_per_s\n"
                        "is_engaged\nis_simulated\n"))
      << names;
}

}  // namespace
}  // namespace replay
