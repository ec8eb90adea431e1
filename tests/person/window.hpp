#pragma once

#include <filesystem>
#include <string>

#include "core/result.hpp"
#include "tests/person/captions.hpp"
#include "tools/process/group.hpp"

namespace person_tests {

// An X server of its own, and what a person at it sees and does. One window is expected, as large as the screen.
class Window {
 public:
  static constexpr int kWidth = 1280, kHeight = 720;

  Window() = default;
  ~Window();
  Window(const Window&) = delete;
  Window& operator=(const Window&) = delete;

  // "": all programs are here; else the one that is missing.
  static std::string MissingProgram();
  // Starts Xvfb on a free display, and says so in the environment of this process (DISPLAY).
  core::Result<void> Open();
  // Waits until a window is there. False: too late.
  bool WaitForWindow(double patience_s);

  // The lower part of the screen; empty when it cannot be taken.
  [[nodiscard]] GreyPicture LookDown() const;
  // The same when so many new pictures have been shown; after a few seconds in any case.
  [[nodiscard]] GreyPicture LookAfter(int num_pictures) const;
  void Press(const std::string& key);
  void HoldKey(const std::string& key, bool is_down);
  void HoldButton(int button, bool is_down);
  void MoveTo(int x, int y);
  // In steps of a hand, not at once.
  void Drag(int dx, int dy);
  void Wheel(int notches);  // away: positive
  // As by a window manager, which is not here.
  void Resize(int width, int height);
  [[nodiscard]] int x() const { return x_; }
  [[nodiscard]] int y() const { return y_; }

 private:
  [[nodiscard]] GreyPicture Rows(int first, int num) const;
  void Do(const std::string& xdotool) const;

  process::Group server_;
  std::filesystem::path folder_;  // of the server's screen
  std::string display_;
  int x_ = kWidth / 2, y_ = kHeight / 2;
};

}  // namespace person_tests
