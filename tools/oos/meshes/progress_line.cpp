#include "tools/oos/meshes/progress_line.hpp"

#include <unistd.h>

#include <algorithm>
#include <thread>
#include <utility>

#include "core/clock.hpp"

namespace oos {

ProgressLine::ProgressLine(std::string title, std::FILE* stream, bool else_stages)
    : title_(std::move(title)),
      stream_(stream),
      is_terminal_(isatty(fileno(stream)) != 0),
      else_stages_(else_stages),
      begin_ns_(core::MonotonicNow_ns()) {}

ProgressLine::~ProgressLine() {
  if (!is_terminal_) return;
  std::fprintf(stream_, "\r\033[K");
  std::fflush(stream_);
}

void ProgressLine::Report(std::string_view stage, double fraction) {
  if (is_terminal_) {
    OverwriteLine(stage, fraction);
  } else if (else_stages_ && stage != last_stage_) {
    last_stage_ = stage;
    std::fprintf(stream_, "  %s\n", last_stage_.c_str());
  }
}

void ProgressLine::OverwriteLine(std::string_view stage, double fraction) {
  const std::int64_t now_ns = core::MonotonicNow_ns();
  // A fraction that falls belongs to another part of the work.
  if (fraction < last_fraction_) begin_ns_ = now_ns;
  last_fraction_ = fraction;
  char left[32] = "";
  const double spent_s = 1e-9 * static_cast<double>(now_ns - begin_ns_);
  if (fraction > 0.02 && spent_s > 0.5) {
    std::snprintf(left, sizeof left, ", %.0f s left", spent_s * (1.0 - fraction) / fraction);
  }
  std::fprintf(stream_, "\r\033[K%s: %.*s %3.0f %%%s", title_.c_str(), static_cast<int>(stage.size()), stage.data(),
               100.0 * fraction, left);
  std::fflush(stream_);
}

unsigned NumCookWorkers() {
  return std::max(std::thread::hardware_concurrency(), 1U);
}

}  // namespace oos
