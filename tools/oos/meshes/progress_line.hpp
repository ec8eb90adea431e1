#pragma once

#include <cstdint>
#include <cstdio>
#include <string>
#include <string_view>

#include "vps/asset/cooked_object.hpp"

namespace oos {

// Progress of building collision structures. On a terminal: one line that is overwritten, and erased at the end.
class ProgressLine {
 public:
  // `else_stages`: where the stream is no terminal, a line for each stage; else nothing is written there.
  ProgressLine(std::string title, std::FILE* stream, bool else_stages);
  ~ProgressLine();
  ProgressLine(const ProgressLine&) = delete;
  ProgressLine& operator=(const ProgressLine&) = delete;

  void Report(std::string_view stage, double fraction);
  // Calls Report; the line has to outlive it.
  [[nodiscard]] vps::Progress AsProgress() {
    return [this](std::string_view stage, double fraction) { Report(stage, fraction); };
  }

 private:
  void OverwriteLine(std::string_view stage, double fraction);

  std::string title_;
  std::FILE* stream_;
  bool is_terminal_;
  bool else_stages_;
  std::string last_stage_;
  double last_fraction_ = 0.0;
  std::int64_t begin_ns_;
};

// Threads for it: one for each processor.
unsigned NumCookWorkers();

}  // namespace oos
