#include "tactile/usb_table.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <limits>

namespace tactile {
namespace {

std::filesystem::path Written(const std::string& text) {
  const auto file = std::filesystem::path(testing::TempDir()) / "usb_tactile.xml";
  std::ofstream(file) << text;
  return file;
}

UsbTable Bracelet() {
  const auto table = ReadUsbTable(VR_OOS_SOURCE_DIR "/scenarios/touch/vibrotac.xml");
  EXPECT_TRUE(table);
  return table ? *table : UsbTable{};
}

TEST(UsbTable, TheBraceletIsReadFromAtMost20Lines) {
  const UsbTable table = Bracelet();
  EXPECT_EQ(table.vendor, 0x1209);
  EXPECT_EQ(table.endpoint, 1);
  EXPECT_EQ(table.num_channels, 6u);
  ASSERT_EQ(table.setup.size(), 1u);
  EXPECT_EQ(table.setup[0].value, 60);
  std::ifstream stream(VR_OOS_SOURCE_DIR "/scenarios/touch/vibrotac.xml");
  int lines = 0;
  for (std::string line; std::getline(stream, line);) ++lines;
  EXPECT_LE(lines, 20);
}

TEST(UsbTable, AFrameIsByteForByteAsDocumented) {
  std::vector<std::uint8_t> bytes;
  EncodeFrame(Bracelet(), std::vector<float>{0.0f, 1.0f, 0.2f, 0.0f, 0.4f, 0.0f}, &bytes);
  EXPECT_EQ(bytes, (std::vector<std::uint8_t>{0xa5, 0, 0xff, 0x33, 0, 0x66, 0, 0xa5 ^ 0xff ^ 0x33 ^ 0x66}));
}

TEST(UsbTable, ALaboratorysOwnDeviceNeedsTextAlone) {
  const auto table = ReadUsbTable(Written(R"(<usb_tactile name="glove" vendor="4617" product="2" endpoint="0x03">
    <frame><level channel="1" bytes="2" most="1000"/><constant value="7"/><level channel="0" most="100"/></frame>
  </usb_tactile>)"));
  ASSERT_TRUE(table);
  std::vector<std::uint8_t> bytes;
  EncodeFrame(*table, std::vector<float>{0.5f, 0.9f}, &bytes);
  EXPECT_EQ(bytes, (std::vector<std::uint8_t>{900 & 0xff, 900 >> 8, 7, 50}));
}

TEST(UsbTable, WhatIsNoLevelIsOff) {
  std::vector<std::uint8_t> bytes;
  const float nan = std::numeric_limits<float>::quiet_NaN();
  EncodeFrame(Bracelet(), std::vector<float>{nan, -1.0f, 1.01f, std::numeric_limits<float>::infinity()}, &bytes);
  EXPECT_EQ(bytes, (std::vector<std::uint8_t>{0xa5, 0, 0, 0, 0, 0, 0, 0xa5}));
}

TEST(UsbTable, AFrameIsReadBackAndAWrongOneIsNone) {
  const UsbTable table = Bracelet();
  std::vector<std::uint8_t> bytes;
  const std::vector<float> levels{0.0f, 1.0f, 0.2f, 0.0f, 0.4f, 0.6f};
  EncodeFrame(table, levels, &bytes);
  std::vector<float> read;
  ASSERT_TRUE(DecodeFrame(table, bytes, &read));
  EXPECT_EQ(read, levels);
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    std::vector<std::uint8_t> wrong = bytes;
    wrong[i] ^= 0x10;
    EXPECT_FALSE(DecodeFrame(table, wrong, &read)) << i;
  }
  bytes.pop_back();
  EXPECT_FALSE(DecodeFrame(table, bytes, &read));
}

TEST(UsbTable, AMistakeIsToldWithItsLineAndWhatToDo) {
  struct Mistake {
    const char* text;
    const char* what;
  };
  for (const Mistake& mistake :
       {Mistake{R"(<usb_tactile name="a" vendor="0xg" product="1" endpoint="1"><frame><level channel="0"/></frame>
                      </usb_tactile>)",
                "vendor is '0xg'"},
        Mistake{R"(<usb_tactile name="a" vendor="1" product="1" endpoint="0x81"><frame><level channel="0"/></frame>
                      </usb_tactile>)",
                "leads to the host"},
        Mistake{R"(<usb_tactile name="a" vendor="1" product="1" endpoint="1"><frame><level channel="1"/></frame>
                      </usb_tactile>)",
                "channel 0 has 0 levels"},
        Mistake{R"(<usb_tactile name="a" vendor="1" product="1" endpoint="1"><frame><level channel="99"/></frame>
                      </usb_tactile>)",
                "channel 99 is too high"},
        Mistake{R"(<usb_tactile name="a" vendor="1" product="1" endpoint="1"><frame/></usb_tactile>)", "level"}}) {
    const auto table = ReadUsbTable(Written(mistake.text));
    ASSERT_FALSE(table) << mistake.text;
    EXPECT_NE(scene::Format(table.error().front()).find(mistake.what), std::string::npos)
        << scene::Format(table.error().front());
    EXPECT_GT(table.error().front().where.line, 0);
  }
}

}  // namespace
}  // namespace tactile
