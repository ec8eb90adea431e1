#pragma once

#include <array>
#include <charconv>
#include <cstddef>
#include <optional>
#include <string_view>

// Of this project's own lines of sensors: "... [id v1 v2 ...] [id v1 v2 ...]".
namespace tracking {

// "v1 v2 ... vN", whole and no more.
template <std::size_t N>
std::optional<std::array<double, N>> ParseNumbers(std::string_view text) {
  std::array<double, N> values{};
  const char* at = text.data();
  const char* const end = text.data() + text.size();
  for (double& value : values) {
    while (at != end && *at == ' ') ++at;
    const auto [next, error] = std::from_chars(at, end, value);
    if (error != std::errc()) return std::nullopt;
    at = next;
  }
  if (at != end) return std::nullopt;
  return values;
}

// The first bracket of N numbers that begins with `id`.
template <std::size_t N>
std::optional<std::array<double, N>> FindNumbers(std::string_view line, int id) {
  for (std::size_t open = 0; (open = line.find('[', open)) != std::string_view::npos; ++open) {
    const std::size_t close = line.find(']', open);
    if (close == std::string_view::npos) return std::nullopt;
    const auto values = ParseNumbers<N>(line.substr(open + 1, close - open - 1));
    if (values && (*values)[0] == static_cast<double>(id)) return values;
  }
  return std::nullopt;
}

}  // namespace tracking
