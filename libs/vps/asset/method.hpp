#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

namespace vps {

// kPaper: integer layers, K = 4 point-sphere tree [VR-OOS, section 3]. kFast: distance field, area-weighted samples,
// vector walk. Both give the same kind of results for the same scenes.
enum class Method : std::uint32_t { kPaper = 0, kFast = 1 };

// "paper" and "fast", as in scenarios and command lines.
constexpr std::optional<Method> MethodFromName(std::string_view name) {
  if (name == "paper") return Method::kPaper;
  if (name == "fast") return Method::kFast;
  return std::nullopt;
}

}  // namespace vps
