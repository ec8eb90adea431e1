#include <gtest/gtest.h>
#include <poll.h>

#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "device/builtin.hpp"
#include "device/haply_messages.hpp"
#include "device/sha1.hpp"
#include "device/testing/fake_haply_service.hpp"
#include "device/websocket.hpp"

namespace device {
namespace {

std::string Hex(const std::array<std::uint8_t, 20>& digest) {
  std::string text;
  for (const std::uint8_t byte : digest) {
    constexpr char kDigits[] = "0123456789abcdef";
    text += kDigits[byte >> 4];
    text += kDigits[byte & 15];
  }
  return text;
}

// FIPS 180's examples.
TEST(Sha1, GivesThePublishedDigests) {
  EXPECT_EQ(Hex(Sha1("abc")), "a9993e364706816aba3e25717850c26c9cd0d89d");
  EXPECT_EQ(Hex(Sha1("abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq")),
            "84983e441c3bd26ebaae4aa1f95129e5e54670f1");
  EXPECT_EQ(Hex(Sha1("")), "da39a3ee5e6b4b0d3255bfef95601890afd80709");
}

// RFC 6455, 1.3.
constexpr const char* kKey = "dGhlIHNhbXBsZSBub25jZQ==";
constexpr const char* kAccept = "s3pPLMBiTxaQ9kYGzzhZRbK+xOo=";

TEST(WebSocket, OpensWithTheAnswerOfTheStandardsExampleAndNoOther) {
  WebSocket good("h", "/", kKey, 1);
  EXPECT_NE(good.TakeOutput().find("Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n"), std::string::npos);
  good.Take(HaplyOpening(kAccept));
  EXPECT_TRUE(good.is_open());
  WebSocket bad("h", "/", kKey, 1);
  bad.Take(HaplyOpening("AAAALMBiTxaQ9kYGzzhZRbK+xOo="));
  EXPECT_TRUE(bad.is_broken());
  WebSocket other("h", "/", kKey, 1);
  other.Take("HTTP/1.1 404 Not Found\r\n\r\n");
  EXPECT_NE(other.why().find("404"), std::string::npos);
}

WebSocket Opened() {
  WebSocket socket("h", "/", kKey, 1);
  socket.TakeOutput();
  socket.Take(HaplyOpening(kAccept));
  return socket;
}

TEST(WebSocket, JoinsFragmentsAndAnswersPingsBetweenThem) {
  WebSocket socket = Opened();
  // RFC 6455, 5.7: "Hello" in two fragments, a ping between them; byte by byte.
  const std::string bytes = std::string("\x01\x03Hel", 5) + std::string("\x89\x02pi", 4) + std::string("\x80\x02lo", 4);
  std::optional<std::string> text;
  for (const char byte : bytes) {
    EXPECT_FALSE(text);
    socket.Take({&byte, 1});
    text = socket.NextText();
  }
  ASSERT_TRUE(text);
  EXPECT_EQ(*text, "Hello");
  const std::string pong = socket.TakeOutput();
  ASSERT_EQ(pong.size(), 8U);
  EXPECT_EQ(pong[0], '\x8A');
  EXPECT_EQ(pong[1], '\x82');
  EXPECT_EQ(pong[6] ^ pong[2], 'p');
}

TEST(WebSocket, WhatIsNoFrameOfAServerBreaksTheConnection) {
  const std::string bad[] = {std::string("\x81\x85\x41\x42\x43\x44hello", 11),
                             std::string("\xC1\x01x", 3),
                             std::string("\x80\x01x", 3),
                             std::string("\x09\x01x", 3),
                             std::string("\x83\x01x", 3),
                             std::string("\x88\x00", 2),
                             std::string("\x81\x7F\0\0\0\0\xFF\xFF\xFF\xFF", 10)};
  for (const std::string& bytes : bad) {
    WebSocket socket = Opened();
    socket.Take(bytes);
    EXPECT_FALSE(socket.NextText());
    EXPECT_TRUE(socket.is_broken());
  }
}

TEST(HaplyMessages, AStateIsReadAndAForceWritten) {
  HaplyState state;
  ASSERT_TRUE(ReadHaplyState(kHaplyMessage, &state));
  EXPECT_EQ(state.device_id, "04A5");
  EXPECT_EQ(state.position_m[1], -0.12);
  EXPECT_EQ(state.velocity_m_per_s[1], 0.5);
  EXPECT_TRUE(state.has_grip);
  EXPECT_NEAR(state.quaternion[1] * state.quaternion[1], 0.5, 1e-9);
  EXPECT_EQ(state.buttons, 5U);
  const auto force = nlohmann::json::parse(WriteHaplyForce("04A5", {1, 2, 3}));
  EXPECT_EQ(force["inverse3"][0]["commands"]["set_cursor_force"]["values"]["y"], 2.0);
  for (const char* bad :
       {"", "[]", "{}", R"({"inverse3": []})", R"({"inverse3": [{"device_id": 4, "state": {}}]})",
        R"({"inverse3": [{"device_id": "4", "state": {"cursor_position": {"x": 1e999, "y": 0, "z": 0}}}]})"}) {
    EXPECT_FALSE(ReadHaplyState(bad, &state)) << bad;
  }
}

TEST(Haply, AForceReachesTheServiceAndItsEndIsNoticed) {
  FakeHaplyService service;
  const std::string address = service.address();
  char why[200] = "";
  oos_device_setting setting{};
  setting.address = address.c_str();
  setting.why = why;
  setting.why_size = sizeof why;
  const oos_device_plugin& plugin = HaplyPlugin();
  void* device = nullptr;
  ASSERT_EQ(plugin.open(&setting, &device), OOS_DEVICE_OK) << why;
  oos_device_state state{};
  oos_device_command command{};
  command.sequence = 9;
  command.F_Do_B[2] = 1.25;
  std::int64_t now_ns = 0;
  for (int i = 0; i < 5000 && (state.sequence < 5 || state.reflected != 9); ++i) {
    pollfd wait{plugin.wait_fd(device), POLLIN, 0};
    poll(&wait, 1, 1);
    now_ns += 1'000'000;
    ASSERT_EQ(plugin.step(device, now_ns, &command, nullptr, &state), OOS_DEVICE_OK);
    service.Serve();
  }
  EXPECT_EQ(state.reflected, 9U);
  EXPECT_EQ(state.X_BD[5], -0.12);
  EXPECT_EQ(state.flags, static_cast<std::uint32_t>(OOS_DEVICE_IS_ENGAGED));
  EXPECT_NE(service.force().find("\"z\":1.25"), std::string::npos) << service.force();
  oos_device_description description{};
  ASSERT_EQ(plugin.describe(device, &description), OOS_DEVICE_OK);
  EXPECT_STREQ(description.serial, "04A5");
  // Without commands the force is gone after 60 ms.
  for (int i = 0; i < 200; ++i) {
    pollfd wait{plugin.wait_fd(device), POLLIN, 0};
    poll(&wait, 1, 1);
    now_ns += 1'000'000;
    plugin.step(device, now_ns, nullptr, nullptr, &state);
    service.Serve();
  }
  EXPECT_NE(service.force().find("\"z\":0.0"), std::string::npos) << service.force();
  service.Drop();
  int result = OOS_DEVICE_OK;
  for (int i = 0; i < 1000 && result == OOS_DEVICE_OK; ++i) {
    pollfd wait{plugin.wait_fd(device), POLLIN, 0};
    poll(&wait, 1, 1);
    result = plugin.step(device, now_ns, nullptr, nullptr, &state);
  }
  EXPECT_EQ(result, OOS_DEVICE_GONE);
  plugin.close(device);
}

TEST(Haply, WithoutAServiceItIsNotThere) {
  char why[200] = "";
  oos_device_setting setting{};
  setting.why = why;
  setting.why_size = sizeof why;
  void* device = nullptr;
  setting.address = "127.0.0.1:1";
  EXPECT_EQ(HaplyPlugin().open(&setting, &device), OOS_DEVICE_GONE);
  EXPECT_NE(std::string(why).find("Inverse Service"), std::string::npos);
  setting.address = "localhost";
  EXPECT_EQ(HaplyPlugin().open(&setting, &device), OOS_DEVICE_BAD_SETTING);
}

}  // namespace
}  // namespace device
