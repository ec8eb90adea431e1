#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/result.hpp"

namespace oos {

// One option of a verb: `--name` or, when `value_name` is given, `--name VALUE`.
struct Option {
  std::string_view name;  // with its dashes
  std::string_view value_name;
  std::string_view help;
};

// The command line of one verb, checked against the options that it declares.
class Arguments {
 public:
  // Fails with a sentence that names the argument and what is accepted instead.
  static core::Result<Arguments> Parse(const std::vector<std::string>& words, const std::vector<Option>& options);

  [[nodiscard]] const std::vector<std::string>& positional() const { return positional_; }
  [[nodiscard]] bool has(std::string_view name) const { return values_.find(name) != values_.end(); }
  [[nodiscard]] std::string text(std::string_view name, std::string_view fallback = "") const;
  [[nodiscard]] std::vector<std::string> texts(std::string_view name) const;  // an option may be given several times
  // Fails when the value is given and is not a finite number.
  [[nodiscard]] core::Result<std::optional<double>> number(std::string_view name) const;
  // The same, for one above zero, and for a whole one within bounds.
  [[nodiscard]] core::Result<std::optional<double>> positive(std::string_view name) const;
  [[nodiscard]] core::Result<std::optional<std::uint64_t>> count(std::string_view name, std::uint64_t least,
                                                                 std::uint64_t most) const;

 private:
  std::vector<std::string> positional_;
  std::multimap<std::string, std::string, std::less<>> values_;
};

}  // namespace oos
