#include "tools/oos/verb/arguments.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdlib>

namespace oos {

core::Result<Arguments> Arguments::Parse(const std::vector<std::string>& words, const std::vector<Option>& options) {
  Arguments arguments;
  bool only_positional = false;
  for (std::size_t i = 0; i < words.size(); ++i) {
    const std::string& word = words[i];
    if (only_positional || word.size() < 2 || word.rfind("--", 0) != 0) {
      arguments.positional_.push_back(word);
      continue;
    }
    if (word == "--") {
      only_positional = true;
      continue;
    }
    const std::size_t equals = word.find('=');
    const std::string name = word.substr(0, equals);
    const auto option = std::find_if(options.begin(), options.end(), [&](const Option& o) { return o.name == name; });
    if (option == options.end()) {
      std::string known;
      for (const Option& o : options) known += " " + std::string(o.name);
      return core::Fail(core::ErrorCode::kInvalidInput,
                        "unknown option " + name + (known.empty() ? "; this verb takes none" : "; known:" + known));
    }
    if (option->value_name.empty()) {
      if (equals != std::string::npos) {
        return core::Fail(core::ErrorCode::kInvalidInput, name + " takes no value");
      }
      arguments.values_.emplace(name, "");
    } else if (equals != std::string::npos) {
      arguments.values_.emplace(name, word.substr(equals + 1));
    } else if (i + 1 < words.size()) {
      arguments.values_.emplace(name, words[++i]);
    } else {
      return core::Fail(core::ErrorCode::kInvalidInput, name + " needs a value: " + std::string(option->value_name));
    }
  }
  return arguments;
}

std::string Arguments::text(std::string_view name, std::string_view fallback) const {
  const auto found = values_.find(name);
  return found == values_.end() ? std::string(fallback) : found->second;
}

std::vector<std::string> Arguments::texts(std::string_view name) const {
  std::vector<std::string> all;
  const auto [first, last] = values_.equal_range(name);
  for (auto it = first; it != last; ++it) all.push_back(it->second);
  return all;
}

core::Result<std::optional<double>> Arguments::number(std::string_view name) const {
  const auto found = values_.find(name);
  if (found == values_.end()) return std::optional<double>{};
  char* end = nullptr;
  const double value = std::strtod(found->second.c_str(), &end);
  if (found->second.empty() || *end != '\0' || !std::isfinite(value)) {
    return core::Fail(core::ErrorCode::kInvalidInput,
                      std::string(name) + " needs a number, not '" + found->second + "'");
  }
  return std::optional<double>{value};
}

core::Result<std::optional<double>> Arguments::positive(std::string_view name) const {
  auto value = number(name);
  if (value && *value && !(**value > 0.0)) {
    return core::Fail(core::ErrorCode::kInvalidInput,
                      std::string(name) + " needs a number above zero, not '" + text(name) + "'");
  }
  return value;
}

core::Result<std::optional<std::uint64_t>> Arguments::count(std::string_view name, std::uint64_t least,
                                                            std::uint64_t most) const {
  if (!has(name)) return std::optional<std::uint64_t>{};
  const std::string word = text(name);
  std::uint64_t value = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error != std::errc() || end != word.data() + word.size() || value < least || value > most) {
    return core::Fail(core::ErrorCode::kInvalidInput, std::string(name) + " needs a whole number from " +
                                                          std::to_string(least) + " to " + std::to_string(most) +
                                                          ", not '" + word + "'");
  }
  return std::optional<std::uint64_t>{value};
}

}  // namespace oos
