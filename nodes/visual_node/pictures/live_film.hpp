#pragma once

#include <condition_variable>
#include <cstdint>
#include <functional>
#include <mutex>
#include <optional>
#include <thread>

#include "core/result.hpp"
#include "picture/image.hpp"

namespace visual_node {

// Pictures that are shown at any times become frames at a constant rate: each lasts until the next one is shown.
class FilmFrames {
 public:
  using Sink = std::function<core::Result<void>(const picture::Image&)>;
  FilmFrames(double frames_per_s, Sink sink) : frames_per_s_(frames_per_s), sink_(std::move(sink)) {}

  // Errors: the sink's.
  core::Result<void> Show(picture::Image image, std::int64_t now_ns);
  // The last picture lasts until then. It has a frame at least.
  core::Result<void> End(std::int64_t now_ns);

 private:
  core::Result<void> WriteUntil(std::int64_t now_ns, std::int64_t least);

  double frames_per_s_;
  Sink sink_;
  std::optional<picture::Image> shown_;
  std::int64_t begin_ns_ = 0;
  std::int64_t num_written_ = 0;
};

// The film of a live viewer, written in a thread of its own: drawing does not wait for whoever reads it. If that takes
// longer than a picture is shown, the next ones are left out.
class LiveFilm {
 public:
  // Writes PPM pictures to that open file, and closes it.
  LiveFilm(int fd, double frames_per_s);
  ~LiveFilm();
  LiveFilm(const LiveFilm&) = delete;
  LiveFilm& operator=(const LiveFilm&) = delete;

  void Show(picture::Image image, std::int64_t now_ns);

 private:
  struct Shown {
    picture::Image image;
    std::int64_t time_ns = 0;
  };
  void Run();
  std::optional<Shown> Next();  // none: the film is over

  std::FILE* file_;
  FilmFrames frames_;
  std::mutex mutex_;
  std::condition_variable is_changed_;
  std::optional<Shown> newest_;
  bool is_over_ = false;
  std::thread thread_;
};

}  // namespace visual_node
