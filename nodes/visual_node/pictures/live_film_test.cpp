#include "nodes/visual_node/pictures/live_film.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <array>
#include <string>

#include "core/clock.hpp"

namespace visual_node {
namespace {

picture::Image Grey(std::uint8_t value) {
  picture::Image image;
  image.width = image.height = 1;
  image.rgba = {value, value, value, 255};
  return image;
}

// The grey of each frame, of pictures shown at times in milliseconds.
struct Film {
  std::vector<int> frames;
  FilmFrames film{10.0, [this](const picture::Image& image) -> core::Result<void> {
                    frames.push_back(image.rgba[0]);
                    return {};
                  }};
  void Show(std::uint8_t value, std::int64_t ms) {
    ASSERT_TRUE(film.Show(Grey(value), 5'000'000'000 + ms * 1'000'000));
  }
  void End(std::int64_t ms) { ASSERT_TRUE(film.End(5'000'000'000 + ms * 1'000'000)); }
};

TEST(FilmFrames, EachPictureLastsUntilTheNextOneIsShown) {
  Film film;
  film.Show(1, 0);
  film.Show(2, 300);
  film.Show(3, 400);
  film.End(700);
  EXPECT_EQ(film.frames, (std::vector<int>{1, 1, 1, 2, 3, 3, 3}));
}

TEST(FilmFrames, HaveTheirTimeThoughPicturesComeAtAnyMoment) {
  Film film;
  int number = 0;
  for (const int ms : {0, 33, 71, 123, 160, 290, 333, 500, 999}) film.Show(static_cast<std::uint8_t>(++number), ms);
  film.End(2000);
  ASSERT_EQ(film.frames.size(), 20u) << "two seconds";
  EXPECT_EQ(film.frames[0], 3) << "the one that is shown when the frame ends";
  EXPECT_EQ(film.frames[4], 7);
  EXPECT_EQ(film.frames[19], 9);
}

TEST(FilmFrames, AFilmOfAMomentHasOneFrame) {
  Film film;
  film.Show(1, 0);
  film.End(1);
  EXPECT_EQ(film.frames, std::vector<int>{1});
}

TEST(LiveFilm, WritesPictures) {
  int ends[2];
  ASSERT_EQ(pipe(ends), 0);
  {
    LiveFilm film(ends[1], 30.0);
    film.Show(Grey(65), core::MonotonicNow_ns());
  }
  std::array<char, 4096> text{};
  const ssize_t size = read(ends[0], text.data(), text.size());
  close(ends[0]);
  ASSERT_GT(size, 0);
  EXPECT_EQ(std::string(text.data(), 14), "P6\n1 1\n255\nAAA");
}

TEST(LiveFilm, AReaderThatIsGoneDoesNotEndTheViewer) {
  int ends[2];
  ASSERT_EQ(pipe(ends), 0);
  close(ends[0]);
  LiveFilm film(ends[1], 30.0);
  for (int i = 0; i < 3; ++i) film.Show(Grey(1), core::MonotonicNow_ns() + i * core::kNanosecondsPerSecond);
}

}  // namespace
}  // namespace visual_node
