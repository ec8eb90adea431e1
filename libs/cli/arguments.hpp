#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cli/range.hpp"
#include "cli/read_number.hpp"
#include "core/result.hpp"

namespace cli {

// One option of a program: `--name`, or `--name VALUE` when `value_name` is given.
struct Option {
  std::string_view name;  // with its dashes
  std::string_view value_name = "";
  std::string_view help = "";
  std::string_view fallback = "";  // the value when it is not given
  Range range = {};
  bool is_required = false;
};

// The command line of one program, or of one verb of a program. Parsing and help come from it.
struct Syntax {
  std::string program;               // as people call it: "oos run", "haptic_node"
  std::string_view summary;          // one line
  std::string_view positional = "";  // as shown in the usage line
  std::size_t min_positional = 0;
  std::size_t max_positional = 0;
  std::vector<Option> options;
  std::string_view details = "";  // below the options in the help
};

// What was given, checked against the syntax. Of an option that is given several times the last value counts, unless
// `texts` is used.
class Arguments {
 public:
  // `words`: without the program's name. Fails with a sentence that names the word and what is accepted instead.
  static core::Result<Arguments> Parse(const std::vector<std::string>& words, const Syntax& syntax);

  [[nodiscard]] bool wants_help() const { return wants_help_; }  // then nothing else was checked
  [[nodiscard]] const std::vector<std::string>& positional() const { return positional_; }
  [[nodiscard]] bool has(std::string_view name) const { return given_.find(name) != given_.end(); }
  // As given, else the declared fallback, else `otherwise`.
  [[nodiscard]] std::string text(std::string_view name, std::string_view otherwise = "") const;
  [[nodiscard]] std::vector<std::string> texts(std::string_view name) const;
  // Fails when there is a value and it is not a finite number.
  [[nodiscard]] core::Result<std::optional<double>> number(std::string_view name) const;
  // The same, for one above zero, and for a whole one within bounds.
  [[nodiscard]] core::Result<std::optional<double>> positive(std::string_view name) const;
  [[nodiscard]] core::Result<std::optional<std::uint64_t>> count(std::string_view name, std::uint64_t least,
                                                                 std::uint64_t most) const;
  // Of an option with a range that Parse has checked, given or with a fallback.
  [[nodiscard]] double checked_number(std::string_view name) const;
  [[nodiscard]] std::uint64_t checked_count(std::string_view name) const;

 private:
  std::vector<std::string> positional_;
  std::map<std::string, std::vector<std::string>, std::less<>> given_;
  std::map<std::string, std::string, std::less<>> fallbacks_;
  bool wants_help_ = false;
};

// What `--help` prints.
std::string Help(const Syntax& syntax);

}  // namespace cli
