#include "nodes/visual_node/pictures/live_film.hpp"

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <utility>

#include "core/clock.hpp"
#include "nodes/visual_node/pictures/replay_frames.hpp"

namespace visual_node {

core::Result<void> FilmFrames::WriteUntil(std::int64_t now_ns, std::int64_t least) {
  const double due = 1e-9 * static_cast<double>(now_ns - begin_ns_) * frames_per_s_ + 1e-6;
  for (const std::int64_t end = std::max(static_cast<std::int64_t>(due), least); num_written_ < end; ++num_written_) {
    if (auto written = sink_(*shown_); !written) return written;
  }
  return {};
}

core::Result<void> FilmFrames::Show(picture::Image image, std::int64_t now_ns) {
  if (!shown_) begin_ns_ = now_ns;
  core::Result<void> written;
  if (shown_) written = WriteUntil(now_ns, 0);
  shown_ = std::move(image);
  return written;
}

core::Result<void> FilmFrames::End(std::int64_t now_ns) {
  return shown_ ? WriteUntil(now_ns, num_written_ + 1) : core::Result<void>{};
}

LiveFilm::LiveFilm(int fd, double frames_per_s)
    : file_(fdopen(fd, "wb")),
      frames_(frames_per_s, [this](const picture::Image& image) { return WritePpm(image, file_); }) {
  std::signal(SIGPIPE, SIG_IGN);  // a reader that is gone ends the film, not the viewer
  thread_ = std::thread([this] { Run(); });
}

LiveFilm::~LiveFilm() {
  {
    const std::scoped_lock lock(mutex_);
    is_over_ = true;
  }
  is_changed_.notify_one();
  thread_.join();
  if (file_ != nullptr) std::fclose(file_);
}

void LiveFilm::Show(picture::Image image, std::int64_t now_ns) {
  {
    const std::scoped_lock lock(mutex_);
    newest_ = Shown{std::move(image), now_ns};
  }
  is_changed_.notify_one();
}

std::optional<LiveFilm::Shown> LiveFilm::Next() {
  std::unique_lock lock(mutex_);
  is_changed_.wait(lock, [this] { return newest_ || is_over_; });
  return std::exchange(newest_, std::nullopt);
}

void LiveFilm::Run() {
  core::Result<void> written;
  while (written) {
    std::optional<Shown> shown = Next();
    if (!shown) break;
    written = frames_.Show(std::move(shown->image), shown->time_ns);
  }
  if (written) written = frames_.End(core::MonotonicNow_ns());
  if (!written) std::fprintf(stderr, "the film ends here: %s\n", written.error().detail.c_str());
}

}  // namespace visual_node
