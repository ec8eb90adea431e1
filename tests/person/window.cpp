#include "tests/person/window.hpp"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <memory>
#include <utility>

#include "bus/rt/periodic_loop.hpp"
#include "core/clock.hpp"
#include "tools/oos/run/session/virtual_display.hpp"

namespace person_tests {
namespace {

constexpr int kLookHeight = 240;                // the captions' rows
constexpr int kClockRow = 60, kClockRows = 40;  // where the time stands that the picture shows

std::string OutputOf(const std::string& command) {
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> pipe(popen(command.c_str(), "r"), pclose);
  std::string output;
  std::array<char, 65536> bytes;
  while (pipe) {
    const std::size_t num = std::fread(bytes.data(), 1, bytes.size(), pipe.get());
    if (num == 0) break;
    output.append(bytes.data(), num);
  }
  return output;
}

}  // namespace

std::string Window::MissingProgram() {
  for (const char* program : {"Xvfb", "xdotool"}) {
    if (OutputOf(std::string("command -v ") + program).empty()) return program;
  }
  return {};
}

// The server keeps its screen in a file (XWD, without compression), which is read as it is.
core::Result<void> Window::Open() {
  std::string folder = std::filesystem::temp_directory_path() / "vr_oos_screen.XXXXXX";
  if (mkdtemp(folder.data()) == nullptr) return core::Fail(core::ErrorCode::kIo, "cannot make a folder like " + folder);
  folder_ = folder;
  auto display = oos::StartVirtualDisplay(&server_, "/dev/null", {"-fbdir", folder_.string()});
  if (!display) return tl::unexpected(display.error());
  display_ = std::move(*display);
  setenv("DISPLAY", display_.c_str(), 1);
  return {};
}

Window::~Window() {
  std::error_code error;
  std::filesystem::remove_all(folder_, error);
}

bool Window::WaitForWindow(double patience_s) {
  OutputOf("timeout " + std::to_string(std::lround(patience_s)) +
           " xdotool search --onlyvisible --sync --name '.' 2>/dev/null");
  return !OutputOf("xdotool search --onlyvisible --name '.' 2>/dev/null").empty();
}

GreyPicture Window::Rows(int first, int num) const {
  constexpr std::size_t kHeadSize = 0, kNumBits = 11, kRowSize = 12, kNumColors = 19, kHeadWords = 25;
  std::ifstream file(folder_ / "Xvfb_screen0", std::ios::binary);
  std::array<unsigned char, 4 * kHeadWords> head{};
  file.read(reinterpret_cast<char*>(head.data()), head.size());
  const auto word = [&](std::size_t i) {
    return static_cast<std::size_t>(head[4 * i] << 24 | head[4 * i + 1] << 16 | head[4 * i + 2] << 8 | head[4 * i + 3]);
  };
  const std::size_t row = word(kRowSize), size = row * static_cast<std::size_t>(num);
  if (!file || word(kNumBits) != 32 || row != 4 * kWidth) return {};
  std::vector<unsigned char> bytes(size);
  file.seekg(
      static_cast<std::streamoff>(word(kHeadSize) + 12 * word(kNumColors) + row * static_cast<std::size_t>(first)));
  file.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(size));
  GreyPicture picture{kWidth, num, {}};
  for (std::size_t at = 0; at < size; at += 4) {
    picture.values.push_back(static_cast<unsigned char>((bytes[at] + bytes[at + 1] + bytes[at + 2]) / 3));
  }
  return picture;
}

GreyPicture Window::LookDown() const {
  return Rows(kHeight - kLookHeight, kLookHeight);
}

GreyPicture Window::LookAfter(int num_pictures) const {
  constexpr std::int64_t kPatience_ns = 4'000'000'000;
  bus::PeriodicLoop glances(10'000'000);
  const std::int64_t begin_ns = core::MonotonicNow_ns();
  std::vector<unsigned char> clock = Rows(kClockRow, kClockRows).values;
  while (num_pictures > 0 && core::MonotonicNow_ns() - begin_ns < kPatience_ns) {
    glances.WaitNext();
    std::vector<unsigned char> now = Rows(kClockRow, kClockRows).values;
    if (now == clock) continue;
    clock = std::move(now);
    --num_pictures;
  }
  return LookDown();
}

void Window::Do(const std::string& xdotool) const {
  OutputOf("xdotool " + xdotool + " 2>/dev/null");
}

void Window::Press(const std::string& key) {
  Do("key --delay 60 " + key);
}

void Window::HoldKey(const std::string& key, bool is_down) {
  Do((is_down ? "keydown " : "keyup ") + key);
}

void Window::HoldButton(int button, bool is_down) {
  Do((is_down ? "mousedown " : "mouseup ") + std::to_string(button));
}

void Window::MoveTo(int x, int y) {
  x_ = x;
  y_ = y;
  Do("mousemove " + std::to_string(x_) + " " + std::to_string(y_));
}

void Window::Drag(int dx, int dy) {
  constexpr int kStep_px = 12;
  const int num_steps = std::max(1, std::max(std::abs(dx), std::abs(dy)) / kStep_px);
  std::string moves;
  for (int i = 1; i <= num_steps; ++i) {
    moves += "mousemove " + std::to_string(x_ + dx * i / num_steps) + " " + std::to_string(y_ + dy * i / num_steps) +
             " sleep 0.02 ";
  }
  x_ += dx;
  y_ += dy;
  Do(moves);
}

void Window::Resize(int width, int height) {
  Do("search --onlyvisible --name '.' windowsize " + std::to_string(width) + " " + std::to_string(height));
}

void Window::Wheel(int notches) {
  if (notches == 0) return;
  Do("click --repeat " + std::to_string(std::abs(notches)) + " --delay 20 " + (notches > 0 ? "4" : "5"));
}

}  // namespace person_tests
