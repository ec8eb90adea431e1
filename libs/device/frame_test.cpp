#include "device/frame.hpp"

#include <gtest/gtest.h>
#include <zlib.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <random>

namespace device {
namespace {

oos_device_state AnyState() {
  oos_device_state state{};
  state.flags = OOS_DEVICE_IS_ENGAGED;
  state.buttons = 5;
  state.X_BD[0] = 0.6;
  state.X_BD[2] = 0.8;
  state.X_BD[4] = 0.1;
  state.V_BD[5] = -0.3;
  state.opening_m = 0.02;
  state.applied[6] = 1.5;
  return state;
}

// Changes a frame at one place and makes its CRC right again, so that only the change is refused.
template <class T>
Frame With(Frame frame, std::size_t at, T value) {
  std::memcpy(frame.bytes.data() + at, &value, sizeof value);
  const auto crc = static_cast<std::uint32_t>(crc32(0, frame.bytes.data(), static_cast<uInt>(frame.size - kCrcSize)));
  std::memcpy(frame.bytes.data() + frame.size - kCrcSize, &crc, sizeof crc);
  return frame;
}

FrameFault FaultOf(const Frame& frame) {
  ReadFrame read;
  return DecodeFrame(frame.span(), &read);
}

TEST(DeviceFrame, StateIsReadAsItWasWritten) {
  const Frame frame = EncodeState({FrameKind::kState, 7, 3, 123'456'789}, AnyState());
  EXPECT_EQ(frame.size, kStateSize);
  ReadFrame read;
  ASSERT_EQ(DecodeFrame(frame.span(), &read), FrameFault::kNone);
  EXPECT_EQ(read.header.kind, FrameKind::kState);
  EXPECT_EQ(read.state.sequence, 7U);
  EXPECT_EQ(read.state.reflected, 3U);
  EXPECT_EQ(read.state.device_time_ns, 123'456'789);
  EXPECT_EQ(read.state.flags, static_cast<std::uint32_t>(OOS_DEVICE_IS_ENGAGED));
  EXPECT_EQ(read.state.buttons, 5U);
  EXPECT_DOUBLE_EQ(read.state.X_BD[2], 0.8);
  EXPECT_EQ(read.state.V_BD[5], -0.3);
  EXPECT_EQ(read.state.opening_m, 0.02);
  EXPECT_EQ(read.state.applied[6], 1.5);
}

TEST(DeviceFrame, CommandAndDescriptionAreReadAsTheyWereWritten) {
  oos_device_command command{};
  command.F_Do_B[2] = -4.5;
  command.brake_Nm_s_per_rad = 4.0;
  ReadFrame read;
  ASSERT_EQ(DecodeFrame(EncodeCommand({FrameKind::kCommand, 1, 0, 1}, command, kDescribeYourself).span(), &read),
            FrameFault::kNone);
  EXPECT_EQ(read.command.F_Do_B[2], -4.5);
  EXPECT_EQ(read.command.brake_Nm_s_per_rad, 4.0);
  EXPECT_EQ(read.command_flags, kDescribeYourself);

  oos_device_description description{};
  std::memset(description.name, 'x', sizeof description.name);  // without an end
  description.opening_max_m = 0.07;
  ASSERT_EQ(DecodeFrame(EncodeDescription({FrameKind::kDescription, 1, 0, 1}, description).span(), &read),
            FrameFault::kNone);
  EXPECT_EQ(std::strlen(read.description.name), sizeof description.name - 1);
  EXPECT_EQ(read.description.opening_max_m, 0.07);
}

TEST(DeviceFrame, EachFaultIsNamed) {
  const Frame good = EncodeState({FrameKind::kState, 1, 0, 0}, AnyState());
  ASSERT_EQ(FaultOf(good), FrameFault::kNone);
  ReadFrame read;
  EXPECT_EQ(DecodeFrame(good.span().first(20), &read), FrameFault::kShort);
  EXPECT_EQ(DecodeFrame(good.span().first(good.size - 1), &read), FrameFault::kLength);
  EXPECT_EQ(FaultOf(With(good, 0, 'X')), FrameFault::kNoMagic);
  EXPECT_EQ(FaultOf(With(good, 4, std::uint8_t{2})), FrameFault::kVersion);
  EXPECT_EQ(FaultOf(With(good, 5, std::uint8_t{9})), FrameFault::kKind);
  EXPECT_EQ(FaultOf(With(good, 6, std::uint16_t{100})), FrameFault::kLength);
  EXPECT_EQ(FaultOf(With(good, kHeaderSize + 8 + 4 * 8, std::numeric_limits<double>::quiet_NaN())),
            FrameFault::kNotFinite);
  EXPECT_EQ(FaultOf(With(good, kHeaderSize + 8, 2.0)), FrameFault::kNotFinite) << "no unit quaternion";
}

TEST(DeviceFrame, EveryFlippedBitIsNoticed) {
  const Frame good = EncodeState({FrameKind::kState, 1, 0, 0}, AnyState());
  for (std::size_t bit = 0; bit < 8 * good.size; ++bit) {
    Frame damaged = good;
    damaged.bytes[bit / 8] ^= static_cast<std::uint8_t>(1U << (bit % 8));
    EXPECT_NE(FaultOf(damaged), FrameFault::kNone) << bit;
  }
}

}  // namespace
}  // namespace device
