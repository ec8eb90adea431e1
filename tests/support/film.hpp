#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace system_tests {

// What ffprobe says of a film, and its pictures.
struct FilmFacts {
  std::string kind;  // "video"; empty: it cannot be read
  double seconds = 0.0;
  double pictures = 0.0;
  std::size_t least_colours = 0;   // of a picture, at a quarter of its size
  std::vector<std::string> small;  // the pictures, RGB, at that size

  // Whether more than one in a thousand of their bytes differ by more than what the encoder changes.
  [[nodiscard]] bool Differ(std::size_t a, std::size_t b) const;
};

FilmFacts ReadFilm(const std::filesystem::path& file);

}  // namespace system_tests
