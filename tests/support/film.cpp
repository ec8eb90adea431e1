#include "tests/support/film.hpp"

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <limits>
#include <set>
#include <sstream>

#include "tools/process/piped_child.hpp"

namespace system_tests {
namespace {

constexpr int kEncodersNoise = 16;  // of 255; at the quality that films have, in flat parts
constexpr std::size_t kWidth = 160, kHeight = 90;

}  // namespace

bool FilmFacts::Differ(std::size_t a, std::size_t b) const {
  if (a >= small.size() || b >= small.size()) return false;
  std::size_t count = 0;
  for (std::size_t i = 0; i < small[a].size(); ++i) {
    const int difference = static_cast<unsigned char>(small[a][i]) - static_cast<unsigned char>(small[b][i]);
    if (std::abs(difference) > kEncodersNoise) ++count;
  }
  return 1000 * count > small[a].size();
}

FilmFacts ReadFilm(const std::filesystem::path& file) {
  FilmFacts facts;
  const auto probed = process::RunHere({"ffprobe", "-v", "error", "-count_frames", "-show_entries",
                                        "stream=codec_type,duration,nb_read_frames", "-of", "default=nw=1", file});
  if (!probed || !probed->is_good()) return facts;
  facts.kind = probed->value("codec_type");
  facts.seconds = std::strtod(probed->value("duration").c_str(), nullptr);
  facts.pictures = std::strtod(probed->value("nb_read_frames").c_str(), nullptr);
  const std::filesystem::path raw = file.string() + ".rgb";
  const auto decoded = process::RunHere({"ffmpeg", "-loglevel", "error", "-y", "-i", file, "-vf",
                                         "scale=" + std::to_string(kWidth) + ":" + std::to_string(kHeight), "-f",
                                         "rawvideo", "-pix_fmt", "rgb24", raw});
  if (!decoded || !decoded->is_good()) return facts;
  std::ifstream in(raw, std::ios::binary);
  const std::string rgb(std::istreambuf_iterator<char>(in), {});
  facts.least_colours = rgb.empty() ? 0 : std::numeric_limits<std::size_t>::max();
  constexpr std::size_t kSize = 3 * kWidth * kHeight;
  for (std::size_t at = 0; at + kSize <= rgb.size(); at += kSize) {
    facts.small.push_back(rgb.substr(at, kSize));
    std::set<std::string> colours;
    for (std::size_t k = 0; k < kSize; k += 3) colours.insert(facts.small.back().substr(k, 3));
    facts.least_colours = std::min(facts.least_colours, colours.size());
  }
  std::filesystem::remove(raw);
  return facts;
}

}  // namespace system_tests
